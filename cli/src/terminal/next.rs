//! A designed test on the terminal.

use super::tables::{Table, table};
use crate::wording::{self, digits, quantity};
use comfy_table::CellAlignment;
use diagnosis::{Form, Next, Outlook};
use experiment::numbers::percent;
use std::fmt::Write as _;

/// Its limits, its phases, and what each possible cause predicts.
pub fn next(n: &Next) -> String {
    let mut text = format!(
        "{}\n{}\n\n{}\n",
        wording::plan::summary(n),
        wording::plan::limits(n),
        phases(n)
    );
    for o in &n.channels {
        let _ = writeln!(text, "\n{}", wording::plan::expectation(o));
        if o.candidates.len() > 1 {
            let _ = writeln!(text, "\n{}", predictions(o));
        } else if !o.parameters.is_empty() {
            let _ = writeln!(text, "\n{}", parameter_table(o));
        }
    }
    text
}

fn phases(n: &Next) -> Table {
    let mut t = table(&[
        "phase of the next test",
        "amplitude",
        "top speed",
        "frequency",
        "takes",
    ]);
    let or_none = |x: f64, unit: &str| match x {
        0.0 => "-".to_owned(),
        x => quantity(x, unit),
    };
    for p in &n.phases {
        let frequency = match p.form {
            Form::Chirp => format!("to {}", quantity(p.frequency_hz, "Hz")),
            _ => or_none(p.frequency_hz, "Hz"),
        };
        t.add_row([
            p.form.in_words().to_owned(),
            or_none(p.amplitude_mm, "mm"),
            or_none(p.speed_mm_per_s, "mm/s"),
            frequency,
            quantity(p.seconds, "s"),
        ]);
    }
    t
}

fn predictions(o: &Outlook) -> Table {
    let mut t = table(&[
        &format!("if it is, in the {},", o.channel.name()),
        "probability",
        "peak",
        "area of the loops",
        "apart from the first, rms",
        "stays apart by",
    ]);
    if let Some(column) = t.column_mut(0) {
        column.set_cell_alignment(CellAlignment::Left);
    }
    for c in &o.candidates {
        t.add_row([
            wording::plan::name(c).to_owned(),
            c.probability.map_or_else(|| "?".into(), percent),
            quantity(c.peak, &o.unit),
            quantity(c.loop_area, &wording::plan::area_unit(o)),
            quantity(c.apart_rms, &o.unit),
            c.separation.map_or_else(
                || "-".into(),
                |s| format!("{} times what is left", digits(s)),
            ),
        ]);
    }
    t
}

fn parameter_table(o: &Outlook) -> Table {
    let mut t = table(&[
        &format!("number of the {}", o.channel.name()),
        "value",
        "known to, 90 %",
        "with the next test",
    ]);
    if let Some(column) = t.column_mut(0) {
        column.set_cell_alignment(CellAlignment::Left);
    }
    for p in &o.parameters {
        t.add_row([
            p.name.clone(),
            digits(p.value),
            format!("+- {}", digits(p.half_now)),
            format!("+- {}", digits(p.half_then)),
        ]);
    }
    t
}
