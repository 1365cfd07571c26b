//! Outcomes of the flips by what the bit belonged to, and an upper bound of the dangerous fraction.

use super::outcome::Outcome;
use super::target::Target;
use std::fmt;

/// Confidence level of the bound.
const SURE: f64 = 0.95;

/// The outcomes of the flips.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// Of each flip: what the bit belonged to, its outcome, and the largest deviation from the plan while PERMIT was high, m.
    pub flips: Vec<(Target, Outcome, f64)>,
}

impl Table {
    /// Number of flips with `outcome`, of `target` or of all.
    pub fn count(&self, target: Option<Target>, outcome: Outcome) -> usize {
        let of = |(from, came, _): &&(Target, Outcome, f64)| {
            target.is_none_or(|target| target == *from) && *came == outcome
        };
        self.flips.iter().filter(of).count()
    }

    /// Number of dangerous flips.
    pub fn dangerous(&self) -> usize {
        let came = self.flips.iter();
        came.filter(|(_, outcome, _)| outcome.is_dangerous())
            .count()
    }

    /// Number of flips with more than this deviation from the plan before PERMIT fell, m.
    pub fn farther_than(&self, apart_m: f64) -> usize {
        self.flips.iter().filter(|flip| flip.2 > apart_m).count()
    }

    fn row(&self, f: &mut fmt::Formatter<'_>, target: Option<Target>) -> fmt::Result {
        write!(f, "| {} |", target.map_or("all", Target::name))?;
        for outcome in Outcome::ALL {
            write!(f, " {} |", self.count(target, outcome))?;
        }
        writeln!(f)
    }
}

/// The table and its bound, in Markdown.
impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "| flipped |")?;
        for outcome in Outcome::ALL {
            write!(f, " {} |", outcome.name())?;
        }
        writeln!(f, "\n|---{}|", "|---".repeat(Outcome::ALL.len()))?;
        for target in Target::ALL {
            self.row(f, Some(target))?;
        }
        self.row(f, None)?;
        let (dangerous, all) = (self.dangerous(), self.flips.len());
        let share = dangerous as f64 / all.max(1) as f64;
        writeln!(
            f,
            "\ndangerous: {dangerous} of {all}, {:.2} %; at most {:.2} % by Clopper and Pearson (one-sided, 95 %)\n\
             more than 2 mm from the plan before PERMIT fell: {}",
            100.0 * share,
            100.0 * upper_bound(dangerous, all),
            self.farther_than(2e-3),
        )
    }
}

/// The one-sided 95 % upper bound of Clopper and Pearson (1934) for a fraction, from `count` of `all` observed: the fraction
/// at which the probability of so few is 1 in 20. 1 if `all` is 0.
pub fn upper_bound(count: usize, all: usize) -> f64 {
    if count >= all {
        return 1.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    // 60 bisections: to the precision of an f64.
    for _ in 0..60 {
        let share = 0.5 * (low + high);
        if at_most(count, all, share) > 1.0 - SURE {
            low = share;
        } else {
            high = share;
        }
    }
    high
}

/// The probability of at most `count` of `all`, each with probability `share`, 0 to 1: the sum of the binomial terms, by
/// their logarithms.
fn at_most(count: usize, all: usize, share: f64) -> f64 {
    let mut term = all as f64 * (-share).ln_1p();
    let mut sum = term.exp();
    for k in 1..=count {
        term += ((all - k + 1) as f64 / k as f64).ln() + share.ln() - (-share).ln_1p();
        sum += term.exp();
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bound_is_that_of_the_tables() {
        // With none observed it is 1 - 0.05^(1/n), the rule of three.
        for all in [10, 100, 2000] {
            let exact = 1.0 - 0.05_f64.powf(1.0 / all as f64);
            assert!((upper_bound(0, all) - exact).abs() < 1e-12);
        }
        // Clopper and Pearson's table: 1 of 10 gives 0.394, 5 of 10 gives 0.777.
        assert!((upper_bound(1, 10) - 0.3942).abs() < 1e-4);
        assert!((upper_bound(5, 10) - 0.7776).abs() < 1e-4);
        assert_eq!((upper_bound(10, 10), upper_bound(0, 0)), (1.0, 1.0));
    }

    #[test]
    fn what_is_unknown_counts_as_dangerous() {
        let flips = vec![
            (Target::Core, Outcome::Trip, 0.0),
            (Target::Bus, Outcome::Unknown, 0.0),
            (Target::Bus, Outcome::Beyond, 3e-3),
        ];
        let table = Table { flips };
        assert_eq!((table.dangerous(), table.farther_than(2e-3)), (2, 1));
        assert!(table.to_string().contains("dangerous: 2 of 3, 66.67 %"));
    }
}
