//! A goal and its result, and how it is read from a row.

use serde_json::Value;

/// Goals and their results.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// What is required, and of which controller.
    pub asked: String,
    /// The results: a figure for each case, actuator or coordinate.
    pub found: Vec<f64>,
    /// The upper limits, in the same order.
    pub limit: Vec<f64>,
    /// Unit of both: `%`, `points` of a per cent, `plants`, `s`.
    pub unit: &'static str,
    /// By how much the worst figure exceeds its limit, in that unit; reached if 0 or less. Infinite if a figure is NaN or
    /// there is none.
    pub missed_by: f64,
    /// Why it is missed, if it is.
    pub why: Option<&'static str>,
}

/// Head of a table of goals.
pub const GOAL_HEAD: [&str; 4] = ["asked for", "found", "at most", ""];

/// A figure of a row; NaN if JSON has no number for it.
pub fn figure(row: &Value, name: &str) -> f64 {
    row[name].as_f64().unwrap_or(f64::NAN)
}

/// A count in a row.
pub fn count(row: &Value, name: &str) -> usize {
    row[name].as_u64().map_or(0, |n| n as usize)
}

impl Goal {
    /// A goal from figures and their upper limits.
    pub fn new(
        asked: impl Into<String>,
        unit: &'static str,
        found_and_limit: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        let (found, limit): (Vec<f64>, Vec<f64>) = found_and_limit.into_iter().unzip();
        let over = found.iter().zip(&limit).map(|(f, l)| f - l);
        let missed_by = over
            .map(|over| if over.is_nan() { f64::INFINITY } else { over })
            .max_by(f64::total_cmp)
            .unwrap_or(f64::INFINITY);
        Self {
            asked: asked.into(),
            found,
            limit,
            unit,
            missed_by,
            why: None,
        }
    }

    /// Adds the reason to give if it is missed.
    #[must_use]
    pub fn or_because(mut self, why: &'static str) -> Self {
        self.why = (!self.reached()).then_some(why);
        self
    }

    /// Whether it is reached.
    pub fn reached(&self) -> bool {
        self.missed_by <= 0.0
    }

    /// The cells under [`GOAL_HEAD`].
    pub fn cells(&self) -> [String; 4] {
        let list = |x: &[f64]| match x {
            [first, rest @ ..] if rest.iter().all(|v| v == first) => self.number(*first),
            all => {
                let cells: Vec<String> = all.iter().map(|v| self.number(*v)).collect();
                cells.join("/")
            }
        };
        let said = if self.reached() {
            "reached".to_owned()
        } else {
            format!("missed by {} {}", self.number(self.missed_by), self.unit)
        };
        [
            self.asked.clone(),
            format!("{} {}", list(&self.found), self.unit),
            format!("{} {}", list(&self.limit), self.unit),
            said,
        ]
    }

    /// In a sentence, with the reason if there is one.
    pub fn sentence(&self) -> String {
        let [asked, found, limit, said] = self.cells();
        let why = self.why.map_or_else(String::new, |why| format!(": {why}"));
        format!("{asked}: {found}, asked for at most {limit}: {said}{why}.")
    }

    fn number(&self, x: f64) -> String {
        match self.unit {
            "plants" | "s" => format!("{x:.0}"),
            _ if x.abs() >= 10.0 => format!("{x:.1}"),
            _ => format!("{x:.2}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missed_says_by_how_much_and_why_and_nan_is_missed() {
        let reached = Goal::new("J4", "%", [(0.05, 0.1), (0.1, 0.1)]).or_because("never said");
        assert!(reached.reached() && reached.why.is_none());
        assert_eq!(
            reached.sentence(),
            "J4: 0.05/0.10 %, asked for at most 0.10 %: reached."
        );
        let missed = Goal::new("J2", "points", [(0.4, 0.5), (0.75, 0.5)]).or_because("it is so");
        assert!(!missed.reached());
        assert_eq!(
            missed.sentence(),
            "J2: 0.40/0.75 points, asked for at most 0.50 points: missed by 0.25 points: it is so."
        );
        assert!(!Goal::new("J1", "%", [(f64::NAN, 1.0), (0.5, 1.0)]).reached());
        assert!(!Goal::new("nothing was found", "%", []).reached());
    }
}
