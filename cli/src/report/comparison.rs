//! The page of the bench of all compensations.

use super::figures::{Figures, figure};
use super::page::{TestSection, escape, page, rank, table as summaries, test_file};
use super::plot;
use super::plot::{Colour, Curve, FIFTH, FOURTH, GROUND, HALF, TESTED, THIRD, WRONG};
use super::rths::table;
use crate::comparison::compared_test::ComparedTest;
use crate::comparison::condition::{ACTUATORS, Family};
use crate::comparison::standing::{self, Standing};
use crate::terminal::{percent, standings_head, standings_row};
use experiment::summary::Summary;
use std::fmt::Write as _;

/// What the plots show; more curves would hide each other.
const SHOWN: [(&str, Colour); 6] = [
    ("none", GROUND),
    ("paper", WRONG),
    ("lagrange", FOURTH),
    ("ats", THIRD),
    ("tangent", FIFTH),
    ("tangent+ats", TESTED),
];

/// Curves of a comparison beside the ideal one.
const BESIDE: [Colour; 5] = [TESTED, WRONG, THIRD, FOURTH, FIFTH];

/// The same test under several compensations: the closer look first, then a row each.
pub fn of_compare(sections: &[TestSection<'_>]) -> String {
    let mut html = String::new();
    let mut records: Vec<&str> = sections.iter().map(|s| s.summary.record.as_str()).collect();
    records.dedup();
    for record in records {
        let own = || sections.iter().filter(|s| s.summary.record == record);
        let mut ranked: Vec<&TestSection<'_>> = own().collect();
        rank(&mut ranked, |s| (s.summary.verdict, s.summary.eps_rms));
        let _ = write!(html, "<h2>{}</h2>", escape(record));
        if let Some(best) = ranked.first() {
            html += &verdict_of_best(best);
            // The best, and the worst as what they are seen against.
            let mut shown: Vec<&TestSection<'_>> =
                ranked.iter().take(BESIDE.len() - 1).copied().collect();
            shown.extend(ranked.iter().skip(shown.len()).last());
            html += &Figures::of(best).overlay(&shown, &BESIDE);
        }
        let rows: Vec<Summary> = own().map(|s| s.summary.clone()).collect();
        html += &summaries(&rows);
    }
    if let Some(first) = sections.first() {
        html += &test_file(&first.experiment.test.text);
    }
    page(
        "One test under several compensations",
        &format!(
            "{} tests. A dot is good, a diamond fair, a triangle not the structure's response.",
            sections.len()
        ),
        &html,
    )
}

fn verdict_of_best(best: &TestSection<'_>) -> String {
    format!(
        "<p class=\"verdict {}\"><b>{}</b> comes nearest. {}</p>",
        best.summary.validity().class(),
        best.summary.compensation,
        escape(&best.summary.sentence())
    )
}

/// The bench: standings, errors over the delay, every condition.
pub fn of_comparison(rows: &[ComparedTest], lead: &str) -> String {
    let standings = standing::of(rows);
    let mut html = standings.first().map_or_else(String::new, nearest);
    html += "<p>Every compensation on the same tests. An error is eps_rms, Eq 18: the rms of the difference to the same \
             integration with an ideal actuator, relative to its largest displacement. Means are geometric; a test that \
             tripped or ran away counts as 100 %.</p>";
    html += "<h2>Error over the delay</h2><p>The worse of the ground motions. The configured delay is exact.</p>";
    for family in [Family::Linear, Family::Yielding] {
        let _ = write!(
            html,
            "<h3>Specimen: {}</h3><div class=\"pair\">",
            family.name()
        );
        for (actuator, _) in ACTUATORS {
            html += &over_delay(rows, family, actuator);
        }
        html += "</div>";
    }
    html += "<h2>Standings</h2><p>The best mean comes first.</p>";
    html += &table(&standings_head(), standings.iter().map(standings_row));
    html += "<h2>Every condition</h2><p>The worse of the ground motions.</p>";
    html += &conditions(rows, &standings);
    page("Compensations on one bench", lead, &html)
}

/// Who is the nearest over all, and how often nobody was nearer.
fn nearest(best: &Standing) -> String {
    let class = if best.failed == 0 { "good" } else { "fair" };
    format!(
        "<p class=\"verdict {class}\"><b>{}</b> comes nearest over all: a mean error of {}, {} at worst; in {} of {} tests nobody \
         is nearer, and {} of them it loses.</p>",
        best.compensation,
        percent(best.mean),
        percent(best.worst),
        best.best_in,
        best.tests,
        if best.failed == 0 {
            "none".to_owned()
        } else {
            best.failed.to_string()
        }
    )
}

/// The larger error of all ground motions.
fn worse(rows: &[ComparedTest], condition: &str, compensation: &str) -> f64 {
    rows.iter()
        .filter(|r| r.condition == condition && r.summary.compensation == compensation)
        .map(ComparedTest::error)
        .fold(0.0, f64::max)
}

fn over_delay(rows: &[ComparedTest], family: Family, actuator: &str) -> String {
    let mut places: Vec<(f64, &str)> = Vec::new();
    for row in rows.iter().filter(|r| r.family == family) {
        if row.condition.contains(actuator) && places.iter().all(|p| p.1 != row.condition) {
            places.push((row.delay_ms, &row.condition));
        }
    }
    let present = |name: &str| rows.iter().any(|r| r.summary.compensation == name);
    let curves: Vec<Curve> = SHOWN
        .into_iter()
        .filter(|(name, _)| present(name))
        .map(|(name, colour)| {
            let point = |(ms, condition): &(f64, &str)| {
                (*ms, worse(rows, condition, name).max(1e-6).log10())
            };
            Curve::new(colour, places.iter().map(point).collect()).named(name)
        })
        .collect();
    let svg = plot::plot(HALF.of_percent(), "delay [ms]", "eps_rms [%]", &curves);
    figure(&svg, &format!("Actuator: {actuator}."))
}

fn conditions(rows: &[ComparedTest], standings: &[Standing]) -> String {
    let mut names: Vec<&str> = Vec::new();
    for row in rows {
        if !names.contains(&row.condition.as_str()) {
            names.push(&row.condition);
        }
    }
    let mut head = vec!["condition"];
    head.extend(standings.iter().map(|s| s.compensation));
    let cells = |condition: &&str| {
        let errors = standings
            .iter()
            .map(|s| percent(worse(rows, condition, s.compensation)));
        [(*condition).to_owned()]
            .into_iter()
            .chain(errors)
            .collect()
    };
    table(&head, names.iter().map(cells))
}
