//! Sensors that contradict each other: two transducers of one displacement, and a force that stands while the specimen moves.

use crate::hardware::Hardware;
use link::command::BoardTest;
use link::telemetry::MAX_INPUTS;
use link::{Input, MAX_ACTUATORS};
use outerloop_core::Fault;

/// Steps that are no fault, one without taking one off: a spike on a wire.
const TIMEOUT_STEPS: u8 = 4;

/// A force within this share of what the declared stiffness makes of the motion is none.
const NO_FORCE_SHARE: f64 = 0.02;

/// A force whose codes stay within this part of its converter's range stands but for the converter's noise: two codes of 16 bits to
/// either side; of 12 the one code that it has. A load cell that lives has more noise than that, also where a specimen yields. No
/// declared noise widens it: a dead one that is louder is not seen here, as docs/hazards.md says.
const STANDS_PART: u16 = 16_000;

/// What a test allows; the largest number where it is not looked at.
#[derive(Clone, Copy, Debug)]
pub struct SensorLimits {
    /// Largest difference of the two displacements, m.
    disagree_m: f32,
    /// Motion over which the force has to leave `no_force_n`, or where it stands, m.
    force_stands_m: f32,
    /// Force around zero that is none, N, of each actuator.
    no_force_n: [f32; MAX_ACTUATORS],
}

impl SensorLimits {
    /// Nothing is looked at.
    pub const NONE: Self = Self {
        disagree_m: f32::MAX,
        force_stands_m: f32::MAX,
        no_force_n: [0.0; MAX_ACTUATORS],
    };

    /// Of a test.
    pub fn of(test: &BoardTest) -> Self {
        let (config, limits) = (&test.config, &test.config.limits);
        let or_never = |limit: Option<f64>| limit.map_or(f32::MAX, |m| m as f32);
        let stiffness = &config.structure.stiffness_n_per_m;
        let stands_m = limits.force_stands_m.unwrap_or(0.0);
        Self {
            disagree_m: or_never(limits.disagree_m),
            force_stands_m: or_never(limits.force_stands_m),
            no_force_n: core::array::from_fn(|storey| {
                // No storey's stiffness is between an actuator and a coupler: there a force that stands is one whose code does.
                let own = stiffness.get(storey).filter(|_| test.coupled.is_none());
                let n_per_m = own.copied().unwrap_or(0.0);
                (NO_FORCE_SHARE * n_per_m * stands_m) as f32
            }),
        }
    }
}

/// What has been seen of the sensors of `A` actuators.
#[derive(Clone, Copy, Debug)]
pub struct SensorWatch<const A: usize> {
    /// Least and largest displacement since the force was last there, m.
    range_m: [[f32; 2]; A],
    /// Least and largest code of the force where it stands.
    stands: [[u16; 2]; A],
    apart_steps: u8,
}

impl<const A: usize> SensorWatch<A> {
    /// Nothing seen yet.
    pub const fn new() -> Self {
        Self {
            range_m: [[f32::MAX, f32::MIN]; A],
            stands: [[0; 2]; A],
            apart_steps: 0,
        }
    }

    /// Takes in a sample: the further inputs, displacements and forces in codes, in m and in N, and by how much a code of the
    /// first displacement stands. `tests`: an equation of motion takes the
    /// forces, here or outside.
    #[inline]
    pub fn fault<H: Hardware<A>>(
        &mut self,
        limits: &SensorLimits,
        inputs: &[u16; MAX_INPUTS],
        (codes, m_per_code): (&[[u16; 2]; A], f32),
        read: &[[f32; 2]; A],
        tests: bool,
    ) -> Option<Fault> {
        let mut apart = false;
        let first = codes.first().map_or(0, |[displacement, _]| *displacement);
        for (second, input) in inputs.iter().zip(H::INPUTS) {
            if *input == Input::SecondDisplacement {
                let off = f32::from(second.abs_diff(first)) * m_per_code.abs();
                apart |= off > limits.disagree_m;
            }
        }
        self.apart_steps = if apart {
            self.apart_steps.saturating_add(1)
        } else {
            self.apart_steps.saturating_sub(1)
        };
        if self.apart_steps > TIMEOUT_STEPS {
            return Some(Fault::Disagree);
        }
        self.force_stands(limits, (codes, H::CODES.sensor_top), read, tests)
            .then_some(Fault::ForceStands)
    }

    /// Around zero, or where it is.
    fn force_stands(
        &mut self,
        limits: &SensorLimits,
        (codes, top): (&[[u16; 2]; A], u16),
        read: &[[f32; 2]; A],
        tests: bool,
    ) -> bool {
        let mut stands = false;
        let seen = self.range_m.iter_mut().zip(&mut self.stands);
        let each = seen.zip(read).zip(codes).zip(&limits.no_force_n);
        for ((((range_m, codes), &[m, n]), &[_, code]), &none_n) in each {
            let [least, most] = range_m;
            let &mut [lowest, highest] = codes;
            let [low, high] = [lowest.min(code), highest.max(code)];
            let is_there = low.abs_diff(high) <= top / STANDS_PART;
            if tests && (n.abs() <= none_n || is_there) {
                (*least, *most) = (least.min(m), most.max(m));
                stands |= *most - *least > limits.force_stands_m;
            } else {
                (*least, *most) = (f32::MAX, f32::MIN);
            }
            *codes = if is_there { [low, high] } else { [code; 2] };
        }
        stands
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_force_that_moves_by_its_converters_noise_alone_stands_and_one_that_lives_does_not() {
        let limits = SensorLimits {
            disagree_m: f32::MAX,
            force_stands_m: 2e-3,
            no_force_n: [0.0; MAX_ACTUATORS],
        };
        for (top, off, expected) in [
            (65_535, 2, true),
            (65_535, 3, false),
            (4095, 0, true),
            (4095, 1, false),
        ] {
            let mut watch = SensorWatch::<1>::new();
            let stands = (0..30_u16).any(|step| {
                let code = top / 4 * 3 + off * (2 * (step % 2));
                let read = [[f32::from(step) * 1e-4, 5e3]];
                watch.force_stands(&limits, (&[[0, code]], top), &read, true)
            });
            assert_eq!(stands, expected, "{off} of {top} codes to either side");
        }
    }
}
