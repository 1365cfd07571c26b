//! Each actuator moves a floor of its own. Corrections make the rig ideal: samples are freed of offsets, gains, skew
//! between channels and bearing friction, and commands bring the actuator to the wanted position.
//!
//! Each error is corrected at its cause. An actuator that is not where its command says gets another command; its
//! reading is right. A transducer that reads wrong has its reading corrected; that does not change the actuator's
//! position. An offset of the displacement shows in the force as stiffness times offset: whoever takes out the one must
//! not take out the other as well.

use super::command::CommandMap;
use super::interface::{Asked, Rig};
use crate::delay_line::{Delay, DelayLine};
use crate::float::{larger, smaller};
use crate::supervise::Finding;

/// The longest skew between the channels, in control steps, and 2.
pub const MAX_SKEW_STEPS: usize = 12;

/// Constants of the axes.
pub type RigConstants<const N: usize> = [AxisCorrection; N];

/// Which channel waits for the other.
#[derive(Clone, Copy, Debug)]
enum Wait {
    Neither,
    Displacement(Delay),
    Force(Delay),
}

/// Checked parameters of an axis, as they are configured.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    pub(crate) displacement_gain: f64,
    pub(crate) displacement_offset_m: f64,
    pub(crate) force_gain: f64,
    pub(crate) force_offset_n: f64,
    /// By how many control steps the force is behind the displacement.
    pub(crate) force_late_steps: f64,
    pub(crate) friction_n: f64,
    pub(crate) presliding_m: f64,
    pub(crate) displacement_noise_m: f64,
}

/// The known properties of an axis.
#[derive(Clone, Copy, Debug)]
pub struct AxisCorrection {
    /// True displacement per measured one.
    displacement_scale: f32,
    displacement_offset_m: f32,
    force_offset_n: f32,
    /// True force per measured force.
    force_scale: f32,
    wait: Wait,
    friction_n: f32,
    /// Motion that may be noise, either way, m.
    idle_m: f32,
    /// 1/m.
    per_presliding: f32,
}

/// Motion that may be noise, in standard deviations of the displacement: one sample in 300 is beyond it.
const NOISE: f64 = 3.0;

impl AxisCorrection {
    pub(crate) fn new(known: &Known) -> Self {
        let late_steps = known.force_late_steps;
        // A reversal shows after the noise has been passed twice. With that much less of presliding, friction has turned
        // where it would have without noise.
        let idle_m = (NOISE * known.displacement_noise_m).min(0.5 * known.presliding_m);
        Self {
            displacement_scale: (1.0 / known.displacement_gain) as f32,
            displacement_offset_m: known.displacement_offset_m as f32,
            force_offset_n: known.force_offset_n as f32,
            force_scale: (1.0 / known.force_gain) as f32,
            wait: if late_steps > 0.0 {
                Wait::Displacement(Delay::new(late_steps))
            } else if late_steps < 0.0 {
                Wait::Force(Delay::new(-late_steps))
            } else {
                Wait::Neither
            },
            friction_n: known.friction_n as f32,
            idle_m: idle_m as f32,
            per_presliding: (1.0 / (known.presliding_m - idle_m)) as f32,
        }
    }
}

/// The memory of an axis.
#[derive(Clone, Debug)]
struct Memory {
    /// Displacement with a play of the noise, m; `None` before the first sample.
    last_m: Option<f32>,
    /// Friction in force, of its largest: -1 to 1.
    friction: f32,
    waiting: DelayLine<MAX_SKEW_STEPS>,
}

/// A rig whose actuators each move a floor of their own: its known properties and its state.
#[derive(Clone, Debug)]
pub struct DirectRig<const N: usize> {
    constants: Option<RigConstants<N>>,
    memory: [Memory; N],
}

impl<const N: usize> DirectRig<N> {
    const BEFORE: [Memory; N] = [const {
        Memory {
            last_m: None,
            friction: 0.0,
            waiting: DelayLine::filled(0.0),
        }
    }; N];

    /// Puts true values in the place of measured ones.
    #[inline(never)]
    fn without_errors(&mut self, displacement_m: &mut [f32; N], force_n: &mut [f32; N]) {
        let Some(constants) = &self.constants else {
            return;
        };
        for j in 0..N {
            let (k, memory) = (&constants[j], &mut self.memory[j]);
            let x = (displacement_m[j] - k.displacement_offset_m) * k.displacement_scale;
            let force = (force_n[j] - k.force_offset_n) * k.force_scale;
            // A friction that follows noise back and forth never builds up to its full size.
            let last = match memory.last_m {
                Some(last) => last,
                // It stood there before.
                None => {
                    memory.waiting = DelayLine::filled(match k.wait {
                        Wait::Force(_) => force,
                        Wait::Displacement(_) | Wait::Neither => x,
                    });
                    x
                }
            };
            let moved = larger(smaller(last, x + k.idle_m), x - k.idle_m);
            let friction = memory.friction + (moved - last) * k.per_presliding;
            memory.friction = larger(smaller(friction, 1.0), -1.0);
            memory.last_m = Some(moved);
            let force = force - k.friction_n * memory.friction;
            (displacement_m[j], force_n[j]) = match k.wait {
                Wait::Neither => (x, force),
                Wait::Displacement(delay) => (memory.waiting.pass(delay, x), force),
                Wait::Force(delay) => (x, memory.waiting.pass(delay, force)),
            };
        }
    }
}

impl<const N: usize> Rig<N> for DirectRig<N> {
    /// `None` if samples need no correction.
    type Constants = Option<RigConstants<N>>;

    const SAME_COORDINATES: bool = true;

    fn at_rest(constants: Self::Constants) -> Self {
        Self {
            constants,
            memory: Self::BEFORE,
        }
    }

    fn rest(&mut self) {
        self.memory = Self::BEFORE;
    }

    #[inline]
    fn correct(
        &mut self,
        _: &[f32; N],
        _: bool,
        displacement_m: &mut [f32; N],
        force_n: &mut [f32; N],
    ) {
        self.without_errors(displacement_m, force_n);
    }

    #[inline]
    fn strokes_m(&self, at_m: &[f32; N]) -> [f32; N] {
        *at_m
    }

    #[inline]
    fn commands(&mut self, maps: &[CommandMap; N], asked: &Asked<'_, N>) -> [f32; N] {
        core::array::from_fn(|j| maps[j].towards(asked.aim_m[j]))
    }

    #[inline]
    fn within(&self, _: &[f32; N], _: &[f32; N]) -> bool {
        true
    }

    #[inline]
    fn first_fault(&self, _: &[f32; N], _: &[f32; N]) -> Option<Finding> {
        None
    }

    #[inline]
    fn per_metre(&self, _: usize) -> f32 {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const IDEAL: Known = Known {
        displacement_gain: 1.0,
        displacement_offset_m: 0.0,
        force_gain: 1.0,
        force_offset_n: 0.0,
        force_late_steps: 0.0,
        friction_n: 0.0,
        presliding_m: 1.0,
        displacement_noise_m: 0.0,
    };

    fn rig(known: Known) -> DirectRig<1> {
        DirectRig::at_rest(Some([AxisCorrection::new(&known)]))
    }

    #[test]
    fn gains_and_offsets_come_out_of_both_channels() {
        let mut rig = rig(Known {
            displacement_gain: 0.5,
            displacement_offset_m: 0.25,
            force_gain: 1.25,
            force_offset_n: 100.0,
            ..IDEAL
        });
        let (mut x, mut f) = ([0.75], [1350.0]);
        rig.without_errors(&mut x, &mut f);
        assert_eq!((x, f), ([1.0], [1000.0]));
    }

    #[test]
    fn the_command_is_what_brings_the_actuator_there() {
        let command = CommandMap::new(1.25, 0.5);
        let sent = command.towards(3.0);
        assert_eq!(1.25 * sent + 0.5, 3.0);
    }

    #[test]
    fn channels_tell_of_the_same_instant_whichever_is_late() {
        for late in [2.5_f64, -2.5] {
            let mut rig = rig(Known {
                force_late_steps: late,
                ..IDEAL
            });
            let (mut x, mut f) = ([0.0], [0.0]);
            for i in 0..20 {
                // A ramp and a force of a hundred times the displacement, one of them late.
                let i = i as f32;
                let (early, behind) = (i, i - 2.5);
                (x, f) = match late > 0.0 {
                    true => ([early], [100.0 * behind]),
                    false => ([behind], [100.0 * early]),
                };
                rig.without_errors(&mut x, &mut f);
            }
            assert_eq!(f[0], 100.0 * x[0]);
        }
    }

    const FRICTION: Known = Known {
        friction_n: 300.0,
        presliding_m: 0.2e-3,
        ..IDEAL
    };

    /// Largest and mean error, N, of friction that is taken out of a slow motion read with a noise of `noise_m`.
    fn friction_left(known: Known, noise_m: f32) -> (f32, f32) {
        let mut rig = rig(known);
        let (mut z, mut last) = (0.0_f32, 0.0_f32);
        let (mut seed, mut worst, mut sum) = (1_u32, 0.0_f32, 0.0_f32);
        for i in 0..6000 {
            let at = 0.01 * (i as f32 * 1e-3).sin();
            z = (z + (at - last) / 0.2e-3).clamp(-1.0, 1.0);
            last = at;
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            // Uniform, of standard deviation 1.
            let noise = ((seed >> 8) as f32 / 16_777_216.0 - 0.5) * 12.0_f32.sqrt();
            let elastic = 158e3 * at;
            let (mut x, mut f) = ([at + noise_m * noise], [elastic + 300.0 * z]);
            rig.without_errors(&mut x, &mut f);
            let error = f[0] - elastic;
            worst = worst.max(error.abs());
            sum += error * z.signum();
        }
        (worst, sum / 6000.0)
    }

    #[test]
    fn friction_comes_out_as_it_came_in() {
        let (worst, _) = friction_left(FRICTION, 0.0);
        assert!(worst < 0.1, "{worst} N");
    }

    #[test]
    fn noise_does_not_rub_friction_away() {
        let noise_m = 2e-5;
        let (_, forgotten) = friction_left(FRICTION, noise_m);
        let (_, mean) = friction_left(
            Known {
                displacement_noise_m: f64::from(noise_m),
                ..FRICTION
            },
            noise_m,
        );
        // Of 300 N; where the noise is not declared, its fast steps keep the friction from its full size.
        assert!(forgotten > 20.0, "{forgotten} N");
        assert!(mean.abs() < 5.0, "{mean} N");
    }
}
