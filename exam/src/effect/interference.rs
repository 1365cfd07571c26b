//! Mains hum, and what the converter rounds away.

use super::physics::{Acts, Channel, Physics, Scale, plus};
use crate::draws::Draws;
use crate::fine::DT;
use std::f64::consts::TAU;

pub(super) fn draw(
    name: &str,
    channel: Channel,
    unseen: bool,
    scale: &Scale,
    rng: &mut Draws,
) -> Option<Physics> {
    let unit = if channel == Channel::Actuator {
        scale.x
    } else {
        scale.x * scale.k
    };
    Some(match name {
        "mains_hum" => {
            let nominal = rng.pick(&[50.0, 60.0]);
            let hz = if unseen {
                nominal + rng.between(-0.25, 0.25)
            } else {
                nominal
            };
            let lines = if unseen {
                vec![(1.0, 1.0), (2.0, 0.2), (3.0, 0.35), (5.0, 0.12)]
            } else {
                vec![(1.0, 1.0), (3.0, rng.between(0.0, 0.4))]
            };
            let phases: Vec<f64> = lines.iter().map(|_| rng.between(0.0, TAU)).collect();
            let beat = if unseen { 0.1 } else { 0.0 };
            let mut physics = Physics::new(
                if unseen {
                    "off nominal by up to 0.25 Hz, harmonics 2, 3 and 5, swells by 10 %"
                } else {
                    "the mains frequency and its third harmonic"
                },
                (1e-5 * unit, 0.2 * unit),
                move |s, _, y| {
                    let hum = |t: f64| {
                        let swell = 1.0 + beat * (TAU * 0.4 * t).sin();
                        let sum: f64 = lines
                            .iter()
                            .zip(&phases)
                            .map(|((n, a), p)| a * (TAU * hz * n * t + p).sin())
                            .sum();
                        s * swell * sum
                    };
                    plus(y, (0..y.len()).map(|i| hum(i as f64 * DT)))
                },
            );
            physics.acts = Acts::Signal;
            physics.with(move |s| {
                if unseen {
                    vec![]
                } else if channel == Channel::Actuator {
                    vec![("amplitude_mm", s), ("frequency_hz", hz)]
                } else {
                    vec![("amplitude_n", s), ("frequency_hz", hz)]
                }
            })
        }
        "quantisation" => {
            let mut physics = Physics::new(
                if unseen {
                    "cut down to the step below, its steps unequal by a tenth"
                } else {
                    "rounded to a step"
                },
                (1e-4 * unit, 0.3 * unit),
                move |s, _, y| {
                    let code = |y: f64| {
                        if unseen {
                            let n = (y / s).floor();
                            s * (n + 0.5 + 0.1 * (1.7 * n).sin())
                        } else {
                            s * (y / s).round()
                        }
                    };
                    y.iter().map(|y| code(*y)).collect()
                },
            );
            physics.acts = Acts::Reading;
            physics.with(move |s| match (unseen, channel) {
                (true, _) => vec![],
                (false, Channel::Actuator) => vec![("step_mm", s)],
                (false, Channel::Specimen) => vec![("step_n", s)],
            })
        }
        _ => return None,
    })
}
