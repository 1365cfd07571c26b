//! The best controllers, ties, and a caution for all figures.

use super::bench::RthsRow;
use super::table::names;

/// The method with the delay corrector for which the declared structure is right.
pub const RIGHT_STRUCTURE: &str = "hydraulic/mu=1.5";

/// Differences of J4 up to this are a tie, percentage points: another draw of the noise changes J4 as read by as much.
pub const TIE: f64 = 0.05;

/// Names of the controllers with the smallest J4 as read (mean over all cases and records), ties included, the best first.
pub fn best(rows: &[RthsRow]) -> Vec<String> {
    let mean = |name: &str| {
        let own = rows.iter().filter(|r| r.controller == name);
        let (sum, n) = own.fold((0.0, 0.0), |(sum, n), r| (sum + r.j[3], n + 1.0));
        sum / n
    };
    let mut ranked: Vec<(f64, &str)> = names(rows).into_iter().map(|n| (mean(n), n)).collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let least = ranked.first().map_or(0.0, |r| r.0);
    ranked
        .into_iter()
        .take_while(|(mean, _)| *mean <= least + TIE)
        .map(|(_, name)| name.to_owned())
        .collect()
}

/// A caution for all these figures.
pub const CAUTION: &str = "Real rigs are reported to be 3 to 5 times worse than this virtual one.";
