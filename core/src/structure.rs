//! The structure of the equation of motion, `M a + C v + R + K_n u = -M g a_g`.

use crate::matrix::{self, Matrix};
use crate::refusal::Refusal;

/// Mass, damping and stiffness of `N` degrees of freedom, in SI units (configuration, f64).
///
/// `stiffness` is that of the whole structure, the best that is known of it; `numerical_stiffness` is the
/// part of it that is only computed (hybrid test). What is left is the specimen.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound(
        serialize = "[f64; N]: serde::Serialize, Matrix<N>: serde::Serialize",
        deserialize = "[f64; N]: serde::Deserialize<'de>, Matrix<N>: serde::Deserialize<'de>"
    ))
)]
pub struct Structure<const N: usize> {
    /// Mass matrix, kg.
    pub mass: Matrix<N>,
    /// Viscous damping matrix, N s/m.
    pub damping: Matrix<N>,
    /// Initial stiffness of specimen and numerical part together, N/m.
    pub stiffness: Matrix<N>,
    /// Stiffness that exists in the computer only, N/m.
    pub numerical_stiffness: Matrix<N>,
    /// Influence vector: what the ground's acceleration is multiplied by in each equation.
    pub influence: [f64; N],
    /// Degrees of freedom `0..physical` have an actuator; the others are numerical.
    pub physical: usize,
    /// Mass that hangs on each load cell, kg.
    pub physical_mass_kg: [f64; N],
}

impl<const N: usize> Structure<N> {
    /// A shear frame, listed from the ground up: one mass and one storey stiffness per floor, one damping ratio per
    /// mode, the lowest `physical` storeys in the laboratory.
    ///
    /// # Errors
    /// Masses or stiffnesses that are not positive are refused by the validation of the configuration
    /// before this is called; here a mass matrix that is not positive definite is.
    pub fn shear_frame(
        mass_kg: &[f64; N],
        storey_stiffness_n_per_m: &[f64; N],
        damping_ratio: &[f64; N],
        physical: usize,
        physical_mass_kg: &[f64; N],
    ) -> Result<Self, Refusal> {
        let mass = matrix::diagonal(mass_kg);
        let stiffness = assemble(storey_stiffness_n_per_m, 0);
        Ok(Self {
            damping: modal_damping(&mass, &stiffness, damping_ratio)?,
            numerical_stiffness: assemble(storey_stiffness_n_per_m, physical),
            influence: [1.0; N],
            physical,
            physical_mass_kg: *physical_mass_kg,
            mass,
            stiffness,
        })
    }

    /// Natural angular frequencies, rad/s, ascending.
    ///
    /// # Errors
    /// A mass matrix that is not symmetric positive definite.
    pub fn natural_frequencies_rad_per_s(&self) -> Result<[f64; N], Refusal> {
        matrix::modes(&self.mass, &self.stiffness)
            .map(|(omegas, _)| omegas)
            .ok_or(Refusal::matrix("structure.mass_kg"))
    }
}

/// Number of axes with an actuator: at most all, and at least one, as checked by the design. Every loop over axes uses
/// it: with a single axis the compiler then knows the number.
#[inline]
pub(crate) fn actuated<const N: usize>(physical: usize) -> usize {
    if N == 1 { 1 } else { physical.min(N) }
}

/// Storey stiffnesses of a shear frame, from the matrix: minus the entry beside the diagonal, and for the lowest the rest.
pub(crate) fn storey_stiffness<const N: usize>(k: &Matrix<N>) -> [f64; N] {
    core::array::from_fn(|j| match j.checked_sub(1) {
        Some(below) => -k[j][below],
        None => k[0].iter().sum(),
    })
}

/// The stiffness matrix of storeys `from..N` of a shear frame.
fn assemble<const N: usize>(storeys: &[f64; N], from: usize) -> Matrix<N> {
    let mut k = matrix::zeros::<N>();
    for j in from..N {
        k[j][j] += storeys[j];
        if j > 0 {
            k[j - 1][j - 1] += storeys[j];
            k[j - 1][j] -= storeys[j];
            k[j][j - 1] -= storeys[j];
        }
    }
    k
}

/// `C = M Phi diag(2 zeta omega) Phi^T M` (Chopra, Dynamics of Structures, section 11.4).
///
/// # Errors
/// A mass matrix that is not symmetric positive definite.
pub fn modal_damping<const N: usize>(
    mass: &Matrix<N>,
    stiffness: &Matrix<N>,
    damping_ratio: &[f64; N],
) -> Result<Matrix<N>, Refusal> {
    let (omegas, shapes) =
        matrix::modes(mass, stiffness).ok_or(Refusal::matrix("structure.mass_kg"))?;
    let mut modal = [0.0; N];
    for r in 0..N {
        modal[r] = 2.0 * damping_ratio[r] * omegas[r];
    }
    let left = matrix::product(mass, &shapes);
    let right = matrix::product(&matrix::diagonal(&modal), &matrix::transpose(&left));
    Ok(matrix::product(&left, &right))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_degree_of_freedom_has_the_textbook_damping() {
        let s = Structure::<1>::shear_frame(&[1000.0], &[158e3], &[0.02], 1, &[0.0]).unwrap();
        let expected = 2.0 * 0.02 * libm::sqrt(158e3 * 1000.0);
        assert!((s.damping[0][0] - expected).abs() < 1e-9 * expected);
        assert_eq!(s.numerical_stiffness[0][0], 0.0);
    }

    #[test]
    fn a_hybrid_frame_splits_into_specimen_and_numerical_part() {
        let s = Structure::<3>::shear_frame(&[1e3; 3], &[3.0, 2.0, 1.0], &[0.05; 3], 1, &[0.0; 3])
            .unwrap();
        assert_eq!(s.stiffness[0][0], 5.0);
        assert_eq!(s.numerical_stiffness[0], [2.0, -2.0, 0.0]);
    }
}
