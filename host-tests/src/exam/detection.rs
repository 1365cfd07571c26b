//! How small an effect may be: share of right answers against its size in units of the noise floor.

use super::grade::Mark;
use super::plan::DETECTION_SIZES;
use super::run::GradedRecord;
use super::tally::Tally;

/// One size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Rms beyond what declared parameters take up, over the noise floor.
    pub size: f64,
    /// How many records.
    pub records: usize,
    /// Share that was named rightly (exact, set or family).
    pub right: f64,
    /// Share that was noticed: anything but `none`.
    pub noticed: f64,
    /// Share that was named wrongly.
    pub wrong: f64,
}

/// Every size that the exam had records of.
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
