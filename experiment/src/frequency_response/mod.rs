//! The frequency response of an actuator: gain, phase and coherence of displacement over command, and how much of the
//! displacement is distortion of even and of odd order, and how much is noise.
//!
//! | look in | for |
//! |---|---|
//! | `linear` | gain, phase, coherence: averaged cross spectra (Bendat and Piersol, Random Data, chapter 9) |
//! | `sweep` | distortion of a sine whose frequency moves: multiples of the command's own phase |
//! | `periodic` | distortion of a periodic odd multisine: lines that the command does not have (Pintelon and Schoukens, System Identification, 2012, section 4.3) |
//!
//! Friction and play turn over with the direction of motion and distort in odd orders; a rod on one side, a bent scale or a
//! valve with unequal edges distort in even ones.

mod distortion;
mod linear;
mod periodic;
mod sweep;

pub use distortion::{Distortion, DistortionLine, Excitation};
pub use linear::ResponseLine;

use crate::failure::Failure;
use diagnosis::Recording;
use schemars::JsonSchema;
use serde::Serialize;

/// The frequency response of an actuator.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct FrequencyResponse {
    /// Lines at which the command moves, ascending.
    pub lines: Vec<ResponseLine>,
    /// Distortion; null: the command is neither a sweep nor periodic, so that distortion cannot be told from noise.
    pub distortion: Option<Distortion>,
}

/// Works out what a record of command and displacement says over frequency.
///
/// # Errors
/// A record without a command or a displacement.
pub fn frequency_response(recording: &Recording) -> Result<FrequencyResponse, Failure> {
    let column = |values: &Option<Vec<f64>>, what: &str| {
        let name = &recording.name;
        values.clone().ok_or_else(|| {
            Failure::input(format!(
                "{name}: has no {what}: accepted is a record with the command and the displacement of an actuator"
            ))
        })
    };
    let interval_s = recording.interval_s();
    let command = column(&recording.command_mm, "command")?;
    let displacement = column(&recording.displacement_mm, "displacement")?;
    let distortion = periodic::distortion(&command, &displacement, interval_s)
        .or_else(|| sweep::distortion(&command, &displacement, interval_s));
    Ok(FrequencyResponse {
        lines: linear::lines(&command, &displacement, interval_s),
        distortion,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::signal::{SignalPoints, SignalShape};
    use rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use std::f64::consts::TAU;

    /// A record at 1 kHz of an actuator that is 5 ms late, and through `of`, a function of the late command and its speed.
    fn played(shape: SignalShape, noise_mm: f64, of: impl Fn(f64, f64) -> f64) -> Recording {
        let signal = SignalPoints::made(shape, 5e-3, [0.25, 8.0], 60.0).unwrap();
        let command: Vec<f64> = signal.command_m.iter().map(|m| 1e3 * m).collect();
        let mut random = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(3);
        let at = |i: usize| command[i.saturating_sub(5)];
        let displacement = (0..command.len()).map(|i| {
            let noise: f64 = StandardNormal.sample(&mut random);
            of(at(i), (at(i + 1) - at(i)) * 1e3) + noise_mm * noise
        });
        Recording {
            name: "made".into(),
            time_s: (0..command.len()).map(|i| 1e-3 * i as f64).collect(),
            displacement_mm: Some(displacement.collect()),
            command_mm: Some(command.clone()),
            ..Recording::default()
        }
    }

    const SHAPES: [SignalShape; 2] = [SignalShape::Chirp, SignalShape::OddMultisine];

    #[test]
    fn a_late_actuator_has_gain_and_phase_of_its_delay() {
        for shape in SHAPES {
            let found = frequency_response(&played(shape, 1e-3, |x, _| 0.98 * x)).unwrap();
            let sure: Vec<_> = found
                .lines
                .iter()
                .filter(|l| l.coherence > 0.99 && l.hz > 0.5 && l.hz < 7.0)
                .collect();
            assert!(sure.len() > 10, "{shape:?}: {} lines", sure.len());
            for line in sure {
                assert!((line.gain - 0.98).abs() < 0.01, "{shape:?} {line:?}");
                let phase_deg = -360.0 * line.hz * 5e-3;
                assert!(
                    (line.phase_deg - phase_deg).abs() < 1.0,
                    "{shape:?} {line:?}"
                );
            }
        }
    }

    #[test]
    fn a_one_sided_law_distorts_evenly_friction_oddly_and_a_linear_rig_not_at_all() {
        for shape in SHAPES {
            let orders = |of: &dyn Fn(f64, f64) -> f64| {
                let record = played(shape, 2e-3, of);
                let found = frequency_response(&record).unwrap().distortion.unwrap();
                let [even, odd, noise, linear] = found.overall_mm();
                let [times_even, times_odd] = found.over_noise();
                assert_eq!(
                    even > 5.0 * noise,
                    times_even > 3.0,
                    "{shape:?}: {times_even}"
                );
                assert_eq!(odd > 5.0 * noise, times_odd > 3.0, "{shape:?}: {times_odd}");
                [even, odd, noise, linear]
            };
            let [even, odd, noise, linear] = orders(&|x, _| x);
            assert!(linear > 0.1, "{shape:?}: {linear}");
            assert!(
                even < 2.0 * noise && odd < 2.0 * noise,
                "{shape:?}: {even} {odd} {noise}"
            );
            let [even, odd, noise, _] = orders(&|x, _| x + 0.02 * x * x);
            assert!(
                even > 5.0 * noise && even > 4.0 * odd,
                "{shape:?}: {even} {odd} {noise}"
            );
            let [even, odd, noise, _] = orders(&|x, v| x - 0.1 * (v / 0.5).tanh());
            assert!(
                odd > 5.0 * noise && odd > 4.0 * even,
                "{shape:?}: {even} {odd} {noise}"
            );
        }
    }

    #[test]
    fn noise_as_a_command_has_a_response_and_no_distortion() {
        let mut record = played(SignalShape::Chirp, 0.0, |x, _| x);
        let mut random = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(5);
        let mut low = 0.0;
        let command: Vec<f64> = (0..40_000)
            .map(|_| {
                let white: f64 = StandardNormal.sample(&mut random);
                low += TAU * 5.0 * 1e-3 * (white - low);
                low
            })
            .collect();
        record.time_s.truncate(command.len());
        record.displacement_mm = Some(command.iter().map(|x| 2.0 * x).collect());
        record.command_mm = Some(command);
        let found = frequency_response(&record).unwrap();
        assert!(found.distortion.is_none());
        assert!(found.lines.iter().all(|l| (l.gain - 2.0).abs() < 1e-6));
    }
}
