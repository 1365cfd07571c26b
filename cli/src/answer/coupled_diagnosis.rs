//! The diagnosis of a specimen with several coordinates.

use super::diagnosis::models;
use crate::document::plot::{Curve, IDEAL, TESTED, WIDE, WRONG, history, plot};
use crate::document::{Document, table};
use diagnosis::{CoordinateAnswer, CoupledDiagnosis, CoupledVerdict};
use experiment::numbers::{percent, si, three};

/// A diagnosis.
pub fn of_coupled(
    title: &str,
    diagnosis: &CoupledDiagnosis,
    declared_and_found: [&str; 2],
    with_page: bool,
) -> Document {
    let lead = format!(
        "The force on each coordinate is compared with stiffness, damping and mass times the motion of all coordinates, up to \
         {:.0} Hz. An entry is named where the record contradicts it beyond its tolerance and the record's own uncertainty.",
        diagnosis.cutoff_hz
    );
    let mut d = Document::new(title, lead, with_page);
    verdicts(&mut d, diagnosis);
    d.tell(format!(
        "Motion and forces up to {:.0} Hz. Diagnosed in {:.2} s.",
        diagnosis.cutoff_hz, diagnosis.seconds
    ));
    diagnosis.coordinates.iter().for_each(|c| forces(&mut d, c));
    models(&mut d, declared_and_found);
    d
}

/// Verdicts, wrong entries and errors.
pub(super) fn verdicts(d: &mut Document, diagnosis: &CoupledDiagnosis) {
    for c in &diagnosis.coordinates {
        d.say(headline(c));
        let unsure = c.wrong.iter().filter(|w| !w.alternatives.is_empty());
        let unsure = unsure.map(|w| {
            format!(
                "In place of {} by {} the record is explained as well by: {}",
                w.matrix,
                w.by,
                w.alternatives.join(", ")
            )
        });
        d.items(c.notes.iter().cloned().chain(unsure).collect());
    }
    let head = [
        "force on",
        "entry",
        "by",
        "declared",
        "tolerance",
        "found",
        "90 % interval",
    ];
    if diagnosis.coordinates.iter().any(|c| !c.wrong.is_empty()) {
        d.heading("What is not as declared");
        let rows = diagnosis.coordinates.iter().flat_map(wrong_rows);
        let entries = table(&head).with_words(3).least_important(&[4, 6]);
        d.table(entries.with_rows(rows));
    }
    d.heading("Errors on held-out data");
    let head = [
        "force on",
        "error before, held out",
        "of the force",
        "error after, held out",
        "of the force",
    ];
    d.table(table(&head).with_rows(diagnosis.coordinates.iter().map(error_row)));
}

/// One row per wrong entry.
fn wrong_rows(c: &CoordinateAnswer) -> Vec<Vec<String>> {
    let row = |w: &diagnosis::WrongEntry| {
        vec![
            c.coordinate.clone(),
            w.matrix.to_owned(),
            w.by.clone(),
            format!("{} {}", three(w.declared), w.unit),
            three(w.tolerance),
            format!("{} {}", three(w.value), w.unit),
            format!("{} to {}", three(w.ci90[0]), three(w.ci90[1])),
        ]
    };
    c.wrong.iter().map(row).collect()
}

/// The errors of a coordinate.
fn error_row(c: &CoordinateAnswer) -> Vec<String> {
    let share = |x: f64| match x.is_finite() {
        true => percent(x),
        false => "no force".into(),
    };
    vec![
        c.coordinate.clone(),
        si(c.error_before.test_rms, c.unit),
        share(c.error_before.test_nrmse),
        si(c.error_after.test_rms, c.unit),
        share(c.error_after.test_nrmse),
    ]
}

/// The verdict in one sentence.
fn headline(c: &CoordinateAnswer) -> String {
    let entries = match c.wrong.len() {
        1 => "one entry is".to_owned(),
        n => format!("{n} entries are"),
    };
    let name = &c.coordinate;
    match c.verdict {
        CoupledVerdict::None => format!("{name}: the force fits what is declared."),
        CoupledVerdict::Effect => format!("{name}: {entries} not what was declared."),
        CoupledVerdict::Ambiguous => format!(
            "{name}: {entries} not what was declared, and this motion cannot tell which from others."
        ),
        CoupledVerdict::Partial => format!(
            "{name}: {entries} not what was declared, and {} of the force is left: no constant matrix explains it.",
            percent(c.error_after.test_nrmse)
        ),
        CoupledVerdict::Unknown => format!(
            "{name}: {} of the force is not explained, and no constant matrix explains it.",
            percent(c.error_after.test_nrmse)
        ),
    }
}

fn forces(d: &mut Document, c: &CoordinateAnswer) {
    let caption = "Held-out data, behind the low-pass that the comparison uses.";
    d.figure(caption, || {
        let t = &c.traces;
        let over = |force: &[f64]| history(force.len(), |k| (k as f64 * t.interval_s, force[k]));
        let measured = Curve::new(IDEAL, over(&t.measured));
        let curves = [
            measured.named("measured").thick(),
            Curve::new(WRONG, over(&t.declared)).named("as declared"),
            Curve::new(TESTED, over(&t.found)).named("as found"),
        ];
        let label = format!("force on {} [{}]", c.coordinate, c.unit);
        plot(WIDE, "time of the held-out data [s]", &label, &curves)
    });
}
