//! Who is best, what is a tie, and what to know beside any figure.

use super::bench::RthsRow;
use super::table::names;

/// The setting of the delay corrector in which the structure is right.
pub const RIGHT_STRUCTURE: &str = "hydraulic/mu=1.5";

/// Differences of J4 below this are a tie, points: another draw of the noise moves J4 as read by as much.
pub const TIE: f64 = 0.05;

/// Who has the least J4 as read, the mean of all cases and records, and who is as good: names, the best first.
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

/// What to know beside any of these figures.
pub const CAUTION: &str = "Real rigs are reported to be 3 to 5 times worse than this virtual one.";
