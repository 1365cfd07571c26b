//! The natural modes of a test's structure.

use crate::failure::Failure;
use crate::floors::with_floors;
use nalgebra::{DMatrix, DVector};
use outerloop_core::{Config, Refusal};

/// Natural modes, from the lowest.
#[derive(Clone, Debug)]
pub struct StructureModes {
    /// Natural frequencies, rad/s of model time.
    pub omega: Vec<f64>,
    /// Displacement of each floor in the first mode.
    pub first_shape: Vec<f64>,
    /// Each gives its mode's coordinate from the displacements of the floors; of unit length.
    pub coordinates: Vec<DVector<f64>>,
}

impl StructureModes {
    /// For a test's structure without damping.
    ///
    /// # Errors
    /// A structure that core refuses.
    pub fn of(config: &Config) -> Result<Self, Failure> {
        fn plain<const N: usize>(config: &Config) -> Result<[DMatrix<f64>; 2], Refusal> {
            let frame = config.frame::<N>()?;
            frame.natural_frequencies_rad_per_s()?;
            let matrix = |x: &[[f64; N]; N]| DMatrix::from_fn(N, N, |i, j| x[i][j]);
            Ok([matrix(&frame.mass), matrix(&frame.stiffness)])
        }
        let [mass, stiffness] = with_floors!(config.degrees_of_freedom(), N => {
            plain::<N>(config).map_err(|e| Failure::input(e.to_string()))
        })?;
        // With masses scaled to one the problem is symmetric.
        let root = mass.diagonal().map(f64::sqrt);
        let floors = root.len();
        let scaled = DMatrix::from_fn(floors, floors, |i, j| {
            stiffness[(i, j)] / (root[i] * root[j])
        });
        let eigen = scaled.symmetric_eigen();
        let mut order: Vec<usize> = (0..floors).collect();
        order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
        let vector = |i: usize| eigen.eigenvectors.column(i);
        Ok(Self {
            omega: order.iter().map(|&i| eigen.eigenvalues[i].sqrt()).collect(),
            first_shape: vector(order[0])
                .component_div(&root)
                .iter()
                .copied()
                .collect(),
            coordinates: order
                .iter()
                .map(|&i| vector(i).component_mul(&root).normalize())
                .collect(),
        })
    }
}
