//! The structure of a test in plain matrices.

use crate::bench::with_floors;
use crate::failure::Failure;
use nalgebra::{DMatrix, DVector};
use outerloop_core::{Config, Structure};

/// The structure of a test in plain matrices.
#[derive(Clone, Debug)]
pub struct StructureMatrices {
    /// kg.
    pub mass: DMatrix<f64>,
    /// N s/m.
    pub damping: DMatrix<f64>,
    /// N/m, specimen and numerical part.
    pub stiffness: DMatrix<f64>,
    /// N/m, numerical part.
    pub numerical: DMatrix<f64>,
    /// Natural frequencies, rad/s of model time, ascending.
    pub omega: Vec<f64>,
    /// First mode.
    pub shape: DVector<f64>,
}

impl StructureMatrices {
    /// Of a test.
    ///
    /// # Errors
    /// A structure that core refuses.
    pub fn of(config: &Config) -> Result<Self, Failure> {
        fn plain<const N: usize>(config: &Config) -> Result<StructureMatrices, Failure> {
            let s = &config.structure;
            let list = |x: &[f64]| core::array::from_fn(|j| x.get(j).copied().unwrap_or(0.0));
            let refused = |e: outerloop_core::Refusal| Failure::input(e.to_string());
            let (m, k): ([f64; N], [f64; N]) = (list(&s.mass_kg), list(&s.stiffness_n_per_m));
            let (z, p) = (list(&s.damping_ratio), list(&s.physical_mass_kg));
            let frame = Structure::<N>::shear_frame(&m, &k, &z, config.physical_storeys(), &p)
                .map_err(refused)?;
            let matrix = |x: &[[f64; N]; N]| DMatrix::from_fn(N, N, |i, j| x[i][j]);
            let (_, shapes) = outerloop_core::modes(&frame.mass, &frame.stiffness)
                .ok_or_else(|| Failure::input("structure.mass_kg: accepted are positive masses"))?;
            Ok(StructureMatrices {
                mass: matrix(&frame.mass),
                damping: matrix(&frame.damping),
                stiffness: matrix(&frame.stiffness),
                numerical: matrix(&frame.numerical_stiffness),
                omega: frame
                    .natural_frequencies_rad_per_s()
                    .map_err(refused)?
                    .to_vec(),
                shape: DVector::from_fn(N, |i, _| shapes[i][0]),
            })
        }
        with_floors!(config.degrees_of_freedom(), N => plain::<N>(config))
    }
}
