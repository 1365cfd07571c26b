//! A controller of another crate gets its rows; this is the example that the documentation refers to.
#![allow(missing_docs)]

use benchmarks::rths::Rules;

#[allow(dead_code)] // Its `main` reads a record and prints.
#[path = "../examples/your_controller.rs"]
mod your_controller;

#[test]
fn a_controller_from_outside_gets_a_row_of_every_case() {
    let rules = Rules::official();
    let rows = your_controller::rows(your_controller::sines(&rules), &rules, 3).unwrap();
    let theirs: Vec<_> = rows.iter().filter(|r| r.controller == "ahead").collect();
    let published: Vec<_> = rows
        .iter()
        .filter(|r| r.controller == "pi-phase-lead")
        .collect();
    assert_eq!((theirs.len(), published.len()), (4, 4));
    for (row, baseline) in theirs.iter().zip(published) {
        assert_eq!((row.prior_knowledge, row.perturbed), ("the delay", 3));
        // At 2 to 4 Hz, linear extrapolation by 25 ms leaves an error of (omega tau)^2 / 2, and the actuator's gain adds
        // some per cent.
        assert!(row.j2_true > 1.0 && row.j2_true < 30.0, "{}", row.j2_true);
        assert!(row.j4_worst > 0.0 && row.j4_worst.is_finite());
        assert!(
            baseline.lost == 0 && baseline.j2_true < 15.0,
            "{}",
            baseline.j2_true
        );
    }
}
