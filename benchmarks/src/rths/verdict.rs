//! What was to be beaten and to be reached, and by how much it is.

use super::bench::RthsRow;
use super::rules::Rules;
use serde::Serialize;

/// A statement with its figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Statement {
    /// What is asked.
    pub asked: String,
    /// What was found, per cent, cases 1 to 4.
    pub found: [f64; 4],
    /// What was asked for, per cent.
    pub limit: [f64; 4],
    /// By how much the worst case misses it, points; 0 or less is reached.
    pub missed_by: f64,
    /// Nobody was lost, where that is part of it.
    pub none_lost: bool,
}

impl Statement {
    /// It is reached.
    pub fn reached(&self) -> bool {
        self.missed_by <= 0.0 && self.none_lost
    }

    /// In a sentence.
    pub fn sentence(&self) -> String {
        let list = |x: &[f64; 4]| x.map(|v| format!("{v:.2}")).join("/");
        let said = if self.reached() {
            "reached".to_owned()
        } else if self.none_lost {
            format!("missed by {:.2} points", self.missed_by)
        } else {
            "missed: a plant was lost".to_owned()
        };
        format!(
            "{}: {} % of {} % asked: {said}.",
            self.asked,
            list(&self.found),
            list(&self.limit)
        )
    }
}

/// The setting of the delay corrector in which the structure is right.
pub const RIGHT_STRUCTURE: &str = "hydraulic/mu=1.5";
/// The setting in which some of that is given for tracking.
pub const RIGHT_TRACKING: &str = "hydraulic/mu=0.78/lead=0.5";

/// A figure of a row.
type Figure = fn(&RthsRow) -> f64;

/// All that can be said of these rows: by official rules, El Centro, 20 perturbed plants and more.
pub fn targets(rules: &Rules, rows: &[RthsRow]) -> Vec<Statement> {
    if *rules != Rules::official() {
        return Vec::new();
    }
    let asked: [(&str, &str, Figure, [f64; 4], bool); 6] = [
        (
            "J4 as read, against the best known before (adaptive model-based, one sample of lead)",
            RIGHT_STRUCTURE,
            |r| r.j[3],
            [2.72, 2.55, 1.91, 2.28],
            false,
        ),
        (
            "J4 as read of the worst perturbed plant, against the best known before",
            RIGHT_STRUCTURE,
            |r| r.j4_worst,
            [2.8, 2.6, 2.0, 2.4],
            true,
        ),
        (
            "J4 as read of the worst perturbed plant",
            RIGHT_STRUCTURE,
            |r| r.j4_worst,
            [2.6, 2.45, 1.65, 2.1],
            true,
        ),
        (
            "J4 of the true displacement",
            RIGHT_STRUCTURE,
            |r| r.j4_true,
            [0.1; 4],
            false,
        ),
        (
            "J2 of the true displacement in the other setting",
            RIGHT_TRACKING,
            |r| r.j2_true,
            [0.8; 4],
            false,
        ),
        (
            "J4 of the true displacement in the other setting",
            RIGHT_TRACKING,
            |r| r.j4_true,
            [0.5; 4],
            false,
        ),
    ];
    asked
        .into_iter()
        .filter_map(|(asked, controller, figure, limit, perturbed)| {
            let own: Vec<&RthsRow> = rows
                .iter()
                .filter(|r| r.controller == controller && r.record == "ElCentro")
                .collect();
            let own: [&RthsRow; 4] = own.try_into().ok()?;
            if perturbed && own.iter().any(|r| r.perturbed < 20) {
                return None;
            }
            let found = own.map(figure);
            let missed = found.iter().zip(limit).map(|(f, l)| f - l);
            Some(Statement {
                asked: format!("{controller}, {asked}"),
                found,
                limit,
                missed_by: missed.fold(f64::NEG_INFINITY, f64::max),
                none_lost: !perturbed || own.iter().all(|r| r.lost == 0),
            })
        })
        .collect()
}

/// Differences of J4 below this are a tie, points: another draw of the noise moves J4 as read by as much.
pub const TIE: f64 = 0.05;

/// Who has the least J4 as read, the mean of all cases and records, and who is as good: names, the best first.
pub fn best(rows: &[RthsRow]) -> Vec<String> {
    let mut names: Vec<&str> = Vec::new();
    for row in rows {
        if !names.contains(&row.controller.as_str()) {
            names.push(&row.controller);
        }
    }
    let mean = |name: &str| {
        let own = rows.iter().filter(|r| r.controller == name);
        let (sum, n) = own.fold((0.0, 0.0), |(sum, n), r| (sum + r.j[3], n + 1.0));
        sum / n
    };
    let mut ranked: Vec<(f64, &str)> = names.iter().map(|name| (mean(name), *name)).collect();
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
