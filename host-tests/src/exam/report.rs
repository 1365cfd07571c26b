//! The table of the targets, and the detailed tables.

use super::detection::{Point, detection};
use super::grade::Mark;
use super::run::GradedRecord;
use super::tally::{Tally, estimates, median, quantile};
use comfy_table::{Table, presets::UTF8_HORIZONTAL_ONLY};
use exam::Class;
use exam::aims::{self, Figure};
use exam::reliability;
use serde_json::{Value, json};

/// A target of the exam and how it was met.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// What is counted.
    pub what: &'static str,
    /// The target value.
    pub wanted: Wanted,
    /// The figure; `None` if there was nothing to count.
    pub figure: Option<f64>,
    /// Number of records, channels or intervals counted.
    pub count: usize,
}

/// A target value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wanted {
    /// A fraction of at least this.
    ShareAtLeast(f64),
    /// A fraction of at most this.
    ShareAtMost(f64),
    /// A fraction between the two.
    ShareBetween(f64, f64),
    /// A number of at most this.
    AtMost(f64),
}

impl Target {
    /// True if it was met; `None` if there was nothing to count.
    pub fn met(&self) -> Option<bool> {
        let figure = self.figure?;
        Some(match self.wanted {
            Wanted::ShareAtLeast(least) => figure >= least,
            Wanted::ShareAtMost(most) | Wanted::AtMost(most) => figure <= most,
            Wanted::ShareBetween(least, most) => (least..=most).contains(&figure),
        })
    }

    /// By how much it was missed, in the figure's own unit; `None` if it was met or there was nothing to count.
    pub fn missed_by(&self) -> Option<f64> {
        let figure = self.figure?;
        let by = match self.wanted {
            Wanted::ShareAtLeast(least) => least - figure,
            Wanted::ShareAtMost(most) | Wanted::AtMost(most) => figure - most,
            Wanted::ShareBetween(least, most) => (least - figure).max(figure - most),
        };
        (by > 0.0).then_some(by)
    }

    fn missed_text(&self) -> String {
        match (self.missed_by(), self.wanted) {
            (None, _) if self.figure.is_some() => "met".into(),
            (None, _) => "-".into(),
            (Some(by), Wanted::AtMost(_)) => format!("missed by {by:.3}"),
            (Some(by), _) => format!("missed by {:.1} points", 100.0 * by),
        }
    }

    fn wanted_text(&self) -> String {
        let percent = |x: f64| format!("{}", (1e4 * x).round() / 100.0);
        match self.wanted {
            Wanted::ShareAtLeast(x) => format!("at least {} %", percent(x)),
            Wanted::ShareAtMost(x) => format!("at most {} %", percent(x)),
            Wanted::ShareBetween(a, b) => format!("{} to {} %", percent(a), percent(b)),
            Wanted::AtMost(x) => format!("at most {x}"),
        }
    }

    fn figure_text(&self) -> String {
        match (self.figure, self.wanted) {
            (None, _) => "nothing to count".into(),
            (Some(x), Wanted::AtMost(_)) => format!("{x:.3}"),
            (Some(x), _) => format!("{:.1} %", 100.0 * x),
        }
    }
}

/// All figures of an exam.
#[derive(Clone, Debug)]
pub struct Report<'a> {
    all: &'a [GradedRecord],
    /// The targets.
    pub targets: Vec<Target>,
    /// The detection limit.
    pub detection: Vec<Point>,
}

impl<'a> Report<'a> {
    /// Evaluates the records.
    pub fn new(all: &'a [GradedRecord]) -> Self {
        Self {
            all,
            targets: targets(all),
            detection: detection(all),
        }
    }

    /// The targets as a table.
    pub fn target_table(&self) -> String {
        let mut table = table(&["target", "wanted", "figure", "of", ""]);
        for t in &self.targets {
            table.add_row([
                t.what.to_string(),
                t.wanted_text(),
                t.figure_text(),
                t.count.to_string(),
                t.missed_text(),
            ]);
        }
        table.to_string()
    }

    /// The aims on sealed exams, and by how much they are missed, as a table in Markdown.
    pub fn aim_table(&self) -> String {
        let nominal = |s: &GradedRecord| s.item.detection.is_none();
        let share = |of: &dyn Fn(Class) -> bool, is: &dyn Fn(Mark) -> bool| {
            let tally = Tally::over(self.all, |s| nominal(s) && of(s.item.class));
            Figure {
                value: tally.share(is),
                of: tally.len(),
            }
        };
        let in_set = |m| matches!(m, Mark::Exact | Mark::Set);
        let sealed = [
            share(&|c| matches!(c, Class::Matched | Class::Unseen), &in_set),
            share(&|c| c == Class::Two, &|m| m == Mark::Exact),
            share(&|c| c == Class::Confounded, &in_set),
            share(&|c| c == Class::Outside, &|m| m == Mark::Exact),
            share(&|_| true, &|m| m == Mark::Wrong),
        ];
        let seconds = aims::seconds(self.all.iter().map(|s| s.seconds));
        let [first, second] = &aims::SEALED;
        aims::table(&[
            (first, &sealed),
            (second, &sealed),
            (&aims::SECONDS, &seconds),
        ])
    }

    /// Distribution of the marks in each class.
    pub fn mark_table(&self) -> String {
        let mut heads = vec!["class".to_string(), "records".into()];
        heads.extend(Mark::ALL.iter().map(|m| format!("{m:?}").to_lowercase()));
        let mut table = table(&heads);
        for class in Class::ALL {
            let tally = Tally::of(self.all, class);
            let mut row = vec![class.name().to_string(), tally.len().to_string()];
            row.extend(Mark::ALL.iter().map(|mark| {
                tally
                    .share(|m| m == *mark)
                    .map_or("-".into(), |s| format!("{:.1} %", 100.0 * s))
            }));
            table.add_row(row);
        }
        table.to_string()
    }

    /// The answers for each hidden effect of a class, with the most frequent wrong or inexact ones.
    pub fn confusion_table(&self, class: Class) -> String {
        let mut table = table(&["hidden", "records", "exact", "right", "wrong", "instead"]);
        for (what, row) in Tally::of(self.all, class).by_effect() {
            let count = |is: &dyn Fn(Mark) -> bool| -> usize {
                row.marks
                    .iter()
                    .filter(|(m, _)| is(**m))
                    .map(|(_, n)| n)
                    .sum()
            };
            let mut instead: Vec<(&String, &usize)> = row.instead.iter().collect();
            instead.sort_by_key(|(_, n)| std::cmp::Reverse(**n));
            let instead: Vec<String> = instead
                .iter()
                .take(3)
                .map(|(what, n)| format!("{n} x {what}"))
                .collect();
            table.add_row([
                what,
                row.records.to_string(),
                count(&|m| m == Mark::Exact).to_string(),
                count(&Mark::is_right).to_string(),
                count(&|m| m == Mark::Wrong).to_string(),
                instead.join(", "),
            ]);
        }
        table.to_string()
    }

    /// How often names are hidden, by the probability stated for them, as a table in Markdown.
    pub fn reliability_table(&self) -> String {
        let stated = self.all.iter().flat_map(GradedRecord::stated);
        reliability::table(&stated.collect::<Vec<_>>())
    }

    /// The detection limit as a table.
    pub fn detection_table(&self) -> String {
        let mut table = table(&[
            "effect / noise floor",
            "records",
            "noticed",
            "right",
            "wrong",
        ]);
        let percent = |x: f64| format!("{:.0} %", 100.0 * x);
        for p in &self.detection {
            table.add_row([
                p.size.to_string(),
                p.records.to_string(),
                percent(p.noticed),
                percent(p.right),
                percent(p.wrong),
            ]);
        }
        table.to_string()
    }

    /// Everything as one object.
    pub fn to_json(&self) -> Value {
        let targets: Vec<Value> = self
            .targets
            .iter()
            .map(|t| {
                json!({ "target": t.what, "wanted": t.wanted_text(), "figure": t.figure, "count": t.count, "met": t.met(), "missed_by": t.missed_by() })
            })
            .collect();
        let records: Vec<Value> = self
            .all
            .iter()
            .map(|s| {
                json!({
                    "class": s.item.class.name(),
                    "seed": s.item.seed,
                    "detection_size": s.item.detection,
                    "mark": format!("{:?}", s.grade.mark).to_lowercase(),
                    "seconds": s.seconds,
                    "stated": s.stated(),
                    "estimates": estimates(s).iter().map(|e| {
                        json!({ "name": e.name, "truth": e.truth, "value": e.value, "ci90": e.ci90 })
                    }).collect::<Vec<_>>(),
                })
            })
            .collect();
        let detection: Vec<Value> = self
            .detection
            .iter()
            .map(|p| {
                json!({ "size": p.size, "records": p.records, "noticed": p.noticed, "right": p.right, "wrong": p.wrong })
            })
            .collect();
        json!({ "targets": targets, "detection": detection, "records": records })
    }
}

fn table<T: ToString>(heads: &[T]) -> Table {
    let mut table = Table::new();
    table
        .load_preset(UTF8_HORIZONTAL_ONLY)
        .set_header(heads.iter().map(ToString::to_string).collect::<Vec<_>>());
    table
}

fn targets(all: &[GradedRecord]) -> Vec<Target> {
    use Wanted::{AtMost, ShareAtLeast, ShareAtMost, ShareBetween};
    let of = |class| Tally::of(all, class);
    let (matched, unseen, clean) = (of(Class::Matched), of(Class::Unseen), of(Class::Clean));
    let (outside, two, confounded) = (of(Class::Outside), of(Class::Two), of(Class::Confounded));
    let everything = Tally::over(all, |_| true);
    let exact = |m| m == Mark::Exact;
    let wrong = |m| m == Mark::Wrong;
    let share = |what, wanted, tally: &Tally, is: &dyn Fn(Mark) -> bool| Target {
        what,
        wanted,
        figure: tally.share(is),
        count: tally.len(),
    };
    let ratio = |what, most, tally: &Tally| {
        let ratios = tally.after_over_floor();
        let count = ratios.len();
        Target {
            what,
            wanted: AtMost(most),
            figure: median(ratios),
            count,
        }
    };
    let (intervals, inside) = matched.covered();
    let (changed, worse) = everything.changed_and_worse();
    let seconds = everything.seconds();
    vec![
        share(
            "matched equations: exact",
            ShareAtLeast(0.97),
            &matched,
            &exact,
        ),
        share(
            "unseen equations: exact, family or right set",
            ShareAtLeast(0.85),
            &unseen,
            &Mark::is_right,
        ),
        share(
            "unseen equations: confidently wrong",
            ShareAtMost(0.02),
            &unseen,
            &wrong,
        ),
        share(
            "outside the library: abstains",
            ShareAtLeast(0.95),
            &outside,
            &exact,
        ),
        share(
            "clean records: false positives",
            ShareAtMost(0.005),
            &clean,
            &|m| matches!(m, Mark::Wrong | Mark::Alarm),
        ),
        share(
            "two effects: both",
            ShareAtLeast(0.8),
            &two,
            &Mark::is_right,
        ),
        share(
            "confounded: exact, family or right set",
            ShareAtLeast(0.85),
            &confounded,
            &Mark::is_right,
        ),
        share(
            "confounded: confidently wrong",
            ShareAtMost(0.02),
            &confounded,
            &wrong,
        ),
        ratio("error after / noise floor, matched, median", 1.05, &matched),
        ratio("error after / noise floor, unseen, median", 1.5, &unseen),
        Target {
            what: "90 % intervals that hold the truth",
            wanted: ShareBetween(0.85, 0.95),
            figure: (intervals > 0).then(|| inside as f64 / intervals as f64),
            count: intervals,
        },
        Target {
            what: "channels made worse on held-out data",
            wanted: AtMost(0.0),
            figure: (changed > 0).then_some(worse as f64),
            count: changed,
        },
        Target {
            what: "seconds a record, 95 % are below",
            wanted: AtMost(1.0),
            figure: quantile(&seconds, 0.95),
            count: seconds.len(),
        },
    ]
}
