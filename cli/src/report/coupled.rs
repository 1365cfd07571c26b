//! The page of the diagnosis of a specimen of several coordinates.

use super::figures;
use super::page::{escape, page};
use super::plot::{Curve, IDEAL, TESTED, WIDE, WRONG, history, plot};
use super::rths::table;
use crate::terminal::coupled::{ERROR_HEAD, WRONG_HEAD, error_row, headline, wrong_rows};
use diagnosis::{CoordinateAnswer, CoupledDiagnosis};
use std::fmt::Write as _;

/// The report.
pub fn of_coupled(title: &str, d: &CoupledDiagnosis, [declared, improved]: [&str; 2]) -> String {
    let mut html = String::new();
    for c in &d.coordinates {
        let _ = write!(html, "<p><b>{}</b></p>", escape(&headline(c)));
        for note in &c.notes {
            let _ = write!(html, "<p>{}</p>", escape(note));
        }
    }
    let wrong: Vec<Vec<String>> = d.coordinates.iter().flat_map(wrong_rows).collect();
    if !wrong.is_empty() {
        html += "<h2>What is not as declared</h2>";
        html += &table(&WRONG_HEAD, wrong.into_iter());
    }
    html += "<h2>Errors on held-out data</h2>";
    html += &table(&ERROR_HEAD, d.coordinates.iter().map(error_row));
    for c in &d.coordinates {
        html += &forces(c);
    }
    let _ = write!(
        html,
        "<h2>The models</h2><h3>As declared</h3><div class=\"scroll\"><pre class=\"file\">{}</pre></div><h3>With what was \
         found</h3><div class=\"scroll\"><pre class=\"file\">{}</pre></div>",
        escape(declared.trim()),
        escape(improved.trim())
    );
    let lead = format!(
        "The force on each coordinate is compared with stiffness, damping and mass times the motion of all coordinates, up to \
         {:.0} Hz. An entry is named where the record contradicts it beyond its tolerance and the record's own uncertainty.",
        d.cutoff_hz
    );
    page(title, &lead, &html)
}

fn forces(c: &CoordinateAnswer) -> String {
    let t = &c.traces;
    let over = |force: &[f64]| history(force.len(), |k| (k as f64 * t.interval_s, force[k]));
    let curves = [
        Curve::new(IDEAL, over(&t.measured))
            .named("measured")
            .thick(),
        Curve::new(WRONG, over(&t.declared)).named("as declared"),
        Curve::new(TESTED, over(&t.found)).named("as found"),
    ];
    let label = format!("force on {} [{}]", c.coordinate, c.unit);
    let svg = plot(WIDE, "time of the held-out data [s]", &label, &curves);
    figures::figure(
        &svg,
        "Held-out data, behind the low-pass that the comparison uses.",
    )
}
