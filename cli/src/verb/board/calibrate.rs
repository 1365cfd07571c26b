//! `outerloop board calibrate`: the line of each channel from codes to metres and newtons.

use crate::answer::{CalibrationAnswer, Zeroed, of_calibration};
use crate::board::{self, Connection};
use crate::provenance::WithProvenance;
use crate::verb::hand_over;
use clap::Args;
use experiment::failure::Failure;
use experiment::files::look_ahead;
use link::Calibration;
use link::command::Channel;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// The files in the folder of the answer.
const FILES: [&str; 3] = ["report.html", "answer.json", "calibration.toml"];

/// Show the calibration, or replace it
#[derive(Args, Debug)]
pub(super) struct Calibrate {
    /// The board's serial port, e.g. /dev/ttyACM0
    #[arg(long, value_name = "DEV")]
    port: String,
    /// The actuator, from 1; required to change one on a board with several
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=link::MAX_ACTUATORS as i64))]
    actuator: Option<u8>,
    /// The calibration to send: a TOML file as this command prints it
    #[arg(long, value_name = "FILE")]
    file: Option<PathBuf>,
    /// Set the zero so that the present reading is this value, in m or N, e.g. displacement=0 or force=0
    #[arg(long, value_name = "CHANNEL=VALUE")]
    zero: Vec<Zero>,
    /// Keep the calibration, and the test if there is one, across power-off
    #[arg(long)]
    save: bool,
    /// Write report.html, answer.json and calibration.toml there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// One JSON object on standard output and nothing else
    #[arg(long)]
    json: bool,
}

/// A channel, and the value that its present reading is to have.
#[derive(Clone, Copy, Debug)]
struct Zero {
    channel: Channel,
    value: f32,
}

/// A channel's name on the command line and in the answer.
const fn name(channel: Channel) -> &'static str {
    match channel {
        Channel::Displacement => "displacement",
        Channel::Force => "force",
    }
}

impl FromStr for Zero {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let accepted = || {
            format!(
                "`{text}`: accepted are displacement=VALUE and force=VALUE with a value in m or N"
            )
        };
        let (named, value) = text.split_once('=').ok_or_else(accepted)?;
        let mut channels = [Channel::Displacement, Channel::Force].into_iter();
        let channel = channels.find(|channel| name(*channel) == named);
        let channel = channel.ok_or_else(accepted)?;
        let value: f32 = value.parse().map_err(|_| accepted())?;
        value
            .is_finite()
            .then_some(Self { channel, value })
            .ok_or_else(accepted)
    }
}

impl Calibrate {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let out = look_ahead::folder(self.out.as_deref(), &FILES)?;
        let found = self.found()?;
        if let Some(said) = found.not_kept {
            eprintln!("outerloop: note: {said}");
        }
        let file = toml::to_string(&found.calibration)
            .map_err(|e| Failure::test(format!("the calibration cannot be shown: {e}")))?;
        let files = || Ok(vec![(FILES[2], file.as_str())]);
        hand_over((out.as_deref(), self.json), files, |_| {
            of_calibration(&found, &file).with_figures(FILES[1], &WithProvenance::of(&found))
        })
    }

    /// Changes what is to be changed, and asks the board what it goes by then.
    fn found(&self) -> Result<CalibrationAnswer, Failure> {
        let sent = self.file.as_deref().map(read_calibration).transpose()?;
        let board = &mut Connection::open(&self.port)?;
        let actuators = board::identify(board)?.actuators();
        let number = self.number(actuators)?;
        let index = number - 1;
        if let Some(calibration) = sent {
            board::calibrate_one(board, index, calibration)?;
        }
        let mut zeroed = Vec::new();
        for &Zero { channel, value } in &self.zero {
            let (code, spread) = board::zero(board, index, channel, value)?;
            zeroed.push(Zeroed {
                channel: name(channel),
                code,
                spread,
                value,
            });
        }
        if self.save {
            board::save(board)?;
        }
        let identity = board::identify(board)?;
        let calibration = identity.calibrations().nth(usize::from(index));
        Ok(CalibrationAnswer {
            actuator: number,
            actuators,
            number: format!("{:08x}", identity.calibration_number()),
            codes: identity.codes,
            calibration: *calibration
                .ok_or_else(|| Failure::test("another board answers than before"))?,
            zeroed,
            not_kept: self.not_kept(),
        })
    }
}

impl Calibrate {
    /// The chosen actuator, from 1, of a board with this many.
    fn number(&self, actuators: usize) -> Result<u8, Failure> {
        match self.actuator {
            Some(number) if usize::from(number) > actuators => Err(Failure::input(format!(
                "--actuator {number}: the board has {actuators}: accepted are 1 to {actuators}"
            ))),
            None if actuators > 1 && self.changes() => Err(Failure::input(format!(
                "--actuator is missing: the board has {actuators}, and one is to be changed: accepted are 1 to {actuators}"
            ))),
            asked => Ok(asked.unwrap_or(1)),
        }
    }

    fn changes(&self) -> bool {
        self.file.is_some() || !self.zero.is_empty()
    }

    /// A note for a person whose calibration would be lost at the next reset.
    fn not_kept(&self) -> Option<&'static str> {
        (self.changes() && !self.save).then_some(
            "the board goes by this until its next reset, and then by what was saved before: --save keeps it, and \
             board.calibration = \"NUMBER\" in a test refuses any other",
        )
    }
}

fn read_calibration(path: &Path) -> Result<Calibration, Failure> {
    look_ahead::refuse_output(path)?;
    let text = std::fs::read_to_string(path).map_err(|e| {
        Failure::input(format!(
            "{}: cannot be read ({e}): accepted is a calibration as `outerloop board calibrate` shows it",
            path.display()
        ))
    })?;
    toml::from_str(&text).map_err(|e| {
        Failure::input(format!(
            "{}: {}: accepted is a calibration as `outerloop board calibrate` shows it",
            path.display(),
            e.message()
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn calibrate(zero: &[&str], file: bool) -> Calibrate {
        Calibrate {
            port: String::new(),
            actuator: None,
            file: file.then(PathBuf::new),
            zero: zero.iter().map(|z| z.parse().unwrap()).collect(),
            save: false,
            out: None,
            json: false,
        }
    }

    #[test]
    fn of_a_board_with_several_actuators_the_one_that_is_changed_is_said() {
        assert_eq!(calibrate(&["force=0"], false).number(1).ok(), Some(1));
        assert_eq!(calibrate(&[], false).number(3).ok(), Some(1));
        for calibrate in [calibrate(&["force=0"], false), calibrate(&[], true)] {
            let refused = calibrate.number(3).unwrap_err().to_string();
            assert!(refused.contains("accepted are 1 to 3"), "{refused}");
        }
    }

    #[test]
    fn a_calibration_that_the_next_reset_takes_back_is_said_to_be_one() {
        let said = |zero: &[&str], file: bool, save| {
            let calibrate = Calibrate {
                save,
                ..calibrate(zero, file)
            };
            calibrate.not_kept().is_some()
        };
        assert!(said(&["force=0"], false, false) && said(&[], true, false));
        assert!(!said(&[], false, false) && !said(&["force=0"], true, true));
    }
}
