//! What the eigenvalues of a step say.

use nalgebra::{Complex, DMatrix, Schur};
use serde::Serialize;

/// A mode of the closed loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LoopMode {
    /// Natural frequency that the structure has, Hz of model time.
    pub structure_hz: f64,
    /// Frequency in the loop, Hz of model time.
    pub frequency_hz: f64,
    /// Damping ratio in the loop; negative: it grows.
    pub damping_ratio: f64,
}

/// Steps of the search for eigenvalues: some thirty each are usual.
const SEARCHES: usize = 1_000_000;

/// All eigenvalues. Of a matrix that is not finite, or where they are not found, one that is infinite: what cannot be
/// shown to be stable is not called so.
pub fn eigenvalues(transition: &DMatrix<f64>) -> Vec<Complex<f64>> {
    if transition.iter().any(|x| !x.is_finite()) {
        return vec![Complex::new(f64::INFINITY, 0.0)];
    }
    Schur::try_new(transition.clone(), f64::EPSILON, SEARCHES)
        .map(|schur| schur.complex_eigenvalues().iter().copied().collect())
        .unwrap_or_else(|| vec![Complex::new(f64::INFINITY, 0.0)])
}

/// What has become of the structure's natural frequencies `omega` (rad/s) in steps of `step_s`.
pub fn modes(eigenvalues: &[Complex<f64>], omega: &[f64], step_s: f64) -> Vec<LoopMode> {
    let mut free: Vec<Complex<f64>> = eigenvalues
        .iter()
        .filter(|z| z.im > 0.0 && z.norm() > 0.0)
        .map(|z| z.ln() / step_s)
        .collect();
    omega
        .iter()
        .filter_map(|w| {
            let own = Complex::new(0.0, *w);
            let (i, s) = free
                .iter()
                .copied()
                .enumerate()
                .min_by(|a, b| (a.1 - own).norm().total_cmp(&(b.1 - own).norm()))
                // Further away than that it is another motion.
                .filter(|(_, s)| (s - own).norm() < *w)?;
            free.swap_remove(i);
            Some(LoopMode {
                structure_hz: w / std::f64::consts::TAU,
                frequency_hz: s.norm() / std::f64::consts::TAU,
                damping_ratio: -s.re / s.norm(),
            })
        })
        .collect()
}
