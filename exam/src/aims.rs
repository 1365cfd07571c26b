//! The list of aims. Each command that prints figures of an exam also prints by how much each aim is missed.
//!
//! The aims were set for records that nobody here has seen: the outside league and its third lot, two sealed exams, laws of
//! OpenSees, and a field trial. A command prints the same figures for the records that it has.

use std::fmt::Write as _;

/// A figure and its aim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// What is counted.
    pub row: &'static str,
    /// The aim.
    pub aim: Wanted,
}

/// The direction of an aim, and its value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wanted {
    /// At least this share.
    ShareAtLeast(f64),
    /// At most this share.
    ShareAtMost(f64),
    /// At most this many seconds.
    SecondsAtMost(f64),
    /// At most this ratio to something else.
    RatioAtMost(f64),
}

const fn at_least(row: &'static str, share: f64) -> Aim {
    let aim = Wanted::ShareAtLeast(share);
    Aim { row, aim }
}

const fn at_most(row: &'static str, share: f64) -> Aim {
    let aim = Wanted::ShareAtMost(share);
    Aim { row, aim }
}

const fn within(row: &'static str, seconds: f64) -> Aim {
    let aim = Wanted::SecondsAtMost(seconds);
    Aim { row, aim }
}

/// Published records: points and wrong names in the league of 35 and in the third league of 60.
pub const LEAGUES: [Aim; 4] = [
    at_least("league: points, 30 of 35", 30.0 / 35.0),
    at_most("league: wrong, 1 of 35", 1.0 / 35.0),
    at_least("third league: points, 51 of 60", 51.0 / 60.0),
    at_most("third league: wrong", 0.017),
];

/// Each of the two sealed exams: one effect exactly or in a set, both of two effects named, effects that cannot be told
/// apart, effects outside the list, and wrong names.
pub const SEALED: [[Aim; 5]; 2] = [
    [
        at_least("first sealed exam: one, exact or set", 0.88),
        at_least("first sealed exam: two named", 0.65),
        at_least("first sealed exam: inseparable", 0.85),
        at_least("first sealed exam: outside", 0.93),
        at_most("first sealed exam: wrong", 0.02),
    ],
    [
        at_least("second sealed exam: one, exact or set", 0.88),
        at_least("second sealed exam: two named", 0.80),
        at_least("second sealed exam: inseparable", 0.80),
        at_least("second sealed exam: outside", 0.88),
        at_most("second sealed exam: wrong", 0.015),
    ],
];

/// Laws of OpenSees: one law, two laws that are both named, no law of the list, and nothing hidden.
pub const OPENSEES: [Aim; 4] = [
    at_least("OpenSees: one law", 0.75),
    at_least("OpenSees: two laws, both named", 0.50),
    at_least("OpenSees: outside", 0.95),
    at_least("OpenSees: clean", 1.0),
];

/// The field trial: sound actuators called sound, effects found, and effects named wrongly.
pub const FIELD_TRIAL: [Aim; 3] = [
    at_least("sound rams called sound, 26 of 29", 26.0 / 29.0),
    at_least("effects found, 30 of 34", 30.0 / 34.0),
    at_most("effects named wrongly, 1 of 34", 1.0 / 34.0),
];

/// Fraction of the rigs with an ambiguous first record that designed tests should settle.
pub const SHARE_SETTLED: f64 = 0.70;
/// Rigs whose first record is ambiguous.
pub const SETTLED: [Aim; 1] = [at_least(
    "settled by two designed tests at most",
    SHARE_SETTLED,
)];

/// Seconds a record: the median and the 95th percentile.
pub const SECONDS: [Aim; 2] = [
    within("seconds a record, median", 0.5),
    within("seconds a record, 95 % are below", 1.5),
];

/// Error of the model found in a motion that was used neither for the fit nor for judging it. The aim was set relative to
/// the error of the true law fed with the readings, which is the load cell's noise and more.
pub const THIRD_MOTION: [Aim; 1] = [Aim {
    row: "third motion: error over the noise, geometric mean",
    aim: Wanted::RatioAtMost(1.8),
}];

/// A figure to compare with its aim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// Its value: a share, seconds or a ratio. None if there was nothing to count.
    pub value: Option<f64>,
    /// The number of records that it is taken over.
    pub of: usize,
}

impl Figure {
    /// `part` as a share of `of`.
    pub fn share(part: f64, of: usize) -> Self {
        let value = (of > 0).then(|| part / of as f64);
        Self { value, of }
    }
}

/// The times of some records as the figures of [`SECONDS`].
pub fn seconds(of_each: impl IntoIterator<Item = f64>) -> [Figure; 2] {
    let mut all: Vec<f64> = of_each.into_iter().collect();
    all.sort_by(f64::total_cmp);
    let of = all.len();
    [0.5, 0.95].map(|share| Figure {
        value: all
            .get(((share * of as f64) as usize).min(of.saturating_sub(1)))
            .copied(),
        of,
    })
}

impl Aim {
    /// By how much a figure misses the aim, in the figure's own unit; none if it meets it.
    pub fn missed_by(&self, figure: f64) -> Option<f64> {
        let by = match self.aim {
            Wanted::ShareAtLeast(least) => least - figure,
            Wanted::ShareAtMost(most) | Wanted::SecondsAtMost(most) | Wanted::RatioAtMost(most) => {
                figure - most
            }
        };
        (by > 0.0).then_some(by)
    }

    fn line(&self, figure: &Figure) -> String {
        let is_share = matches!(self.aim, Wanted::ShareAtLeast(_) | Wanted::ShareAtMost(_));
        let number = |x: f64| match self.aim {
            Wanted::ShareAtLeast(_) | Wanted::ShareAtMost(_) => format!("{:.1} %", 100.0 * x),
            Wanted::SecondsAtMost(_) => format!("{x:.2} s"),
            Wanted::RatioAtMost(_) => format!("{x:.2}"),
        };
        let wanted = match self.aim {
            Wanted::ShareAtLeast(x) => format!("at least {}", number(x)),
            Wanted::ShareAtMost(x) | Wanted::SecondsAtMost(x) | Wanted::RatioAtMost(x) => {
                format!("at most {}", number(x))
            }
        };
        let [value, missed] = match figure.value {
            None => ["nothing to count", "-"].map(String::from),
            Some(x) => {
                let missed = match self.missed_by(x) {
                    None => "met".into(),
                    Some(by) if is_share => format!("missed by {:.1} points", 100.0 * by),
                    Some(by) => format!("missed by {}", number(by)),
                };
                [number(x), missed]
            }
        };
        format!(
            "| {} | {wanted} | {value} | {} | {missed} |",
            self.row, figure.of
        )
    }
}

/// Figures next to their aims, in the order of the aims, as a Markdown table.
///
/// # Panics
/// If the numbers of figures and aims differ.
pub fn table(rows: &[(&[Aim], &[Figure])]) -> String {
    let mut text = String::from("| figure | aim | is | of | |\n|---|---|---|---|---|\n");
    for (aims, figures) in rows {
        assert_eq!(aims.len(), figures.len(), "a figure for each aim");
        for (aim, figure) in aims.iter().zip(figures.iter()) {
            let _ = writeln!(text, "{}", aim.line(figure));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_figure_says_by_how_much_it_misses_its_aim() {
        let figures = [
            Figure::share(20.0, 29),
            Figure::share(31.0, 34),
            Figure::share(0.0, 0),
        ];
        let text = table(&[(&FIELD_TRIAL, &figures), (&SECONDS, &seconds([0.1, 2.0]))]);
        for line in [
            "| sound rams called sound, 26 of 29 | at least 89.7 % | 69.0 % | 29 | missed by 20.7 points |",
            "| effects found, 30 of 34 | at least 88.2 % | 91.2 % | 34 | met |",
            "| effects named wrongly, 1 of 34 | at most 2.9 % | nothing to count | 0 | - |",
            "| seconds a record, 95 % are below | at most 1.50 s | 2.00 s | 2 | missed by 0.50 s |",
        ] {
            assert!(text.contains(line), "{text}");
        }
    }
}
