//! Delays, lags and ringing.

use super::physics::{Channel, Physics, Scale, plus};
use crate::draws::Draws;
use crate::fine::{DT, delay, lag, second_order};
use std::f64::consts::TAU;

pub(super) fn draw(
    name: &str,
    channel: Channel,
    unseen: bool,
    scale: &Scale,
    rng: &mut Draws,
) -> Option<Physics> {
    use Channel::{Actuator, Specimen};
    Some(match (name, channel) {
        ("delay_error", Actuator) if unseen => Physics::new(
            "eight equal short lags in a chain: a transport delay that smears",
            (2e-4, 0.05),
            |s, _, y| (0..8).fold(y.to_vec(), |y, _| lag(&y, s / 8.0)),
        ),
        ("delay_error", Actuator) => Physics::new("x(t - d)", (2e-4, 0.05), |s, _, y| delay(y, s))
            .with(|s| vec![("delay_ms", 1e3 * s)]),
        ("lag_error", Actuator) if unseen => {
            let typical = 0.5 * scale.v;
            Physics::new(
                "a lag whose time constant grows by up to a sixth with speed",
                (2e-4, 0.08),
                move |s, scene, y| {
                    let drive = scene.drive();
                    let known = lag(&drive.delayed, drive.lag_s);
                    let mut x = drive.delayed[0];
                    let mut v: f64 = 0.0;
                    let slow = drive.delayed.iter().map(|u| {
                        let share = v.abs() / (v.abs() + typical);
                        let time = drive.lag_s + s * (1.0 + 0.17 * share);
                        v = (u - x) / time;
                        x += DT * v;
                        x
                    });
                    plus(y, slow.zip(known).map(|(a, b)| a - b))
                },
            )
        }
        ("lag_error", Actuator) => Physics::new(
            "the first-order lag is longer",
            (2e-4, 0.08),
            |s, scene, y| {
                let drive = scene.drive();
                let slow = lag(&drive.delayed, drive.lag_s + s);
                let known = lag(&drive.delayed, drive.lag_s);
                plus(y, slow.into_iter().zip(known).map(|(a, b)| a - b))
            },
        )
        .with(|s| vec![("lag_ms", 1e3 * s)]),
        ("second_lag", Actuator) if unseen => Physics::new(
            "two further lags, the second a quarter of the first",
            (3e-4, 0.1),
            |s, _, y| lag(&lag(y, 0.8 * s), 0.2 * s),
        ),
        ("second_lag", Actuator) => {
            Physics::new("a further lag in series", (3e-4, 0.1), |s, _, y| lag(y, s))
                .with(|s| vec![("lag_ms", 1e3 * s)])
        }
        ("oil_column", Actuator) => {
            let ratio = rng.between(0.08, 0.3);
            let linear = if unseen { 0.5 * ratio } else { ratio };
            // As much as the linear part at the typical speed.
            let quadratic = if unseen { 0.5 * ratio / scale.v } else { 0.0 };
            let physics = Physics::new(
                if unseen {
                    "oil spring and mass, damped by leakage and by the square of velocity, behind a valve of 1 ms"
                } else {
                    "second order of frequency f and damping ratio z"
                },
                (1.0 / 150.0, 1.0 / (1.5 * scale.high_hz)),
                move |s, _, y| {
                    let omega = TAU / s;
                    let y = if unseen { lag(y, 1e-3) } else { y.to_vec() };
                    second_order(&y, omega, |v| {
                        2.0 * omega * (linear + quadratic * v.abs()) * v
                    })
                },
            );
            if unseen {
                physics
            } else {
                physics.with(move |s| vec![("frequency_hz", 1.0 / s), ("damping_ratio", ratio)])
            }
        }
        ("channel_skew", Specimen) if unseen => Physics::new(
            "an anti-alias filter of second order (Bessel) before the force's converter",
            (2e-4, 0.03),
            |s, _, y| {
                // Group delay s at low frequency is 2 z / w with z = sqrt(3) / 2.
                let omega = 3f64.sqrt() / s;
                second_order(y, omega, |v| 3f64.sqrt() * omega * v)
            },
        ),
        ("channel_skew", Specimen) => Physics::new("F(t - d)", (2e-4, 0.03), |s, _, y| delay(y, s))
            .with(|s| vec![("skew_ms", 1e3 * s)]),
        _ => return None,
    })
}

/// `F(t + d)`.
pub(super) fn early_force() -> Physics {
    Physics::new("F(t + d)", (2e-4, 0.03), |s, _, y| delay(y, -s))
        .with(|s| vec![("skew_ms", -1e3 * s)])
}
