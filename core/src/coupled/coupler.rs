//! The geometry of a coupler that two actuators move in x and in rotation.
//!
//! Each actuator acts along x on a pin of the coupler. When the interface moves by `x` and turns by `theta`, the pin at
//! `(p_x, p_y)` from the interface moves along x by `x + p_x (cos theta - 1) - p_y sin theta`. Sideways motion of a pin
//! swings its actuator by an angle that is neglected.

use super::pair::Pair;

/// Where the actuators hold the coupler, m from the interface point.
///
/// ```
/// use outerloop_core::coupled::Coupler;
///
/// let coupler = Coupler { pin_x_m: [0.1, 0.1], pin_y_m: [-0.4, 0.4] };
/// let strokes_m = coupler.strokes_m(0.010, 0.005);
/// assert!((strokes_m[0] - 0.012).abs() < 1e-5 && (strokes_m[1] - 0.008).abs() < 1e-5);
/// let [x_m, theta_rad] = coupler.interface(&strokes_m);
/// assert!((x_m - 0.010).abs() < 1e-6 && (theta_rad - 0.005).abs() < 1e-6);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Coupler {
    /// Along the actuators.
    pub pin_x_m: Pair,
    /// Across them; the two must differ, or nothing turns the coupler.
    pub pin_y_m: Pair,
}

impl Coupler {
    /// True if the strokes determine x and theta.
    pub fn is_regular(&self) -> bool {
        let arm = self.pin_y_m[1] - self.pin_y_m[0];
        let finite = self.pin_x_m.iter().all(|p| p.is_finite());
        finite && arm.is_finite() && arm.abs() > 1e-4
    }

    /// Strokes of the actuators, m, at `x` (m) and `theta` (rad).
    pub fn strokes_m(&self, x_m: f32, theta_rad: f32) -> Pair {
        let sine = sine(theta_rad);
        let fall = cosine_less_one(theta_rad);
        core::array::from_fn(|i| x_m + self.pin_x_m[i] * fall - self.pin_y_m[i] * sine)
    }

    /// The same, linearised about zero: valid for derivatives at small rotations.
    #[inline]
    pub fn linear_m(&self, x_m: f32, theta_rad: f32) -> Pair {
        core::array::from_fn(|i| x_m - self.pin_y_m[i] * theta_rad)
    }

    /// `x` (m) and `theta` (rad) at given strokes: two Newton steps from the linear solution, whose remaining error
    /// below half a radian is less than f32 resolves.
    pub fn interface(&self, stroke_m: &Pair) -> Pair {
        let arm = self.pin_y_m[0] - self.pin_y_m[1];
        let mut theta = (stroke_m[1] - stroke_m[0]) / arm;
        let mut x = stroke_m[0] + self.pin_y_m[0] * theta;
        for _ in 0..3 {
            let at = self.strokes_m(x, theta);
            let (e0, e1) = (stroke_m[0] - at[0], stroke_m[1] - at[1]);
            // d stroke / d theta = -p_x sin - p_y cos.
            let (sine, cosine) = (sine(theta), 1.0 + cosine_less_one(theta));
            let slope: Pair =
                core::array::from_fn(|i| -self.pin_x_m[i] * sine - self.pin_y_m[i] * cosine);
            let turn = (e0 - e1) / (slope[0] - slope[1]);
            theta += turn;
            x += e0 - slope[0] * turn;
        }
        [x, theta]
    }

    /// Resultant of two actuator forces, a force (N) along x and a moment (N m) about the interface, at a rotation of
    /// `theta_rad`: the arm of an actuator is the change of its stroke per rotation.
    pub fn resultant(&self, force_n: &Pair, theta_rad: f32) -> Pair {
        let (sine, cosine) = (sine(theta_rad), 1.0 + cosine_less_one(theta_rad));
        let arm_m = |i: usize| -self.pin_x_m[i] * sine - self.pin_y_m[i] * cosine;
        [
            force_n[0] + force_n[1],
            arm_m(0) * force_n[0] + arm_m(1) * force_n[1],
        ]
    }
}

/// The largest rotation for which the coupler's geometry is valid, rad.
pub const LARGEST_ROTATION: f32 = 0.5;

/// The sine up to [`LARGEST_ROTATION`], where the next term, `x^9 / 9!`, is below half a unit in the last place.
/// Library functions use double precision, which the microcontroller lacks in hardware.
#[inline]
fn sine(x: f32) -> f32 {
    let square = x * x;
    let rest = 1.0 / 120.0 - square * (1.0 / 5040.0);
    x - x * square * (1.0 / 6.0 - square * rest)
}

/// `cos x - 1`, without cancellation at small angles.
#[inline]
fn cosine_less_one(x: f32) -> f32 {
    let square = x * x;
    let rest = 1.0 / 24.0 - square * (1.0 / 720.0 - square * (1.0 / 40_320.0));
    -square * (0.5 - square * rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUPLER: Coupler = Coupler {
        pin_x_m: [0.2667, 0.2667],
        pin_y_m: [-0.127, 0.127],
    };

    #[test]
    fn sine_and_cosine_are_those_of_the_library() {
        for i in -500..=500 {
            let x = i as f32 * 1e-3;
            let (s, c) = (libm::sin(f64::from(x)), libm::cos(f64::from(x)) - 1.0);
            let off =
                |mine: f32, exact: f64| (f64::from(mine) - exact).abs() / (exact.abs() + 1e-12);
            assert!(off(sine(x), s) < 2e-7, "sine of {x}");
            assert!(off(cosine_less_one(x), c) < 3e-7, "cosine of {x}");
        }
    }

    #[test]
    fn strokes_lead_back_to_where_they_came_from() {
        for (x, theta) in [(0.0, 0.0), (0.01, 0.02), (-0.02, 0.2), (0.005, -0.4)] {
            let back = COUPLER.interface(&COUPLER.strokes_m(x, theta));
            assert!((back[0] - x).abs() < 1e-7, "{x} {theta}: {back:?}");
            assert!((back[1] - theta).abs() < 1e-6, "{x} {theta}: {back:?}");
        }
    }

    #[test]
    fn small_rotations_are_linear_and_virtual_work_agrees() {
        let (exact, linear) = (COUPLER.strokes_m(1e-3, 1e-3), COUPLER.linear_m(1e-3, 1e-3));
        for i in 0..2 {
            assert!((exact[i] - linear[i]).abs() < 2e-7);
        }
        // F . ds = N dx + M dtheta for any forces and motions.
        let force = [120.0, -70.0];
        let [n, m] = COUPLER.resultant(&force, 0.0);
        let d = COUPLER.linear_m(2e-3, -3e-3);
        let (strokes, interface) = (force[0] * d[0] + force[1] * d[1], n * 2e-3 - m * 3e-3);
        assert!((strokes - interface).abs() < 1e-6 * strokes.abs());
    }

    #[test]
    fn virtual_work_agrees_at_a_large_rotation() {
        let (force, at, by) = ([120.0, -70.0], 0.3, 1e-3);
        let [n, m] = COUPLER.resultant(&force, at);
        let (after, before) = (
            COUPLER.strokes_m(by, at + by),
            COUPLER.strokes_m(-by, at - by),
        );
        let work: f32 = (0..2).map(|i| force[i] * (after[i] - before[i])).sum();
        let exact = 2.0 * by * (n + m);
        assert!((work - exact).abs() < 2e-4 * exact.abs(), "{work} {exact}");
    }

    #[test]
    fn pins_on_one_line_turn_nothing() {
        let line = Coupler {
            pin_x_m: [0.1, 0.2],
            pin_y_m: [0.1, 0.1],
        };
        assert!(!line.is_regular() && COUPLER.is_regular());
    }
}
