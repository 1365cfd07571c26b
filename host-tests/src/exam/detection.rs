//! Detection limit: fraction of right answers against an effect's size in units of the noise floor.

use super::grade::Mark;
use super::plan::DETECTION_SIZES;
use super::run::GradedRecord;
use super::tally::Tally;

/// Figures for one size of effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Rms that declared parameters cannot absorb, as a multiple of the noise floor.
    pub size: f64,
    /// Number of records.
    pub records: usize,
    /// Fraction named correctly (exact, set or family).
    pub right: f64,
    /// Fraction noticed: any mark but `Missed`.
    pub noticed: f64,
    /// Fraction named wrongly.
    pub wrong: f64,
}

/// Every size for which the exam had records.
pub fn detection(all: &[GradedRecord]) -> Vec<Point> {
    DETECTION_SIZES
        .iter()
        .filter_map(|&size| {
            let tally = Tally::over(all, |s| s.item.detection == Some(size));
            Some(Point {
                size,
                records: tally.len(),
                right: tally.share(Mark::is_right)?,
                noticed: tally.share(|m| m != Mark::Missed)?,
                wrong: tally.share(|m| m == Mark::Wrong)?,
            })
        })
        .collect()
}
