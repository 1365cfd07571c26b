//! The report of one test on many rigs.

use super::figures::{Figures, figure};
use super::page::{self, TestSection, escape, page, test_file};
use super::plot::{self, Colour, Curve, HALF, TALL, TESTED, WRONG};
use super::rths::table;
use experiment::numbers::{percent, percent_or_lost, three};
use experiment::stability::perturbed::Spread;
use experiment::stability::variation::Variation;
use experiment::summary::{GOOD_EPS_RMS, POOR_EPS_RMS, Summary, TestVerdict};

/// The tests as the report shows them.
#[derive(Clone, Copy, Debug)]
pub struct ManyTests<'a> {
    /// How the rigs were drawn.
    pub spread: &'a Spread,
    /// The rigs.
    pub rigs: &'a [Variation],
    /// The test on each.
    pub summaries: &'a [Summary],
    /// The rig of the worst test.
    pub worst_rig: &'a Variation,
    /// The worst test.
    pub worst: TestSection<'a>,
}

/// Errors below this are drawn at it.
const LEAST: f64 = 1e-6;
/// Dots of a plot; where there are more, the best of them are thinned out.
const DOTS: usize = 4000;

impl ManyTests<'_> {
    /// The errors of all tests, ascending; infinite: it tripped or ran away.
    fn errors(&self) -> Vec<f64> {
        let mut errors: Vec<f64> = self.summaries.iter().map(Summary::error).collect();
        errors.sort_by(f64::total_cmp);
        errors
    }
}

/// The report of many tests.
pub fn of_monte_carlo(m: &ManyTests<'_>) -> String {
    let errors = m.errors();
    let body = [
        verdict(&errors),
        tiles(&errors),
        distribution(&errors),
        over_the_rigs(m),
        "<h2>The worst of them</h2>".into(),
        worst_rig(m.worst_rig),
        Figures::of(&m.worst).response("Over the response of the same rig with an ideal actuator."),
        test_file(&m.worst.experiment.test.text),
    ]
    .concat();
    let title = format!("One test on {} rigs", m.rigs.len());
    let lead = format!(
        "{}, compensation <b>{}</b>, on rigs that are not quite the declared one. Each is judged by the same integration \
         with an ideal actuator on the same specimen.",
        escape(&m.worst.summary.record),
        m.worst.summary.compensation
    );
    page(&title, &lead, &body)
}

/// The error that a share of the tests does not exceed.
fn at(errors: &[f64], share: f64) -> f64 {
    errors[((errors.len() - 1) as f64 * share).round() as usize]
}

fn completed(errors: &[f64]) -> usize {
    errors.iter().filter(|e| e.is_finite()).count()
}

fn verdict(errors: &[f64]) -> String {
    let (done, most) = (completed(errors), at(errors, 0.95));
    let class = match most {
        e if e <= GOOD_EPS_RMS && done == errors.len() => "good",
        e if e <= POOR_EPS_RMS => "fair",
        _ => "bad",
    };
    let most = if most.is_finite() {
        format!(
            "95 % of the rigs have an error of at most <b>{}</b> rms, the worst {}.",
            percent(most),
            percent_or_lost(at(errors, 1.0))
        )
    } else {
        "On more than one rig in twenty it tripped or ran away.".into()
    };
    format!(
        "<p class=\"verdict {class}\">{done} of {} tests ran to their end. {most}</p>",
        errors.len()
    )
}

fn tiles(errors: &[f64]) -> String {
    let tiles = [
        (
            format!("{} of {}", completed(errors), errors.len()),
            "ran to their end",
        ),
        (
            percent_or_lost(at(errors, 0.5)),
            "rms error (Eq 18) that half of them stay below",
        ),
        (
            percent_or_lost(at(errors, 0.95)),
            "that 95 % of them stay below",
        ),
        (percent_or_lost(at(errors, 1.0)), "the worst"),
    ];
    page::tiles(&tiles)
}

/// As the axis of per cent has it: a test that is lost counts as an error of 100 %.
fn on_axis(error: f64) -> f64 {
    error.clamp(LEAST, 1.0).log10()
}

fn distribution(errors: &[f64]) -> String {
    let share = |i: usize| 100.0 * (i as f64 + 0.5) / errors.len() as f64;
    let points = plot::history(errors.len(), |i| (share(i), on_axis(errors[i])));
    let svg = plot::plot(
        TALL.of_percent(),
        "tests, the best first [%]",
        "eps_rms [%]",
        &[Curve::new(TESTED, points)],
    );
    format!(
        "<h2>The error</h2>{}",
        figure(
            &svg,
            "What share of the tests stays below which error. A test that tripped or ran away counts as 100 %."
        )
    )
}

/// One of the factors of a rig.
type Factor = fn(&Variation) -> f64;

/// The error over each of what was drawn.
fn over_the_rigs(m: &ManyTests<'_>) -> String {
    let mut order: Vec<usize> = (0..m.rigs.len()).collect();
    order.sort_by(|a, b| {
        let error = |i: &usize| m.summaries[*i].error();
        error(b).total_cmp(&error(a))
    });
    let (worst, rest) = order.split_at(order.len().min(DOTS / 2));
    let stride = rest.len().div_ceil(DOTS / 2).max(1);
    let shown: Vec<usize> = worst
        .iter()
        .chain(rest.iter().step_by(stride))
        .copied()
        .collect();
    let dots = |colour: Colour, factor: Factor, lost: bool| {
        let of = |i: &&usize| (m.summaries[**i].verdict != TestVerdict::Completed) == lost;
        let points = shown.iter().filter(of);
        let points = points.map(|i| (factor(&m.rigs[*i]), on_axis(m.summaries[*i].error())));
        Curve::new(colour, points.collect()).dots()
    };
    let mut html = String::from("<h2>Over what was drawn</h2><div class=\"pair\">");
    let factors: [(&str, Factor, f64); 3] = [
        ("times of the actuator", |v| v.delay, m.spread.delay),
        ("gain of the actuator", |v| v.gain, m.spread.gain),
        (
            "stiffness of the specimen",
            |v| v.stiffness,
            m.spread.stiffness,
        ),
    ];
    for (name, factor, deviation) in factors {
        let curves = [
            dots(TESTED, factor, false).named("ran to its end"),
            dots(WRONG, factor, true).named("tripped or ran away"),
        ];
        let label = format!("{name}, of the declared [1]");
        let svg = plot::plot(HALF.of_percent(), &label, "eps_rms [%]", &curves);
        html += &figure(
            &svg,
            &format!("A dot a test; standard deviation {}.", percent(deviation)),
        );
    }
    html + "</div>"
}

fn worst_rig(v: &Variation) -> String {
    let row = |name: &str, factor: f64| vec![name.to_owned(), three(factor)];
    table(
        &["of the declared", "factor"],
        [
            row("times of the actuator", v.delay),
            row("gain of the actuator", v.gain),
            row("stiffness of the specimen", v.stiffness),
        ]
        .into_iter(),
    )
}
