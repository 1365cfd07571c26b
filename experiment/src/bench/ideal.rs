//! The reference for a test: core's integration on the simulated specimen, without anything in between.

use crate::failure::Failure;
use crate::trace::Response;
use ::plant::{Rig, RigSpec};
use outerloop_core::{Config, Design, GroundMotion, IdealTest};

/// Number of tests that run in turn: while one waits the others compute.
const IN_TURN: usize = 4;

/// The responses of `rigs`, with ideal actuators and sensors, over `steps` control steps or to the end of `ground`.
/// They have the same bits as when computed one by one.
///
/// # Errors
/// A refused parameter of a rig, with its name and value.
pub fn responses<const N: usize>(
    rigs: &[RigSpec],
    config: &Config,
    design: &Design<N>,
    ground: &GroundMotion<'_>,
    steps: usize,
) -> Result<Vec<Response>, Failure> {
    let storeys = &config.structure.stiffness_n_per_m[..config.physical_storeys().min(N)];
    let elastic: Option<Vec<Vec<f64>>> = rigs
        .iter()
        .map(|rig| rig.elastic_n_per_m(storeys))
        .collect::<Result<_, _>>()
        .map_err(Failure::input)?;
    let Some(elastic) = elastic else {
        let one = |rig| response(rig, config, design, ground, steps);
        return rigs.iter().map(one).collect();
    };
    let room = steps / usize::from(config.timing.substeps);
    let mut lanes: Vec<Elastic<N>> = elastic
        .into_iter()
        .map(|stiffness_n_per_m| Elastic {
            stiffness_n_per_m,
            test: IdealTest::new(design),
            response: Response::with_room(N, room),
            runs: true,
        })
        .collect();
    for lanes in lanes.chunks_mut(IN_TURN) {
        for _ in 0..steps {
            for lane in lanes.iter_mut() {
                lane.step(ground);
            }
        }
    }
    Ok(lanes.into_iter().map(|lane| lane.response).collect())
}

/// A test on linear springs, in progress.
struct Elastic<const N: usize> {
    stiffness_n_per_m: Vec<f64>,
    test: IdealTest<N>,
    response: Response,
    runs: bool,
}

impl<const N: usize> Elastic<N> {
    #[inline]
    fn step(&mut self, ground: &GroundMotion<'_>) {
        let command_m = *self.test.command_m();
        let finite = command_m.iter().all(|u| u.is_finite());
        self.runs &= finite && !self.test.is_over(ground);
        if !self.runs {
            return;
        }
        let mut shear_n = [0.0; N];
        let mut below_m = 0.0;
        for (j, k) in self.stiffness_n_per_m.iter().enumerate() {
            let at_m = f64::from(command_m[j]);
            shear_n[j] = k * (at_m - below_m);
            below_m = at_m;
        }
        let mut force_n = [0.0; N];
        let mut above_n = 0.0;
        for j in (0..self.stiffness_n_per_m.len()).rev() {
            // No sensor reads a zero with a sign.
            force_n[j] = (shear_n[j] - above_n + 0.0) as f32;
            above_n = shear_n[j];
        }
        if self.test.at_target() {
            self.response.push(&command_m);
        }
        self.test.step(force_n, ground);
    }
}

/// The response of `rig`, with ideal actuators and sensors, over `steps` control steps or to the end of `ground`. It
/// ends at the first NaN.
///
/// # Errors
/// A refused parameter of the rig, with its name and value.
fn response<const N: usize>(
    rig: &RigSpec,
    config: &Config,
    design: &Design<N>,
    ground: &GroundMotion<'_>,
    steps: usize,
) -> Result<Response, Failure> {
    let physical = config.physical_storeys().min(N);
    let storeys = &config.structure.stiffness_n_per_m[..physical];
    let mut rig = Rig::new(rig, storeys, config.timing.rate_hz, 0).map_err(Failure::input)?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use ::plant::PerAxis;

    fn same_bits<const N: usize>(physical: u8, substeps: u16) {
        let mut config = Config::shear_frame([1000.0; N], [4e5; N], [0.02; N]);
        config.structure.physical_storeys = Some(physical);
        config.timing.substeps = substeps;
        config.compensation.kind = outerloop_core::Method::None;
        let points: Vec<f32> = (0..150).map(|i| 3.0 * (0.4 * i as f32).sin()).collect();
        let ground = GroundMotion::new(&points, 0.01, config.model_step_s()).unwrap();
        let design = Design::<N>::new(&config).unwrap();
        let rigs: Vec<RigSpec> = (0..6)
            .map(|i| {
                let mut rig = RigSpec::default();
                let k = 4e5 * (1.0 + 0.03 * f64::from(i));
                rig.specimen.stiffness_n_per_m = Some(PerAxis::All(k));
                rig
            })
            .collect();
        let steps = 200 * 20 * usize::from(substeps);
        let together = responses(&rigs, &config, &design, &ground, steps).unwrap();
        assert_eq!(together.len(), rigs.len());
        for (rig, together) in rigs.iter().zip(&together) {
            let alone = response(rig, &config, &design, &ground, steps).unwrap();
            assert!(alone.steps() > 300 && alone.peaks_m()[0] > 1e-4);
            assert_eq!(alone.steps(), together.steps());
            for i in 0..alone.steps() {
                let bits = |r: &Response| {
                    r.at(i)
                        .unwrap()
                        .iter()
                        .map(|u| u.to_bits())
                        .collect::<Vec<_>>()
                };
                assert_eq!(bits(&alone), bits(together), "step {i}");
            }
        }
    }

    #[test]
    fn tests_in_turn_on_springs_have_the_bits_of_one_on_the_simulated_rig() {
        same_bits::<1>(1, 1);
        same_bits::<1>(1, 5);
        same_bits::<3>(3, 1);
        same_bits::<3>(2, 2);
    }
}
