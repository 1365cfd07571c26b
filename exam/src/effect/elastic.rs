//! Nonlinear springs.

use super::physics::{Channel, Physics, Scale, plus};
use crate::draws::Draws;

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
    let largest = scale.x;
    let sign = rng.sign();
    // `shape` is the added force over k, at a drift `r`; both in units of the largest drift.
    let spring = |equation, shape: Box<dyn Fn(f64, f64) -> f64 + Send + Sync>| {
        Physics::new(equation, (0.01, 1.9), move |s, scene, y| {
            let m = scene.motion();
            plus(y, m.x.iter().map(|x| m.k * largest * shape(s, x / largest)))
        })
    };
    Some(match name {
        "hardening" if unseen => spring(
            "k d sinh(x / d)",
            Box::new(|s, r| (s * 2.0 * r).sinh() / (2.0 * s) - r),
        ),
        "hardening" => {
            let exponent = rng.between(1.5, 3.0);
            spring(
                "k x |x / d|^p",
                Box::new(move |s, r| r * (s * r).abs().powf(exponent)),
            )
            .with(move |s| vec![("reference_mm", largest / s), ("exponent", exponent)])
        }
        "softening" if unseen => spring("k d tanh(x / d)", Box::new(|s, r| (s * r).tanh() / s - r)),
        "softening" => {
            let exponent = rng.between(0.8, 2.0);
            spring(
                "k x / (1 + |x / d|^p)",
                Box::new(move |s, r| {
                    let p = (s * r).abs().powf(exponent);
                    -r * p / (1.0 + p)
                }),
            )
            .with(move |s| vec![("reference_mm", largest / s), ("exponent", exponent)])
        }
        "asymmetric_stiffness" if unseen => spring(
            "stiffness that passes smoothly from one way to the other",
            Box::new(move |s, r| sign * s * 0.5 * (r * r + 0.01).sqrt() - sign * s * 0.05),
        ),
        "asymmetric_stiffness" => spring(
            "k (1 + d/2) one way, k (1 - d/2) the other",
            Box::new(move |s, r| 0.5 * sign * s * r.abs()),
        )
        .with(move |s| vec![("difference", sign * s)]),
        _ => return None,
    })
}
