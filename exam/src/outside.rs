//! Effects that no name of the effect list describes. The right answer is that something is missing, without a name.

use crate::draws::Draws;
use crate::effect::{Channel, Physics, Scale, plus};
use crate::fine::{DT, at, derivative, lag, peak, second_order};
use std::f64::consts::TAU;

/// The kinds and their channels.
pub(crate) const KINDS: [(&str, Channel); 9] = [
    ("breathing stiffness", Channel::Specimen),
    ("pump beside the specimen", Channel::Specimen),
    ("fracture in the middle", Channel::Specimen),
    ("appendage that resonates", Channel::Specimen),
    ("damping that grows with drift", Channel::Specimen),
    ("hunting valve", Channel::Actuator),
    ("dip of the oil pressure", Channel::Actuator),
    ("crosstalk from another axis", Channel::Actuator),
    ("wandering delay", Channel::Actuator),
];

/// Draws an effect of a kind.
pub(crate) fn draw(kind: usize, scale: &Scale, rng: &mut Draws) -> Physics {
    let (what, channel) = KINDS[kind];
    let unit = if channel == Channel::Actuator {
        scale.x
    } else {
        scale.x * scale.k
    };
    let seconds = scale.seconds;
    let time = |i: usize| i as f64 * DT;
    let added = (1e-4 * unit, 0.5 * unit);
    let physics = match kind {
        0 => {
            let hz = rng.between(0.7, 3.0);
            Physics::new(what, (1e-3, 0.8), move |s, scene, y| {
                let m = scene.motion();
                plus(
                    y,
                    (0..y.len()).map(|i| s * m.k * m.x[i] * (TAU * hz * time(i)).sin()),
                )
            })
        }
        1 => {
            let wave = narrow_band(rng.between(3.0, 9.0), 0.15, seconds, rng);
            Physics::new(what, added, move |s, _, y| {
                plus(y, (0..y.len()).map(|i| s * at(&wave, i as f64)))
            })
        }
        2 => {
            let when = rng.between(0.35, 0.55) * seconds;
            Physics::new(what, (1e-3, 0.8), move |s, scene, y| {
                let m = scene.motion();
                plus(
                    y,
                    (0..y.len()).map(|i| {
                        if time(i) > when {
                            -s * m.k * m.x[i]
                        } else {
                            0.0
                        }
                    }),
                )
            })
        }
        3 => {
            let omega = TAU * rng.between(0.3, 0.7) * scale.high_hz;
            Physics::new(what, added, move |s, scene, y| {
                let m = scene.motion();
                let moves = second_order(&m.x, omega, |v| 0.06 * omega * v);
                let felt = derivative(&derivative(&moves));
                let size = omega * omega * peak(&m.x);
                plus(y, felt.iter().map(|a| s * a / size))
            })
        }
        4 => {
            let (x, v) = (scale.x, scale.v);
            Physics::new(what, added, move |s, scene, y| {
                let m = scene.motion();
                plus(
                    y,
                    (0..y.len()).map(|i| s * (m.x[i] / x).powi(2) * m.v[i] / v),
                )
            })
        }
        5 => {
            let wave = narrow_band(rng.between(10.0, 18.0), 0.1, seconds, rng);
            Physics::new(what, added, move |s, _, y| {
                let speed = lag(
                    &derivative(y).iter().map(|v| v.abs()).collect::<Vec<_>>(),
                    0.2,
                );
                let most = peak(&speed);
                plus(
                    y,
                    (0..y.len())
                        .map(|i| s * (speed[i] / most).min(0.3) / 0.3 * at(&wave, i as f64)),
                )
            })
        }
        6 => {
            let (when, half) = (
                rng.between(0.3, 0.5) * seconds,
                rng.between(0.06, 0.12) * seconds,
            );
            Physics::new(what, (1e-3, 0.8), move |s, _, y| {
                let dip = |i| (-((time(i) - when) / half).powi(2)).exp();
                (0..y.len()).map(|i| y[i] * (1.0 - s * dip(i))).collect()
            })
        }
        7 => {
            let wave = narrow_band(rng.between(1.5, 4.0), 0.5, seconds, rng);
            Physics::new(what, added, move |s, _, y| {
                plus(y, (0..y.len()).map(|i| s * at(&wave, i as f64)))
            })
        }
        _ => {
            let hz = rng.between(0.4, 1.2);
            Physics::new(what, (2e-4, 0.1), move |s, _, y| {
                let late = |i| s * (TAU * hz * time(i)).sin() / DT;
                (0..y.len()).map(|i| at(y, i as f64 - late(i))).collect()
            })
        }
    };
    Physics {
        name: "",
        channel,
        ..physics
    }
}

/// Random motion of unit rms around a frequency, driven from 0.2 to 0.8 of the record.
fn narrow_band(hz: f64, ratio: f64, seconds: f64, rng: &mut Draws) -> Vec<f64> {
    let omega = TAU * hz;
    let shaking: Vec<f64> = (0..(seconds / DT) as usize)
        .map(|i| {
            let part = i as f64 * DT / seconds;
            if (0.2..0.8).contains(&part) {
                rng.normal()
            } else {
                0.0
            }
        })
        .collect();
    // A motion through oil has no acceleration far above the oil's frequency.
    let resonant = |u: &[f64]| second_order(u, omega, |v| 2.0 * ratio * omega * v);
    let mut wave = resonant(&resonant(&lag(&shaking, 1.0 / omega)));
    let size = crate::fine::rms(&wave);
    wave.iter_mut().for_each(|w| *w /= size);
    wave
}
