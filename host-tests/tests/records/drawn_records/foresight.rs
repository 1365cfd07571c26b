//! The next error of a drawn record, predicted.

use super::super::next_errors::they_hold;
use super::friction::axis;
use super::specimens::beam;
use host_tests::foresight::{Pair, of_case};

/// Beside the pairs of open records whose next error was predicted, by the same shares.
#[test]
fn foretold_errors_hold_on_drawn_records() {
    let pairs: Vec<Pair> = [axis("axis-next"), beam("beam-next")]
        .iter()
        .flat_map(of_case)
        .collect();
    assert_eq!(pairs.len(), 8);
    they_hold(&pairs);
}
