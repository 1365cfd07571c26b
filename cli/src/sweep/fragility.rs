//! A fragility curve: the share of ground motions under which a displacement is exceeded, over their strength.
//!
//! A lognormal distribution function P = Phi(ln(x / median) / beta), fitted by greatest likelihood to how many of the tests
//! at each value exceed the limit (Baker, Earthquake Spectra 31, 2015, Eq 11).

use super::swept_test::SweptTest;
use experiment::numbers::three;
use serde::Serialize;
use std::f64::consts::{PI, SQRT_2};

/// What happened at one value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Share {
    /// The value.
    pub value: f64,
    /// Tests that went beyond the limit.
    pub beyond: usize,
    /// All of them.
    pub of: usize,
}

/// The lognormal distribution of the value at which a ground motion exceeds the limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Lognormal {
    /// The value that half of the ground motions exceed the limit at.
    pub median: f64,
    /// Standard deviation of its logarithm.
    pub beta: f64,
}

/// A curve of one compensation, or of the ideal rig.
#[derive(Clone, Debug, Serialize)]
pub struct Fragility {
    /// Name of the compensation; `ideal`: the same ground motions on an ideal rig.
    pub of: &'static str,
    /// What happened at each value.
    pub shares: Vec<Share>,
    /// The fit; `None` where the ground motions do not differ enough to tell a spread: all of them exceed the limit
    /// from one value on, or none does.
    pub fit: Option<Lognormal>,
}

impl Fragility {
    /// Of the rows of one compensation.
    pub fn of(name: &'static str, rows: &[SweptTest], beyond: impl Fn(&SweptTest) -> bool) -> Self {
        let mut shares: Vec<Share> = Vec::new();
        for row in rows {
            match shares.iter_mut().find(|s| s.value == row.value) {
                Some(share) => {
                    share.of += 1;
                    share.beyond += usize::from(beyond(row));
                }
                None => shares.push(Share {
                    value: row.value,
                    beyond: usize::from(beyond(row)),
                    of: 1,
                }),
            }
        }
        shares.sort_by(|a, b| a.value.total_cmp(&b.value));
        let fit = Lognormal::fit(&shares);
        Self {
            of: name,
            shares,
            fit,
        }
    }

    /// What the fit says, in words.
    pub fn in_words(&self) -> String {
        match self.fit {
            Some(l) => format!("median {}, beta {}", three(l.median), three(l.beta)),
            None => {
                "no curve: the ground motions do not differ in where they exceed the limit".into()
            }
        }
    }
}

/// The standard normal distribution function.
fn phi(z: f64) -> f64 {
    0.5 * libm::erfc(-z / SQRT_2)
}

/// Steps of the search; it needs five to ten.
const STEPS: usize = 100;
/// Largest step of the standardised distance.
const LONGEST: f64 = 1.0;
/// A change below this ends it.
const SMALL: f64 = 1e-10;

impl Lognormal {
    /// The share at `value`.
    pub fn at(&self, value: f64) -> f64 {
        phi((value / self.median).ln() / self.beta)
    }

    /// By greatest likelihood; `None` where there is none: values above zero are needed, and one at which a test goes
    /// beyond the limit below one at which another does not.
    pub fn fit(shares: &[Share]) -> Option<Self> {
        let used: Vec<&Share> = shares.iter().filter(|s| s.value > 0.0).collect();
        let first_beyond = used.iter().find(|s| s.beyond > 0)?.value;
        let last_within = used.iter().rev().find(|s| s.beyond < s.of)?.value;
        if first_beyond > last_within || used.iter().all(|s| s.value == first_beyond) {
            return None;
        }
        let mean = used.iter().map(|s| s.value.ln()).sum::<f64>() / used.len() as f64;
        // P = Phi(a + b (ln x - mean)): Fisher's scoring, which is Newton's step with the expected curvature.
        let (mut a, mut b) = (0.0, 1.0);
        for _ in 0..STEPS {
            let (mut g, mut h) = ([0.0; 2], [0.0; 3]);
            for s in &used {
                let x = s.value.ln() - mean;
                let z: f64 = a + b * x;
                let p = phi(z).clamp(1e-12, 1.0 - 1e-12);
                let density = (-0.5 * z * z).exp() / (2.0 * PI).sqrt();
                let weight = density / (p * (1.0 - p));
                let pull = weight * (s.beyond as f64 - s.of as f64 * p);
                let curve = weight * density * s.of as f64;
                g = [g[0] + pull, g[1] + pull * x];
                h = [h[0] + curve, h[1] + curve * x, h[2] + curve * x * x];
            }
            let determinant = h[0] * h[2] - h[1] * h[1];
            if determinant.abs() < f64::MIN_POSITIVE {
                return None;
            }
            let step = [
                (h[2] * g[0] - h[1] * g[1]) / determinant,
                (h[0] * g[1] - h[1] * g[0]) / determinant,
            ];
            let long = step[0].abs().max(step[1].abs());
            let share = (LONGEST / long).min(1.0);
            (a, b) = (a + share * step[0], b + share * step[1]);
            if long < SMALL {
                break;
            }
        }
        let fitted = Self {
            median: (mean - a / b).exp(),
            beta: 1.0 / b,
        };
        (b > 0.0 && fitted.median.is_finite()).then_some(fitted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shares(counts: &[(f64, usize)], of: usize) -> Vec<Share> {
        let share = |&(value, beyond)| Share { value, beyond, of };
        counts.iter().map(share).collect()
    }

    #[test]
    fn a_curve_that_is_sampled_exactly_is_found_again() {
        let truth = Lognormal {
            median: 1.3,
            beta: 0.4,
        };
        let of = 100_000;
        let counts: Vec<(f64, usize)> = (1..=12)
            .map(|i| {
                let value = 0.25 * f64::from(i);
                (value, (truth.at(value) * of as f64).round() as usize)
            })
            .collect();
        let found = Lognormal::fit(&shares(&counts, of)).unwrap();
        assert!((found.median / 1.3 - 1.0).abs() < 1e-4, "{found:?}");
        assert!((found.beta / 0.4 - 1.0).abs() < 1e-4, "{found:?}");
        assert!((phi(1.0) - 0.841_344_746_068_543).abs() < 1e-12);
    }

    #[test]
    fn no_other_curve_is_likelier() {
        let counts = shares(&[(0.2, 0), (0.4, 1), (0.6, 4), (0.8, 7), (1.0, 9)], 10);
        let likelihood = |l: Lognormal| -> f64 {
            let log = |s: &Share| {
                let p = l.at(s.value);
                s.beyond as f64 * p.ln() + (s.of - s.beyond) as f64 * (1.0 - p).ln()
            };
            counts.iter().map(log).sum()
        };
        let best = Lognormal::fit(&counts).unwrap();
        for (median, beta) in [(1.01, 1.0), (0.99, 1.0), (1.0, 1.02), (1.0, 0.98)] {
            let other = Lognormal {
                median: best.median * median,
                beta: best.beta * beta,
            };
            assert!(likelihood(best) > likelihood(other), "{best:?} {other:?}");
        }
    }

    #[test]
    fn without_a_spread_there_is_no_fit() {
        for counts in [
            &[(0.5, 0), (1.0, 3)][..],
            &[(0.5, 0), (1.0, 0)],
            &[(0.5, 3), (1.0, 3)],
        ] {
            assert_eq!(Lognormal::fit(&shares(counts, 3)), None);
        }
    }
}
