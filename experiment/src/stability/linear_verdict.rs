//! A test under one compensation, by the eigenvalues of its loop.

use super::closed_loop::Question;
use super::rig::Variation;
use super::spectrum;
use super::structure_matrices::StructureMatrices;
use crate::failure::Failure;
use serde::Serialize;

/// A growth of the largest eigenvalue by less than this in a step is rounding: of 1e-6 a second at 1 kHz.
const ROUNDING: f64 = 1e-9;

/// The same test under one compensation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LinearVerdict {
    /// Its name.
    pub compensation: &'static str,
    /// True if it is stable.
    pub stable: bool,
    /// Largest magnitude of an eigenvalue over an integration step.
    pub spectral_radius: f64,
    /// What the fastest growing motion grows by, 1/s of model time; negative: all decays.
    pub growth_per_s: f64,
    /// Damping ratio of the first mode in the loop.
    pub damping_ratio: f64,
}

/// Eigenvalues of `question` on its rig with `vary`.
///
/// # Errors
/// A test that cannot be written down.
pub fn linear_verdict(
    question: &Question<'_>,
    frame: &StructureMatrices,
    vary: &Variation,
) -> Result<LinearVerdict, Failure> {
    let step_s = question.config.model_step_s();
    let z = question.eigenvalues(frame, vary)?;
    let radius = z.iter().map(|z| z.norm()).fold(0.0, f64::max);
    let first = spectrum::modes(&z, &frame.omega[..1], step_s);
    Ok(LinearVerdict {
        compensation: question.config.compensation.kind.name(),
        stable: radius <= 1.0 + ROUNDING,
        spectral_radius: radius,
        growth_per_s: radius.ln() / step_s,
        damping_ratio: first.first().map_or(f64::NAN, |m| m.damping_ratio),
    })
}
