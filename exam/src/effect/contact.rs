//! Friction, play, dead zones, bolts.

use super::physics::{Channel, Physics, Scale, plus};
use crate::draws::Draws;
use crate::fine::DT;
use crate::rig::Scene;

pub(super) fn draw(
    name: &str,
    channel: Channel,
    unseen: bool,
    scale: &Scale,
    rng: &mut Draws,
) -> Option<Physics> {
    use Channel::{Actuator, Specimen};
    let force = scale.k * scale.x;
    let presliding = rng.log_between(0.003, 0.015) * scale.x;
    let stribeck = (rng.between(1.4, 2.5), rng.log_between(0.1, 0.5) * scale.v);
    Some(match (name, channel) {
        ("coulomb_friction", Specimen) if unseen => Physics::new(
            "LuGre, without Stribeck's drop",
            (1e-4 * force, 0.5 * force),
            move |s, scene, y| {
                let m = scene.motion();
                plus(y, lugre(&m.x, s, presliding, |_| 1.0))
            },
        ),
        ("coulomb_friction", Specimen) => Physics::new(
            "a slider behind a spring",
            (1e-4 * force, 0.5 * force),
            move |s, scene, y| plus(y, slider(&scene.motion().x, presliding).map(|z| s * z)),
        )
        .with(move |s| vec![("force_n", s), ("presliding_mm", presliding)]),
        ("coulomb_friction", Actuator) => Physics::new(
            if unseen {
                "held back by LuGre's bristles"
            } else {
                "held back by a slider behind a spring"
            },
            (1e-4 * scale.x, 0.1 * scale.x),
            move |s, _, y| {
                let way = presliding + s;
                let held: Vec<f64> = if unseen {
                    lugre(y, s, way, |_| 1.0).collect()
                } else {
                    slider(y, way).map(|z| s * z).collect()
                };
                plus(y, held.iter().map(|h| -h))
            },
        )
        .with(move |s| {
            if unseen {
                vec![]
            } else {
                vec![("error_mm", s)]
            }
        }),
        ("stribeck_friction", Specimen) => {
            let (ratio, speed) = stribeck;
            let physics = Physics::new(
                if unseen {
                    "LuGre with Stribeck's drop"
                } else {
                    "a slider whose limit drops with (v / vs)^2"
                },
                (1e-4 * force, 0.5 * force),
                move |s, scene, y| {
                    let m = scene.motion();
                    if unseen {
                        let limit = |v: f64| 1.0 + (ratio - 1.0) * (-(v / speed).abs()).exp();
                        plus(y, lugre(&m.x, s, presliding, limit))
                    } else {
                        let (mut z, mut before) = (0.0, m.x[0]);
                        plus(
                            y,
                            m.x.iter().map(|x| {
                                let way = x - before;
                                before = *x;
                                let v = way / DT / speed;
                                let limit = 1.0 + (ratio - 1.0) * (-v * v).exp();
                                z = (z + ratio * way / presliding).clamp(-limit, limit);
                                s * z
                            }),
                        )
                    }
                },
            );
            if unseen {
                physics
            } else {
                physics.with(move |s| {
                    vec![
                        ("force_n", s),
                        ("rest_ratio", ratio),
                        ("stribeck_mm_per_s", speed),
                    ]
                })
            }
        }
        ("backlash", _) => lost(
            (1e-4 * scale.x, 0.3 * scale.x),
            if unseen {
                "seven plays side by side, from half the width to one and a half"
            } else {
                "play"
            },
            move |s, x| {
                if unseen {
                    average(x, (0..7).map(|i| s * (0.5 + f64::from(i) / 6.0)), play)
                } else {
                    play(x, s)
                }
            },
        )
        .with(move |s| {
            if unseen {
                vec![]
            } else {
                vec![("width_mm", s)]
            }
        }),
        ("dead_band", _) => lost(
            (1e-4 * scale.x, 0.5 * scale.x),
            if unseen {
                "a dead zone with rounded corners"
            } else {
                "a dead zone"
            },
            move |s, x| {
                let (half, soft) = (0.5 * s, 0.12 * s);
                let passes = |x: f64| {
                    if unseen {
                        soft * (softplus((x - half) / soft) - softplus((-x - half) / soft))
                    } else {
                        (x.abs() - half).max(0.0) * x.signum()
                    }
                };
                x.iter().map(|x| passes(*x)).collect()
            },
        )
        .with(move |s| {
            if unseen {
                vec![]
            } else {
                vec![("width_mm", s)]
            }
        }),
        ("slip_gap", Specimen) => {
            let holds = rng.between(0.1, 0.4) * scale.x;
            let slip_n = holds * scale.k;
            lost(
                (1e-4 * scale.x, 0.6 * scale.x),
                if unseen {
                    "a group of five bolts that slip and bear one after the other"
                } else {
                    "a bolt holds, slips through its clearance, bears"
                },
                move |s, x| {
                    if unseen {
                        let bolts = (0..5).map(|i| 0.8 + 0.1 * f64::from(i));
                        average(x, bolts, |x, part| bolt(x, holds * part, s * part))
                    } else {
                        bolt(x, holds, s)
                    }
                },
            )
            .with(move |s| {
                if unseen {
                    vec![]
                } else {
                    vec![("gap_mm", s), ("slip_n", slip_n)]
                }
            })
        }
        _ => return None,
    })
}

/// Lost motion: of the actuator, or ahead of the specimen's spring.
fn lost(
    range: (f64, f64),
    equation: &'static str,
    passes: impl Fn(f64, &[f64]) -> Vec<f64> + Send + Sync + 'static,
) -> Physics {
    Physics::new(equation, range, move |s, scene, y| match scene {
        Scene::Actuator(_) => passes(s, y),
        Scene::Specimen(m) => plus(
            y,
            passes(s, &m.x)
                .into_iter()
                .zip(&m.x)
                .map(|(p, x)| m.k * (p - x)),
        ),
    })
}

fn average(
    x: &[f64],
    each: impl Iterator<Item = f64>,
    passes: impl Fn(&[f64], f64) -> Vec<f64>,
) -> Vec<f64> {
    let all: Vec<Vec<f64>> = each.map(|s| passes(x, s)).collect();
    (0..x.len())
        .map(|i| all.iter().map(|y| y[i]).sum::<f64>() / all.len() as f64)
        .collect()
}

/// Goes from one end of `-1..1` to the other over twice the pre-sliding distance after a reversal.
fn slider(x: &[f64], presliding: f64) -> impl Iterator<Item = f64> {
    let (mut z, mut before) = (0.0_f64, x[0]);
    x.iter().map(move |x| {
        z = (z + (x - before) / presliding).clamp(-1.0, 1.0);
        before = *x;
        z
    })
}

/// LuGre: `z' = v - s0 |v| z / g(v)`, `F = s0 z + s1 z'`, `s0 = force / presliding`, exact over a step of constant velocity.
fn lugre(
    x: &[f64],
    force: f64,
    presliding: f64,
    limit: impl Fn(f64) -> f64,
) -> impl Iterator<Item = f64> {
    let (mut z, mut before) = (0.0_f64, x[0]);
    x.iter().map(move |x| {
        let way = x - before;
        before = *x;
        let end = presliding * limit(way / DT);
        let next = way.signum() * end + (z - way.signum() * end) * (-way.abs() / end).exp();
        let rate = (next - z) / DT;
        z = next;
        force / presliding * (z + 5e-4 * rate)
    })
}

/// Play of a given width; the output starts in the middle.
fn play(x: &[f64], width: f64) -> Vec<f64> {
    let mut at = x[0];
    x.iter()
        .map(|x| {
            at = at.max(x - 0.5 * width).min(x + 0.5 * width);
            at
        })
        .collect()
}

fn bolt(x: &[f64], holds: f64, gap: f64) -> Vec<f64> {
    let mut slipped = 0.0_f64;
    x.iter()
        .map(|x| {
            slipped = slipped.max(x - holds).min(x + holds);
            slipped = slipped.clamp(-0.5 * gap, 0.5 * gap);
            x - slipped
        })
        .collect()
}

fn softplus(x: f64) -> f64 {
    x.max(0.0) + (-x.abs()).exp().ln_1p()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn sine() -> Vec<f64> {
        (0..16_000)
            .map(|i| 5.0 * (TAU * f64::from(i) * DT).sin())
            .collect()
    }

    /// Work during the second period of the sine.
    fn loop_area(x: &[f64], f: &[f64]) -> f64 {
        (8000..15_999)
            .map(|i| 0.5 * (f[i] + f[i + 1]) * (x[i + 1] - x[i]))
            .sum()
    }

    #[test]
    fn lugre_takes_the_work_of_friction_less_its_pre_sliding() {
        let x = sine();
        let f: Vec<f64> = lugre(&x, 20.0, 0.05, |_| 1.0).collect();
        // Each reversal loses 2 x (force x pre-sliding) while the bristles turn over: the integral of 2 exp(-s / p).
        let exact = 2.0 * 20.0 * (10.0 - 2.0 * 0.05);
        assert!((loop_area(&x, &f) / exact - 1.0).abs() < 5e-3);
    }

    #[test]
    fn lugre_holds_more_at_creep_where_stribeck_says_so() {
        let creep: Vec<f64> = (0..80_000).map(|i| 0.1 * f64::from(i) * DT).collect();
        let quick: Vec<f64> = creep.iter().map(|x| 500.0 * x).collect();
        let limit = |v: f64| 1.0 + 0.8 * (-(v / 5.0).abs()).exp();
        let last = |x: &[f64]| lugre(x, 10.0, 0.02, limit).last().unwrap();
        assert!((last(&creep) - 10.0 * limit(0.1)).abs() < 0.02);
        assert!((last(&quick) - 10.0).abs() < 0.01);
    }

    #[test]
    fn plays_and_bolts_lose_what_their_width_says() {
        let x = sine();
        assert!((play(&x, 0.4)[2000] - 4.8).abs() < 1e-6);
        let many = average(&x, (0..7).map(|i| 0.4 * (0.5 + f64::from(i) / 6.0)), play);
        assert!((many[2000] - 4.8).abs() < 1e-6);
        assert!((bolt(&x, 1.0, 0.6)[2000] - 4.7).abs() < 1e-6);
        assert!(loop_area(&x, &bolt(&x, 1.0, 0.6)) > 0.5);
    }
}
