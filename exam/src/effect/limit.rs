//! Limits of stroke, range and flow; pistons that push and pull differently.

use super::physics::{Channel, Physics, Scale, plus};
use crate::draws::Draws;
use crate::fine::{DT, lag};

pub(super) fn draw(
    name: &str,
    channel: Channel,
    unseen: bool,
    scale: &Scale,
    rng: &mut Draws,
) -> Option<Physics> {
    use Channel::Actuator;
    let range_of_signal = if channel == Actuator {
        scale.x
    } else {
        scale.x * scale.k
    };
    // The peak velocity is about four times its rms.
    let fastest = 4.0 * scale.v;
    Some(match (name, channel) {
        ("saturation", _) if unseen => {
            let sharp = rng.between(10.0, 20.0);
            Physics::new("y / (1 + |y / L|^n)^(1/n)", (0.7, 2.5), move |s, _, y| {
                let limit = range_of_signal / s;
                let clipped = |y: f64| y / (1.0 + (y / limit).abs().powf(sharp)).powf(1.0 / sharp);
                y.iter().map(|y| clipped(*y)).collect()
            })
        }
        ("saturation", _) => Physics::new("clipped at its limit", (1.0, 2.5), move |s, _, y| {
            let limit = range_of_signal / s;
            y.iter().map(|y| y.clamp(-limit, limit)).collect()
        })
        .with(move |s| {
            let name = if channel == Actuator {
                "limit_mm"
            } else {
                "limit_n"
            };
            vec![(name, range_of_signal / s)]
        }),
        ("rate_limit", Actuator) => Physics::new(
            if unseen {
                "the flow of the valve saturates: v = L tanh(error / (T L))"
            } else {
                "the velocity is clipped"
            },
            (if unseen { 0.1 } else { 0.5 }, 12.0),
            move |s, scene, y| {
                let drive = scene.drive();
                let most = fastest / s;
                if unseen {
                    let known = lag(&drive.delayed, drive.lag_s);
                    let mut x = drive.delayed[0];
                    let valve = drive.delayed.iter().map(|u| {
                        x += DT * most * ((u - x) / (drive.lag_s * most)).tanh();
                        x
                    });
                    plus(y, valve.zip(known).map(|(a, b)| a - b))
                } else {
                    let mut x = y[0];
                    y.iter()
                        .map(|y| {
                            x += (y - x).clamp(-most * DT, most * DT);
                            x
                        })
                        .collect()
                }
            },
        )
        .with(move |s| {
            if unseen {
                vec![]
            } else {
                vec![("rate_mm_per_s", fastest / s)]
            }
        }),
        ("asymmetric_actuator", Actuator) if unseen => {
            let sign = rng.sign();
            Physics::new(
                "a valve with unequal openings: the lag is shorter one way than the other",
                (1e-3, 0.6),
                move |s, scene, y| {
                    let drive = scene.drive();
                    let known = lag(&drive.delayed, drive.lag_s);
                    let mut x = drive.delayed[0];
                    let valve = drive.delayed.iter().map(|u| {
                        let error = u - x;
                        x += DT * error / drive.lag_s * (1.0 + sign * s * error.signum());
                        x
                    });
                    plus(y, valve.zip(known).map(|(a, b)| a - b))
                },
            )
        }
        ("asymmetric_actuator", Actuator) => {
            let sign = rng.sign();
            Physics::new(
                "gain 1 + d/2 pushing, 1 - d/2 pulling",
                (1e-3, 0.6),
                move |s, _, y| {
                    y.iter()
                        .map(|y| y * (1.0 + 0.5 * sign * s * y.signum()))
                        .collect()
                },
            )
            .with(move |s| vec![("difference", sign * s)])
        }
        _ => return None,
    })
}
