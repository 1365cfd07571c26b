//! Inverses of third and fifth order, as sums of the motion ahead.

use super::Sum;
use nalgebra::Complex;
use outerloop_core::config::{Compensation, Hydraulic};

/// Displacement and velocity that are missing at `omega` so that the answer there is `wanted`: real part and imaginary part
/// over `omega`.
fn missing(sum: &Sum, wanted: Complex<f64>, omega: f64) -> [f64; 2] {
    let d = Complex::new(0.0, omega);
    let has = sum.displacement + d * sum.velocity + d * d * sum.acceleration + d * d * d * sum.jerk;
    let left = wanted - has;
    [left.re, left.im / omega]
}

/// The gradient moves each coefficient by its gain times its derivative: what a frequency cannot tell apart is shared so.
pub(super) fn model_based(
    c: &Compensation,
    r: f64,
    wanted: Option<Complex<f64>>,
    omega: f64,
) -> Sum {
    let [first, second, third] = c.inverse();
    let mut sum = Sum {
        displacement: 1.0,
        velocity: first * r,
        acceleration: second * r.powi(2),
        jerk: third * r.powi(3),
        ..Sum::default()
    };
    if let Some(wanted) = wanted {
        let [real, imaginary] = missing(&sum, wanted, omega);
        let [g0, g1, g2, g3] = c.amb.gains;
        let square = (omega * r).powi(2);
        let share = |own: f64, other: f64| own / (own + other).max(f64::MIN_POSITIVE);
        let of_acceleration = share(g2 * square * square, g0);
        let of_jerk = share(g3 * square * square, g1);
        sum.displacement += real * (1.0 - of_acceleration);
        sum.acceleration -= real * of_acceleration / (omega * omega);
        sum.velocity += imaginary * (1.0 - of_jerk);
        sum.jerk -= imaginary * of_jerk / (omega * omega);
    }
    sum
}

/// The inverse of the declared plant, half a period early; fourth and fifth derivative are left out. What it learns of the
/// plant shows at `omega` in displacement and velocity.
pub(super) fn hydraulic(
    plant: &Hydraulic,
    r: f64,
    wanted: Option<Complex<f64>>,
    omega: f64,
) -> Sum {
    let [a0, a1, a2, a3, ..] = plant.inverse();
    let (a1, a2, a3) = (a1 * r, a2 * r.powi(2), a3 * r.powi(3));
    let mut sum = Sum {
        displacement: a0,
        velocity: a1 - 0.5 * a0,
        acceleration: a2 - 0.5 * a1 + 0.125 * a0,
        jerk: a3 - 0.5 * a2 + 0.125 * a1 - a0 / 48.0,
        ..Sum::default()
    };
    if let Some(wanted) = wanted {
        let [real, velocity] = missing(&sum, wanted, omega);
        sum.displacement += real;
        sum.velocity += velocity;
    }
    sum
}

pub(super) fn inverse_and_feedback(c: &Compensation, rate_hz: f64) -> Sum {
    let tau_s = c.delay_ms * 1e-3;
    let [first, second, third] = c.inverse();
    Sum {
        displacement: 1.0,
        velocity: first * rate_hz,
        acceleration: second * rate_hz.powi(2),
        jerk: third * rate_hz.powi(3),
        feedback: [c.feedback, 1.0 - (-1.0 / (tau_s * rate_hz)).exp()],
        ..Sum::default()
    }
}
