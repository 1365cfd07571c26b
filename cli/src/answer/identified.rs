//! An identified actuator: the parameters of its model, and its frequency response.

use crate::document::plot::{
    Colour, Curve, GROUND, PlotShape, RAW, TALL, TESTED, THIRD, WIDE, WRONG, plot,
};
use crate::document::{Document, Grade};
use crate::wording::digits;
use diagnosis::Identified;
use experiment::frequency_response::{Distortion, DistortionLine, Excitation, FrequencyResponse};
use experiment::numbers::percent;

/// Distortion below this share of the displacement is drawn at it.
const LEAST_SHARE: f64 = 1e-6;
/// Multiple of the noise above which a distortion is reported as one.
const ABOVE_NOISE: f64 = 2.0;

/// A sound actuator leaves less than this of its displacement beyond delay and lag.
const SOUND_NRMSE: f64 = 0.02;

/// What the four numbers do not say although they fit.
fn remarks(found: &Identified) -> Vec<String> {
    let mut all = Vec::new();
    if found.nrmse > SOUND_NRMSE {
        all.push(
            "That is more than a sound actuator leaves. Unless it is the transducer's noise, it does something else as well, and \
             these numbers have a part of it: `outerloop diagnose` looks for what."
                .to_owned(),
        );
    }
    for (name, value, [low, high]) in [
        ("delay", found.delay_ms, found.delay_ms_ci90),
        ("lag", found.lag_ms, found.lag_ms_ci90),
    ] {
        let (sum, uncertain) = (found.delay_ms + found.lag_ms, high - low);
        if uncertain > value.abs() && uncertain > UNCERTAIN * sum {
            all.push(format!(
                "The {name} is uncertain by more than itself: a record with more motion at high frequencies tells delay from lag."
            ));
        }
    }
    all
}

/// Width of an interval, as a share of delay and lag together, that matters.
const UNCERTAIN: f64 = 0.5;

/// What was identified from the record `name`; `doubt` is an objection to it, `response` is for a page.
pub fn of_identify(
    name: &str,
    found: &Identified,
    doubt: Option<&str>,
    response: Option<&FrequencyResponse>,
) -> Document {
    let mut d = Document::new(
        "What the actuator does over frequency",
        format!("Displacement over command, from {name}."),
        response.is_some(),
    );
    if let Some(doubt) = doubt {
        d.on_page(|d| d.verdict(Grade::Bad, doubt));
    }
    let mut tiles = Vec::new();
    for (name, unit, meaning, value, [low, high]) in [
        ("gain", "", "gain at rest", found.gain, found.gain_ci90),
        (
            "delay",
            " ms",
            "transport delay",
            found.delay_ms,
            found.delay_ms_ci90,
        ),
        (
            "lag",
            " ms",
            "first-order lag",
            found.lag_ms,
            found.lag_ms_ci90,
        ),
        (
            "offset",
            " mm",
            "offset",
            found.offset_mm,
            found.offset_mm_ci90,
        ),
    ] {
        let [value, low, high] = [value, low, high].map(digits);
        d.tell(format!(
            "{name:<7}{value:>9}{unit:<3}  90 % in {low} to {high}{unit}"
        ));
        tiles.push((
            format!("{value}{unit}"),
            format!("{meaning}; 90 % in {low} to {high}{unit}"),
        ));
    }
    tiles.push((
        percent(found.nrmse),
        "of the displacement is left by this model".to_owned(),
    ));
    d.tell(format!(
        "The model leaves {:.2} % of the displacement's standard deviation.",
        found.nrmse * 100.0
    ));
    for remark in remarks(found) {
        d.tell(remark);
    }
    d.tiles(tiles);
    if let Some(response) = response {
        linear(&mut d, found, response);
        distorted(&mut d, response);
    }
    d
}

fn linear(d: &mut Document, found: &Identified, response: &FrequencyResponse) {
    let over = |of: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        response.lines.iter().map(|l| (l.hz, of(l.hz))).collect()
    };
    let turn = |hz: f64| std::f64::consts::TAU * hz;
    let model_gain = |hz: f64| found.gain / (1.0 + (turn(hz) * 1e-3 * found.lag_ms).powi(2)).sqrt();
    let model_phase = |delay_ms: f64, hz: f64| {
        -(turn(hz) * 1e-3 * delay_ms).to_degrees()
            - (turn(hz) * 1e-3 * found.lag_ms).atan().to_degrees()
    };
    let mut figure = |shape: PlotShape, label: &str, curves: &[Curve], caption: &str| {
        d.figure(caption, || plot(shape, "frequency [Hz]", label, curves));
    };
    let measured = |of: &dyn Fn(usize) -> f64| -> Curve {
        let lines = response.lines.iter().enumerate();
        Curve::new(TESTED, lines.map(|(i, l)| (l.hz, of(i))).collect())
    };
    let model = |points| Curve::new(WRONG, points).named("gain, delay and lag as identified");
    let edge = |delay_ms: f64| Curve::new(RAW, over(&|hz| model_phase(delay_ms, hz)));
    figure(
        WIDE,
        "displacement over command [1]",
        &[
            measured(&|i| response.lines[i].gain).named("measured"),
            model(over(&model_gain)),
        ],
        "Averaged cross spectra over the lines at which the command moves.",
    );
    figure(
        WIDE,
        "phase [degrees]",
        &[
            edge(found.delay_ms_ci90[0]).named("delay at the ends of its interval"),
            edge(found.delay_ms_ci90[1]),
            measured(&|i| response.lines[i].phase_deg).named("measured"),
            model(over(&|hz| model_phase(found.delay_ms, hz))),
        ],
        "Below zero the displacement is late. A pure delay is a straight line.",
    );
    figure(
        WIDE.within(1.0),
        "coherence [1]",
        &[measured(&|i| response.lines[i].coherence)],
        "The share of the displacement's power that is a linear answer to the command; the rest is noise or distortion.",
    );
}

fn distorted(d: &mut Document, response: &FrequencyResponse) {
    d.heading("Distortion and noise");
    let Some(distortion) = &response.distortion else {
        return d.explain(
            "Distortion cannot be told from noise with this command: it is neither a sweep nor a periodic odd multisine. \
             `outerloop new --signal` writes either.",
        );
    };
    let [even, odd, noise, linear] = distortion.overall_mm();
    let [even_times, odd_times] = distortion.over_noise();
    d.explain(format!("The linear answer has {linear:.4} mm rms a line."));
    let mut said = |name: &str, value: f64, times: f64, cause: &str| {
        let level = format!(
            "**{name} orders: {:.3} um rms a line**, {times:.1} times the noise in the median line",
            1e3 * value
        );
        d.on_page(|d| match times > ABOVE_NOISE {
            true => d.verdict(Grade::Fair, format!("{level}. {cause}")),
            false => d.verdict(
                Grade::Good,
                format!(
                    "{level}: no distortion stands out (noise: {:.3} um).",
                    1e3 * noise
                ),
            ),
        });
    };
    said(
        "Even",
        even,
        even_times,
        "The two directions differ: unequal areas or valve edges, a bent scale.",
    );
    said(
        "Odd",
        odd,
        odd_times,
        "The same both ways: friction, play, a limit, a valve whose gain depends on its opening.",
    );
    let how = match distortion.excitation {
        Excitation::Sweep => {
            "Per cent of the linear answer at that frequency: multiples 2 and 4 of the command's phase, 3 and 5, and, as the \
             noise floor, 1.5 to 4.5 between them."
        }
        Excitation::OddMultisine => {
            "Per cent of the linear answer's mean line: lines of even order, odd lines that the command leaves out, and what \
             lies between the lines of the period."
        }
    };
    d.figure(how, || levels(distortion));
}

fn levels(d: &Distortion) -> String {
    let level = |of: fn(&DistortionLine) -> Option<f64>, colour: Colour, name: &'static str| {
        let share = |l: &DistortionLine| {
            // A multisine leaves lines out on purpose: the mean linear response is used instead.
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
    let below = "frequency of the command [Hz]";
    plot(
        TALL.of_percent(),
        below,
        "of the linear answer [%]",
        &curves,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fit_that_leaves_much_and_a_delay_that_may_be_lag_are_said() {
        let sound = Identified {
            gain: 1.0,
            gain_ci90: [0.99, 1.01],
            delay_ms: 4.0,
            delay_ms_ci90: [3.9, 4.1],
            lag_ms: 10.0,
            lag_ms_ci90: [9.9, 10.1],
            offset_mm: 0.0,
            offset_mm_ci90: [-0.1, 0.1],
            nrmse: 0.01,
        };
        assert_eq!(remarks(&sound), [""; 0]);
        let left = Identified {
            nrmse: 0.03,
            ..sound
        };
        assert!(remarks(&left)[0].contains("`outerloop diagnose`"));
        // Wider than its value, and than half of delay and lag.
        let open = Identified {
            delay_ms_ci90: [0.0, 8.0],
            ..sound
        };
        assert!(remarks(&open)[0].starts_with("The delay is uncertain"));
        let narrower = Identified {
            delay_ms: 1.0,
            delay_ms_ci90: [0.0, 3.0],
            ..sound
        };
        assert_eq!(remarks(&narrower), [""; 0]);
    }
}
