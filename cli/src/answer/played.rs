//! A signal that moved the actuator instead of a test.

use super::served::ShownFloor;
use crate::document::{Document, Grade};
use experiment::bench::Played;
use experiment::numbers::{length, three};

/// The result of the signal `name`; the page shows its record if it is long enough.
pub fn of_played(name: &str, played: &Played, with_page: bool) -> Document {
    let lead = "The actuator played a signal and nothing was integrated.";
    let mut d = Document::new("A signal instead of a test", lead, with_page);
    let grade = played.early.as_ref().map_or(Grade::Good, |_| Grade::Bad);
    let (to_m, to_n) = (length(played.peak_m), three(1e-3 * played.peak_n));
    let steps = played.steps;
    d.verdict(
        grade,
        format!("{steps} steps of {name}: up to {to_m} and {to_n} kN."),
    );
    if let Some(why) = &played.early {
        d.explain(format!("The signal ended early: {why}."));
    }
    let record = with_page.then(|| played.recording().ok()).flatten();
    let columns =
        record.and_then(|r| Some((r.time_s, r.command_mm?, r.displacement_mm?, r.force_n?)));
    if let Some((time_s, command_mm, displacement_mm, force_n)) = columns {
        let metres = |mm: Vec<f64>| mm.iter().map(|mm| (1e-3 * mm) as f32).collect::<Vec<_>>();
        let force: Vec<f32> = force_n.iter().map(|n| *n as f32).collect();
        let shown = ShownFloor {
            heading: "Displacement".to_owned(),
            units: ["mm", "kN"],
            target: &metres(command_mm),
            displacement: &metres(displacement_mm),
            force: &force,
        };
        shown.draw(&mut d, |i| time_s[i]);
    }
    d
}
