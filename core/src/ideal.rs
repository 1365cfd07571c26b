//! A test as an ideal actuator would run it: the integration and the signal generation, and nothing else.
//!
//! What a test is compared with (Eqs 17 and 18) has an actuator that is where it is sent, sensors without an error and no
//! compensation. Energies, estimates and interlocks change no number of it, so they are left out: it takes a fraction of the
//! time of [`OuterLoop`](crate::OuterLoop) and has the same bits.

use crate::design::Design;
use crate::ground_motion::GroundMotion;
use crate::newmark::{Coefficients, Newmark};
use crate::signal::{SignalConstants, SignalGenerator, Target};

/// A test with an ideal actuator, in motion.
///
/// ```
/// use outerloop_core::{Config, Design, GroundMotion, IdealTest};
///
/// let config = Config::shear_frame([1000.0], [158e3], [0.02]);
/// let points = [0.0, 2.0, -2.0, 0.0, 0.0, 0.0];
/// let ground = GroundMotion::new(&points, 0.05, config.model_step_s()).unwrap();
/// let mut test = IdealTest::<1>::new(&Design::new(&config)?);
/// let mut peak_m = 0.0_f32;
/// while !test.is_over(&ground) {
///     let at_m = test.command_m()[0];
///     peak_m = peak_m.max(at_m.abs());
///     test.step([158e3 * at_m], &ground);
/// }
/// assert!(peak_m > 1e-3);
/// # Ok::<(), outerloop_core::Refusal>(())
/// ```
#[derive(Clone, Debug)]
pub struct IdealTest<const N: usize> {
    coefficients: Coefficients<N>,
    constants: SignalConstants,
    physical: usize,
    newmark: Newmark<N>,
    signal: SignalGenerator<N>,
    step: u32,
}

impl<const N: usize> IdealTest<N> {
    /// At rest at zero. Compensation, estimation, limits and rig of `design` are not used.
    pub fn new(design: &Design<N>) -> Self {
        Self {
            coefficients: design.step.newmark.clone(),
            constants: design.step.signal,
            physical: design.step.physical,
            newmark: Newmark::at_rest(),
            signal: SignalGenerator::standing_at([0.0; N]),
            step: 0,
        }
    }

    /// Positions of the actuators, m.
    #[inline]
    pub fn command_m(&self) -> &[f32; N] {
        self.signal.command_m()
    }

    /// True if the next call of [`IdealTest::step`] solves an integration step and uses its force.
    #[inline]
    pub fn at_target(&self) -> bool {
        self.signal.at_target()
    }

    /// True if the integration has passed the end of `ground`.
    #[inline]
    pub fn is_over(&self, ground: &GroundMotion<'_>) -> bool {
        self.step > ground.steps()
    }

    /// One control step: `force_n` is the restoring force at the actuators' positions, N. Axes without an actuator have
    /// none.
    #[inline]
    pub fn step(&mut self, mut force_n: [f32; N], ground: &GroundMotion<'_>) {
        if self.at_target() {
            force_n
                .iter_mut()
                .skip(self.physical)
                .for_each(|force| *force = 0.0);
            let load_n = self.coefficients.load_n(ground.at(self.step));
            self.newmark
                .advance(&self.coefficients, &load_n, &force_n, &[0.0; N]);
            let target = Target {
                displacement_m: self.newmark.displacement_m(),
                velocity_dt_m: self.newmark.predictor_velocity_dt_m(),
                acceleration_dt2_m: *self.newmark.acceleration_dt2_m(),
            };
            self.signal.aim(&self.constants, target);
            self.step = self.step.wrapping_add(1);
        }
        self.signal.advance(&self.constants);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Config;
    use crate::{Event, Method, Mode, OuterLoop, Sample};

    /// A softening specimen: the force of each storey falls short of its stiffness as the drift grows.
    fn force_n<const N: usize>(u: &[f32; N], physical: usize) -> [f32; N] {
        let mut force = [0.0; N];
        let mut below = 0.0;
        for j in 0..physical {
            let drift = u[j] - below;
            let shear = 1e6 * drift / (1.0 + 20.0 * drift.abs());
            force[j] += shear;
            if j > 0 {
                force[j - 1] -= shear;
            }
            below = u[j];
        }
        force
    }

    fn same_bits<const N: usize>(physical: usize, substeps: u16, solve_substeps: u16) {
        let mut config = Config::shear_frame([1000.0; N], [1e6; N], [0.02; N]);
        config.compensation.kind = Method::None;
        config.structure.physical_storeys = Some(physical as u8);
        (config.timing.substeps, config.timing.solve_substeps) = (substeps, solve_substeps);
        let points: [f32; 200] = core::array::from_fn(|i| libm::sinf(0.4 * i as f32));
        let ground = GroundMotion::new(&points, 0.01, config.model_step_s()).unwrap();
        let design = Design::<N>::new(&config).unwrap();
        let (mut outer, mut ideal) = (OuterLoop::new(design.clone()), IdealTest::new(&design));
        let (mut sent_m, mut compared, mut peak_m) = ([0.0; N], 0, 0.0_f32);
        loop {
            let running = outer.mode() == Mode::Running;
            let sample = Sample::new(sent_m, force_n(&sent_m, physical));
            sent_m = outer.step(&sample, &ground).command_m;
            if running {
                assert!(!ideal.is_over(&ground), "after {compared} steps");
                ideal.step(force_n(ideal.command_m(), physical), &ground);
                assert_eq!(
                    sent_m.map(f32::to_bits),
                    ideal.command_m().map(f32::to_bits)
                );
                compared += 1;
                peak_m = peak_m.max(sent_m[0].abs());
            }
            match outer.mode() {
                Mode::Idle => drop(outer.handle(Event::Arm)),
                Mode::Armed => drop(outer.handle(Event::Start)),
                Mode::Running => {}
                other => {
                    assert_eq!(other, Mode::Finished);
                    break;
                }
            }
        }
        assert!(ideal.is_over(&ground));
        assert!(compared >= 199 * 20 && peak_m > 1e-4, "{compared} {peak_m}");
    }

    #[test]
    fn the_outer_loop_on_an_ideal_actuator_has_the_same_bits() {
        same_bits::<1>(1, 1, 0);
        same_bits::<1>(1, 10, 3);
        same_bits::<3>(3, 1, 0);
        same_bits::<3>(1, 4, 2);
    }
}
