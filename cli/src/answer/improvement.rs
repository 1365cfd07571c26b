//! A test, the diagnosis of its record, and the improved test.

use super::figures::Figures;
use super::section::TestSection;
use super::{diagnosis, next};
use crate::document::{Document, table};
use crate::improve::Improvement;
use crate::wording::{headline, plan, sureness};
use ::diagnosis::{ChannelAnswer, Verdict};
use experiment::Experiment;
use experiment::judged::JudgedRun;
use experiment::numbers::percent;
use experiment::summary::GOOD_EPS_RMS;

/// Tests whose records were diagnosed, and the improved tests.
pub fn of_improvements(improvements: &[(String, &Improvement)], with_page: bool) -> Document {
    let lead = "A test runs on a rig that has something in it that nobody declared. Its record is diagnosed, what was found goes \
                into the next test, and that test is judged by the same ideal.";
    let mut d = Document::new("From a record to a better test", lead, with_page);
    d.on_terminal(|d| {
        for (name, improvement) in improvements {
            d.say(name);
            in_short(d, improvement);
        }
    });
    table_of(&mut d, improvements);
    d.on_page(|d| {
        for (name, improvement) in improvements {
            section(d, &format!("Test {name}"), improvement);
        }
    });
    d
}

/// What was found, what was not settled, and what was changed.
pub(super) fn in_short(d: &mut Document, improvement: &Improvement) {
    let channel = |c: &ChannelAnswer| [headline(c)].into_iter().chain(sureness(c));
    let mut lines: Vec<String> = Vec::new();
    for c in &improvement.first.channels {
        lines.extend(channel(c));
        // If nothing is near, the note gives the reason.
        if c.verdict == Verdict::Unknown && c.nearest.is_none() {
            lines.extend(c.notes.iter().cloned());
        }
    }
    for designed in &improvement.designed {
        lines.push(format!("Not settled: {}", plan::summary(&designed.next)));
        lines.push(plan::limits(&designed.next));
        lines.extend(designed.diagnosis.channels.iter().flat_map(channel));
    }
    let changes = improvement.changes.iter();
    lines.extend(changes.map(|change| format!("-> {change}")));
    lines.extend(by_the_method(improvement));
    d.items(lines);
}

/// That an error which is left is the compensation's own: a test without the effect has it, too, or nothing is missing.
fn by_the_method(improvement: &Improvement) -> Option<String> {
    let after = &improvement.after.summary;
    let channels = &improvement.diagnosis.channels;
    let own = match &improvement.possible {
        Some(without) => (without.summary.eps_rms / after.eps_rms - 1.0).abs() < SAME,
        None => channels.iter().all(|c| c.verdict == Verdict::None),
    };
    (own && after.eps_rms > GOOD_EPS_RMS).then(|| {
        format!(
            "The error that is left is that of `{}` with this actuator, and of nothing that is missing. `outerloop check` says which \
             method has less.",
            after.compensation
        )
    })
}

/// Errors that differ by less are the same.
const SAME: f64 = 0.1;

/// One row per improvement.
pub(super) fn table_of(d: &mut Document, improvements: &[(String, &Improvement)]) {
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
    for (name, s) in improvements {
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
        t.grade_last(s.after.summary.validity());
    }
    d.table(t);
}

/// An improvement on the page.
pub(super) fn section(d: &mut Document, title: &str, s: &Improvement) {
    let response = |d: &mut Document, experiment: &Experiment, run: &JudgedRun| {
        let Some(trace) = &run.trace else {
            return;
        };
        let section = TestSection {
            experiment,
            summary: &run.summary,
            trace,
            ideal: &s.ideal,
        };
        let caption = "Grey is the structure as it would move on an ideal rig.";
        Figures::of(&section).response(d, caption);
    };
    d.heading(title);
    let without = s.possible.as_ref().map_or_else(String::new, |r| {
        let error = percent(r.summary.eps_rms);
        format!("; without the effect in the rig it is {error}")
    });
    let [before, after] = [&s.before, &s.after].map(|run| percent(run.summary.eps_rms));
    d.verdict(
        s.after.summary.validity(),
        format!("eps_rms {before} before, **{after}** after{without}."),
    );
    d.subheading("The test as it was declared");
    response(d, &s.experiment, &s.before);
    let channels = s.diagnosis.channels.iter();
    for c in channels.filter(|c| !c.effects.is_empty() || c.verdict == Verdict::Unknown) {
        diagnosis::channel(d, c);
    }
    for designed in &s.designed {
        next::section(d, &designed.next);
        d.subheading("What all records say together");
        designed
            .diagnosis
            .channels
            .iter()
            .for_each(|c| d.say(headline(c)));
    }
    d.subheading("What was done about it");
    if s.changes.is_empty() {
        d.say("Nothing: the second test is the first once more.");
    }
    d.items(s.changes.clone());
    d.subheading("The test with what was found");
    response(d, &s.improved, &s.after);
    d.say(format!(
        "The record of this test, diagnosed with the improved model: missing is {}.",
        Improvement::named(&s.remains)
    ));
}
