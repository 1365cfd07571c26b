//! The geometry of a coupler that two actuators move in x and in rotation, in f64 and without linearisation.

use super::pair::{Pair, within};
use crate::error::RigError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where the actuators hold the coupler; they act along x.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CouplerSpec {
    /// Distance of each pin from the interface point along the actuators, m, -100 to 100.
    pub pin_x_m: [f64; 2],
    /// Distance of each pin from the interface point across the actuators, m, -100 to 100; the two must differ.
    pub pin_y_m: [f64; 2],
}

impl CouplerSpec {
    /// Checks the geometry; `path` is that of the table.
    ///
    /// # Errors
    /// A distance out of range; pins on one line, which cannot produce a rotation.
    pub fn check(&self, path: &str) -> Result<(), RigError> {
        for (name, pins) in [("pin_x_m", self.pin_x_m), ("pin_y_m", self.pin_y_m)] {
            for pin in pins {
                let at = format!("{path}.{name}");
                within(at, pin, -100.0..=100.0, "distances from -100 to 100 m")?;
            }
        }
        let apart = (self.pin_y_m[1] - self.pin_y_m[0]).abs();
        if apart < 1e-3 {
            return Err(RigError::new(
                format!("{path}.pin_y_m"),
                format!("{:?}", self.pin_y_m),
                "pins at least 1 mm apart: others turn nothing",
            ));
        }
        Ok(())
    }

    /// Strokes, m, at x (m) and rotation (rad).
    pub fn strokes_m(&self, [x, theta]: Pair) -> Pair {
        [0, 1].map(|i| x + self.pin_x_m[i] * (theta.cos() - 1.0) - self.pin_y_m[i] * theta.sin())
    }

    /// Change of each stroke with the rotation, m/rad: the arm of that actuator's force.
    pub fn arms_m(&self, theta: f64) -> Pair {
        [0, 1].map(|i| -self.pin_x_m[i] * theta.sin() - self.pin_y_m[i] * theta.cos())
    }

    /// x (m) and rotation (rad) at given strokes, by Newton's method from the linear solution.
    pub fn interface(&self, stroke_m: Pair) -> Pair {
        let mut theta = (stroke_m[1] - stroke_m[0]) / (self.pin_y_m[0] - self.pin_y_m[1]);
        let mut x = stroke_m[0] + self.pin_y_m[0] * theta;
        for _ in 0..20 {
            let at = self.strokes_m([x, theta]);
            let [e0, e1] = [stroke_m[0] - at[0], stroke_m[1] - at[1]];
            let arms = self.arms_m(theta);
            let turn = (e0 - e1) / (arms[0] - arms[1]);
            theta += turn;
            x += e0 - arms[0] * turn;
            // Strokes that match no rotation never converge: the loop that sees them trips on its tracking.
            if turn.is_nan() || turn.abs() <= 1e-15 {
                break;
            }
        }
        [x, theta]
    }

    /// Actuator forces, N, with the given resultant, a force along x (N) and a moment (N m), at a rotation.
    pub fn forces_n(&self, [along_x, moment]: Pair, theta: f64) -> Pair {
        let arms = self.arms_m(theta);
        let first = (moment - arms[1] * along_x) / (arms[0] - arms[1]);
        [first, along_x - first]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUPLER: CouplerSpec = CouplerSpec {
        pin_x_m: [0.2667, 0.3],
        pin_y_m: [-0.127, 0.15],
    };

    #[test]
    fn strokes_lead_back_and_forces_do_the_work_of_their_resultant() {
        for at in [[0.0, 0.0], [0.01, 0.02], [-0.02, 0.4], [0.005, -0.7]] {
            let strokes = COUPLER.strokes_m(at);
            let back = COUPLER.interface(strokes);
            assert!((back[0] - at[0]).abs() < 1e-14 && (back[1] - at[1]).abs() < 1e-14);
            // F . ds = N dx + M dtheta.
            let (by, resultant) = (1e-6, [120.0, -35.0]);
            let force = COUPLER.forces_n(resultant, at[1]);
            let after = COUPLER.strokes_m([at[0] + by, at[1] + by]);
            let before = COUPLER.strokes_m([at[0] - by, at[1] - by]);
            let work: f64 = (0..2).map(|i| force[i] * (after[i] - before[i])).sum();
            let exact = 2.0 * by * (resultant[0] + resultant[1]);
            assert!((work - exact).abs() < 1e-9 * exact.abs());
        }
    }

    #[test]
    fn pins_on_one_line_are_refused() {
        let line = CouplerSpec {
            pin_y_m: [0.1, 0.1],
            ..COUPLER
        };
        let said = line.check("coupled.coupler").unwrap_err().to_string();
        assert!(
            said.starts_with("coupled.coupler.pin_y_m is [0.1, 0.1]"),
            "{said}"
        );
        COUPLER.check("coupled.coupler").unwrap();
    }
}
