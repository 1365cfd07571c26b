//! A controller of another crate gets its row of the multi-axial problem.
#![allow(missing_docs)]

#[allow(dead_code)] // Its `main` prints.
#[path = "../examples/your_pair.rs"]
mod your_pair;

#[test]
fn a_pair_from_outside_gets_a_row_of_the_multi_axial_problem() {
    let Some(stiffness) = test_data::file("marths/K_matrix.csv") else {
        return;
    };
    let Some(record) = test_data::file("ground-motion/RTHSBENCH_ElCentro.csv") else {
        return;
    };
    let folder = stiffness.parent().expect("it is in a folder");
    let rows = your_pair::rows(folder, &record.to_string_lossy(), 2).expect("the problem's files");
    let [as_they_are, ahead] = &rows[..] else {
        panic!("two rows: {rows:?}")
    };
    assert_eq!(
        (as_they_are.controller, ahead.controller),
        ("none", "ahead")
    );
    assert_eq!((ahead.worst.perturbed, ahead.worst.lost), (2, 0));
    // The delay causes most of the error of sending the targets unchanged.
    for i in 0..2 {
        assert!(ahead.j.j2[i] < 0.7 * as_they_are.j.j2[i], "{rows:?}");
    }
}
