//! What the watch had to say of a test, as data and in words.

use crate::numbers::three;
use outerloop_core::watch::Finding;
use schemars::JsonSchema;
use serde::Serialize;

/// A cause that was named. The keys are a contract.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct NamedCause {
    /// The effect's name in the catalogue.
    pub name: &'static str,
    /// Where it is: `actuator`, `displacement`, `force` (the sensors) or `specimen`.
    pub side: &'static str,
    /// Of which actuator, from 1, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub actuator: Option<usize>,
    /// How much more than declared, in `unit`.
    pub value: f64,
    /// Its unit; empty for a share.
    pub unit: &'static str,
    /// Interval of 90 %.
    pub ci90: [f64; 2],
    /// True of a noise, a hum or a reading that stands still: a sensor shows it by itself, so it is present whichever other cause
    /// of the set is the right one.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub beside: bool,
    /// How much of it the loop corrects for, in `unit`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub corrected: Option<f64>,
}

/// A change of state or set. The keys are a contract.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct WatchEvent {
    /// When, s of the model from the first control step of the running test.
    pub t_s: f64,
    /// The state from then on.
    pub state: &'static str,
    /// The causes that the motion does not distinguish, and what a sensor shows by itself.
    pub set: Vec<NamedCause>,
    /// True if the loop corrects for one of them.
    pub corrected: bool,
    /// True if what the adaptive compensation has learnt is held at what was declared.
    pub held: bool,
}

/// A correction as it was changed: 50 ms or more after the last one. The keys are a contract.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CorrectionStep {
    /// When it was asked for, s of the model from the first control step of the running test.
    pub t_s: f64,
    /// The effect's name in the catalogue.
    pub name: &'static str,
    /// Where it is.
    pub side: &'static str,
    /// Of which actuator, from 1, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub actuator: Option<usize>,
    /// How much is corrected for from then on, in `unit`.
    pub corrected: f64,
    /// Its unit; empty for a share.
    pub unit: &'static str,
}

/// A cause that would be named in a test like this. The keys are a contract.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Watchable {
    /// The effect's name in the catalogue.
    pub name: &'static str,
    /// Where it is.
    pub side: &'static str,
    /// Of which actuator, from 1, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub actuator: Option<usize>,
    /// The least of it that the motion would have named, where it told most, in `unit`.
    pub least: f64,
    /// Its unit; empty for a share.
    pub unit: &'static str,
}

/// What the diagnosis of the record behind the first name says of the names. The keys are a contract.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Agreement {
    /// True if it names a cause of any set, from the first to the last; null if it could not be asked.
    pub agrees: Option<bool>,
    /// Whether, and why not, in a sentence.
    pub sentence: String,
}

/// The report of the rig watch on a test. The keys are a contract.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct WatchReport {
    /// The state at the end.
    pub state: &'static str,
    /// Every change; the last one is what had settled by the end.
    pub events: Vec<WatchEvent>,
    /// Every correction, 20 a second while it moves.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub corrections: Vec<CorrectionStep>,
    /// Whether the diagnosis of the same record agrees, where it was asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diagnosis: Option<Agreement>,
    /// What would have been named, and from which size on.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub watchable: Vec<Watchable>,
    /// What could not be watched, and why, in sentences.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub not_watched: Vec<String>,
}

impl WatchReport {
    /// A line for each change. The last event is no change: it has what had settled at the end, and since when.
    pub fn lines(&self) -> Vec<String> {
        let mut lines: Vec<String> = self.events.iter().map(WatchEvent::in_words).collect();
        if let ([before @ .., end], Some(line)) = (&self.events[..], lines.last_mut()) {
            let same = before.iter().rev().take_while(|e| e.says_the_same(end));
            if let Some(since) = same.last() {
                *line = format!("at the end: {}", end.since(since.t_s));
            }
        }
        lines
    }

    /// What happened and when, in a sentence.
    pub fn sentence(&self) -> String {
        let first = self.events.iter().find(|e| !e.set.is_empty());
        let (Some(first), Some(last)) = (first, self.events.last()) else {
            let found = match self.state {
                "sound" => "The watch named nothing.",
                _ => "The watch had a doubt that got no name.",
            };
            return format!("{found} {}", self.not_watched.join(" "))
                .trim_end()
                .to_owned();
        };
        // Another set may have come first: what is said below is the last one.
        let same = self.events.iter().rev();
        let same = same.take_while(|e| e.causes() == last.causes()).last();
        let since = match same {
            Some(since) if since.t_s > first.t_s => {
                format!(" and as follows since {:.2} s", since.t_s)
            }
            _ => String::new(),
        };
        let what = last.causes_in_words(|several| format!("one of {}", several.join(", ")));
        let stopped = if self.state == "trip" {
            " The test cannot be trusted from there on."
        } else {
            ""
        };
        let held = self
            .events
            .iter()
            .find(|e| e.held)
            .map_or(String::new(), |e| {
                format!(
                    " From {:.2} s on the compensation was held at what was declared.",
                    e.t_s
                )
            });
        let agrees = self.diagnosis.as_ref();
        let agrees = agrees.map_or(String::new(), |d| format!(" {}", d.sentence));
        format!(
            "The watch named, first at {:.2} s{since}: {what}.{}{held}{stopped}{agrees}",
            first.t_s,
            self.corrected_in_words()
        )
    }

    /// What could be named in a test like this, in sentences. What is not watched stands last, with what of it is for all that.
    pub fn outlook(&self) -> String {
        let can: Vec<String> = self.watchable.iter().map(Watchable::in_words).collect();
        let mut said = match &can[..] {
            [] => "In this motion the rig watch could name no error by its size".to_owned(),
            _ => format!("In this motion the rig watch could name {}", can.join(", ")),
        };
        if let Some(beside) = self.watched_beside() {
            said += if can.is_empty() {
                ", but "
            } else {
                "; beside them "
            };
            said += beside;
        }
        said += ".";
        for gap in &self.not_watched {
            said += " ";
            said += gap;
        }
        said
    }

    /// What is watched beside errors by their size, as far as no gap says it. A side of which something has a least size is declared.
    fn watched_beside(&self) -> Option<&'static str> {
        let all = self.not_watched.is_empty();
        let tells_of = |side: &str| all || self.watchable.iter().any(|w| w.side == side);
        match (tells_of("actuator"), tells_of("force")) {
            (true, true) => Some(
                "sensors that stand, hum or become noisy, limits of stroke and speed, and play",
            ),
            (true, false) => Some(
                "a displacement transducer that stands, hums or becomes noisy, and limits of stroke and speed",
            ),
            (false, true) => Some("a load cell that stands, hums or becomes noisy, and play"),
            (false, false) => None,
        }
    }

    /// What was corrected for: from when, and by how much in the end.
    fn corrected_in_words(&self) -> String {
        let (Some(first), Some(last)) = (self.corrections.first(), self.corrections.last()) else {
            return String::new();
        };
        format!(
            " From {:.2} s on it was corrected for, in the end by {}.",
            first.t_s,
            with_unit(last.corrected, last.unit)
        )
    }
}

/// As `the load cell 2`.
fn place(side: &str, actuator: Option<usize>) -> String {
    let side = match side {
        "displacement" => "the displacement transducer",
        "force" => "the load cell",
        "actuator" => "the actuator",
        _ => "the specimen",
    };
    actuator.map_or(side.to_owned(), |n| format!("{side} {n}"))
}

/// As `6.1 ms`.
fn with_unit(value: f64, unit: &str) -> String {
    let space = if unit.is_empty() { "" } else { " " };
    format!("{}{space}{unit}", three(value))
}

impl Watchable {
    /// As `delay_error of the actuator from 2.9 ms on`.
    pub fn in_words(&self) -> String {
        let least = with_unit(self.least, self.unit);
        format!(
            "{} of {} from {least} on",
            self.name,
            place(self.side, self.actuator)
        )
    }
}

impl WatchEvent {
    /// As `named since 9.40 s: delay_error of the actuator (12.1 ms, 11.8 to 12.4); delay_error is corrected for by 11.9 ms`.
    pub fn in_words(&self) -> String {
        self.since(self.t_s)
    }

    /// The same, where it has been so since another instant.
    fn since(&self, t_s: f64) -> String {
        let mut said = format!("{} since {t_s:.2} s", self.state);
        if !self.set.is_empty() {
            said += ": ";
            said += &self.causes_in_words(|several| several.join(", or "));
        }
        for cause in &self.set {
            if let Some(corrected) = cause.corrected {
                let by = with_unit(corrected, cause.unit);
                said += &format!("; {} is corrected for by {by}", cause.name);
            }
        }
        if self.held {
            said += "; what the compensation learns is held at what was declared";
        }
        said
    }
}

impl WatchEvent {
    /// Its set in words: what the motion does not tell apart as `several` has it, of each actuator, and what a sensor shows beside it.
    fn causes_in_words(&self, several: impl Fn(&[String]) -> String) -> String {
        let (fitted, beside): (Vec<_>, Vec<_>) = self.set.iter().partition(|c| !c.beside);
        let mut all = Vec::new();
        for of_one in fitted.chunk_by(|a, b| a.actuator == b.actuator) {
            let names: Vec<String> = of_one.iter().map(|c| c.in_words()).collect();
            all.push(match &names[..] {
                [one] => one.clone(),
                names => several(names),
            });
        }
        all.extend(beside.iter().map(|c| c.in_words()));
        all.join("; and ")
    }

    /// Whether it says of the same causes what another one does, whatever their values are by now.
    fn says_the_same(&self, other: &Self) -> bool {
        self.state == other.state && self.causes() == other.causes()
    }

    /// What is in its set, and of which actuator.
    fn causes(&self) -> Vec<(&'static str, &'static str, Option<usize>)> {
        let own = self.set.iter().map(|c| (c.name, c.side, c.actuator));
        own.collect()
    }
}

impl NamedCause {
    /// What was found, of which actuator, from 1, where there are several.
    pub fn of(found: &Finding, actuator: Option<usize>) -> Self {
        let cause = found.cause;
        Self {
            name: cause.name(),
            side: cause.side().name(),
            actuator,
            value: f64::from(found.value),
            unit: cause.unit(),
            ci90: found.interval_90().map(f64::from),
            beside: !cause.is_fitted(),
            corrected: None,
        }
    }

    /// As `delay_error of the actuator (6.1 ms, 5.2 to 7.0)`.
    pub fn in_words(&self) -> String {
        let of = format!("{} of {}", self.name, place(self.side, self.actuator));
        if self.value == 0.0 {
            return of;
        }
        let [low, high] = self.ci90.map(three);
        format!(
            "{of} ({}, {low} to {high})",
            with_unit(self.value, self.unit)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::{NamedCause, WatchEvent, WatchReport, Watchable};

    fn event(t_s: f64, state: &'static str, value: f64) -> WatchEvent {
        let cause = NamedCause {
            name: "delay_error",
            side: "actuator",
            actuator: None,
            value,
            unit: "ms",
            ci90: [value - 0.5, value + 0.5],
            beside: false,
            corrected: None,
        };
        WatchEvent {
            t_s,
            state,
            set: if state == "named" {
                vec![cause]
            } else {
                Vec::new()
            },
            corrected: false,
            held: false,
        }
    }

    #[test]
    fn what_is_watched_beside_sizes_is_only_of_what_was_declared() {
        let outlook = |sides: &[&'static str], gap: &str| {
            let of = |side: &'static str| Watchable {
                name: "gain_error",
                side,
                actuator: None,
                least: 0.1,
                unit: "",
            };
            let gap = (!gap.is_empty()).then(|| gap.to_owned());
            let report = WatchReport {
                state: "sound",
                events: Vec::new(),
                corrections: Vec::new(),
                diagnosis: None,
                watchable: sides.iter().copied().map(of).collect(),
                not_watched: gap.into_iter().collect(),
            };
            report.outlook()
        };
        let all = outlook(&["actuator"], "");
        assert!(
            all.ends_with("limits of stroke and speed, and play."),
            "{all}"
        );
        let forces = outlook(&["force"], "A gap.");
        assert!(!forces.contains("stroke"), "{forces}");
        assert!(forces.ends_with("noisy, and play. A gap."), "{forces}");
        let actuators = outlook(&["actuator"], "A gap.");
        assert!(!actuators.contains("play"), "{actuators}");
        assert!(actuators.contains("displacement transducer that stands"));
        let nothing = outlook(&[], "A gap.");
        assert!(
            nothing.ends_with("no error by its size. A gap."),
            "{nothing}"
        );
    }

    #[test]
    fn the_last_line_says_since_when_it_has_been_so_and_not_when_the_test_ended() {
        let mut report = WatchReport {
            state: "named",
            events: vec![
                event(8.0, "doubtful", 0.0),
                event(8.3, "named", 9.0),
                event(30.0, "named", 12.0),
            ],
            corrections: Vec::new(),
            diagnosis: None,
            watchable: Vec::new(),
            not_watched: Vec::new(),
        };
        let lines = report.lines();
        assert_eq!(lines[0], "doubtful since 8.00 s");
        assert!(
            lines[1].starts_with("named since 8.30 s: delay_error"),
            "{lines:?}"
        );
        assert!(
            lines[2].starts_with("at the end: named since 8.30 s: delay_error"),
            "{lines:?}"
        );
        assert!(
            lines[2].contains("12.0 ms") || lines[2].contains("12 ms"),
            "{lines:?}"
        );
        let said = report.sentence();
        assert!(
            said.starts_with("The watch named, first at 8.30 s: delay_error"),
            "{said}"
        );
        // Where another set came first, it says since when it has been this one.
        let mut other = event(8.2, "named", 9.0);
        other.set.push(NamedCause {
            name: "coulomb_friction",
            ..other.set[0].clone()
        });
        report.events.insert(1, other);
        let said = report.sentence();
        let begins = "The watch named, first at 8.20 s and as follows since 8.30 s: delay_error";
        assert!(said.starts_with(begins), "{said}");
        report.events.remove(1);
        // What changed at the end has been so since then.
        report.events.push(event(31.0, "sound", 0.0));
        assert_eq!(report.lines()[3], "sound since 31.00 s");
    }
}
