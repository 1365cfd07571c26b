//! `outerloop board commission`: each actuator alone, one after the other.

use crate::board::Trajectory;
use crate::document::{Document, table};
use crate::scope::Scoped;
use crate::serve::shear_frame;
use crate::site::{MovedActuator, TestSite};
use crate::verb::rig_arguments::RigArguments;
use crate::wording::digits;
use clap::Args;
use diagnosis::Identified;
use experiment::failure::Failure;
use experiment::files::signal::SignalPoints;
use experiment::files::test::TestFile;
use experiment::files::{look_ahead, output};
use experiment::rig::declared::configured_times;
use link::command::SignalShape;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Move an actuator by a signal and record it; several actuators move one after the other, while the rest stand still
#[derive(Args, Debug)]
#[command(group(clap::ArgGroup::new("place").args(["port", "emulated"]).required(true)))]
pub(super) struct Commission {
    /// The test file, whose limits apply
    test: PathBuf,
    #[command(flatten)]
    place: RigArguments,
    /// The actuator to move, from 1; left out: each actuator of the board in turn
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=link::MAX_ACTUATORS as i64))]
    actuator: Option<u8>,
    /// Seed of everything random in the simulated rig (--emulated)
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Shape of the signal: constant, sine or chirp; or a file with time_s and command_mm, such as `diagnose --next` writes,
    /// to which the next four options do not apply
    #[arg(long, value_name = "SHAPE|FILE", default_value = "chirp")]
    signal: Wanted,
    /// Largest displacement, mm
    #[arg(long, value_name = "MM", default_value_t = 5.0)]
    amplitude_mm: f32,
    /// Length, s, including half a second of rise and of fall
    #[arg(long, value_name = "S", default_value_t = 30.0)]
    seconds: f32,
    /// Frequency of the sine, or at the start of the chirp, Hz
    #[arg(long, value_name = "HZ", default_value_t = 0.1)]
    from_hz: f32,
    /// Frequency at the end of the chirp, Hz
    #[arg(long, value_name = "HZ", default_value_t = 10.0)]
    to_hz: f32,
    /// The record, a CSV file for `outerloop identify`; if each of several actuators is moved, NAME-1.csv and so on, and the
    /// results in NAME-actuators.toml
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    scope: Scoped,
}

/// A shape that the board generates, or a file.
#[derive(Clone, Debug)]
enum Wanted {
    Constant,
    Sine,
    Chirp,
    File(PathBuf),
}

impl FromStr for Wanted {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        Ok(match text {
            "constant" => Self::Constant,
            "sine" => Self::Sine,
            "chirp" => Self::Chirp,
            file if Path::new(file).exists() => Self::File(file.into()),
            other => {
                return Err(format!(
                    "`{other}` is no shape and no file: accepted are constant, sine, chirp, and a file with time_s and \
                     command_mm"
                ));
            }
        })
    }
}

impl Commission {
    fn trajectory(&self) -> Result<Trajectory, Failure> {
        let shape = match &self.signal {
            Wanted::File(path) => return SignalPoints::load(path).map(Trajectory::Points),
            Wanted::Constant => SignalShape::Constant,
            Wanted::Sine => SignalShape::Sine {
                frequency_hz: self.from_hz,
            },
            Wanted::Chirp => SignalShape::Chirp {
                from_hz: self.from_hz,
                to_hz: self.to_hz,
            },
        };
        Ok(Trajectory::Formula(link::command::CommissioningSignal {
            actuator: 0,
            shape,
            amplitude_m: self.amplitude_mm / 1e3,
            seconds: self.seconds,
        }))
    }

    /// Moves the actuators and writes the recordings.
    ///
    /// # Errors
    /// A signal or a test that is refused; a board that is silent, refuses, trips or is wrongly wired; a file that cannot
    /// be written.
    pub(super) fn run(&self) -> Result<(), Failure> {
        look_ahead::new_record(&self.out)?;
        // For several actuators.
        for actuator in 0..link::MAX_ACTUATORS {
            look_ahead::new_record(&self.numbered(actuator))?;
        }
        let test = TestFile::load(&self.test, &[])?;
        let trajectory = self.trajectory()?;
        let place = self.place.watched(self.scope.is_wanted());
        let title = match &self.signal {
            Wanted::File(path) => format!("{} under {}", path.display(), self.test.display()),
            shape => format!("{shape:?} under {}", self.test.display()),
        };
        let rate_hz = test.config.timing.rate_hz;
        let mut scope = self.scope.open(&title, rate_hz, false)?;
        let wanted = self.actuator.map(|n| usize::from(n) - 1);
        let mut found = Vec::new();
        let played = place.commission(&test, &trajectory, wanted, self.seed, &mut scope, |turn| {
            found.push(self.keep(&turn)?);
            // With several actuators each recording is written at once: the next one may trip.
            if turn.of > 1 {
                let text = toml::to_string(&Actuators { actuator: &found })
                    .map_err(|e| Failure::test(format!("what was found cannot be written: {e}")))?;
                let file = self.sibling_file("-actuators.toml");
                match found.len() {
                    1 => output::write(&file, &text)?,
                    // The file that this run itself has just written.
                    _ => output::write_back(&file, &text)?,
                }
            }
            wrong(&turn)
        });
        if found.len() > 1 {
            let mut d = of_actuators(&found, &test.config.structure.stiffness_n_per_m);
            let file = self.sibling_file("-actuators.toml");
            d.say(format!("What was found is in {}.", file.display()));
            println!("{}", d.terminal());
        }
        played
    }

    /// A file next to the recording.
    fn sibling_file(&self, ending: &str) -> PathBuf {
        let stem = self.out.file_stem().unwrap_or_default().to_string_lossy();
        self.out.with_file_name(format!("{stem}{ending}"))
    }

    /// The recording of one of several actuators, numbered from 0.
    fn numbered(&self, actuator: usize) -> PathBuf {
        let ending = self.out.extension().unwrap_or_default().to_string_lossy();
        self.sibling_file(&format!("-{}.{ending}", actuator + 1))
    }

    /// Writes a recording and identifies its actuator.
    fn keep(&self, turn: &MovedActuator) -> Result<FoundActuator, Failure> {
        let number = turn.actuator + 1;
        let file = match turn.of {
            1 => self.out.clone(),
            _ => self.numbered(turn.actuator),
        };
        output::write(&file, &turn.played.text)?;
        println!("{} steps are in {}.", turn.played.steps, file.display());
        // A constant and a sine are not informative enough.
        let tells = !matches!(self.signal, Wanted::Constant | Wanted::Sine);
        let identified = if tells && turn.of > 1 && turn.played.early.is_none() {
            diagnosis::identify(&turn.played.recording()?).ok()
        } else {
            None
        };
        let stiffness = turn.played.stiffness_n_per_m.iter();
        Ok(FoundActuator {
            number,
            file,
            identified,
            stiffness_n_per_m: stiffness.map(|k| k.unwrap_or(0.0)).collect(),
        })
    }
}

/// The reason not to go on to the next actuator.
fn wrong(turn: &MovedActuator) -> Result<(), Failure> {
    let suspicion = turn.played.suspicion.as_deref();
    match (&turn.played.early, suspicion) {
        (None, None) => Ok(()),
        (None, Some(wiring)) => Err(Failure::test(format!(
            "{wiring}; the recording is kept: accepted is a rig wired as docs/wiring.md says, before anything else moves"
        ))),
        (Some(why), wiring) => Err(Failure::test(format!(
            "the signal ended early: {why}; what was received is kept{}",
            wiring.map_or(String::new(), |wiring| format!("; {wiring}"))
        ))),
    }
}

/// What was identified of an actuator.
#[derive(Serialize)]
struct FoundActuator {
    /// From 1.
    number: usize,
    /// Its recording.
    file: PathBuf,
    /// Force on each actuator over the displacement of this one, N/m; 0 where no force responded.
    stiffness_n_per_m: Vec<f64>,
    #[serde(flatten)]
    identified: Option<Identified>,
}

/// The file of all actuators.
#[derive(Serialize)]
struct Actuators<'a> {
    actuator: &'a [FoundActuator],
}

/// A table, with the declared stiffness of the storeys.
fn of_actuators(found: &[FoundActuator], storeys_n_per_m: &[f64]) -> Document {
    let names = ["actuator", "gain", "delay, ms", "lag, ms", "offset, mm"].map(str::to_owned);
    let forces = (1..=found.len()).map(|j| format!("force {j}, kN/mm"));
    let head: Vec<String> = names.into_iter().chain(forces).collect();
    let mut table = table(&head.iter().map(String::as_str).collect::<Vec<_>>());
    let frame = shear_frame(&storeys_n_per_m[..found.len().min(storeys_n_per_m.len())]);
    for each in found {
        let known = each.identified.as_ref();
        let parameters = known.map(|i| [i.gain, i.delay_ms, i.lag_ms, i.offset_mm].map(digits));
        let forces = each.stiffness_n_per_m.iter().enumerate().map(|(j, k)| {
            let declared = frame.get(j * found.len() + each.number - 1);
            let declared = declared.copied().unwrap_or(0.0);
            format!("{} ({})", digits(k * 1e-6), digits(declared * 1e-6))
        });
        let row = std::iter::once(each.number.to_string())
            .chain(parameters.unwrap_or_default())
            .chain(forces);
        table.add_row(row.collect::<Vec<_>>());
    }
    let mut d = Document::new("What the actuators are", "", false);
    d.table(table);
    d.say("Forces are over the displacement of the actuator that moved; in brackets what the test file declares.");
    if let Some(lines) = for_the_test_file(found) {
        d.say(lines);
    }
    d
}

/// The lines for the test file with these actuators' times; `None` if one of them was not identified.
fn for_the_test_file(found: &[FoundActuator]) -> Option<String> {
    let each: Option<Vec<_>> = found.iter().map(|f| f.identified.as_ref()).collect();
    let each: Vec<_> = each?
        .into_iter()
        .map(|i| configured_times([i.delay_ms, i.lag_ms]))
        .collect();
    let lines = each
        .first()?
        .iter()
        .enumerate()
        .map(|(k, (table, key, _))| {
            // A thousandth of a millisecond is finer than any rig.
            let list: Vec<String> = each.iter().map(|own| format!("{:.3}", own[k].2)).collect();
            format!("{table}.{key} = [{}]", list.join(", "))
        });
    let lines: Vec<String> = lines.collect();
    Some(format!("For the test file:\n{}", lines.join("\n")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(number: usize, times: Option<[f64; 2]>) -> FoundActuator {
        let identified = times.map(|[delay_ms, lag_ms]| Identified {
            gain: 1.0,
            gain_ci90: [1.0; 2],
            delay_ms,
            delay_ms_ci90: [delay_ms; 2],
            lag_ms,
            lag_ms_ci90: [lag_ms; 2],
            offset_mm: 0.0,
            offset_mm_ci90: [0.0; 2],
            nrmse: 0.0,
        });
        FoundActuator {
            number,
            file: PathBuf::new(),
            identified,
            stiffness_n_per_m: vec![],
        }
    }

    #[test]
    fn what_was_found_is_said_as_the_test_file_says_it() {
        let two = [found(1, Some([4.0, 1.5])), found(2, Some([6.25, 0.0]))];
        assert_eq!(
            for_the_test_file(&two).unwrap(),
            "For the test file:\ncompensation.delay_ms = [5.500, 6.250]\nestimation.delay_ms = [4.000, 6.250]\n\
             estimation.lag_ms = [1.500, 0.050]"
        );
        assert_eq!(for_the_test_file(&[found(1, None)]), None);
    }
}
