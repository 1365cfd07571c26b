//! An outside controller as a table: its commands for a given table of targets.
//!
//! The targets are the first floor of the reference structure, where a perfect test would have the specimen. The commands are
//! played on the nominal plant. The force goes into the numerical part as usual, but the target stays that of the table, so
//! the loop is not closed: the row says how well the commands follow and how the structure would have responded, but not
//! whether the closed loop is stable.

use super::FLOORS;
use super::case::{CASES, Structure};
use super::channels::Noise;
use super::criteria::{TrialVerdict, delay_ms};
use super::parameters::{Parameters, Specimen};
use super::record::GroundRecord;
use super::rules::{Deviation, Rules};
use super::trial::{Answers, Hybrid, Readings, RthsTrace, run};
use crate::Refused;

/// The targets of the case at `place` of [`CASES`] under `record`, m, one for each sample at 4096 Hz.
pub fn targets_m(record: &GroundRecord, place: usize) -> Vec<f64> {
    let floors = record.ground(place).reference_m;
    floors.iter().map(|floors| floors[0]).collect()
}

/// Judges `commands_m`, one for each sample and held until the next.
///
/// # Errors
/// Numbers of commands and samples that differ.
pub fn judge(
    record: &GroundRecord,
    place: usize,
    commands_m: &[f64],
    seed: u64,
    rules: &Rules,
) -> Result<TrialVerdict, Refused> {
    let samples = record.samples();
    if commands_m.len() != samples {
        return Err(Refused::new(format!(
            "{} commands for the {samples} samples of {}: one a sample is accepted",
            commands_m.len(),
            record.name
        )));
    }
    let case = CASES[place];
    let parts = [(case, case.numerical(&Specimen::NOMINAL))];
    let ground = record.ground(place);
    let mut played = Played {
        structure: Structure::new(&parts)
            .ok_or_else(|| Refused::new("rths: the mass of a numerical part is not positive"))?,
        targets: ground.reference_m,
        commands_m,
        sample: 0,
        force_n: [0.0],
    };
    let mut trace = RthsTrace::default();
    let noise = Noise::new(seed << 32, samples);
    let plant = [Parameters::NOMINAL];
    let verdict = run(&mut played, &plant, ground, &[&noise], Some(&mut trace));
    let about_mean = !rules.deviates(Deviation::RootMeanSquare);
    let mut verdict = verdict.verdict(0, record.scale(place), about_mean);
    verdict.j[0] = delay_ms(&trace.target_m, &trace.read_m);
    Ok(verdict)
}

struct Played<'a> {
    structure: Structure<1>,
    targets: &'a [[f64; FLOORS]],
    commands_m: &'a [f64],
    sample: usize,
    force_n: [f64; 1],
}

impl Hybrid<1> for Played<'_> {
    fn step(&mut self, readings: &Readings<1>) -> Answers<1> {
        let mut floors_m = self.structure.floors_m();
        floors_m[0] = [self.targets[self.sample][0]];
        let command_m = [self.commands_m[self.sample]];
        self.sample += 1;
        self.structure.step(readings.ground_m_per_s2, self.force_n);
        self.force_n = readings.force_n;
        Answers {
            floors_m,
            command_m,
            judged_m: readings.displacement_m,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rths::yielding::Behaviour;

    #[test]
    fn a_quarter_of_a_second_too_little_is_refused_and_the_inverse_of_the_plant_follows() {
        let acc: Vec<f32> = (0..200).map(|i| (0.4 * i as f32).sin()).collect();
        let rules = Rules::official();
        let record = GroundRecord::new("sine", &acc, 0.02, &rules, Behaviour::Linear);
        let targets = targets_m(&record, 0);
        assert!(judge(&record, 0, &targets[..1000], 1, &rules).is_err());
        // A target sent unchanged arrives about 25 ms late; one sent that much earlier does not.
        let late = judge(&record, 0, &targets, 1, &rules).unwrap();
        let ahead: Vec<f64> = (0..targets.len())
            .map(|k| targets.get(k + 100).copied().unwrap_or(0.0))
            .collect();
        let led = judge(&record, 0, &ahead, 1, &rules).unwrap();
        assert!(
            late.j[0] > 15.0 && led.j[0].abs() < 3.0,
            "{} {}",
            late.j[0],
            led.j[0]
        );
        assert!(led.j2_true < 0.4 * late.j2_true);
    }
}
