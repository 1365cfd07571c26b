//! Effects between displacement and force; columns in N.

use super::candidate::{
    Candidate, Known, Shape, any, four, growth, hum_columns, hum_size, humming, no_shape, none,
    once, positive, rest_ratio, settling, stribeck,
};
use crate::numbers::linear::Bound;
use crate::numbers::operators as op;
use crate::numbers::signals::{Scales, Signals, delayed};
use plant::Effect;

/// The base of this channel's candidates.
const BASIS: Candidate = Candidate {
    effect: Effect::Offset,
    shapes: no_shape,
    columns: |s, _, _| vec![vec![1.0; s.x.len()]],
    stage: None,
    bounds: any,
    parameters: |a, _, _| vec![("offset_n", "N", a[0])],
};

fn times(x: &[f64], factor: f64) -> Vec<f64> {
    x.iter().map(|x| factor * x).collect()
}

/// `k (f(x) - x)`: the missing force if only `f(x)` of the displacement acts.
fn instead(x: &[f64], felt: impl IntoIterator<Item = f64>, stiffness: f64) -> Vec<Vec<f64>> {
    vec![
        felt.into_iter()
            .zip(x)
            .map(|(f, x)| stiffness * (f - x))
            .collect(),
    ]
}

fn share(_: &Scales) -> Vec<Bound> {
    vec![Bound {
        low: 0.0,
        high: 1.0,
    }]
}

fn width(s: &Scales) -> Vec<Shape> {
    vec![Shape::new(0.003 * s.x, 0.9 * s.x)]
}

fn presliding(s: &Scales) -> Vec<Shape> {
    vec![Shape::new(0.001 * s.x, 0.3 * s.x)]
}

/// Powers of the displacement, relative to the largest, with the displacement itself.
fn power(s: &Signals, exponent: f64, k: &Scales) -> impl Iterator<Item = (f64, f64)> {
    let (x, scale) = (s.x.clone(), k.x);
    x.into_iter()
        .map(move |x| (x, (x / scale).abs().powf(exponent)))
}

/// Fraction of a stiffness lost at a displacement: half at the reference, with a steepness set by the exponent.
fn lost(at_mm: f64, [reference_mm, exponent]: [f64; 2]) -> f64 {
    1.0 - 1.0 / (1.0 + (at_mm / reference_mm).powf(exponent))
}

/// A spring's loss by travel: the other form of `degradation`.
pub const FATIGUE: Candidate = Candidate {
    effect: Effect::Degradation,
    shapes: |s| {
        // Back and forth at a third of the top speed.
        let travel = 0.3 * s.v * s.seconds;
        vec![Shape::new(0.02 * travel, 20.0 * travel)]
    },
    columns: |s, p, k| {
        let travel = op::travel(&s.v, s.interval_s, s.travel_before_mm);
        // Applied to the spring's force in the model, with the reading's noise, like a gain that changes with time.
        let forces = s.reading.iter().zip(travel);
        vec![
            forces
                .map(|(x, w)| -k.stiffness * x * w / (w + p[0]))
                .collect(),
        ]
    },
    bounds: share,
    parameters: |a, p, _| vec![("travel_mm", "mm", p[0]), ("lost_share", "", a[0])],
    ..BASIS
};

/// Sharpness of a limit with a rounded corner. A fit may go down to half of it, where a channel is still of transducer class 0.5 %
/// at half of its limit; softer, it is a force that levels off.
const SHARP: f64 = 10.0;

/// A force limit with a rounded corner: the rival of a softening spring.
pub const ROUNDED_LIMIT: Candidate = Candidate {
    effect: Effect::Saturation,
    shapes: |s| {
        vec![
            Shape::new(0.3 * s.base, 1.5 * s.base),
            Shape::new(SHARP, 4.0 * SHARP),
        ]
    },
    columns: |s, p, _| rounded(s, [p[0], p[1]]),
    bounds: once,
    parameters: |_, p, _| vec![("limit_n", "N", p[0]), ("sharpness", "", p[1])],
    ..BASIS
};

/// A force limit whose two ends are not equally far from zero, as of an amplifier that was balanced under load: half of the
/// distance between them, and their middle.
pub const OFF_CENTRE_LIMIT: Candidate = Candidate {
    effect: Effect::Saturation,
    shapes: |s| {
        vec![
            Shape::new(0.3 * s.base, 0.998 * s.base),
            Shape::new(-0.5 * s.base, 0.5 * s.base),
        ]
    },
    columns: |s, p, _| between(s, [p[1] - p[0], p[1] + p[0]]),
    bounds: once,
    parameters: |_, p, _| vec![("lower_n", "N", p[1] - p[0]), ("upper_n", "N", p[1] + p[0])],
    ..BASIS
};

/// What a limit with a rounded corner takes from the force.
fn rounded(s: &Signals, [limit, sharpness]: [f64; 2]) -> Vec<Vec<f64>> {
    let ends = |f: &f64| f / (1.0 + (f / limit).abs().powf(sharpness)).powf(1.0 / sharpness);
    vec![s.base.iter().map(|f| ends(f) - f).collect()]
}

/// What two limits take from the force.
fn between(s: &Signals, [lower, upper]: [f64; 2]) -> Vec<Vec<f64>> {
    let cut = s.base.iter().map(|f| f.min(upper).max(lower) - f);
    vec![cut.collect()]
}

/// Forms that the engine finds in addition to those below, as they are read back from a model file.
pub const FORMS: &[Known] = &[
    Known {
        effect: Effect::Saturation,
        columns: |s, p, _| between(s, [p[0], p[1]]),
        stage: None,
    },
    Known {
        effect: Effect::Saturation,
        columns: |s, p, _| rounded(s, [p[0], p[1]]),
        stage: None,
    },
];

/// Largest rounding of a gap's corners, relative to the gap: there they meet in the middle, and a spring that is felt
/// there is one that stiffens.
const ROUND: f64 = 0.5;

/// A gap with rounded corners: the rival of a stiffening spring.
pub const ROUNDED_GAP: Candidate = Candidate {
    effect: Effect::DeadBand,
    shapes: |s| [width(s), vec![Shape::new(0.1 * ROUND, ROUND)]].concat(),
    columns: |s, p, k| {
        instead(
            &s.x,
            op::dead_zone(&s.x, [p[0], p[0] * p[1], 0.0]),
            k.stiffness,
        )
    },
    bounds: once,
    parameters: |_, p, _| vec![("width_mm", "mm", p[0])],
    ..BASIS
};

pub const CANDIDATES: &[Candidate] = &[
    Candidate {
        effect: Effect::ChannelSkew,
        shapes: |_| vec![Shape::new(-0.03, 0.03)],
        columns: |_, _, _| Vec::new(),
        stage: Some(|f, p, k| delayed(f, p[0], k.step_s)),
        bounds: none,
        parameters: |_, p, _| vec![("skew_ms", "ms", 1e3 * p[0])],
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
        columns: |s, _, k| vec![times(&s.base, -k.stiffness)],
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
                ("rate_n_per_s", "N/s", a[0]),
                ("time_constant_s", "s", p[0]),
            ]
        },
        ..BASIS
    },
    Candidate {
        effect: Effect::TemperatureGain,
        shapes: settling,
        columns: |s, p, _| vec![growth(s, p[0]).zip(&s.base).map(|(g, f)| g * f).collect()],
        parameters: |a, p, _| vec![("change", "", a[0]), ("time_constant_s", "s", p[0])],
        ..BASIS
    },
    Candidate {
        effect: Effect::CoulombFriction,
        shapes: presliding,
        columns: |s, p, _| vec![op::slider(&s.x, p[0])],
        bounds: positive,
        parameters: |a, p, _| vec![("force_n", "N", a[0]), ("presliding_mm", "mm", p[0])],
        ..BASIS
    },
    Candidate {
        effect: Effect::StribeckFriction,
        shapes: |s| {
            vec![
                Shape::new(0.001 * s.x, 0.1 * s.x),
                Shape::new(0.01 * s.v, 0.5 * s.v),
            ]
        },
        columns: |s, p, _| {
            let z = op::slider(&s.x, p[0]);
            let slow = |v: &f64| (-(v / p[1]).powi(2)).exp();
            stribeck(z, s.v.iter().map(slow))
        },
        bounds: |_| vec![Bound::POSITIVE; 2],
        parameters: |a, p, _| {
            vec![
                ("force_n", "N", a[0] + a[1]),
                ("rest_ratio", "", rest_ratio(a)),
                ("stribeck_mm_per_s", "mm/s", p[1]),
                ("presliding_mm", "mm", p[0]),
            ]
        },
        ..BASIS
    },
    Candidate {
        effect: Effect::BilinearHysteresis,
        shapes: |s| vec![Shape::new(0.05 * s.x, 0.97 * s.x)],
        columns: |s, p, k| instead(&s.x, op::elastic_plastic(&s.x, p[0]), k.stiffness),
        bounds: share,
        parameters: |a, p, _| {
            vec![
                ("yield_mm", "mm", p[0]),
                ("hardening_ratio", "", 1.0 - a[0]),
            ]
        },
        ..BASIS
    },
    Candidate {
        effect: Effect::BoucWenHysteresis,
        shapes: |s| vec![Shape::new(0.05 * s.x, 0.97 * s.x), Shape::new(0.7, 12.0)],
        columns: |s, p, k| instead(&s.x, op::bouc_wen(&s.x, p[0], p[1], 0.5), k.stiffness),
        bounds: share,
        parameters: |a, p, _| {
            vec![
                ("yield_mm", "mm", p[0]),
                ("hardening_ratio", "", 1.0 - a[0]),
                ("sharpness", "", p[1]),
            ]
        },
        ..BASIS
    },
    Candidate {
        effect: Effect::Backlash,
        shapes: width,
        columns: |s, p, k| instead(&s.x, op::play(&s.x, p[0]), k.stiffness),
        bounds: once,
        parameters: |_, p, _| vec![("width_mm", "mm", p[0])],
        ..BASIS
    },
    Candidate {
        effect: Effect::DeadBand,
        shapes: width,
        columns: |s, p, k| instead(&s.x, op::dead_zone(&s.x, [p[0], 0.0, 0.0]), k.stiffness),
        bounds: once,
        parameters: |_, p, _| vec![("width_mm", "mm", p[0])],
        ..BASIS
    },
    Candidate {
        effect: Effect::SlipGap,
        shapes: |s| {
            vec![
                Shape::new(0.01 * s.x, s.x),
                Shape::new(0.02 * s.x, 0.9 * s.x),
            ]
        },
        columns: |s, p, k| vec![times(&op::slipped(&s.x, p[1], p[0]), -k.stiffness)],
        bounds: once,
        parameters: |_, p, k| vec![("gap_mm", "mm", p[0]), ("slip_n", "N", p[1] * k.stiffness)],
        ..BASIS
    },
    Candidate {
        effect: Effect::Saturation,
        shapes: |s| vec![Shape::new(0.3 * s.base, 0.998 * s.base)],
        columns: |s, p, _| vec![s.base.iter().map(|f| f.clamp(-p[0], p[0]) - f).collect()],
        bounds: once,
        parameters: |_, p, _| vec![("limit_n", "N", p[0])],
        ..BASIS
    },
    Candidate {
        effect: Effect::ViscousDamping,
        columns: |s, _, _| vec![s.v.clone()],
        parameters: |a, _, _| vec![("damping_n_s_per_mm", "N s/mm", a[0])],
        bounds: positive,
        ..BASIS
    },
    Candidate {
        effect: Effect::QuadraticDamping,
        columns: |s, _, _| vec![s.v.iter().map(|v| v * v.abs()).collect()],
        parameters: |a, _, _| vec![("damping_n_s2_per_mm2", "N s2/mm2", a[0])],
        bounds: positive,
        ..BASIS
    },
    Candidate {
        effect: Effect::MaxwellDamper,
        shapes: |s| vec![Shape::new(2.0 * s.interval_s, 0.2 * s.seconds)],
        columns: |s, p, _| vec![op::relaxed(&s.x, p[0], s.interval_s)],
        bounds: positive,
        parameters: |a, p, _| {
            vec![
                ("stiffness_n_per_mm", "N/mm", a[0]),
                ("relaxation_ms", "ms", 1e3 * p[0]),
            ]
        },
        ..BASIS
    },
    Candidate {
        effect: Effect::Hardening,
        shapes: |_| vec![Shape::new(0.5, 6.0)],
        columns: |s, p, k| {
            vec![
                power(s, p[0], k)
                    .map(|(x, r)| k.stiffness * x * r)
                    .collect(),
            ]
        },
        bounds: positive,
        parameters: |a, p, k| {
            vec![
                (
                    "reference_mm",
                    "mm",
                    k.x * a[0].max(1e-12).powf(-1.0 / p[0]),
                ),
                ("exponent", "", p[0]),
            ]
        },
        ..BASIS
    },
    Candidate {
        effect: Effect::Softening,
        // The reference displacement, then the exponent: the softening has no proportional amplitude.
        shapes: |s| vec![Shape::new(0.3 * s.x, 30.0 * s.x), Shape::new(0.7, 5.0)],
        columns: |s, p, k| {
            let forces = s.x.iter();
            vec![
                forces
                    .map(|x| -k.stiffness * x * lost(x.abs(), [p[0], p[1]]))
                    .collect(),
            ]
        },
        bounds: once,
        parameters: |_, p, _| vec![("reference_mm", "mm", p[0]), ("exponent", "", p[1])],
        ..BASIS
    },
    Candidate {
        effect: Effect::Degradation,
        shapes: |s| vec![Shape::new(0.1 * s.x, 30.0 * s.x), Shape::new(0.2, 4.0)],
        columns: |s, p, k| {
            let largest = op::largest(&s.x, s.largest_before_mm);
            let forces = s.x.iter().zip(largest);
            vec![
                forces
                    .map(|(x, l)| -k.stiffness * x * lost(l, [p[0], p[1]]))
                    .collect(),
            ]
        },
        bounds: once,
        parameters: |_, p, _| vec![("reference_mm", "mm", p[0]), ("exponent", "", p[1])],
        ..BASIS
    },
    FATIGUE,
    Candidate {
        effect: Effect::AsymmetricStiffness,
        columns: |s, _, k| vec![s.x.iter().map(|x| 0.5 * k.stiffness * x.abs()).collect()],
        parameters: |a, _, _| vec![("difference", "", a[0])],
        ..BASIS
    },
    Candidate {
        effect: Effect::InertiaForce,
        columns: |s, _, _| vec![times(&s.a, 1e-3)],
        bounds: positive,
        parameters: |a, _, _| vec![("mass_kg", "kg", a[0])],
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
                ("amplitude_n", "N", amplitude),
                ("frequency_hz", "Hz", p[0]),
                ("third_harmonic", "", third),
            ]
        },
        ..BASIS
    },
];
