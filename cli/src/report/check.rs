//! The report of a check: the planned motion, and how far the test is from where it would run away.

use super::figures::{Figures, figure};
use super::page::{self, TestSection, escape, page, test_file};
use super::plot::{self, Colour, Curve, GROUND, TALL, TESTED, WIDE, WRONG};
use super::rths::table;
use experiment::numbers::{length, percent, percent_or_lost, three};
use experiment::soundness::{Judgement, SoundnessVerdict};
use experiment::stability::Stability;
use experiment::stability::growth::SmallMotions;
use experiment::stability::limits::StabilityLimit;
use std::fmt::Write as _;

/// A check as the report shows it.
#[derive(Clone, Copy, Debug)]
pub struct CheckSection<'a> {
    /// The verdict.
    pub judgement: &'a Judgement,
    /// What its small motions say.
    pub answer: &'a Stability,
    /// The fastest growing motion over the delay: ms of the laboratory, 1/s of model time.
    pub over_delay: &'a [(f64, f64)],
    /// The planned motion on the simulated rig.
    pub planned: TestSection<'a>,
}

/// The report of a check.
pub fn of_check(c: &CheckSection<'_>) -> String {
    let body = [
        soundness(c.judgement.verdict, &c.judgement.reason),
        tiles(c),
        Figures::of(&c.planned).displacement(),
        how_near(c),
        tables(c.answer),
        test_file(&c.planned.experiment.test.text),
    ]
    .concat();
    let title = format!("May this test be run? {}", c.planned.summary.record);
    let lead = format!(
        "The planned motion on the simulated rig, with compensation <b>{}</b>, and small motions of the same loop after a \
         blow; integration steps of {} ms. What is not in the test file is in no verdict.",
        c.answer.row.compensation,
        three(c.answer.step_s * 1e3)
    );
    page(&title, &lead, &body)
}

/// A verdict and why.
pub(super) fn soundness(verdict: SoundnessVerdict, reason: &str) -> String {
    let class = match verdict {
        SoundnessVerdict::Stable => "good",
        SoundnessVerdict::Doubtful => "fair",
        SoundnessVerdict::Unstable => "bad",
    };
    format!(
        "<p class=\"verdict {class}\"><b>{}</b>: {}.</p>",
        verdict.name().to_uppercase(),
        escape(reason)
    )
}

fn tiles(c: &CheckSection<'_>) -> String {
    let (j, a) = (c.judgement, c.answer);
    let delay = &a.limits.delay;
    let limit = delay.limit.map_or_else(
        || "; no limit was found".into(),
        |limit| {
            format!(
                "; with {} as it is configured small motions grow from {} ms on",
                a.row.compensation,
                three(limit)
            )
        },
    );
    let delay_meaning = format!("delay at the first natural frequency{limit}");
    let tiles = [
        (
            percent_or_lost(j.expected_eps_rms),
            "expected rms error, of the largest ideal displacement (Eq 18)",
        ),
        (
            percent_or_lost(j.expected_eps_rms_differing),
            "the same on a rig that differs by a standard deviation",
        ),
        (
            length(c.planned.summary.peak_displacement_m),
            "largest displacement of the planned motion",
        ),
        (format!("{} ms", three(delay.present)), &delay_meaning),
        (
            format!("{} of {}", a.perturbed.unstable, a.perturbed.spread.plants),
            "drawn rigs on which small motions grow",
        ),
    ];
    page::tiles(&tiles)
}

/// Growth over the delay and over the drawn rigs, with the notes on what small motions cannot say.
fn how_near(c: &CheckSection<'_>) -> String {
    let a = c.answer;
    let mut html = String::from("<h2>How near it is to running away</h2>");
    if !a.notes.is_empty() {
        html += "<ul>";
        for note in &a.notes {
            let _ = write!(html, "<li>{}.</li>", escape(note));
        }
        html += "</ul>";
    }
    let here = a.limits.delay.present;
    html += &growth(
        "delay [ms]",
        c.over_delay.to_vec(),
        Some((here, "this test")),
        &format!(
            "The fastest growing small motion over the delay at the first natural frequency, with compensation {} as it is \
             configured: it is not told of the delay. Above the line small motions grow.",
            a.row.compensation
        ),
    );
    let p = &a.perturbed;
    let share = |i: usize| 100.0 * (i as f64 + 0.5) / p.growths_per_s.len() as f64;
    let rigs = p.growths_per_s.iter().enumerate();
    html += &growth(
        "drawn rigs, the steadiest first [%]",
        rigs.map(|(i, growth)| (share(i), *growth)).collect(),
        None,
        &format!(
            "The same over {} rigs that differ from the declared one; standard deviations: times {}, gain {}, stiffness \
             {}, damping {}.",
            p.spread.plants,
            percent(p.spread.delay),
            percent(p.spread.gain),
            percent(p.spread.stiffness),
            percent(p.spread.damping)
        ),
    );
    html
}

fn growth(
    x_label: &str,
    points: Vec<(f64, f64)>,
    here: Option<(f64, &'static str)>,
    caption: &str,
) -> String {
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
    let svg = plot::plot(shape, x_label, "growth [1/s]", &curves);
    figure(&svg, caption)
}

fn tables(a: &Stability) -> String {
    let or_none = |value: Option<f64>, unit: &str| {
        value.map_or_else(|| "none found".into(), |v| format!("{}{unit}", three(v)))
    };
    let limit = |name: &str, l: &StabilityLimit, unit: &str| {
        let margin = l.margin_percent;
        vec![
            name.to_owned(),
            format!("{}{unit}", three(l.present)),
            or_none(l.limit, unit),
            margin.map_or_else(|| "-".into(), |m| format!("{} %", three(m))),
        ]
    };
    let needed = a.limits.time_scale_needed;
    let margins = [
        limit("delay", &a.limits.delay, " ms"),
        limit("loop gain", &a.limits.gain, ""),
        vec![
            "time scale".into(),
            three(a.time_scale),
            needed.map_or_else(|| "none found".into(), |x| format!("at least {}", three(x))),
            needed.map_or_else(|| "-".into(), |x| percent(a.time_scale / x - 1.0)),
        ],
    ];
    let modes = a.modes.iter().enumerate().map(|(i, m)| {
        vec![
            format!("mode {}", i + 1),
            format!("{} Hz", three(m.structure_hz)),
            format!("{} Hz", three(m.frequency_hz)),
            percent(m.damping_ratio),
        ]
    });
    let budget = a.delay_budget.iter().map(|p| {
        vec![
            p.part.to_owned(),
            format!("{:+.3} ms", p.ms),
            p.from.to_owned(),
        ]
    });
    let row = |r: &SmallMotions, here: &str| {
        vec![
            format!("{}{here}", r.compensation),
            r.word().to_owned(),
            if r.growth_per_s.is_finite() {
                format!("{} 1/s", three(r.growth_per_s))
            } else {
                "-".into()
            },
            if r.damping_ratio.is_nan() {
                "-".into()
            } else {
                percent(r.damping_ratio)
            },
        ]
    };
    let compensations = [row(&a.row, ", this test")]
        .into_iter()
        .chain(a.at_start.iter().map(|r| row(r, ", before it has learnt")))
        .chain(a.alternatives.iter().map(|r| row(r, "")));
    [
        "<h2>Margins</h2>".into(),
        table(&["", "present", "limit", "margin"], margins.into_iter()),
        "<h2>Modes</h2>".into(),
        table(&["", "structure", "in the loop", "damping in the loop"], modes),
        "<h2>Where the delay comes from</h2>".into(),
        table(&["part", "delay", "from"], budget),
        "<h2>Other compensations on the same rig</h2><p>By their small motions alone, which do not decide over variable \
         damping, corrected forces and predictors that learn.</p>"
            .into(),
        table(
            &["compensation", "small motions", "growth", "damping, mode 1"],
            compensations,
        ),
    ]
    .concat()
}
