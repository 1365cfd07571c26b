//! The record of a control step, in a fixed layout of 32-bit words.

use crate::energy::Errors;
use crate::supervise::mode::Mode;

/// One control step. Quantities of the integration (energies, C_cor, G_v, velocity) belong to the last solved
/// integration step.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Record<const N: usize> {
    /// Control step since power-up.
    pub tick: u32,
    /// Integration steps solved since the start of the test.
    pub step: u32,
    /// Mode, fault and [`flag`] bits.
    pub flags: u32,
    /// Ground acceleration, m/s^2.
    pub ground_m_per_s2: f32,
    /// u_c: the target that was in force while the sample was taken, m. Energies and errors refer to it.
    pub command_m: [f32; N],
    /// The command sent to the actuators for it, m: u_c itself if there is no predictor.
    pub sent_m: [f32; N],
    /// u_m as measured, m.
    pub displacement_m: [f32; N],
    /// R_m as measured, N.
    pub force_n: [f32; N],
    /// u_m as estimated, m.
    pub estimated_displacement_m: [f32; N],
    /// R_m as estimated, N.
    pub estimated_force_n: [f32; N],
    /// Velocity v_i in model time, m/s.
    pub velocity_m_per_s: [f32; N],
    /// Acceleration a_i in model time, m/s^2.
    pub acceleration_m_per_s2: [f32; N],
    /// C_cor, N s/m.
    pub added_damping_n_s_per_m: [f32; N],
    /// G_v of Eq 19.
    pub gain: [f32; N],
    /// Energy errors of the step, J.
    pub energy_step: EnergyWords,
    /// Energy errors since the start, J.
    pub energy_sum: EnergyWords,
    /// Work of the external load since the start, J.
    pub energy_input_j: f32,
    /// Energy error relative to the energy in the test.
    pub energy_ratio: f32,
    /// Mean squared innovation of displacement and force; 1 means that the model fits.
    pub innovation: [f32; 2],
}

/// The three energy errors as words.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct EnergyWords {
    /// Eq 6, J.
    pub stiffness_j: f32,
    /// HSEM, J.
    pub hsem_j: f32,
    /// Eq 12, J.
    pub modified_j: f32,
}

impl From<Errors> for EnergyWords {
    fn from(e: Errors) -> Self {
        Self {
            stiffness_j: e.stiffness_j,
            hsem_j: e.hsem_j,
            modified_j: e.modified_j,
        }
    }
}

/// Bits of [`Record::flags`] above the mode (bits 0 to 3) and the latched fault (bits 8 to 15).
pub mod flag {
    /// An integration step was solved.
    pub const SOLVED: u32 = 1 << 16;
    /// C_cor was held.
    pub const HELD: u32 = 1 << 17;
    /// C_cor was clamped.
    pub const CLAMPED: u32 = 1 << 18;
    /// The energy error is above the warning threshold.
    pub const ENERGY_WARNING: u32 = 1 << 19;
    /// The structure is locked by its own added damping.
    pub const LOCKED: u32 = 1 << 20;
    /// The target is late.
    pub const LATE: u32 = 1 << 21;
    /// The innovation does not fit the estimator's model.
    pub const MODEL_DOUBT: u32 = 1 << 22;
    /// The sample was stale.
    pub const STALE: u32 = 1 << 23;
    /// The approach waits for the contact behind PERMIT.
    pub const CHAIN_OPEN: u32 = 1 << 24;
    /// The watch holds an adaptive compensation at its declared values.
    pub const GUARDED: u32 = 1 << 25;
    /// The watch corrects command or reading.
    pub const ADJUSTED: u32 = 1 << 26;
    /// The watch was not evaluated in time and has ended.
    pub const WATCH_LATE: u32 = 1 << 27;
    /// With `STALE`: no sample came in this step.
    pub const MISSED: u32 = 1 << 30;
    /// Position of the lower of the two bits of the watch's state.
    pub const WATCH_STATE_SHIFT: u32 = 28;
}

impl<const N: usize> Record<N> {
    /// The loop's mode.
    pub fn mode(&self) -> Option<Mode> {
        Mode::from_code(self.flags & 0xf)
    }

    /// Number of 32-bit words.
    pub const WORDS: usize = 4 + 10 * N + 10;

    /// Everything zero, in mode `Idle`.
    pub const EMPTY: Self = Self {
        tick: 0,
        step: 0,
        flags: Mode::Idle as u32,
        ground_m_per_s2: 0.0,
        command_m: [0.0; N],
        sent_m: [0.0; N],
        displacement_m: [0.0; N],
        force_n: [0.0; N],
        estimated_displacement_m: [0.0; N],
        estimated_force_n: [0.0; N],
        velocity_m_per_s: [0.0; N],
        acceleration_m_per_s2: [0.0; N],
        added_damping_n_s_per_m: [0.0; N],
        gain: [0.0; N],
        energy_step: EnergyWords {
            stiffness_j: 0.0,
            hsem_j: 0.0,
            modified_j: 0.0,
        },
        energy_sum: EnergyWords {
            stiffness_j: 0.0,
            hsem_j: 0.0,
            modified_j: 0.0,
        },
        energy_input_j: 0.0,
        energy_ratio: 0.0,
        innovation: [0.0; 2],
    };

    /// True if a [`flag`] is set.
    pub const fn has(&self, flag: u32) -> bool {
        self.flags & flag != 0
    }

    /// Calls `each` with every word in the order of the fields; floats as their bits.
    pub fn for_each_word(&self, mut each: impl FnMut(u32)) {
        each(self.tick);
        each(self.step);
        each(self.flags);
        each(self.ground_m_per_s2.to_bits());
        for axes in [
            &self.command_m,
            &self.sent_m,
            &self.displacement_m,
            &self.force_n,
            &self.estimated_displacement_m,
            &self.estimated_force_n,
            &self.velocity_m_per_s,
            &self.acceleration_m_per_s2,
            &self.added_damping_n_s_per_m,
            &self.gain,
        ] {
            for x in axes {
                each(x.to_bits());
            }
        }
        for e in [self.energy_step, self.energy_sum] {
            each(e.stiffness_j.to_bits());
            each(e.hsem_j.to_bits());
            each(e.modified_j.to_bits());
        }
        each(self.energy_input_j.to_bits());
        each(self.energy_ratio.to_bits());
        each(self.innovation[0].to_bits());
        each(self.innovation[1].to_bits());
    }

    /// Mixes every word into an FNV-1a hash, to compare whole traces by one number. Start with
    /// [`Record::<N>::HASH_START`](Self::HASH_START).
    pub fn hash(&self, mut hash: u64) -> u64 {
        self.for_each_word(|w| hash = (hash ^ u64::from(w)).wrapping_mul(0x0000_0100_0000_01b3));
        hash
    }

    /// The hash of an empty trace.
    pub const HASH_START: u64 = 0xcbf2_9ce4_8422_2325;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_layout_is_as_long_as_it_says() {
        fn check<const N: usize>() {
            let mut words = 0;
            Record::<N>::EMPTY.for_each_word(|_| words += 1);
            assert_eq!(words, Record::<N>::WORDS);
            assert_eq!(words * 4, core::mem::size_of::<Record<N>>());
        }
        check::<1>();
        check::<3>();
        check::<8>();
    }
}
