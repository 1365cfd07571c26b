//! Ranking of the compensations.

use super::compared_test::ComparedTest;
use super::condition::Family;
use serde::Serialize;

/// A contestant's errors over the bench: geometric means, because they span many orders of magnitude.
#[derive(Clone, Debug, Serialize)]
pub struct Standing {
    /// Its name.
    pub compensation: &'static str,
    /// Mean of eps_rms in each family, in the order of [`Family::ALL`].
    pub by_family: Vec<f64>,
    /// Mean over all tests.
    pub mean: f64,
    /// Largest eps_rms.
    pub worst: f64,
    /// Number of tests in which no other was better.
    pub best_in: usize,
    /// Number of tests that tripped, ran away or ended with an error as large as the motion.
    pub failed: usize,
    /// Number of tests.
    pub tests: usize,
}

/// Errors below this are rounding and count as equal.
const ROUNDING: f64 = 1e-6;

/// The standings of all contestants in `rows`, the best mean first.
pub fn of(rows: &[ComparedTest]) -> Vec<Standing> {
    let mut names: Vec<&'static str> = rows.iter().map(|r| r.summary.compensation).collect();
    names.sort_unstable();
    names.dedup();
    let mut all: Vec<Standing> = names
        .into_iter()
        .map(|name| standing_of(name, rows))
        .collect();
    all.sort_by(|a, b| a.mean.total_cmp(&b.mean));
    all
}

fn standing_of(name: &'static str, rows: &[ComparedTest]) -> Standing {
    let own: Vec<&ComparedTest> = rows
        .iter()
        .filter(|r| r.summary.compensation == name)
        .collect();
    let best_in = own.iter().filter(|r| error(r) <= best(r, rows)).count();
    let family = |f| mean(own.iter().filter(|r| r.family == f).map(|r| error(r)));
    Standing {
        compensation: name,
        by_family: Family::ALL.map(family).to_vec(),
        mean: mean(own.iter().map(|r| error(r))),
        worst: own.iter().map(|r| error(r)).fold(0.0, f64::max),
        best_in,
        failed: own.iter().filter(|r| r.error() >= 1.0).count(),
        tests: own.len(),
    }
}

fn error(row: &ComparedTest) -> f64 {
    row.error().max(ROUNDING)
}

/// The smallest error of all contestants in the test of `row`.
fn best(row: &ComparedTest, rows: &[ComparedTest]) -> f64 {
    rows.iter()
        .filter(|r| r.condition == row.condition && r.summary.record == row.summary.record)
        .map(error)
        .fold(f64::INFINITY, f64::min)
}

fn mean(errors: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = errors.fold((0.0, 0), |(sum, n), e| (sum + e.ln(), n + 1));
    (sum / f64::from(n.max(1))).exp()
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_mean_is_geometric() {
        assert!((super::mean([1e-4, 1e-2].into_iter()) - 1e-3).abs() < 1e-12);
    }
}
