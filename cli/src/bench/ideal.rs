//! What a test is compared with: core's integration on the simulated specimen, without anything between them.

use crate::failure::Failure;
use crate::trace::Response;
use ::plant::{Rig, RigSpec};
use outerloop_core::{Config, Design, GroundMotion, IdealTest};

/// The response of `rig`, whose actuators and sensors are ideal, over `steps` control steps or to the end of `ground`. It
/// ends where a number is none.
///
/// # Errors
/// A parameter of the rig that is refused, with its name and value.
pub fn response<const N: usize>(
    rig: &RigSpec,
    config: &Config,
    design: &Design<N>,
    ground: &GroundMotion<'_>,
    steps: usize,
) -> Result<Response, Failure> {
    let physical = config.physical_storeys().min(N);
    let storeys = &config.structure.stiffness_n_per_m[..physical];
    let mut rig = Rig::new(rig, storeys, config.timing.rate_hz, 0)
        .map_err(|e| Failure::input(e.to_string()))?;
    let mut test = IdealTest::new(design);
    let mut response = Response::with_room(N, steps / usize::from(config.timing.substeps));
    for _ in 0..steps {
        let command_m = *test.command_m();
        let finite = command_m.iter().all(|u| u.is_finite());
        if !finite || test.is_over(ground) {
            break;
        }
        let reading = rig.step(&command_m.map(f64::from)[..physical]);
        let mut force_n = [0.0; N];
        for (force, &read) in force_n.iter_mut().zip(&reading.force_n) {
            *force = read as f32;
        }
        if test.at_target() {
            response.push(&command_m);
        }
        test.step(force_n, ground);
    }
    Ok(response)
}
