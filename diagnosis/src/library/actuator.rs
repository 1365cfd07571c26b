//! Effects between command and displacement; columns in mm.

use super::operators as op;
use super::{
    Candidate, Shape, any, four, growth, hum_columns, hum_size, humming, no_shape, once, positive,
    settling,
};
use crate::linear::Bound;
use crate::signals::{Scales, Signals, Transfer, lagged, resonant};
use plant::{Channel, Effect};

/// A candidate of this channel that generalises nothing.
const BASIS: Candidate = Candidate {
    effect: Effect::Offset,
    channel: Channel::Actuator,
    shapes: no_shape,
    columns: |s, _, _| vec![vec![1.0; s.x.len()]],
    bounds: any,
    parameters: |a, _, _| vec![("offset_mm", "mm", a[0])],
    includes: &[],
};

/// `f(x) - x`: the difference that a stage behind the actuator makes.
fn instead(x: &[f64], stage: impl IntoIterator<Item = f64>) -> Vec<Vec<f64>> {
    vec![stage.into_iter().zip(x).map(|(f, x)| f - x).collect()]
}

/// The shape is the whole delay and one interval more, so that it is never 0.
fn extra_delay_s(shape: &[f64], k: &Scales) -> f64 {
    shape[0] - k.interval_s - k.declared.delay_s
}

/// What another transfer from the command would make of it.
fn otherwise(s: &Signals, transfer: Transfer) -> Vec<Vec<f64>> {
    instead(&s.base, transfer.answer(&s.command, s.interval_s))
}

fn width(s: &Scales) -> Vec<Shape> {
    vec![Shape::new(0.002 * s.x, 0.9 * s.x, 12)]
}

pub const CANDIDATES: &[Candidate] = &[
    Candidate {
        effect: Effect::DelayError,
        shapes: |s| {
            vec![Shape::new(
                s.interval_s,
                3.0 * s.declared.delay_s + 60.0 * s.interval_s,
                20,
            )]
        },
        columns: |s, p, k| {
            let delay_s = (k.actuator.delay_s + extra_delay_s(p, k)).max(0.0);
            let late = Transfer {
                delay_s,
                ..k.actuator
            };
            otherwise(s, late)
        },
        bounds: once,
        parameters: |_, p, k| vec![("delay_ms", "ms", 1e3 * extra_delay_s(p, k))],
        ..BASIS
    },
    Candidate {
        effect: Effect::LagError,
        shapes: |s| {
            vec![Shape::new(
                0.3 * s.interval_s,
                4.0 * s.declared.lag_s + 60.0 * s.interval_s,
                20,
            )]
        },
        columns: |s, p, k| {
            let lag_s = (k.actuator.lag_s + p[0] - k.declared.lag_s).max(0.0);
            let slow = Transfer {
                lag_s,
                ..k.actuator
            };
            otherwise(s, slow)
        },
        bounds: once,
        parameters: |_, p, k| vec![("lag_ms", "ms", 1e3 * (p[0] - k.declared.lag_s))],
        ..BASIS
    },
    Candidate {
        effect: Effect::SecondLag,
        shapes: |s| vec![Shape::new(0.5 * s.interval_s, 60.0 * s.interval_s, 14)],
        columns: |s, p, _| instead(&s.x, lagged(&s.x, p[0], s.interval_s)),
        bounds: once,
        parameters: |_, p, _| vec![("lag_ms", "ms", 1e3 * p[0])],
        ..BASIS
    },
    Candidate {
        effect: Effect::OilColumn,
        shapes: |s| {
            vec![
                Shape::new(3.0, 0.4 / s.interval_s, 12),
                Shape::new(0.02, 1.5, 5),
            ]
        },
        columns: |s, p, _| instead(&s.x, resonant(&s.x, p[0], p[1], s.interval_s)),
        bounds: once,
        parameters: |_, p, _| vec![("frequency_hz", "Hz", p[0]), ("damping_ratio", "", p[1])],
        includes: &[Effect::SecondLag],
        ..BASIS
    },
    Candidate {
        effect: Effect::GainError,
        columns: |s, _, _| vec![s.base.clone()],
        parameters: |a, _, _| vec![("error", "", a[0])],
        ..BASIS
    },
    BASIS,
    Candidate {
        effect: Effect::RigCompliance,
        columns: |s, _, _| vec![s.force.iter().map(|f| -f).collect()],
        bounds: positive,
        parameters: |a, _, _| vec![("stiffness_n_per_mm", "N/mm", 1.0 / a[0].max(1e-12))],
        ..BASIS
    },
    Candidate {
        effect: Effect::Drift,
        shapes: settling,
        columns: |s, p, _| vec![growth(s, p[0]).map(|g| g * p[0]).collect()],
        parameters: |a, p, _| {
            vec![
                ("rate_mm_per_s", "mm/s", a[0]),
                ("time_constant_s", "s", p[0]),
            ]
        },
        ..BASIS
    },
    Candidate {
        effect: Effect::TemperatureGain,
        shapes: settling,
        columns: |s, p, _| vec![growth(s, p[0]).zip(&s.base).map(|(g, x)| g * x).collect()],
        parameters: |a, p, _| vec![("change", "", a[0]), ("time_constant_s", "s", p[0])],
        ..BASIS
    },
    Candidate {
        effect: Effect::CoulombFriction,
        shapes: |s| vec![Shape::new(0.001 * s.x, 0.3 * s.x, 8)],
        columns: |s, p, _| vec![op::friction(&s.x, p[0]).iter().map(|z| -z).collect()],
        bounds: positive,
        parameters: |a, p, _| vec![("error_mm", "mm", a[0]), ("presliding_mm", "mm", p[0])],
        // Friction that builds up over its own size is backlash.
        includes: &[Effect::Backlash],
        ..BASIS
    },
    Candidate {
        effect: Effect::StribeckFriction,
        shapes: |s| {
            vec![
                Shape::new(0.001 * s.x, 0.1 * s.x, 5),
                Shape::new(0.01 * s.v, 0.5 * s.v, 6),
            ]
        },
        columns: |s, p, _| {
            let z: Vec<f64> = op::friction(&s.x, p[0]).iter().map(|z| -z).collect();
            let slow = |v: &f64| (-(v / p[1]).powi(2)).exp();
            let more = z.iter().zip(&s.v).map(|(z, v)| z * slow(v)).collect();
            vec![z, more]
        },
        bounds: |_| vec![Bound::POSITIVE; 2],
        parameters: |a, p, _| {
            vec![
                ("error_mm", "mm", a[0]),
                ("rest_ratio", "", 1.0 + a[1] / a[0].max(1e-9)),
                ("stribeck_mm_per_s", "mm/s", p[1]),
                ("presliding_mm", "mm", p[0]),
            ]
        },
        includes: &[Effect::CoulombFriction, Effect::Backlash],
        ..BASIS
    },
    Candidate {
        effect: Effect::Backlash,
        shapes: width,
        columns: |s, p, _| instead(&s.x, op::play(&s.x, p[0])),
        bounds: once,
        parameters: |_, p, _| vec![("width_mm", "mm", p[0])],
        ..BASIS
    },
    Candidate {
        effect: Effect::DeadBand,
        shapes: width,
        columns: |s, p, _| instead(&s.x, op::dead_zone(&s.x, p[0])),
        bounds: once,
        parameters: |_, p, _| vec![("width_mm", "mm", p[0])],
        ..BASIS
    },
    Candidate {
        effect: Effect::Saturation,
        shapes: |s| vec![Shape::new(0.3 * s.x, 0.998 * s.x, 16)],
        columns: |s, p, _| instead(&s.x, s.x.iter().map(|x| x.clamp(-p[0], p[0]))),
        bounds: once,
        parameters: |_, p, _| vec![("limit_mm", "mm", p[0])],
        ..BASIS
    },
    Candidate {
        effect: Effect::RateLimit,
        shapes: |s| vec![Shape::new(0.1 * s.v, 0.995 * s.v, 16)],
        columns: |s, p, _| instead(&s.x, op::slew(&s.x, p[0] * s.interval_s)),
        bounds: once,
        parameters: |_, p, _| vec![("rate_mm_per_s", "mm/s", p[0])],
        ..BASIS
    },
    Candidate {
        effect: Effect::AsymmetricActuator,
        shapes: |s| vec![Shape::new(0.3 * s.interval_s, 40.0 * s.interval_s, 8)],
        columns: |s, p, _| {
            let gain = s.x.iter().map(|x| 0.5 * x.abs()).collect();
            let lag = op::retract_lag(&s.x, p[0], s.interval_s);
            vec![gain, lag.iter().zip(&s.x).map(|(f, x)| f - x).collect()]
        },
        bounds: |_| {
            vec![
                Bound::FREE,
                Bound {
                    low: 0.0,
                    high: 1.1,
                },
            ]
        },
        parameters: |a, p, _| {
            vec![
                ("difference", "", a[0]),
                ("retract_lag_ms", "ms", 1e3 * p[0] * a[1]),
            ]
        },
        ..BASIS
    },
    Candidate {
        effect: Effect::MainsHum,
        shapes: humming,
        columns: |s, p, _| hum_columns(s, p),
        bounds: four,
        parameters: |a, p, _| {
            let (amplitude, third) = hum_size(a);
            vec![
                ("amplitude_mm", "mm", amplitude),
                ("frequency_hz", "Hz", p[0]),
                ("third_harmonic", "", third),
            ]
        },
        ..BASIS
    },
];
