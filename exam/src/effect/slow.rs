//! Slow changes with time.

use super::physics::{Channel, Physics, Scale, plus};
use crate::draws::Draws;
use crate::fine::DT;

pub(super) fn draw(
    name: &str,
    channel: Channel,
    unseen: bool,
    scale: &Scale,
    rng: &mut Draws,
) -> Option<Physics> {
    let actuator = channel == Channel::Actuator;
    let sign = rng.sign();
    let unit = if actuator { scale.x } else { scale.x * scale.k };
    // About the square of a third of the range.
    let power = 0.1 * unit * unit;
    let seconds = scale.seconds;
    let clock = |n: usize| (0..n).map(|i| i as f64 * DT);
    Some(match name {
        "drift" => {
            let range = (1e-4 * unit, 0.5 * unit);
            let parameter = if actuator {
                "rate_mm_per_s"
            } else {
                "rate_n_per_s"
            };
            if unseen {
                let (quick, slow) = (
                    rng.between(0.1, 0.3) * seconds,
                    rng.between(0.6, 2.0) * seconds,
                );
                let share = rng.between(0.25, 0.75);
                Physics::new(
                    "two bodies warm up, each with its time constant",
                    range,
                    move |s, _, y| {
                        let grown = |t: f64| {
                            1.0 - share * (-t / quick).exp() - (1.0 - share) * (-t / slow).exp()
                        };
                        plus(y, clock(y.len()).map(|t| sign * s * grown(t)))
                    },
                )
            } else if rng.chance(0.5) {
                Physics::new("y + r t", range, move |s, _, y| {
                    plus(y, clock(y.len()).map(|t| sign * s * t / seconds))
                })
                .with(move |s| vec![(parameter, sign * s / seconds)])
            } else {
                let tau = rng.between(0.3, 1.0) * seconds;
                Physics::new("y + r T (1 - exp(-t / T))", range, move |s, _, y| {
                    plus(
                        y,
                        clock(y.len()).map(|t| sign * s * (1.0 - (-t / tau).exp())),
                    )
                })
                .with(move |s| vec![(parameter, sign * s / tau), ("time_constant_s", tau)])
            }
        }
        "temperature_gain" if unseen => {
            let tau = rng.between(0.2, 0.8) * seconds;
            Physics::new(
                "the gain follows the heat of the signal's own power and of the room",
                (1e-3, 0.5),
                move |s, _, y| {
                    let mut heat = 0.0;
                    y.iter()
                        .map(|y| {
                            heat += DT / tau * (0.5 * y * y / power + 0.5 - heat);
                            y * (1.0 + sign * s * heat)
                        })
                        .collect()
                },
            )
        }
        "temperature_gain" => {
            let tau = rng.between(0.2, 1.0) * seconds;
            Physics::new(
                "(1 + c (1 - exp(-t / T))) y",
                (1e-3, 0.5),
                move |s, _, y| {
                    let gain = |t: f64| sign * s * (1.0 - (-t / tau).exp());
                    plus(y, y.iter().zip(clock(y.len())).map(|(y, t)| y * gain(t)))
                },
            )
            .with(move |s| vec![("change", sign * s), ("time_constant_s", tau)])
        }
        _ => return None,
    })
}
