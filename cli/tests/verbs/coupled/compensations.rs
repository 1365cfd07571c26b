//! What each compensation is worth.

use super::{EXAMPLE, figures, run};
use crate::common::json;
use experiment::summary::TestVerdict;

#[test]
fn knowing_the_coupling_is_worth_what_the_comparison_says() {
    let eps = |kind: &str| run(&[&format!("coupled.compensation={kind}")]).3;
    let [none, uncoupled, fixed, coupled] =
        ["none", "uncoupled", "coupled-fixed", "coupled"].map(eps);
    assert_ne!(none.verdict, TestVerdict::Completed);
    assert!(coupled.eps_rms < 0.02, "{}", coupled.eps_rms);
    assert!(fixed.eps_rms > 2.0 * coupled.eps_rms || fixed.verdict != TestVerdict::Completed);
    assert!(uncoupled.verdict != TestVerdict::Completed || uncoupled.eps_rms > fixed.eps_rms);
    // The estimate comes nearer to the rig than the declaration.
    for name in ["slow_pole_hz.0", "slow_pole_hz.1"] {
        let f = figures(&coupled)
            .found
            .iter()
            .find(|f| f.name == name)
            .unwrap();
        let (before, after) = (
            (f.declared - f.simulated).abs(),
            (f.found - f.simulated).abs(),
        );
        assert!(after < 0.5 * before, "{f:?}");
    }
}

#[test]
fn compare_has_a_row_for_each() {
    let rows = json(&["compare", EXAMPLE, "--json", "--duration", "8"]);
    assert_eq!(rows["rows"].as_array().unwrap().len(), 4);
}
