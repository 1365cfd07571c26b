//! A diagnosis on the terminal.

use super::tables::{Table, table};
use crate::improve::Improvement;
use crate::wording::{
    corrected, depends_on, digits, headline, next, parameter, predicted, quantity, refitted, rest,
    sureness, verdict,
};
use diagnosis::{ChannelAnswer, Diagnosis};
use experiment::numbers::percent;
use std::fmt::Write as _;

/// Effects that are listed as tried.
const LISTED: usize = 6;

/// Verdicts, errors, effects and what to do next.
pub fn diagnosis(d: &Diagnosis) -> String {
    let mut text = String::new();
    for a in &d.channels {
        let _ = writeln!(text, "{}", headline(a));
        if let Some(sentence) = sureness(a) {
            let _ = writeln!(text, "    {sentence}");
        }
        for e in &a.effects {
            for p in &e.parameters {
                let _ = writeln!(text, "    {:22} {}", e.name.name(), parameter(p));
            }
        }
        // The first note says in figures what the headline has said.
        for note in a.notes.iter().skip(1) {
            let _ = writeln!(text, "    {note}");
        }
        for sentence in rest(a)
            .into_iter()
            .chain(corrected(a))
            .chain(predicted(a))
            .chain(refitted(a))
            .chain(next(a))
        {
            let _ = writeln!(text, "    {sentence}");
        }
        text.push('\n');
    }
    let _ = writeln!(text, "{}", errors(&d.channels));
    for a in &d.channels {
        if let Some(table) = shares(a) {
            let _ = writeln!(text, "\n{table}");
        }
    }
    for a in d.channels.iter().filter(|a| !a.tried.is_empty()) {
        let _ = writeln!(text, "\n{}", candidate_table(a));
    }
    let _ = write!(text, "Diagnosed in {:.2} s.", d.seconds);
    text
}

/// One row a story.
pub fn improvements(stories: &[(String, &Improvement)]) -> Table {
    let mut t = table(&[
        "test",
        "undeclared",
        "found",
        "eps_rms before",
        "after",
        "without the effect",
        "the second test is",
        "then missing",
    ])
    .with_words(3);
    for (name, s) in stories {
        t.add_row([
            name.clone(),
            s.undeclared(),
            Improvement::named(&s.diagnosis),
            percent(s.before.summary.eps_rms),
            percent(s.after.summary.eps_rms),
            s.possible
                .as_ref()
                .map_or_else(|| "?".into(), |r| percent(r.summary.eps_rms)),
            s.outcome().name().to_owned(),
            Improvement::named(&s.remains),
        ]);
    }
    t
}

/// Errors on the held-out data: narrow enough for 80 columns.
fn errors(channels: &[ChannelAnswer]) -> Table {
    let mut t = table(&[
        "held out, rms",
        "verdict",
        "declared",
        "refitted",
        "improved",
        "noise",
        "fall, 90 %",
    ])
    .with_words(2);
    for a in channels {
        let rms = |x: f64| quantity(x, &a.unit);
        t.add_row([
            a.channel.name().to_owned(),
            verdict(a.verdict).to_owned(),
            rms(a.error_declared.test_rms),
            rms(a.error_before.test_rms),
            rms(a.error_after.test_rms),
            rms(a.noise_floor_rms),
            if a.effects.is_empty() {
                "-".to_owned()
            } else {
                format!(
                    "{} to {}",
                    digits(a.improvement_ci90[0]),
                    digits(a.improvement_ci90[1])
                )
            },
        ]);
    }
    t
}

/// What the rest depends on.
fn shares(a: &ChannelAnswer) -> Option<Table> {
    let r = a.remainder.as_ref()?;
    if r.shares.is_empty() && r.lines.is_empty() {
        return None;
    }
    let head = format!("residual of the {}: depends on", a.channel.name());
    let mut t = table(&[&head, "share of squares", "odd", "even"]);
    let part = |x: f64| if x > 0.0 { percent(x) } else { "-".into() };
    for s in &r.shares {
        t.add_row([
            depends_on(s.depends_on, a.channel).to_owned(),
            percent(s.share),
            part(s.odd),
            part(s.even),
        ]);
    }
    for l in &r.lines {
        t.add_row([
            format!("a line at {} Hz", digits(l.frequency_hz)),
            percent((l.rms / r.rms).powi(2)),
            "-".to_owned(),
            "-".to_owned(),
        ]);
    }
    Some(t)
}

fn candidate_table(a: &ChannelAnswer) -> Table {
    let mut t = table(&[
        &format!("tried in the {}", a.channel.name()),
        "left, rms",
        "evidence (fall of BIC)",
    ]);
    let (listed, others) = a.tried.split_at(a.tried.len().min(LISTED));
    let nearest = a.nearest.as_ref().map(|n| n.name);
    let named = others.iter().find(|e| Some(e.name) == nearest);
    for e in listed.iter().chain(named) {
        t.add_row([
            e.name.name().to_owned(),
            quantity(e.rms_left, &a.unit),
            format!("{:.0}", e.bic_gain),
        ]);
    }
    t
}
