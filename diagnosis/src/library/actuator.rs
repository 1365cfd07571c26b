//! Effects between command and displacement; columns in mm.

use super::candidate::{
    Candidate, Shape, any, four, growth, hum_columns, hum_size, humming, no_shape, none, once,
    positive, rest_ratio, settling, stribeck,
};
use super::operators as op;
use crate::drivetrain::part::{Part, PartKind, Shapes, shapes};
use crate::drivetrain::signal_path::SignalPath;
use crate::linear::Bound;
use crate::signals::{Scales, delayed, difference, lagged, resonant, unlagged};
use plant::{Channel, Effect};

/// A candidate of this channel that generalises nothing.
const BASIS: Candidate = Candidate {
    effect: Effect::Offset,
    channel: Channel::Actuator,
    shapes: no_shape,
    columns: |s, _, _| vec![vec![1.0; s.x.len()]],
    stage: None,
    bounds: any,
    parameters: |a, _, _| vec![("offset_mm", "mm", a[0])],
};

/// The shape is the whole delay and one interval more, so that it is never 0.
fn extra_delay_s(shape: &[f64], k: &Scales) -> f64 {
    shape[0] - k.interval_s - k.declared.delay_s
}

/// A stage behind the actuator, which adds nothing of its own.
const STAGE: Candidate = Candidate {
    columns: |_, _, _| Vec::new(),
    bounds: none,
    ..BASIS
};

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
        stage: Some(|y, p, k| delayed(y, extra_delay_s(p, k), k.step_s)),
        parameters: |_, p, k| vec![("delay_ms", "ms", 1e3 * extra_delay_s(p, k))],
        ..STAGE
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
        stage: Some(|y, p, k| {
            let known_s = k.actuator.lag_s;
            let lag_s = (known_s + p[0] - k.declared.lag_s).max(0.0);
            let before = unlagged(y, known_s, k.step_s);
            lagged(&before, lag_s, k.step_s)
        }),
        parameters: |_, p, k| vec![("lag_ms", "ms", 1e3 * (p[0] - k.declared.lag_s))],
        ..STAGE
    },
    Candidate {
        effect: Effect::SecondLag,
        shapes: |s| vec![Shape::new(0.5 * s.interval_s, 60.0 * s.interval_s, 14)],
        stage: Some(|y, p, k| lagged(y, p[0], k.step_s)),
        parameters: |_, p, _| vec![("lag_ms", "ms", 1e3 * p[0])],
        ..STAGE
    },
    Candidate {
        effect: Effect::OilColumn,
        shapes: |s| {
            vec![
                Shape::new(3.0, 0.4 / s.interval_s, 12),
                Shape::new(0.02, 0.7, 5),
            ]
        },
        stage: Some(|y, p, k| resonant(y, p[0], p[1], k.step_s)),
        parameters: |_, p, _| vec![("frequency_hz", "Hz", p[0]), ("damping_ratio", "", p[1])],
        // Far below its frequency it is late by 2 zeta / omega, and no more.
        ..STAGE
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
        columns: |s, p, _| vec![op::slider(&s.x, p[0]).iter().map(|z| -z).collect()],
        bounds: positive,
        parameters: |a, p, _| vec![("error_mm", "mm", a[0]), ("presliding_mm", "mm", p[0])],
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
            let z: Vec<f64> = op::slider(&s.x, p[0]).iter().map(|z| -z).collect();
            let slow = |v: &f64| (-(v / p[1]).powi(2)).exp();
            stribeck(z, s.v.iter().map(slow))
        },
        bounds: |_| vec![Bound::POSITIVE; 2],
        parameters: |a, p, _| {
            vec![
                ("error_mm", "mm", a[0] + a[1]),
                ("rest_ratio", "", rest_ratio(a)),
                ("stribeck_mm_per_s", "mm/s", p[1]),
                ("presliding_mm", "mm", p[0]),
            ]
        },
        ..BASIS
    },
    Candidate {
        effect: Effect::Backlash,
        shapes: width,
        stage: Some(|y, p, _| op::play(y, p[0])),
        parameters: |_, p, _| vec![("width_mm", "mm", p[0])],
        ..STAGE
    },
    Candidate {
        effect: Effect::DeadBand,
        shapes: width,
        stage: Some(|y, p, _| op::dead_zone(y, p[0]).collect()),
        parameters: |_, p, _| vec![("width_mm", "mm", p[0])],
        ..STAGE
    },
    Candidate {
        effect: Effect::Saturation,
        shapes: |s| vec![Shape::new(0.3 * s.x, 0.998 * s.x, 16)],
        stage: Some(|y, p, _| y.iter().map(|y| y.clamp(-p[0], p[0])).collect()),
        parameters: |_, p, _| vec![("limit_mm", "mm", p[0])],
        ..STAGE
    },
    Candidate {
        effect: Effect::RateLimit,
        shapes: |s| vec![Shape::new(0.1 * s.v, 0.995 * s.v, 16)],
        stage: Some(|y, p, k| op::slew(y, p[0] * k.step_s)),
        parameters: |_, p, _| vec![("rate_mm_per_s", "mm/s", p[0])],
        ..STAGE
    },
    Candidate {
        effect: Effect::AsymmetricActuator,
        shapes: |s| vec![Shape::new(0.03 * s.interval_s, 40.0 * s.interval_s, 10)],
        columns: |s, p, k| {
            let gain = s.x.iter().map(|x| 0.5 * x.abs()).collect();
            let lag = op::retract_lag(&s.x, p[0], k.interval_s, s.interval_s);
            vec![gain, difference(&lag, &s.x)]
        },
        // The lag of the way back acts once: its size is its shape.
        bounds: |s| [vec![Bound::FREE], once(s)].concat(),
        parameters: |a, p, _| {
            vec![
                ("difference", "", a[0]),
                ("retract_lag_ms", "ms", 1e3 * p[0]),
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

/// Forms that the engine finds as parts of the path (`drivetrain/part.rs`), beside those above: the same names, other numbers
/// of shapes. Here they are only read back from a model file.
pub const FORMS: &[Candidate] = &[
    // Unequal areas of a cylinder, x' = (e + b e^2) / T: b, 1/mm.
    Candidate {
        effect: Effect::AsymmetricActuator,
        shapes: |s| vec![Shape::new(-1.0 / s.x, 1.0 / s.x, 1)],
        stage: Some(|y, p, k| through_valve(y, k, PartKind::UnequalAreas, shapes([p[0]]))),
        parameters: |_, p, _| vec![("unequal_areas_per_mm", "1/mm", p[0])],
        ..STAGE
    },
    // A single rod, x' = (e + r |e|) / T: r.
    Candidate {
        effect: Effect::AsymmetricActuator,
        shapes: |_| vec![Shape::new(-0.9, 0.9, 1)],
        stage: Some(|y, p, k| through_valve(y, k, PartKind::TwoSpeeds, shapes([p[0]]))),
        parameters: |_, p, _| vec![("flow_difference", "", p[0])],
        ..STAGE
    },
    // A valve that overlaps: to either side, mm, and the lag behind it, s.
    Candidate {
        effect: Effect::DeadBand,
        shapes: |s| {
            vec![
                Shape::new(1e-3 * s.x, 0.5 * s.x, 1),
                Shape::new(1e-4, 1.0, 1),
            ]
        },
        stage: Some(|y, p, k| through_valve(y, k, PartKind::Overlap, shapes([p[0]]))),
        parameters: |_, p, _| vec![("width_mm", "mm", 2.0 * p[0])],
        ..STAGE
    },
    // A flow that saturates smoothly: the opening where it does, mm, and the lag behind it, s.
    Candidate {
        effect: Effect::RateLimit,
        shapes: |s| {
            vec![
                Shape::new(1e-3 * s.x, 10.0 * s.x, 1),
                Shape::new(1e-4, 1.0, 1),
            ]
        },
        stage: Some(|y, p, k| through_valve(y, k, PartKind::FlowLimit, shapes([p[0]]))),
        parameters: |_, p, _| vec![("rate_mm_per_s", "mm/s", p[0] / p[1].max(1e-6))],
        ..STAGE
    },
    // A largest flow, inside the lag: the speed at which it ends, mm/s, at gain 1.
    Candidate {
        effect: Effect::RateLimit,
        shapes: |s| vec![Shape::new(0.1 * s.v, 2.0 * s.v, 1)],
        stage: Some(|y, p, k| through_valve(y, k, PartKind::RateLimit, shapes([p[0]]))),
        parameters: |_, p, _| vec![("rate_mm_per_s", "mm/s", p[0])],
        ..STAGE
    },
    // Stops: the lower and the upper, mm.
    Candidate {
        effect: Effect::Saturation,
        shapes: |s| vec![Shape::new(-s.x, s.x, 1), Shape::new(-s.x, s.x, 1)],
        stage: Some(|y, p, _| y.iter().map(|y| y.min(p[1]).max(p[0])).collect()),
        parameters: |_, p, _| vec![("limit_mm", "mm", p[0].abs().min(p[1].abs()))],
        ..STAGE
    },
    // Friction of seals against the spring of the oil: what it bends it by and the seals' give, mm, and the lag behind it, s.
    Candidate {
        effect: Effect::CoulombFriction,
        shapes: |s| vec![Shape::new(1e-3 * s.x, 0.3 * s.x, 1); 3],
        stage: Some(|y, p, k| through_valve(y, k, PartKind::Seal, shapes([p[0], p[1]]))),
        parameters: |_, p, _| vec![("error_mm", "mm", p[0]), ("presliding_mm", "mm", p[1])],
        ..STAGE
    },
    // The same where it falls with speed: its level at rest over that in motion, and the speed, mm/s.
    Candidate {
        effect: Effect::StribeckFriction,
        shapes: |s| vec![Shape::new(1e-3 * s.x, 0.3 * s.x, 1); 5],
        stage: Some(|y, p, k| {
            through_valve(y, k, PartKind::StickySeal, shapes([p[0], p[1], p[2], p[3]]))
        }),
        parameters: |_, p, _| {
            vec![
                ("error_mm", "mm", p[0]),
                ("rest_ratio", "", p[2]),
                ("stribeck_mm_per_s", "mm/s", p[3]),
                ("presliding_mm", "mm", p[1]),
            ]
        },
        ..STAGE
    },
];

/// The answer of a lag as it would be behind another valve: what went into the lag, through that valve.
fn through_valve(y: &[f64], k: &Scales, kind: PartKind, shapes: Shapes) -> Vec<f64> {
    let known = k.actuator;
    let plain: Vec<f64> = y
        .iter()
        .map(|y| (y - known.offset_mm) / known.gain)
        .collect();
    let input = unlagged(&plain, known.lag_s, k.step_s);
    let path = SignalPath {
        delay_s: 0.0,
        lag_s: known.lag_s,
        parts: vec![Part { kind, shapes }],
    };
    let answer = path.valve(&input, k.step_s);
    let whole = answer.iter().map(|y| known.gain * y + known.offset_mm);
    whole.collect()
}
