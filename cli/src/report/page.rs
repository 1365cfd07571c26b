//! The page of every report, and the pieces that several have.

use crate::provenance::Provenance;
use crate::terminal::summary_columns;
use experiment::Experiment;
use experiment::summary::{Summary, TestVerdict};
use experiment::trace::{Response, Trace};
use std::fmt::Write as _;

/// A test as the report shows it.
#[derive(Clone, Copy, Debug)]
pub struct TestSection<'a> {
    /// What was tested.
    pub experiment: &'a Experiment,
    /// Its figures.
    pub summary: &'a Summary,
    /// Its trace.
    pub trace: &'a Trace,
    /// The ideal it is compared with.
    pub ideal: &'a Response,
}

/// What was tested, how long, and under which compensation.
pub(super) fn lead(s: &TestSection<'_>) -> String {
    let c = &s.experiment.test.config;
    let floors = match (c.degrees_of_freedom(), c.physical_storeys()) {
        (n, _) if s.trace.interface.is_some() => format!(
            "Two coupled actuators move the interface of {n} degrees of freedom in x and in rotation"
        ),
        (1, _) => "One degree of freedom".to_owned(),
        (n, p) if n == p => format!("{n} degrees of freedom, an actuator at each"),
        (n, p) => format!("{n} degrees of freedom, {p} of them in the laboratory"),
    };
    let pace = match c.timing.time_scale {
        1.0 => "in real time".to_owned(),
        scale => format!("{scale} times slower than real time"),
    };
    format!(
        "{floors}, {} Hz, {pace}. {:.1} s of the ground motion {}{}, compensation <b>{}</b>.",
        c.timing.rate_hz,
        s.summary.steps as f64 / c.timing.rate_hz / c.timing.time_scale,
        escape(&s.summary.record),
        match s.experiment.scale {
            1.0 => String::new(),
            scale => format!(" times {scale:.3}"),
        },
        s.summary.compensation,
    )
}

/// The tests that completed first, then by their error.
pub(super) fn rank<T>(tests: &mut [&T], of: impl Fn(&T) -> (TestVerdict, f64)) {
    let wrong = |test: &T| {
        let (verdict, eps_rms) = of(test);
        (verdict != TestVerdict::Completed, eps_rms)
    };
    tests.sort_by(|a, b| {
        let (a, b) = (wrong(a), wrong(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
}

/// Figures side by side, each with what it means.
pub(super) fn tiles(all: &[(String, &str)]) -> String {
    format!("<div class=\"tiles\">{}</div>", each_tile(all))
}

/// The same without the box around them.
pub(super) fn each_tile(all: &[(String, &str)]) -> String {
    let tile = |(value, meaning): &(String, &str)| {
        format!("<div class=\"tile\"><b>{value}</b><span>{meaning}</span></div>")
    };
    all.iter().map(tile).collect()
}

/// One row a test, as on the terminal, with a dot that says what it is worth.
pub(super) fn table(rows: &[Summary]) -> String {
    let (columns, _) = summary_columns(rows);
    let mut html = String::from("<div class=\"scroll\"><table><tr>");
    for (head, _) in &columns {
        let _ = write!(html, "<th>{head}</th>");
    }
    for s in rows {
        html += "</tr><tr>";
        for (head, cell) in &columns {
            let dot = match *head {
                "compensation" => format!("<span class=\"dot {}\"></span>", s.validity().class()),
                _ => String::new(),
            };
            let _ = write!(html, "<td>{dot}{}</td>", escape(&cell(s)));
        }
    }
    html += "</tr></table></div><p>eps_max and eps_rms are Eqs 17 and 18 of the paper: the difference to the same \
             integration with an ideal actuator, relative to the largest ideal displacement.</p>";
    html
}

/// The test file, as it was used.
pub(super) fn test_file(text: &str) -> String {
    format!(
        "<h2>The test file, as it was used</h2><pre class=\"file\">{}</pre>",
        escape(text.trim())
    )
}

/// Who, when, with what: at the end of every report.
fn origin(p: &Provenance) -> String {
    let mut html = String::from("<div class=\"origin\"><dl>");
    let mut line = |name: &str, value: &str| {
        let _ = write!(html, "<dt>{name}</dt><dd>{}</dd>", escape(value));
    };
    line("date", &p.date);
    line("operator", &format!("{} on {}", p.operator, p.machine));
    line("command", &p.command);
    line("in", &p.folder);
    if let Some(seed) = p.seed {
        line("seed", &seed.to_string());
    }
    for file in &p.files {
        line(&escape(&file.file), &format!("SHA-256 {}", file.sha256));
    }
    line(
        "program",
        &format!("{}, SHA-256 {}", p.version, p.program_sha256),
    );
    html + "</dl></div>"
}

pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

pub(super) fn page(title: &str, lead: &str, body: &str) -> String {
    let title = escape(title);
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width,initial-scale=1\"><title>{title}</title><style>{}</style></head><body>\
         <h1>{title}</h1><p class=\"lead\">{lead}</p>{body}{}<script>{}</script></body></html>\n",
        include_str!("style.css"),
        origin(Provenance::of_this_run()),
        include_str!("zoom.js"),
    )
}
