//! Dampers and mass.

use super::physics::{Channel, Physics, Scale, plus};
use crate::draws::Draws;
use crate::fine::{DT, second_order};
use std::f64::consts::TAU;

pub(super) fn draw(
    name: &str,
    channel: Channel,
    unseen: bool,
    scale: &Scale,
    rng: &mut Draws,
) -> Option<Physics> {
    if channel == Channel::Actuator {
        return None;
    }
    let force = scale.k * scale.x;
    let range = (1e-4 * force, force);
    let typical = scale.v;
    // The strength of each of the three dampers is its force at the typical velocity.
    let power = |equation, exponent: f64| {
        Physics::new(equation, range, move |s, scene, y| {
            let v = scene.motion().v.iter();
            plus(
                y,
                v.map(|v| s * (v / typical).abs().powf(exponent) * v.signum()),
            )
        })
    };
    Some(match name {
        "viscous_damping" if unseen => power("c |v|^0.92 sign v", 0.92),
        "viscous_damping" => {
            power("c v", 1.0).with(move |s| vec![("damping_n_s_per_mm", s / typical)])
        }
        "quadratic_damping" if unseen => power("c |v|^1.8 sign v", 1.8),
        "quadratic_damping" => power("c v |v|", 2.0)
            .with(move |s| vec![("damping_n_s2_per_mm2", s / (typical * typical))]),
        "maxwell_damper" => {
            // Viscous at the lower end of the band, elastic at the upper end.
            let relaxes = 1.0 / (TAU * scale.high_hz * rng.between(0.15, 0.5));
            let branches: Vec<(f64, f64)> = if unseen {
                vec![(0.6, 0.6 * relaxes), (0.4, 1.6 * relaxes)]
            } else {
                vec![(1.0, relaxes)]
            };
            let physics = Physics::new(
                if unseen {
                    "two Maxwell branches"
                } else {
                    "spring and dashpot in series"
                },
                range,
                move |s, scene, y| {
                    let m = scene.motion();
                    let mut forces = vec![0.0; branches.len()];
                    let mut before = m.v[0];
                    let stiffness = s / typical / relaxes;
                    plus(
                        y,
                        m.v.iter().map(|v| {
                            // Mean over the step that ends here.
                            let mean = 0.5 * (v + before);
                            before = *v;
                            for (f, (share, time)) in forces.iter_mut().zip(&branches) {
                                let end = share * stiffness * time * mean;
                                *f = end + (*f - end) * (-DT / time).exp();
                            }
                            forces.iter().sum()
                        }),
                    )
                },
            );
            if unseen {
                physics
            } else {
                physics.with(move |s| {
                    vec![
                        ("stiffness_n_per_mm", s / typical / relaxes),
                        ("relaxation_ms", 1e3 * relaxes),
                    ]
                })
            }
        }
        "inertia_force" => {
            let mount_hz = if unseen {
                rng.between(60.0, 120.0)
            } else {
                f64::INFINITY
            };
            let acceleration = typical * TAU * scale.high_hz;
            let physics = Physics::new(
                if unseen {
                    "a mass on a mount of 60 to 120 Hz, damped by 5 %"
                } else {
                    "m a"
                },
                (1e-4 * force, force),
                move |s, scene, y| {
                    let a = &scene.motion().a;
                    let felt = if unseen {
                        let omega = TAU * mount_hz;
                        second_order(a, omega, |v| 0.1 * omega * v)
                    } else {
                        a.clone()
                    };
                    plus(y, felt.iter().map(|a| s * a / acceleration))
                },
            );
            if unseen {
                physics
            } else {
                physics.with(move |s| vec![("mass_kg", 1e3 * s / acceleration)])
            }
        }
        _ => return None,
    })
}
