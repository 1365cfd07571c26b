//! The rig of a field record. It plays any command, read by the same transducers over the same range.

use super::motion::{Moved, Plan};
use super::reading::{self, Reading};
use super::{drive, force, ram};
use crate::draws::Draws;
use crate::fine::{DT, FINE_HZ};
use crate::record::Record;

/// The machine in the rig.
#[derive(Clone, Debug)]
pub(super) enum Machine {
    /// A specimen; its displacement is exactly as commanded.
    Specimen(force::Rig),
    /// An actuator without a load.
    Actuator(drive::Rig),
    /// A ram with its position control and its load.
    Ram(ram::Ram),
}

/// A rig with its transducers. Only the scorer has it; the examinee may ask for tests.
#[derive(Clone, Debug)]
pub struct Stand {
    machine: Machine,
    pub(super) reading: Reading,
    /// Ranges of displacement and force: those of the first record.
    scale: Option<[f64; 2]>,
    rate_hz: f64,
    /// Expected top speed of the first record, mm/s.
    speed: f64,
}

/// Limits of a rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// The transducer's range to either side of zero, mm.
    pub displacement_mm: f64,
    /// Twice the expected top speed of the first record, mm/s.
    pub velocity_mm_per_s: f64,
    /// The load cell's range, N; none if there is no load cell.
    pub force_n: Option<f64>,
}

/// How many times as fast as in its first record a rig may move.
const FASTER: f64 = 2.0;

impl Stand {
    pub(super) fn new(machine: Machine, reading: Reading, plan: &Plan) -> Self {
        Self {
            machine,
            reading,
            scale: None,
            rate_hz: plan.rate_hz,
            speed: plan.speed(),
        }
    }

    /// The reading of a motion, and a perfect reading of it.
    pub(super) fn read(&mut self, moved: &Moved, rng: &mut Draws) -> [Record; 2] {
        let (x, command, force) = match &mut self.machine {
            Machine::Specimen(rig) => (moved.x.clone(), None, Some(rig.force(&moved.x, rng))),
            Machine::Actuator(rig) => (rig.displacement(&moved.x, rng), Some(&moved.x[..]), None),
            Machine::Ram(ram) => (ram.displacement(&moved.x), Some(&moved.x[..]), None),
        };
        let ranges = || reading::scale(&x, force.as_deref().unwrap_or_default());
        let scale = *self.scale.get_or_insert_with(ranges);
        let at = Moved { x, ..moved.clone() };
        let mut by = |reading: &Reading| reading.record(&at, command, force.as_deref(), scale, rng);
        [by(&self.reading), by(&Reading::PERFECT)]
    }

    /// Its limits.
    pub fn limits(&self) -> Limits {
        let [x, f] = self.scale.unwrap_or_default();
        Limits {
            displacement_mm: x,
            velocity_mm_per_s: FASTER * self.speed,
            force_n: (f > 0.0).then_some(f),
        }
    }

    /// The record of a command with a value every `interval_s`, from the same rig with the same rate, noise and range.
    pub fn play(&self, command_mm: &[f64], interval_s: f64, seed: u64) -> Record {
        let [record, _] = self.play_with_truth(command_mm, interval_s, seed);
        record
    }

    /// The same, and a perfect reading of it.
    pub fn play_with_truth(&self, command_mm: &[f64], interval_s: f64, seed: u64) -> [Record; 2] {
        let seconds = command_mm.len().saturating_sub(1) as f64 * interval_s;
        let n = (seconds * FINE_HZ) as usize;
        let x: Vec<f64> = (0..n)
            .map(|i| between(command_mm, i as f64 * DT / interval_s))
            .collect();
        let moved = Moved {
            end: x.len(),
            x,
            from: 0,
            rate_hz: self.rate_hz,
        };
        self.clone().read(&moved, &mut Draws::new(seed))
    }
}

/// Value at a fractional index by Catmull-Rom splines: no corners between samples, which would show through a mass.
fn between(u: &[f64], index: f64) -> f64 {
    let last = u.len() - 1;
    let i = (index as usize).min(last);
    let p = [i.saturating_sub(1), i, (i + 1).min(last), (i + 2).min(last)].map(|i| u[i]);
    let t = index - i as f64;
    let slopes = [0.5 * (p[2] - p[0]), 0.5 * (p[3] - p[1])];
    let (bend, turn) = (
        3.0 * (p[2] - p[1]) - 2.0 * slopes[0] - slopes[1],
        2.0 * (p[1] - p[2]) + slopes[0] + slopes[1],
    );
    p[1] + t * (slopes[0] + t * (bend + t * turn))
}

#[cfg(test)]
mod tests {
    use super::super::set_field;
    use super::*;
    use crate::fine::peak;
    use std::f64::consts::TAU;

    #[test]
    fn between_samples_a_command_is_smooth_and_passes_through_them() {
        let h = 0.01;
        let u: Vec<f64> = (0..200).map(|i| (TAU * i as f64 * h).sin()).collect();
        assert_eq!(between(&u, 7.0), u[7]);
        assert_eq!(between(&u, 199.0), u[199]);
        let error = (30..1900).map(|i| {
            let index = 0.1 * f64::from(i);
            (between(&u, index) - (TAU * index * h).sin()).abs()
        });
        assert!(error.fold(0.0, f64::max) < 2e-5);
    }

    #[test]
    fn what_a_rig_plays_is_read_as_its_record_was() {
        for seed in 30_000..30_035 {
            let field = set_field(seed);
            let stand = field.stand.as_ref().unwrap();
            let limits = stand.limits();
            let hz = limits.velocity_mm_per_s / (2.0 * TAU * limits.displacement_mm);
            let h = 2e-3;
            let command: Vec<f64> = (0..5000)
                .map(|i| 0.5 * limits.displacement_mm * (TAU * hz * h * f64::from(i)).sin())
                .collect();
            let played = stand.play(&command, h, 1);
            assert_eq!(played.rate_hz, field.train.record.rate_hz);
            assert_eq!(
                played.force_n.is_empty(),
                field.train.record.force_n.is_empty()
            );
            assert_eq!(
                played.displacement_mm,
                stand.play(&command, h, 1).displacement_mm
            );
            let far = peak(&field.train.record.displacement_mm);
            assert!(far <= limits.displacement_mm * 1.01, "{seed}");
            let reaches = peak(&played.displacement_mm) / limits.displacement_mm;
            assert!((0.2..1.0).contains(&reaches), "{seed}: {reaches}");
        }
    }

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
        // A tenth of the records are simulated: neither noise nor a converter.
        assert!((2..15).contains(&exact), "{exact}");
    }
}
