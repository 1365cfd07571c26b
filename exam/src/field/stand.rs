//! The rig of a field record with its transducers: what it does, and what is read of it.

use super::motion::Moved;
use super::reading::{self, Reading};
use super::{drive, force};
use crate::dice::Dice;
use crate::record::Record;

/// What stands in the rig.
#[derive(Clone, Debug)]
pub(super) enum Machine {
    /// Its displacement is as commanded.
    Specimen(force::Rig),
    /// Nothing hangs on it.
    Actuator(drive::Rig),
}

/// A rig with its transducers.
#[derive(Clone, Debug)]
pub(super) struct Stand {
    machine: Machine,
    pub(super) reading: Reading,
    /// Ranges of displacement and force: those of the first record.
    scale: Option<[f64; 2]>,
}

impl Stand {
    pub(super) fn new(machine: Machine, reading: Reading) -> Self {
        Self {
            machine,
            reading,
            scale: None,
        }
    }

    /// What is read of a motion, and what a perfect reading would be.
    pub(super) fn read(&mut self, moved: &Moved, dice: &mut Dice) -> [Record; 2] {
        let (x, command, force) = match &self.machine {
            Machine::Specimen(rig) => (moved.x.clone(), None, Some(rig.force(&moved.x, dice))),
            Machine::Actuator(rig) => (rig.displacement(&moved.x, dice), Some(&moved.x[..]), None),
        };
        let ranges = || reading::scale(&x, force.as_deref().unwrap_or_default());
        let scale = *self.scale.get_or_insert_with(ranges);
        let at = Moved { x, ..moved.clone() };
        let mut by =
            |reading: &Reading| reading.record(&at, command, force.as_deref(), scale, dice);
        [by(&self.reading), by(&Reading::PERFECT)]
    }
}

#[cfg(test)]
mod tests {
    use super::super::set_field;
    use crate::fine::peak;

    #[test]
    fn the_noise_of_the_key_is_what_the_reading_adds() {
        let mut exact = 0;
        for seed in 30_000..30_070 {
            let field = set_field(seed);
            let r = &field.train.record;
            let output = if r.force_n.is_empty() {
                &r.displacement_mm
            } else {
                &r.force_n
            };
            let share = field.noise_rms / peak(output);
            exact += usize::from(share == 0.0);
            assert!((0.0..0.02).contains(&share), "{seed}: {share}");
        }
        // A tenth is simulated by others: neither noise nor a converter.
        assert!((2..15).contains(&exact), "{exact}");
    }
}
