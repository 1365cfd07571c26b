//! A check: the planned motion, and how far the test is from running away.

use super::figures::Figures;
use super::section::TestSection;
use crate::document::plot::{Colour, Curve, GROUND, TALL, TESTED, WIDE, WRONG, plot};
use crate::document::{Document, Table, table};
use experiment::Experiment;
use experiment::numbers::{growth_percent, length, percent, percent_or_lost, three};
use experiment::soundness::Judgement;
use experiment::stability::Stability;
use experiment::stability::growth::SmallMotions;
use experiment::stability::limits::{LimitSearch, StabilityLimit};

/// A check, and the further data of its page.
#[derive(Clone, Copy, Debug)]
pub struct CheckSection<'a> {
    /// The test.
    pub experiment: &'a Experiment,
    /// The verdict.
    pub judgement: &'a Judgement,
    /// The result from small motions.
    pub answer: &'a Stability,
    /// For the page: the fastest growing motion over the delay (ms of the laboratory, 1/s of model time), and the planned
    /// motion on the simulated rig.
    pub drawn: Option<(&'a [(f64, f64)], TestSection<'a>)>,
}

/// A check.
pub fn of_check(c: &CheckSection<'_>) -> Document {
    let (j, a) = (c.judgement, c.answer);
    let lead = format!(
        "The planned motion on the simulated rig, with compensation **{}**, and small motions of the same loop after a blow; \
         integration steps of {} ms. What is not in the test file is in no verdict.",
        a.row.compensation,
        three(a.step_s * 1e3)
    );
    let mut d = opening(&c.experiment.record, lead, j, c.drawn.is_some());
    d.tell(format!(
        "Small motions of the loop after a blow, integration steps of {:.4} ms:",
        a.step_s * 1e3
    ));
    if let Some((over_delay, planned)) = &c.drawn {
        tiles(&mut d, c, planned);
        Figures::of(planned).displacement(&mut d);
        how_near(&mut d, a, over_delay);
    }
    d.heading("Compensations on this rig");
    d.explain(
        "By their small motions alone, which do not decide over variable damping, corrected forces and predictors that learn.",
    );
    d.table(compensations(a));
    d.heading("Modes");
    d.table(modes(a));
    margins(
        &mut d,
        &[
            ("delay", &a.limits.delay, " ms", LARGEST),
            ("loop gain", &a.limits.gain, "", LARGEST),
            (
                "time scale",
                &a.limits.time_scale_needed,
                "",
                ["at least ", "down to"],
            ),
        ],
        "These margins are of small motions alone: the planned motion may be poor within them.",
    );
    d.heading("Where the delay comes from");
    d.table(budget(a));
    let p = &a.perturbed;
    d.say(format!(
        "On {} of {} perturbed rigs small motions grow (standard deviations: {}).\nWorst: {} a second, least damping of mode 1 {}.",
        p.unstable,
        p.spread.plants,
        deviations(a),
        grown(p.worst_growth_per_s),
        or_dash(p.least_damping_ratio),
    ));
    for note in &a.notes {
        d.say(format!("Note: {note}."));
    }
    d.heading("What will be watched");
    d.say(watched(j));
    d.test_file(&c.experiment.test.text);
    d
}

/// The beginning of a check of a test on the ground motion `record`.
pub(super) fn opening(record: &str, lead: String, j: &Judgement, with_page: bool) -> Document {
    let mut d = Document::new(format!("May this test be run? {record}"), lead, with_page);
    let reason = j.reason.trim_end_matches('.');
    d.verdict(
        j.verdict,
        format!("**{}**: {reason}.", j.verdict.name().to_uppercase()),
    );
    d.tell(format!("Expected error: {}.\n", expected(j)));
    d
}

/// What can be watched in this test, in words.
fn watched(judgement: &Judgement) -> String {
    let Some(watch) = &judgement.watch else {
        return "The rig watch is off in this test.".into();
    };
    let now = match watch.events.iter().any(|e| !e.set.is_empty()) {
        true => format!(" On the simulated rig: {}", watch.sentence()),
        false => String::new(),
    };
    format!("{}{now}", watch.outlook())
}

/// The expected error in words.
fn expected(judgement: &Judgement) -> String {
    if !judgement.expected_eps_rms.is_finite() {
        return "none, since the planned motion does not run to its end".into();
    }
    format!(
        "{} rms; {} on a rig that differs",
        percent(judgement.expected_eps_rms),
        percent_or_lost(judgement.expected_eps_rms_differing)
    )
}

fn deviations(a: &Stability) -> String {
    let spread = &a.perturbed.spread;
    format!(
        "times {}, gain {}, stiffness {}, damping {}",
        percent(spread.delay),
        percent(spread.gain),
        percent(spread.stiffness),
        percent(spread.damping)
    )
}

fn tiles(d: &mut Document, c: &CheckSection<'_>, planned: &TestSection<'_>) {
    let (j, a) = (c.judgement, c.answer);
    let delay = &a.limits.delay;
    let limit = match delay.search {
        LimitSearch::Found { limit, .. } => format!(
            "; with {} as it is configured small motions grow from {} ms on",
            a.row.compensation,
            three(limit)
        ),
        LimitSearch::BeyondRange { searched_to } | LimitSearch::Refused { searched_to, .. } => {
            format!(
                "; up to {} ms small motions do not grow",
                three(searched_to)
            )
        }
        LimitSearch::NoMargin { .. } => String::new(),
    };
    d.tiles(vec![
        (
            percent_or_lost(j.expected_eps_rms),
            "expected rms error, of the largest ideal displacement (Eq 18)".into(),
        ),
        (
            percent_or_lost(j.expected_eps_rms_differing),
            "the same on a rig that differs by a standard deviation".into(),
        ),
        (
            length(planned.summary.peak_displacement_m),
            "largest displacement of the planned motion".into(),
        ),
        (
            format!("{} ms", three(delay.present)),
            format!("delay at the first natural frequency{limit}"),
        ),
        (
            format!("{} of {}", a.perturbed.unstable, a.perturbed.spread.plants),
            "drawn rigs on which small motions grow".into(),
        ),
    ]);
}

/// Growth over the delay, and over the drawn rigs.
fn how_near(d: &mut Document, a: &Stability, over_delay: &[(f64, f64)]) {
    d.heading("How near it is to running away");
    let here = a.limits.delay.present;
    let caption = format!(
        "The fastest growing small motion over the delay at the first natural frequency, with compensation {} as it is \
         configured: it is not told of the delay. Above the line small motions grow.",
        a.row.compensation
    );
    let points = over_delay.to_vec();
    d.figure(caption, || {
        growth("delay [ms]", points, Some((here, "this test")))
    });
    let growths = &a.perturbed.growths_per_s;
    let caption = format!(
        "The same over {} rigs that differ from the declared one; standard deviations: {}.",
        a.perturbed.spread.plants,
        deviations(a)
    );
    let share = |i: usize| 100.0 * (i as f64 + 0.5) / growths.len() as f64;
    let points = growths
        .iter()
        .enumerate()
        .map(|(i, growth)| (share(i), *growth));
    let points = points.collect();
    d.figure(caption, || {
        growth("drawn rigs, the steadiest first [%]", points, None)
    });
}

fn growth(x_label: &str, points: Vec<(f64, f64)>, here: Option<(f64, &'static str)>) -> String {
    let ends = |pick: fn(&(f64, f64)) -> f64| {
        let values = points.iter().map(pick).filter(|v| v.is_finite());
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        })
    };
    let (first, last) = ends(|p| p.0);
    let (low, high) = ends(|p| p.1);
    let line = |colour: Colour, a, b| Curve::new(colour, vec![a, b]);
    let mut curves =
        vec![line(WRONG, (first, 0.0), (last, 0.0)).named("above: the response grows")];
    if let Some((x, name)) = here {
        let (low, high) = (low.min(0.0), high.max(0.0));
        curves.push(line(GROUND, (x, low), (x, high)).named(name));
    }
    curves.push(Curve::new(TESTED, points).named("fastest growing motion"));
    let shape = if here.is_some() { TALL } else { WIDE };
    plot(shape, x_label, "growth [1/s]", &curves)
}

fn or_dash(value: f64) -> String {
    match value.is_finite() {
        true => percent(value),
        false => "-".into(),
    }
}

/// Growth in a second; a dash where it could not be measured.
fn grown(rate_per_s: f64) -> String {
    match rate_per_s.is_finite() {
        true => growth_percent(rate_per_s.exp_m1()),
        false => "-".into(),
    }
}

fn compensations(a: &Stability) -> Table {
    let mut t = table(&[
        "compensation",
        "small motions",
        "growth a second",
        "damping, mode 1",
    ]);
    let mut row = |r: &SmallMotions, here: &str| {
        t.add_row([
            format!("{}{here}", r.compensation),
            r.word().to_owned(),
            grown(r.growth_per_s),
            or_dash(r.damping_ratio),
        ]);
    };
    row(&a.row, "  <- this test");
    a.at_start
        .iter()
        .for_each(|r| row(r, ", before it has learnt"));
    a.alternatives.iter().for_each(|r| row(r, ""));
    t
}

fn modes(a: &Stability) -> Table {
    let mut t = table(&["mode", "structure", "in the loop", "damping in the loop"]);
    for (i, m) in a.modes.iter().enumerate() {
        t.add_row([
            (i + 1).to_string(),
            format!("{:.3} Hz", m.structure_hz),
            format!("{:.3} Hz", m.frequency_hz),
            percent(m.damping_ratio),
        ]);
    }
    t
}

/// The name of a quantity, its limit, its unit, and the words before its limit and before the end of its range.
pub(super) type MarginRow<'a> = (&'a str, &'a StabilityLimit, &'a str, [&'a str; 2]);

/// The words where the limit is the largest value.
pub(super) const LARGEST: [&str; 2] = ["", "up to"];

/// The margins, and `what` they are of.
pub(super) fn margins(d: &mut Document, rows: &[MarginRow<'_>], what: &str) {
    d.heading("Margins");
    let mut t = table(&["", "present", "limit", "margin"]);
    let mut refused = Vec::new();
    for (name, l, unit, [at, to]) in rows {
        let said = |x: f64| format!("{x:.3}{unit}");
        let none = |x: f64| format!("none {to} {}", said(x));
        let (limit, margin) = match &l.search {
            LimitSearch::Found {
                limit,
                margin_percent,
            } => (format!("{at}{}", said(*limit)), *margin_percent),
            LimitSearch::BeyondRange { searched_to } => (none(*searched_to), None),
            LimitSearch::Refused { searched_to, why } => {
                refused.push(format!(
                    "The search over the {name} ended at a refusal: {why}."
                ));
                (none(*searched_to), None)
            }
            LimitSearch::NoMargin { why } => {
                d.say(format!("There are no margins: {why}."));
                return;
            }
        };
        let margin = margin.map_or_else(|| "-".into(), |m| format!("{m:.1} %"));
        t.add_row([(*name).to_owned(), said(l.present), limit, margin]);
    }
    d.table(t);
    refused.into_iter().for_each(|sentence| d.say(sentence));
    d.say(format!(
        "Delay and gain change on the rig alone: the loop does not know of it and keeps its parameters. A test that declares the \
         change may be stable beyond the limit. {what}"
    ));
}

fn budget(a: &Stability) -> Table {
    let mut t = table(&["delay budget", "ms", "from"]);
    for p in &a.delay_budget {
        t.add_row([
            p.part.to_owned(),
            format!("{:+.3}", p.ms),
            p.from.to_owned(),
        ]);
    }
    t
}
