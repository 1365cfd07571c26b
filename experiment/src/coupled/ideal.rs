//! The motion of a test of two coupled actuators that follow their commands exactly.

use super::part::CoupledPart;
use super::settings;
use super::table::CoupledCompensation;
use crate::failure::Failure;
use crate::trace::Response;
use outerloop_core::{Coefficients, Config, GroundMotion, Newmark};
use plant::coupled::CoupledSpecimen;

/// The same integration, with the specimen exactly where it is sent: the displacement of every coordinate, m or rad,
/// one step per control step.
///
/// # Errors
/// A structure that is refused.
pub(crate) fn response<const N: usize>(
    part: &CoupledPart,
    config: &Config,
    ground: &GroundMotion<'_>,
    steps: usize,
) -> Result<Response, Failure> {
    let settings = settings::of::<N>(&part.declared, config, CoupledCompensation::None)?;
    let step_s = config.model_step_s();
    let k = Coefficients::new(&settings.structure, step_s, 1.0).map_err(Failure::input)?;
    let mut newmark = Newmark::<N>::at_rest();
    let mut specimen = CoupledSpecimen::new(&part.rig.specimen, config.timing.rate_hz);
    let mut response = Response::with_room(N, steps);
    for step in 0..steps {
        let at = newmark.displacement_m();
        response.push(&at);
        let answer = specimen.step([0, 1].map(|i| at.get(i).copied().map_or(0.0, f64::from)));
        let mut force_n = [0.0; N];
        for (all, force) in force_n.iter_mut().zip(answer) {
            *all = force as f32;
        }
        newmark.advance(&k, &k.load_n(ground.at(step as u32)), &force_n, &[0.0; N]);
    }
    Ok(response)
}
