//! Samples as an ideal rig would have given them: offsets, gains, skew between the channels, friction of the bearings.

use crate::estimate::{Delay, DelayLine};
use crate::order::{larger, smaller};

/// The longest skew between the channels, in control steps, and 2.
pub const MAX_SKEW_STEPS: usize = 12;

/// Constants of the axes.
pub type Constants<const N: usize> = [Axis; N];

/// Which channel waits for the other.
#[derive(Clone, Copy, Debug)]
enum Wait {
    Neither,
    Displacement(Delay),
    Force(Delay),
}

/// What is known of an axis.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    displacement_offset_m: f32,
    force_offset_n: f32,
    /// True force per measured force.
    force_scale: f32,
    wait: Wait,
    friction_n: f32,
    /// 1/m.
    per_presliding: f32,
}

impl Axis {
    /// From checked parameters: by how many control steps the force is late, friction in N and presliding in m.
    pub(crate) fn new(
        displacement_offset_m: f64,
        force_gain: f64,
        force_offset_n: f64,
        late_steps: f64,
        [friction_n, presliding_m]: [f64; 2],
    ) -> Self {
        Self {
            displacement_offset_m: displacement_offset_m as f32,
            force_offset_n: force_offset_n as f32,
            force_scale: (1.0 / force_gain) as f32,
            wait: if late_steps > 0.0 {
                Wait::Displacement(Delay::new(late_steps))
            } else if late_steps < 0.0 {
                Wait::Force(Delay::new(-late_steps))
            } else {
                Wait::Neither
            },
            friction_n: friction_n as f32,
            per_presliding: (1.0 / presliding_m) as f32,
        }
    }
}

/// The memory of an axis.
#[derive(Clone, Debug)]
struct Memory {
    /// Displacement of the last sample, m; `None` before the first.
    last_m: Option<f32>,
    /// Friction in force, of its largest: -1 to 1.
    friction: f32,
    waiting: DelayLine<MAX_SKEW_STEPS>,
}

/// What is known of a rig, and its memory.
#[derive(Clone, Debug)]
pub struct Rig<const N: usize> {
    constants: Option<Constants<N>>,
    memory: [Memory; N],
}

impl<const N: usize> Rig<N> {
    const BEFORE: [Memory; N] = [const {
        Memory {
            last_m: None,
            friction: 0.0,
            waiting: DelayLine::filled(0.0),
        }
    }; N];

    /// Before the first sample.
    pub(crate) fn new(constants: Option<Constants<N>>) -> Self {
        Self {
            constants,
            memory: Self::BEFORE,
        }
    }

    /// Back to before the first sample.
    pub(crate) fn rest(&mut self) {
        self.memory = Self::BEFORE;
    }

    /// Puts true values in the place of measured ones.
    #[inline(never)]
    pub(crate) fn correct(&mut self, displacement_m: &mut [f32; N], force_n: &mut [f32; N]) {
        let Some(constants) = &self.constants else {
            return;
        };
        for j in 0..N {
            let (k, memory) = (&constants[j], &mut self.memory[j]);
            let x = displacement_m[j] - k.displacement_offset_m;
            let force = (force_n[j] - k.force_offset_n) * k.force_scale;
            let step = x - memory.last_m.unwrap_or(x);
            let friction = memory.friction + step * k.per_presliding;
            memory.friction = larger(smaller(friction, 1.0), -1.0);
            memory.last_m = Some(x);
            let force = force - k.friction_n * memory.friction;
            (displacement_m[j], force_n[j]) = match k.wait {
                Wait::Neither => (x, force),
                Wait::Displacement(delay) => (memory.waiting.pass(delay, x), force),
                Wait::Force(delay) => (x, memory.waiting.pass(delay, force)),
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: [f64; 2] = [0.0, 1.0];

    fn rig(axis: Axis) -> Rig<1> {
        Rig::new(Some([axis]))
    }

    #[test]
    fn gain_and_offset_come_out() {
        let mut rig = rig(Axis::new(0.25, 1.25, 100.0, 0.0, PLAIN));
        let (mut x, mut f) = ([1.25], [1350.0]);
        rig.correct(&mut x, &mut f);
        assert_eq!((x, f), ([1.0], [1000.0]));
    }

    #[test]
    fn channels_tell_of_the_same_instant_whichever_is_late() {
        for late in [2.5_f64, -2.5] {
            let mut rig = rig(Axis::new(0.0, 1.0, 0.0, late, PLAIN));
            let (mut x, mut f) = ([0.0], [0.0]);
            for i in 0..20 {
                // A ramp and a force of a hundred times the displacement, one of them late.
                let i = i as f32;
                let (early, behind) = (i, i - 2.5);
                (x, f) = match late > 0.0 {
                    true => ([early], [100.0 * behind]),
                    false => ([behind], [100.0 * early]),
                };
                rig.correct(&mut x, &mut f);
            }
            assert_eq!(f[0], 100.0 * x[0]);
        }
    }

    #[test]
    fn friction_comes_out_as_it_came_in() {
        let (largest, presliding) = (300.0_f32, 0.2e-3_f32);
        let mut rig = rig(Axis::new(
            0.0,
            1.0,
            0.0,
            0.0,
            [f64::from(largest), f64::from(presliding)],
        ));
        let (mut z, mut last) = (0.0_f32, 0.0_f32);
        for i in 0..2000 {
            let at = 0.01 * (i as f32 * 0.01).sin();
            z = (z + (at - last) / presliding).clamp(-1.0, 1.0);
            last = at;
            let elastic = 158e3 * at;
            let (mut x, mut f) = ([at], [elastic + largest * z]);
            rig.correct(&mut x, &mut f);
            assert!(
                (f[0] - elastic).abs() < 0.1,
                "step {i}: {} for {elastic}",
                f[0]
            );
        }
    }
}
