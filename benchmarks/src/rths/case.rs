//! The four structures. One frame of the first storey is the specimen, and the rest is computed.

use super::parameters::Specimen;
use super::size::{FLOORS, RATE_HZ};
use crate::linear::Lanes;
use nalgebra::{Cholesky, Matrix3, SMatrix, SymmetricEigen, Vector3};
use plant::linear::Linear;

/// Stiffness of the whole structure, 1e7 N/m.
const STIFFNESS_1E7: Matrix3<f64> = Matrix3::new(
    2.605_488, -2.313_394, 0.593_704, //
    -2.313_394, 3.256_077, -1.441_997, //
    0.593_704, -1.441_997, 0.926_728,
);

/// One of the four structures of the problem.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// Its number, 1 to 4.
    pub number: u8,
    /// Mass of each floor, kg.
    pub mass_kg: f64,
    /// Damping ratio of each mode.
    pub damping_ratio: f64,
}

/// All four, in the order of the problem.
pub const CASES: [Case; 4] = [
    Case::new(1, 1000.0, 0.05),
    Case::new(2, 1100.0, 0.04),
    Case::new(3, 1300.0, 0.03),
    Case::new(4, 1000.0, 0.03),
];

/// Mass, damping and stiffness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matrices {
    /// kg.
    pub mass: Matrix3<f64>,
    /// N s/m.
    pub damping: Matrix3<f64>,
    /// N/m.
    pub stiffness: Matrix3<f64>,
}

impl Case {
    const fn new(number: u8, mass_kg: f64, damping_ratio: f64) -> Self {
        Self {
            number,
            mass_kg,
            damping_ratio,
        }
    }

    /// The whole structure, the specimen included.
    pub fn reference(&self) -> Matrices {
        let stiffness = STIFFNESS_1E7 * 1e7;
        // All masses are equal: the modes are those of K, and C = m Phi diag(2 zeta omega) Phi^T with orthonormal Phi.
        let modes = SymmetricEigen::new(stiffness / self.mass_kg);
        let twice = modes
            .eigenvalues
            .map(|square| 2.0 * self.damping_ratio * square.sqrt());
        let shapes = modes.eigenvectors;
        Matrices {
            mass: Matrix3::identity() * self.mass_kg,
            damping: shapes * Matrix3::from_diagonal(&twice) * shapes.transpose() * self.mass_kg,
            stiffness,
        }
    }

    /// The numerical part: the reference minus `specimen` at the first floor.
    pub fn numerical(&self, specimen: &Specimen) -> Matrices {
        let mut rest = self.reference();
        rest.mass[(0, 0)] -= specimen.mass_kg;
        rest.damping[(0, 0)] -= specimen.damping_n_s_per_m;
        rest.stiffness[(0, 0)] -= specimen.stiffness_n_per_m;
        rest
    }
}

/// `L` structures under ground acceleration (`-M_total 1 a_g`) and a restoring force at the first floor, discretized exactly.
#[derive(Clone, Debug)]
pub struct Structure<const L: usize> {
    /// Inputs: ground acceleration, its rise over the period, force at the first floor.
    system: Lanes<6, 3, L>,
}

impl<const L: usize> Structure<L> {
    /// Structures at rest: the matrices of each of `parts`, with the ground shaking the whole mass of its case.
    ///
    /// Returns `None` for a mass matrix that is not positive definite.
    pub fn new(parts: &[(Case, Matrices); L]) -> Option<Self> {
        let mut systems = [(SMatrix::zeros(), SMatrix::zeros()); L];
        for (system, (case, matrices)) in systems.iter_mut().zip(parts) {
            *system = sampled(case, matrices)?;
        }
        Some(Self {
            system: Lanes::new(&systems),
        })
    }

    /// Displacements of the floors, m.
    #[inline(always)]
    pub fn floors_m(&self) -> [[f64; L]; FLOORS] {
        let [a, b, c, ..] = self.system.state;
        [a, b, c]
    }

    /// Advances by one sampling period. The ground's acceleration is linear over it, and the forces (N) are held.
    #[inline(always)]
    pub fn step(&mut self, ground_m_per_s2: [f64; 2], force_n: [f64; L]) {
        let [now, next] = ground_m_per_s2;
        self.system.step(&[[now; L], [next - now; L], force_n]);
    }
}

/// Transition and input matrices over a period.
fn sampled(case: &Case, matrices: &Matrices) -> Option<(SMatrix<f64, 6, 6>, SMatrix<f64, 6, 3>)> {
    let flexible = Cholesky::new(matrices.mass)?;
    let mut a = SMatrix::<f64, 6, 6>::zeros();
    a.fixed_view_mut::<FLOORS, FLOORS>(0, FLOORS)
        .copy_from(&Matrix3::identity());
    a.fixed_view_mut::<FLOORS, FLOORS>(FLOORS, 0)
        .copy_from(&-flexible.solve(&matrices.stiffness));
    a.fixed_view_mut::<FLOORS, FLOORS>(FLOORS, FLOORS)
        .copy_from(&-flexible.solve(&matrices.damping));
    let mut b = SMatrix::<f64, 6, 2>::zeros();
    let shaken = Vector3::repeat(case.mass_kg);
    b.fixed_view_mut::<FLOORS, 1>(FLOORS, 0)
        .copy_from(&-flexible.solve(&shaken));
    b.fixed_view_mut::<FLOORS, 1>(FLOORS, 1)
        .copy_from(&-flexible.solve(&Vector3::x()));
    let linear = Linear::new(&a, &b, 1.0 / RATE_HZ);
    let mut input = SMatrix::<f64, 6, 3>::zeros();
    input.set_column(0, &linear.held().column(0));
    input.set_column(1, &linear.rising().column(0));
    input.set_column(2, &linear.held().column(1));
    Some((*linear.transition(), input))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_damping_is_that_of_the_case_in_every_mode() {
        for case in CASES {
            let m = case.reference();
            let modes = SymmetricEigen::new(m.stiffness / case.mass_kg);
            for r in 0..FLOORS {
                let shape = modes.eigenvectors.column(r);
                let c = (shape.transpose() * m.damping * shape)[0] / case.mass_kg;
                let ratio = c / (2.0 * modes.eigenvalues[r].sqrt());
                assert!((ratio - case.damping_ratio).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn the_modes_are_those_of_the_published_matrices() {
        // Roots w^2 of det(K - w^2 M) = -x^3 + tr x^2 - minors x + det.
        let k = STIFFNESS_1E7 * 1e4;
        let minors = 0.5 * (k.trace().powi(2) - (k * k).trace());
        let cubic = |x: f64| ((k.trace() - x) * x - minors) * x + k.determinant();
        let squares = SymmetricEigen::new(CASES[0].reference().stiffness / 1000.0).eigenvalues;
        for square in squares.iter() {
            assert!(cubic(square * 0.999_999) * cubic(square * 1.000_001) < 0.0);
        }
        let slowest = squares.min().sqrt() / std::f64::consts::TAU;
        assert!((slowest - 3.61).abs() < 0.01, "{slowest} Hz");
    }
}
