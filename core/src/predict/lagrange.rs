//! Polynomial extrapolation: Horiuchi, Inoue, Konno and Namita, EESD 28 (1999) 1121.
//!
//! The polynomial of order n through the targets now, one delay ago, ... n delays ago, carried on by one delay:
//! `2, -1`, `3, -3, 1` or `4, -6, 4, -1` times those.
//!
//! Parameters: `delay_ms`, `order` 1 to 3. State 260 bytes an axis. Cost: up to three interpolated taps.
//!
//! # When not to use it
//! With order 3 the gain at `omega tau` = 1.57 is 15: a mode there is driven to instability, damped or not. It does
//! not notice a delay that differs from the declared one, and a gain error stays.

use super::interface::{LastCommand, PredictAxis, TargetMotion};
use super::past::{PastTargets, REACH};
use crate::config::{Compensation, Timing};
use crate::context::ActuatorContext;
use crate::refusal::{Refusal, accept};

/// Polynomial extrapolation of past targets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extrapolation {
    /// Weights of the target now and one, two and three delays ago.
    weights: [f32; 4],
    order: u8,
    /// Control steps between the points that are kept.
    stride: u16,
    per_stride: f32,
}

impl Extrapolation {
    /// Of `order` 1 to 3, by delays up to `longest` control steps.
    pub fn new(order: u8, longest: f64) -> Self {
        // One stride is lost to the phase.
        let reach = f64::from(order) * longest / (REACH - 1) as f64;
        let stride = libm::ceil(reach).max(1.0);
        Self {
            weights: weights(order).map(|w| w as f32),
            order,
            stride: stride as u16,
            per_stride: (1.0 / stride) as f32,
        }
    }

    /// Takes in `target_m` and returns the polynomial `delay` control steps ahead of it.
    #[inline]
    pub fn ahead(&self, past: &mut PastTargets, target_m: f32, delay: f32) -> f32 {
        past.push(self.stride, target_m);
        let mut sum = self.weights[0] * target_m;
        let mut steps = 0.0;
        for weight in &self.weights[1..=usize::from(self.order.min(3))] {
            steps += delay;
            sum += weight * past.tap(self.per_stride, steps);
        }
        sum
    }
}

/// Weights of the target now and one, two and three delays ago, of a polynomial of `order` 1 to 3.
fn weights(order: u8) -> [f64; 4] {
    let n = f64::from(order.clamp(1, 3));
    // Binomials of n + 1 with alternating signs: at order 3 they are 4, -6, 4, -1.
    let second = -(n + 1.0) * n / 2.0;
    let third = -second * (n - 1.0) / 3.0;
    [n + 1.0, second, third, -third * (n - 2.0) / 4.0]
}

/// Constants of the extrapolation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constants {
    /// Delay, control steps.
    pub delay: f32,
    /// The polynomial.
    pub extrapolation: Extrapolation,
}

/// Past targets of one axis.
#[derive(Clone, Debug)]
pub(crate) struct Lagrange {
    past: PastTargets,
}

impl PredictAxis for Lagrange {
    type Constants = Constants;

    fn check(c: &Compensation, _: &Timing) -> Result<(), Refusal> {
        accept(
            "compensation.order",
            f64::from(c.order),
            (1..=3).contains(&c.order),
            "1 to 3",
        )
    }

    fn design(context: &ActuatorContext<'_>) -> Constants {
        let steps = context.delay_steps();
        Constants {
            delay: steps as f32,
            extrapolation: Extrapolation::new(context.parameters.order, steps),
        }
    }

    fn at_rest(_: &Constants) -> Self {
        Self {
            past: PastTargets::at_rest(),
        }
    }

    #[inline]
    fn command(&mut self, k: &Constants, _: &LastCommand, ahead: &TargetMotion) -> f32 {
        k.extrapolation
            .ahead(&mut self.past, ahead.displacement_m, k.delay)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predict::checks::{self, Axis};

    #[test]
    fn each_order_is_exact_for_its_polynomial_and_removes_the_delay_it_was_told() {
        let mut last = 1.0;
        for order in 1..=3 {
            let k = Constants {
                delay: 8.0,
                extrapolation: Extrapolation::new(order, 8.0),
            };
            let mut axis = Lagrange::at_rest(&k);
            let p = |t: f32| (0.3 * t).powi(i32::from(order));
            for i in 0..200 {
                let t = i as f32 * 0.01;
                let sent = k.extrapolation.ahead(&mut axis.past, p(t), 8.0);
                if i > 100 {
                    assert!((sent - p(t + 0.08)).abs() < 1e-5, "order {order}");
                }
            }
            let rest = checks::tracking_error::<Lagrange>(
                &k,
                Axis {
                    delay: 8,
                    gain: 1.0,
                },
            );
            assert!(rest < 0.2 * last, "order {order}: {rest}");
            last = rest;
        }
    }
}
