//! A controller of another crate gets its row of the multi-axial problem.
#![allow(missing_docs)]

#[allow(dead_code)] // Its `main` prints.
#[path = "../examples/your_pair.rs"]
mod your_pair;

#[path = "../../host-tests/src/frame.rs"]
mod frame;

use std::fmt::Write as _;
use std::path::Path;

#[test]
fn a_pair_from_outside_gets_a_row_of_the_multi_axial_problem() {
    let Some(stiffness) = test_data::file("marths/K_matrix.csv") else {
        return;
    };
    let Some(record) = test_data::file("ground-motion/RTHSBENCH_ElCentro.csv") else {
        return;
    };
    let folder = stiffness.parent().expect("it is in a folder");
    gets_a_row(folder, &record);
}

/// The same where the problem's files are not.
#[test]
fn a_pair_from_outside_gets_a_row_of_a_drawn_frame() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("drawn-frame");
    std::fs::create_dir_all(&folder).expect("a folder");
    let names = ["K_matrix.csv", "M_matrix.csv", "initial_parameters.csv"];
    for (name, table) in names.into_iter().zip(frame::tables()) {
        std::fs::write(folder.join(name), table).expect("a table");
    }
    let mut text = String::from("time_s,acc_g\n");
    for i in 0..1000 {
        let t = f64::from(i) * 0.02;
        let shape = (t / 3.0) * (1.0 - t / 3.0).exp();
        let waves = [3.1, 7.3, 11.9, 19.7].map(|w: f64| (w * t + w).sin());
        let _ = writeln!(
            text,
            "{t:.2},{:.6}",
            0.08 * shape * waves.iter().sum::<f64>()
        );
    }
    let record = folder.join("drawn.csv");
    std::fs::write(&record, text).expect("a record");
    gets_a_row(&folder, &record);
}

fn gets_a_row(folder: &Path, record: &Path) {
    let rows = your_pair::rows(folder, &record.to_string_lossy(), 2).expect("the problem's files");
    let [as_they_are, ahead] = &rows[..] else {
        panic!("two rows: {rows:?}")
    };
    assert_eq!(
        (as_they_are.controller, ahead.controller),
        ("none", "ahead")
    );
    assert_eq!((ahead.worst.perturbed, ahead.worst.lost), (2, 0));
    println!("J2 {:?} -> {:?}", as_they_are.j.j2, ahead.j.j2);
    // The delay causes most of the error of sending the targets unchanged.
    for i in 0..2 {
        assert!(ahead.j.j2[i] < 0.7 * as_they_are.j.j2[i], "{rows:?}");
    }
}
