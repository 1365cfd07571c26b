//! The frame in the laboratory: one bay of steel with pinned feet.
//!
//! It has five degrees of freedom (x of the beam and four rotations), condensed to x and the rotation of the interface. Velocity
//! and acceleration of the interface are not measured; here they come from a second-order filter at 50 Hz.

use super::{PERIOD_S, SIGN};
use nalgebra::{Matrix2, SMatrix, SymmetricEigen, Vector2};

/// Mass, damping and stiffness for x and the rotation of the interface, in the rig's sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterfaceFrame {
    /// kg, kg m^2.
    pub mass: Matrix2<f64>,
    /// N s/m, and the matching units for rotation.
    pub damping: Matrix2<f64>,
    /// N/m, and the matching units for rotation.
    pub stiffness: Matrix2<f64>,
}

impl InterfaceFrame {
    /// The published frame.
    pub fn published() -> Self {
        let inch4 = 0.0254_f64.powi(4);
        let inch2 = 0.0254_f64.powi(2);
        let (beam, column) = (0.762, 0.641_35);
        let (young, density) = (200e9, 7.85e3);
        let column_ei = young * 2.520 * inch4 * 0.7;
        let beam_ei = young * 4.213_72e-7;
        let sway = 6.0 * column_ei / (column * column);
        let (near, far) = (4.0 * column_ei / column, 2.0 * column_ei / column);
        let (beam_near, beam_far) = (4.0 * beam_ei / beam, 2.0 * beam_ei / beam);
        // x, rotation 1 (interface), rotation 2, feet 3 and 4.
        let k = SMatrix::<f64, 5, 5>::from_row_slice(&[
            24.0 * column_ei / column.powi(3),
            sway,
            sway,
            sway,
            sway,
            sway,
            near + beam_near,
            beam_far,
            0.0,
            far,
            sway,
            beam_far,
            near + beam_near,
            far,
            0.0,
            sway,
            0.0,
            far,
            near,
            0.0,
            sway,
            far,
            0.0,
            0.0,
            near,
        ]);
        let inner = k.fixed_view::<3, 3>(2, 2).into_owned();
        let follow = inner
            .try_inverse()
            .map_or_else(SMatrix::<f64, 3, 2>::zeros, |f| {
                -f * k.fixed_view::<3, 2>(2, 0)
            });
        let stiffness = k.fixed_view::<2, 2>(0, 0) + k.fixed_view::<2, 3>(0, 2) * follow;
        let beam_kg = density * 7.56e-4 * beam;
        let column_kg = density * 1.670 * inch2 * column;
        let mass = Matrix2::from_diagonal(&Vector2::new(
            (beam_kg + 2.0 * column_kg) / 2.0 * 1.1,
            (beam_kg / 2.0 * beam * beam + column_kg / 2.0 * column * column) / 3.0 * 1.1,
        ));
        Self {
            damping: modal(&mass, &stiffness, 0.05),
            mass,
            stiffness,
        }
    }

    /// Mass, damping and stiffness in the structure's sign, as they add to the numerical part.
    pub fn in_structure(&self) -> [Matrix2<f64>; 3] {
        let turn = Matrix2::from_diagonal(&Vector2::new(1.0, SIGN));
        [self.mass, self.damping, self.stiffness].map(|m| turn * m * turn)
    }
}

/// Damping with the same ratio in both modes.
fn modal(mass: &Matrix2<f64>, stiffness: &Matrix2<f64>, ratio: f64) -> Matrix2<f64> {
    let root = Matrix2::from_diagonal(&mass.diagonal().map(f64::sqrt));
    let less = Matrix2::from_diagonal(&mass.diagonal().map(|m| 1.0 / m.sqrt()));
    let modes = SymmetricEigen::new(less * stiffness * less);
    let twice = modes.eigenvalues.map(|square| 2.0 * ratio * square.sqrt());
    root * modes.eigenvectors
        * Matrix2::from_diagonal(&twice)
        * modes.eigenvectors.transpose()
        * root
}

/// Corner of the filter that gives velocities and accelerations, rad/s.
const CORNER_RAD_PER_S: f64 = std::f64::consts::TAU * 50.0;
/// Its damping ratio.
const RATIO: f64 = 0.7;

/// The force of a frame in motion.
#[derive(Clone, Debug)]
pub struct Resistance {
    frame: InterfaceFrame,
    last: Vector2<f64>,
    smooth: Vector2<f64>,
    velocity: Vector2<f64>,
}

impl Resistance {
    /// A frame at rest.
    pub fn new(frame: InterfaceFrame) -> Self {
        Self {
            frame,
            last: Vector2::zeros(),
            smooth: Vector2::zeros(),
            velocity: Vector2::zeros(),
        }
    }

    /// Force (N) and moment (N m) at x (m) and rotation (rad), in the rig's sign, one sample after the last.
    pub fn step(&mut self, interface: [f64; 2]) -> [f64; 2] {
        let at = Vector2::from(interface);
        let w = CORNER_RAD_PER_S;
        // Semi-implicit steps of a quarter period are stable, and accurate enough behind a 50 Hz filter. The interface
        // moves linearly between samples. With a staircase the filter would slow down within every sample: its acceleration
        // at the end would be too small by 148 times the speed, which adds negative damping for every kilogram.
        let mut acceleration = Vector2::zeros();
        for part in [0.25, 0.5, 0.75, 1.0] {
            let there = self.last + (at - self.last) * part;
            acceleration = (there - self.smooth) * (w * w) - self.velocity * (2.0 * RATIO * w);
            self.velocity += acceleration * (PERIOD_S / 4.0);
            self.smooth += self.velocity * (PERIOD_S / 4.0);
        }
        self.last = at;
        let f = &self.frame;
        let force = f.stiffness * at + f.damping * self.velocity + f.mass * acceleration;
        [force[0], force[1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stiffness_and_mass_are_those_that_others_found() {
        let frame = InterfaceFrame::published();
        for (found, known) in [
            (frame.stiffness[(0, 0)], 2.324e6),
            (frame.stiffness[(0, 1)], 0.861e6),
            (frame.stiffness[(1, 1)], 1.086e6),
            (frame.mass[(0, 0)], 8.45),
        ] {
            assert!((found / known - 1.0).abs() < 1e-3, "{found} {known}");
        }
    }

    /// The effective damping is the work in a period over pi times the squared amplitude and the angular frequency.
    #[test]
    fn a_slow_sine_finds_the_damping_of_the_frame() {
        let f = InterfaceFrame::published();
        let (mut frame, samples) = (Resistance::new(f), 512);
        let w = std::f64::consts::TAU / f64::from(samples);
        let (mut work, mut before) = (0.0, ([0.0; 2], 0.0));
        for k in 0..=5 * samples {
            let x = (w * f64::from(k)).sin();
            let force = frame.step([x, 0.0]);
            if k > 4 * samples {
                work += 0.5 * (force[0] + before.0[0]) * (x - before.1);
            }
            before = (force, x);
        }
        let omega = w / PERIOD_S;
        let found = work / (std::f64::consts::PI * omega);
        // The acceleration is 4.5 ms late, which adds a little damping.
        let late = 2.0 * RATIO / CORNER_RAD_PER_S * omega * omega * f.mass[(0, 0)];
        let known = f.damping[(0, 0)] + late;
        assert!(
            (found / known - 1.0).abs() < 0.05,
            "{found} N s/m, known {known}"
        );
    }

    #[test]
    fn held_still_only_the_stiffness_answers() {
        let mut frame = Resistance::new(InterfaceFrame::published());
        let mut force = [0.0; 2];
        for _ in 0..2000 {
            force = frame.step([1e-3, 2e-3]);
        }
        let k = InterfaceFrame::published().stiffness;
        assert!((force[0] - (k[(0, 0)] * 1e-3 + k[(0, 1)] * 2e-3)).abs() < 1e-6);
    }
}
