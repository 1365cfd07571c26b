//! The error that a diagnosis foretells of held-out data, on a sample of the pairs that `scripts/next-errors` prints.
#![allow(missing_docs)]
#![cfg(not(debug_assertions))] // Minutes without optimisation.

use host_tests::foresight::{Pair, of_case};
use host_tests::outside::cases;
use rayon::prelude::*;

#[test]
fn foretold_errors_hold_in_most_pairs_of_a_sample_of_open_records() {
    let sample = ["seal_napn_3bar", "seal_kidney_3bar", "seal_xring_7bar"];
    let open = cases().unwrap_or_default();
    let pairs: Vec<Pair> = open
        .par_iter()
        .filter(|c| sample.contains(&c.id.as_str()))
        .flat_map(of_case)
        .collect();
    for p in &pairs {
        println!(
            "{}: {:.4?}, {:.4}, {}",
            p.name,
            p.foretold,
            p.came,
            p.holds()
        );
        // An interval that says nothing is none.
        assert!(
            p.foretold[1] < 8.0 * p.foretold[0],
            "{}: {:?}",
            p.name,
            p.foretold
        );
    }
    let held = pairs.iter().filter(|p| p.holds()).count();
    assert!(
        held as f64 >= 0.85 * pairs.len() as f64,
        "{held} of {}",
        pairs.len()
    );
}
