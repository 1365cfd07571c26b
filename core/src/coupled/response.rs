//! The modes of a structure, in the form needed by the observers of a target.

use super::observer::{MAX_MODES, ObserverSettings, VibrationMode};
use crate::matrix;
use crate::refusal::Refusal;
use crate::structure::Structure;

/// Observer settings for degree of freedom `axis`: the lowest modes of `structure`, damping ratios
/// `phi^T C phi / 2 omega` and parts in the axis' acceleration, `-phi_axis phi^T M iota` for mass-normalised `phi`.
///
/// `noise` is the target's noise, m (or rad) rms; `process_per_s2` the white acceleration besides the ground's.
///
/// # Errors
/// An axis missing in the structure; a mass matrix that is not symmetric positive definite.
pub fn observed<const N: usize>(
    structure: &Structure<N>,
    axis: usize,
    noise: f64,
    process_per_s2: f64,
) -> Result<ObserverSettings, Refusal> {
    let (omegas, shapes) = matrix::modes(&structure.mass, &structure.stiffness)
        .ok_or(Refusal::matrix("structure.mass_kg"))?;
    let row = shapes.get(axis).ok_or(Refusal {
        name: "coupled.axis",
        value: axis as f64,
        accepted: "a degree of freedom of the structure",
    })?;
    let form = |a: &matrix::Matrix<N>, m: usize, right: &dyn Fn(usize) -> f64| -> f64 {
        (0..N)
            .map(|i| shapes[i][m] * (0..N).map(|j| a[i][j] * right(j)).sum::<f64>())
            .sum()
    };
    let modes = (0..N.min(MAX_MODES)).map(|m| VibrationMode {
        omega_rad_per_s: omegas[m],
        damping_ratio: form(&structure.damping, m, &|j| shapes[j][m]) / (2.0 * omegas[m]),
        participation: -row[m] * form(&structure.mass, m, &|j| structure.influence[j]),
    });
    Ok(ObserverSettings {
        modes: modes.collect(),
        noise,
        process_per_s2,
    })
}
