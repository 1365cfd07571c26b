//! Effects between command and displacement; columns in mm.

use super::candidate::{Known, growth, hum_columns, stribeck};
use crate::laws::drivetrain::part::{Part, PartKind, Shapes, shapes};
use crate::laws::drivetrain::signal_path::SignalPath;
use crate::numbers::operators as op;
use crate::numbers::signals::{Scales, delayed, difference, lagged, resonant, unlagged};
use plant::Effect;

/// Base that most of them vary.
const BASIS: Known = Known {
    effect: Effect::Offset,
    columns: |s, _, _| vec![vec![1.0; s.x.len()]],
    stage: None,
};

/// The shape is the whole delay plus one interval, so that it is never 0.
fn extra_delay_s(shape: &[f64], k: &Scales) -> f64 {
    shape[0] - k.interval_s - k.declared.delay_s
}

/// A stage after the actuator, which has no columns of its own.
const STAGE: Known = Known {
    columns: |_, _, _| Vec::new(),
    ..BASIS
};

pub const EFFECTS: &[Known] = &[
    Known {
        effect: Effect::DelayError,
        stage: Some(|y, p, k| delayed(y, extra_delay_s(p, k), k.step_s)),
        ..STAGE
    },
    Known {
        effect: Effect::LagError,
        stage: Some(|y, p, k| {
            let known_s = k.actuator.lag_s;
            let lag_s = (known_s + p[0] - k.declared.lag_s).max(0.0);
            let before = unlagged(y, known_s, k.step_s);
            lagged(&before, lag_s, k.step_s)
        }),
        ..STAGE
    },
    Known {
        effect: Effect::SecondLag,
        stage: Some(|y, p, k| lagged(y, p[0], k.step_s)),
        ..STAGE
    },
    Known {
        effect: Effect::OilColumn,
        stage: Some(|y, p, k| resonant(y, p[0], [p[1], 0.0], k.step_s)),
        ..STAGE
    },
    Known {
        effect: Effect::GainError,
        columns: |s, _, _| vec![s.base.clone()],
        ..BASIS
    },
    BASIS,
    Known {
        effect: Effect::RigCompliance,
        columns: |s, _, _| vec![s.force.iter().map(|f| -f).collect()],
        ..BASIS
    },
    Known {
        effect: Effect::Drift,
        columns: |s, p, _| vec![growth(s, p[0]).map(|g| g * p[0]).collect()],
        ..BASIS
    },
    Known {
        effect: Effect::TemperatureGain,
        columns: |s, p, _| vec![growth(s, p[0]).zip(&s.base).map(|(g, x)| g * x).collect()],
        ..BASIS
    },
    Known {
        effect: Effect::CoulombFriction,
        columns: |s, p, _| vec![op::slider(&s.x, p[0]).iter().map(|z| -z).collect()],
        ..BASIS
    },
    Known {
        effect: Effect::StribeckFriction,
        columns: |s, p, _| {
            let z: Vec<f64> = op::slider(&s.x, p[0]).iter().map(|z| -z).collect();
            let slow = |v: &f64| (-(v / p[1]).powi(2)).exp();
            stribeck(z, s.v.iter().map(slow))
        },
        ..BASIS
    },
    Known {
        effect: Effect::Backlash,
        stage: Some(|y, p, _| op::play(y, p[0])),
        ..STAGE
    },
    Known {
        effect: Effect::DeadBand,
        stage: Some(|y, p, _| op::dead_zone(y, [p[0], 0.0, 0.0]).collect()),
        ..STAGE
    },
    Known {
        effect: Effect::Saturation,
        stage: Some(|y, p, _| y.iter().map(|y| y.clamp(-p[0], p[0])).collect()),
        ..STAGE
    },
    Known {
        effect: Effect::RateLimit,
        stage: Some(|y, p, k| op::slew(y, p[0] * k.step_s)),
        ..STAGE
    },
    Known {
        effect: Effect::AsymmetricActuator,
        columns: |s, p, k| {
            let gain = s.x.iter().map(|x| 0.5 * x.abs()).collect();
            let lag = op::retract_lag(&s.x, p[0], k.interval_s, s.interval_s);
            vec![gain, difference(&lag, &s.x)]
        },
        ..BASIS
    },
    Known {
        effect: Effect::MainsHum,
        columns: |s, p, _| hum_columns(s, p),
        ..BASIS
    },
];

/// Forms that the engine finds as parts of the path (`laws/drivetrain/part.rs`), in addition to those above: the same
/// names with other numbers of shapes. Here they are only read back from a model file.
pub const FORMS: &[Known] = &[
    // Unequal areas of a cylinder, x' = (e + b e^2) / T: b, 1/mm.
    Known {
        effect: Effect::AsymmetricActuator,
        stage: Some(|y, p, k| through_valve(y, k, PartKind::UnequalAreas, shapes([p[0]]))),
        ..STAGE
    },
    // A single rod, x' = (e + r |e|) / T: r.
    Known {
        effect: Effect::AsymmetricActuator,
        stage: Some(|y, p, k| through_valve(y, k, PartKind::TwoSpeeds, shapes([p[0]]))),
        ..STAGE
    },
    // An overlapped valve: overlap to either side, mm, and the lag after it, s.
    Known {
        effect: Effect::DeadBand,
        stage: Some(|y, p, k| through_valve(y, k, PartKind::Overlap, shapes([p[0]]))),
        ..STAGE
    },
    // A smoothly saturating flow: its saturation opening, mm, and the lag after it, s.
    Known {
        effect: Effect::RateLimit,
        stage: Some(|y, p, k| through_valve(y, k, PartKind::FlowLimit, shapes([p[0]]))),
        ..STAGE
    },
    // A largest flow, inside the lag: the limiting speed, mm/s, at gain 1.
    Known {
        effect: Effect::RateLimit,
        stage: Some(|y, p, k| through_valve(y, k, PartKind::RateLimit, shapes([p[0]]))),
        ..STAGE
    },
    // A resonance of the oil whose damping grows with speed: frequency, Hz, damping ratio, and its growth, s/mm.
    Known {
        effect: Effect::OilColumn,
        stage: Some(|y, p, k| resonant(y, p[0], [p[1], p[2]], k.step_s)),
        ..STAGE
    },
    // Stops: the lower, the upper, and how far their corners are rounded, mm.
    Known {
        effect: Effect::Saturation,
        stage: Some(|y, p, _| op::stopped(y, [p[0], p[1], p[2]])),
        ..STAGE
    },
    // The same with sharp corners.
    Known {
        effect: Effect::Saturation,
        stage: Some(|y, p, _| op::stopped(y, [p[0], p[1], 0.0])),
        ..STAGE
    },
    // A dead band: its width and its middle, mm.
    Known {
        effect: Effect::DeadBand,
        stage: Some(|y, p, _| op::dead_zone(y, [p[0], 0.0, p[1]]).collect()),
        ..STAGE
    },
    // Friction that turns over gradually: its level and its give, mm, and how round, see `op::dahl`.
    Known {
        effect: Effect::CoulombFriction,
        stage: Some(|y, p, _| {
            let held = op::dahl(y, p[1], p[2]);
            y.iter().zip(held).map(|(y, z)| y - p[0] * z).collect()
        }),
        ..STAGE
    },
    // A gain that drifts with time and by the own heat: its change with time, its time constant, s, and how much more by the
    // motion, 1/mm^2.
    Known {
        effect: Effect::TemperatureGain,
        columns: |s, p, _| {
            let heat = op::heated(&s.base, p[1], s.interval_s);
            let warms = growth(s, p[1]).zip(heat).zip(&s.base);
            vec![
                warms
                    .map(|((with_time, heat), x)| p[0] * (with_time + p[2] * heat) * x)
                    .collect(),
            ]
        },
        ..BASIS
    },
    // Seal friction against the oil's spring: the oil's compression and the seals' give, mm, and the lag after it, s.
    Known {
        effect: Effect::CoulombFriction,
        stage: Some(|y, p, k| through_valve(y, k, PartKind::Seal, shapes([p[0], p[1]]))),
        ..STAGE
    },
    // The same with friction that falls with speed: its level at rest over that in motion, and the speed, mm/s.
    Known {
        effect: Effect::StribeckFriction,
        stage: Some(|y, p, k| {
            through_valve(y, k, PartKind::StickySeal, shapes([p[0], p[1], p[2], p[3]]))
        }),
        ..STAGE
    },
];

/// A lag's response through another valve: the lag's input is recovered and passed through that valve.
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
