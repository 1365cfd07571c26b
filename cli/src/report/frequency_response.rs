//! What an actuator does over frequency, as a page.

use super::figures::figure;
use super::page::{escape, page, tiles};
use super::plot::{self, Colour, Curve, GROUND, PlotShape, RAW, TALL, TESTED, THIRD, WIDE, WRONG};
use crate::wording::digits;
use diagnosis::Identified;
use experiment::frequency_response::{Distortion, DistortionLine, Excitation, FrequencyResponse};
use experiment::numbers::percent;

/// Distortion below this share of the displacement is drawn at it.
const LEAST_SHARE: f64 = 1e-6;
/// A distortion is called one where it is so many times the noise.
const ABOVE_NOISE: f64 = 2.0;

/// The page of a record of which `found` was identified; `doubt` is what speaks against it.
pub fn of_identify(
    name: &str,
    found: &Identified,
    doubt: Option<&str>,
    response: &FrequencyResponse,
) -> String {
    let interval = |[low, high]: [f64; 2], unit: &str| {
        format!("90 % in {} to {}{unit}", digits(low), digits(high))
    };
    let [delay, lag, gain] = [
        interval(found.delay_ms_ci90, " ms"),
        interval(found.lag_ms_ci90, " ms"),
        interval(found.gain_ci90, ""),
    ];
    let figures = [
        (
            format!("{} ms", digits(found.delay_ms)),
            format!("transport delay; {delay}"),
        ),
        (
            format!("{} ms", digits(found.lag_ms)),
            format!("first-order lag; {lag}"),
        ),
        (digits(found.gain), format!("gain at rest; {gain}")),
        (
            percent(found.nrmse),
            "left by this model, of what the displacement moves".to_owned(),
        ),
    ];
    let figures: Vec<(String, &str)> = figures
        .iter()
        .map(|(v, m)| (v.clone(), m.as_str()))
        .collect();
    let doubtful = doubt.map_or_else(String::new, |doubt| {
        format!("<p class=\"verdict bad\">{}</p>", escape(doubt))
    });
    let body = [
        doubtful,
        tiles(&figures),
        linear(found, response),
        response
            .distortion
            .as_ref()
            .map_or_else(no_distortion, distortion),
    ]
    .concat();
    page(
        "What the actuator does over frequency",
        &format!("Displacement over command, from {}.", escape(name)),
        &body,
    )
}

fn linear(found: &Identified, response: &FrequencyResponse) -> String {
    let over = |of: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        response.lines.iter().map(|l| (l.hz, of(l.hz))).collect()
    };
    let turn = |hz: f64| std::f64::consts::TAU * hz;
    let model_gain = |hz: f64| found.gain / (1.0 + (turn(hz) * 1e-3 * found.lag_ms).powi(2)).sqrt();
    let model_phase = |delay_ms: f64, hz: f64| {
        -(turn(hz) * 1e-3 * delay_ms).to_degrees()
            - (turn(hz) * 1e-3 * found.lag_ms).atan().to_degrees()
    };
    let plot = |shape: PlotShape, label: &str, curves: &[Curve], caption: &str| {
        figure(&plot::plot(shape, "frequency [Hz]", label, curves), caption)
    };
    let measured = |of: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        let lines = response.lines.iter().enumerate();
        lines.map(|(i, l)| (l.hz, of(i))).collect()
    };
    let model = |points| Curve::new(WRONG, points).named("gain, delay and lag as identified");
    let edge = |delay_ms: f64| Curve::new(RAW, over(&|hz| model_phase(delay_ms, hz)));
    [
        "<h2>Gain, phase and coherence</h2>".to_owned(),
        plot(
            WIDE,
            "displacement over command [1]",
            &[
                Curve::new(TESTED, measured(&|i| response.lines[i].gain)).named("measured"),
                model(over(&model_gain)),
            ],
            "Averaged cross spectra over the lines at which the command moves.",
        ),
        plot(
            WIDE,
            "phase [degrees]",
            &[
                edge(found.delay_ms_ci90[0]).named("delay at the ends of its interval"),
                edge(found.delay_ms_ci90[1]),
                Curve::new(TESTED, measured(&|i| response.lines[i].phase_deg)).named("measured"),
                model(over(&|hz| model_phase(found.delay_ms, hz))),
            ],
            "Below zero the displacement is late. A pure delay is a straight line.",
        ),
        plot(
            WIDE.within(1.0),
            "coherence [1]",
            &[Curve::new(TESTED, measured(&|i| response.lines[i].coherence))],
            "The share of the displacement's power that is a linear answer to the command; the rest is noise or distortion.",
        ),
    ]
    .concat()
}

fn no_distortion() -> String {
    "<h2>Distortion</h2><p>Distortion cannot be told from noise with this command: it is neither a sweep nor a periodic \
     odd multisine. <code>outerloop new --signal</code> writes either.</p>"
        .into()
}

fn distortion(d: &Distortion) -> String {
    let level = |of: fn(&DistortionLine) -> Option<f64>, colour: Colour, name: &'static str| {
        let share = |l: &DistortionLine| {
            // A multisine leaves lines out on purpose: the linear answer beside them counts.
            let linear = match d.excitation {
                Excitation::Sweep => l.linear_mm,
                Excitation::OddMultisine => d.overall_mm()[3],
            };
            let share = of(l)? / linear.max(f64::MIN_POSITIVE);
            Some((l.hz, share.max(LEAST_SHARE).log10()))
        };
        let curve = Curve::new(colour, d.lines.iter().filter_map(share).collect()).named(name);
        match d.excitation {
            Excitation::Sweep => curve,
            Excitation::OddMultisine => curve.dots(),
        }
    };
    let curves = [
        level(|l| l.even_mm, WRONG, "even orders"),
        level(|l| l.odd_mm, THIRD, "odd orders"),
        level(|l| Some(l.noise_mm), GROUND, "noise floor"),
    ];
    let how = match d.excitation {
        Excitation::Sweep => {
            "Per cent of the linear answer at that frequency: multiples 2 and 4 of the command's phase, 3 and 5, and, as the \
             noise floor, 1.5 to 4.5 between them."
        }
        Excitation::OddMultisine => {
            "Per cent of the linear answer's mean line: lines of even order, odd lines that the command leaves out, and what \
             lies between the lines of the period."
        }
    };
    let [even, odd, noise, linear] = d.overall_mm();
    let [even_times, odd_times] = d.over_noise();
    let said = |name: &str, [value, times]: [f64; 2], cause: &str| {
        let um = 1e3 * value;
        match times > ABOVE_NOISE {
            true => format!(
                "<p class=\"verdict fair\"><b>{name} orders: {um:.3} um rms a line</b>, {times:.1} times the noise in the \
                 median line. {cause}</p>"
            ),
            false => format!(
                "<p class=\"verdict good\"><b>{name} orders: {um:.3} um rms a line</b>, {times:.1} times the noise in the \
                 median line: no distortion that it would show (noise: {:.3} um).</p>",
                1e3 * noise
            ),
        }
    };
    [
        format!("<h2>Distortion and noise</h2><p>The linear answer has {linear:.4} mm rms a line.</p>"),
        said("Even", [even, even_times], "The two directions differ: unequal areas or valve edges, a bent scale."),
        said("Odd", [odd, odd_times], "The same both ways: friction, play, a limit, a valve whose gain depends on its opening."),
        figure(
            &plot::plot(TALL.of_percent(), "frequency of the command [Hz]", "of the linear answer [%]", &curves),
            how,
        ),
    ]
    .concat()
}
