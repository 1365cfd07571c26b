//! A designed test on the terminal.

use super::tables::{Table, table};
use crate::wording::{self, digits, quantity};
use diagnosis::{Form, Next, Outlook, Phase};
use experiment::numbers::percent;
use std::fmt::Write as _;

/// Its limits, its phases, and what each possible cause predicts.
pub fn next(n: &Next) -> String {
    let mut text = format!(
        "{}\n{}\n\n{}\n",
        wording::plan::summary(n),
        wording::plan::limits(n),
        table_of(
            "phase of the next test",
            PHASE_HEAD,
            n.phases.iter().map(phase_row)
        )
    );
    for o in &n.channels {
        let _ = writeln!(text, "\n{}", wording::plan::expectation(o));
        let channel = o.channel.name();
        if o.candidates.len() > 1 {
            let first = format!("if it is, in the {channel},");
            let t = table_of(&first, PREDICTION_HEAD, prediction_rows(o));
            let _ = writeln!(text, "\n{t}");
        } else if !o.parameters.is_empty() {
            let first = format!("number of the {channel}");
            let t = table_of(&first, NUMBER_HEAD, number_rows(o));
            let _ = writeln!(text, "\n{t}");
        }
    }
    text
}

/// Head of [`phase_row`].
pub const PHASE_HEAD: [&str; 5] = ["phase", "amplitude", "top speed", "frequency", "takes"];

/// A phase in a row.
pub fn phase_row(p: &Phase) -> Vec<String> {
    let or_none = |x: f64, unit: &str| match x {
        0.0 => "-".to_owned(),
        x => quantity(x, unit),
    };
    let frequency = match p.form {
        Form::Chirp => format!("to {}", quantity(p.frequency_hz, "Hz")),
        _ => or_none(p.frequency_hz, "Hz"),
    };
    vec![
        p.form.in_words().to_owned(),
        or_none(p.amplitude_mm, "mm"),
        or_none(p.speed_mm_per_s, "mm/s"),
        frequency,
        quantity(p.seconds, "s"),
    ]
}

/// Head of [`prediction_rows`].
pub const PREDICTION_HEAD: [&str; 6] = [
    "if it is",
    "probability",
    "peak",
    "area of the loops",
    "apart from the first, rms",
    "stays apart by",
];

/// What each possible cause predicts, in a row.
pub fn prediction_rows(o: &Outlook) -> impl Iterator<Item = Vec<String>> {
    o.candidates.iter().map(|c| {
        vec![
            wording::plan::name(c).to_owned(),
            c.probability.map_or_else(|| "?".into(), percent),
            quantity(c.peak, &o.unit),
            quantity(c.loop_area, &wording::plan::area_unit(o)),
            quantity(c.apart_rms, &o.unit),
            c.separation.map_or_else(
                || "-".into(),
                |s| format!("{} times what is left", digits(s)),
            ),
        ]
    })
}

/// Head of [`number_rows`].
pub const NUMBER_HEAD: [&str; 4] = ["number", "value", "known to, 90 %", "with the next test"];

/// Each number of a model, how well it is known and will be, in a row.
pub fn number_rows(o: &Outlook) -> impl Iterator<Item = Vec<String>> {
    o.parameters.iter().map(|p| {
        vec![
            p.name.clone(),
            digits(p.value),
            format!("+- {}", digits(p.half_now)),
            format!("+- {}", digits(p.half_then)),
        ]
    })
}

/// A table whose first column is called `first`.
fn table_of<'a, const C: usize>(
    first: &'a str,
    mut head: [&'a str; C],
    rows: impl Iterator<Item = Vec<String>>,
) -> Table {
    head[0] = first;
    let mut t = table(&head);
    t.add_rows(rows);
    t
}
