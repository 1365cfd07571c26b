//! `outerloop board`: commands from a person to a board at a serial port.

mod commission;
mod desk;

use super::{hand_over, no_files};
use crate::answer::{of_identity, of_status};
use crate::board::{self, Connection, Serial, Timeouts};
use crate::document::Document;
use crate::provenance::WithProvenance;
use clap::{Args, Subcommand};
use commission::Commission;
use desk::Desk;
pub use desk::DeskAnswer;
use experiment::failure::Failure;
use experiment::files::look_ahead;
use link::Calibration;
use link::command::Channel;
use schemars::JsonSchema;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Send commands to a board at a serial port
#[derive(Args, Debug)]
pub struct Board {
    #[command(subcommand)]
    order: Order,
}

#[derive(Subcommand, Debug)]
enum Order {
    /// Show what the board is: firmware, clocks, limits
    Identify(Plain),
    /// Show its state, readings, times and the reason of a trip or a crash
    Status(Plain),
    Calibrate(Calibrate),
    Commission(Commission),
    Desk(Desk),
    /// Return to idle after a test or a fault
    Clear(Plain),
}

impl Board {
    /// Carries out the command.
    ///
    /// # Errors
    /// A port that cannot be opened; a board that is silent, of another version, or refuses.
    pub fn run(&self) -> Result<(), Failure> {
        match &self.order {
            Order::Identify(order) => order.run(|board| {
                let identity = board::identify(board)?;
                let document = of_identity(&identity);
                Ok((identity, document))
            }),
            Order::Status(order) => order.run(|board| {
                let identity = board::identify(board)?;
                let status = board::status(board)?;
                let document = of_status(&identity, &status);
                Ok((status, document))
            }),
            Order::Calibrate(order) => order.run(),
            Order::Commission(order) => order.run(),
            Order::Desk(order) => order.run(),
            Order::Clear(order) => order.run(|board| {
                board::clear(board)?;
                let mut document = Document::new("A board was cleared", "", true);
                document.say("The board is idle.");
                Ok((Cleared {}, document))
            }),
        }
    }
}

/// An order that needs nothing but the board
#[derive(Args, Debug)]
struct Plain {
    /// The board's serial port, e.g. /dev/ttyACM0
    #[arg(long, value_name = "DEV")]
    port: String,
    /// Write report.html and answer.json there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// One JSON object on standard output and nothing else
    #[arg(long)]
    json: bool,
}

fn connect(device: &str) -> Result<Connection<Serial>, Failure> {
    Ok(Connection::new(Serial::open(device)?, Timeouts::BOARD))
}

impl Plain {
    /// Hands over the board's reply.
    fn run<T: Serialize>(
        &self,
        ask: impl FnOnce(&mut Connection<Serial>) -> Result<(T, Document), Failure>,
    ) -> Result<(), Failure> {
        let out = look_ahead::folder(self.out.as_deref(), &["report.html", "answer.json"])?;
        let (found, document) = ask(&mut connect(&self.port)?)?;
        let wanted = (out.as_deref(), self.json);
        hand_over(wanted, no_files, |_| {
            document.with_figures("answer.json", &WithProvenance::of(&found))
        })
    }
}

/// `board clear` answers with the provenance only.
#[derive(Serialize, JsonSchema)]
pub struct Cleared {}

/// Show the calibration, or replace it
#[derive(Args, Debug)]
struct Calibrate {
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
}

/// A channel, and the value that its present reading is to have.
#[derive(Clone, Copy, Debug)]
struct Zero {
    channel: Channel,
    value: f32,
}

impl FromStr for Zero {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let accepted = || {
            format!(
                "`{text}`: accepted are displacement=VALUE and force=VALUE with a value in m or N"
            )
        };
        let (channel, value) = text.split_once('=').ok_or_else(accepted)?;
        let channel = match channel {
            "displacement" => Channel::Displacement,
            "force" => Channel::Force,
            _ => return Err(accepted()),
        };
        let value: f32 = value.parse().map_err(|_| accepted())?;
        value
            .is_finite()
            .then_some(Self { channel, value })
            .ok_or_else(accepted)
    }
}

impl Calibrate {
    fn run(&self) -> Result<(), Failure> {
        let board = &mut connect(&self.port)?;
        let actuators = board::identify(board)?.actuators();
        let number = self.number(actuators)?;
        let actuator = number - 1;
        if let Some(path) = &self.file {
            board::calibrate_one(board, actuator, read_calibration(path)?)?;
        }
        for zero in &self.zero {
            let (code, spread) = board::zero(board, actuator, zero.channel, zero.value)?;
            println!(
                "# {:?}: code {code:.1} with a spread of {spread} is {} now",
                zero.channel, zero.value
            );
        }
        if self.save {
            board::save(board)?;
        }
        if let Some(said) = self.not_kept() {
            eprintln!("outerloop: note: {said}");
        }
        let identity = board::identify(board)?;
        let calibration = identity.calibrations().nth(usize::from(actuator));
        let text = toml::to_string(&calibration)
            .map_err(|e| Failure::test(format!("the calibration cannot be shown: {e}")))?;
        if actuators > 1 {
            println!("# actuator {number} of {actuators}; the number is of all of them");
        }
        println!(
            "# number {:08x}; quantity = per_code * (code - zero_code), in m and N; the sensors' codes are 0 to {}, the command's 0 to {}",
            identity.calibration_number(),
            identity.codes.sensor_top,
            identity.codes.command_top
        );
        print!("{text}");
        Ok(())
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
