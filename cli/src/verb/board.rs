//! `outerloop board`: commands from a person to a board at a serial port.

mod calibrate;
mod commission;
mod desk;

use super::{hand_over, no_files};
use crate::answer::{of_identity, of_status};
use crate::board::{self, Connection, Serial};
use crate::document::Document;
use crate::provenance::WithProvenance;
use calibrate::Calibrate;
use clap::{Args, Subcommand};
use commission::Commission;
use desk::Desk;
pub use desk::DeskAnswer;
use experiment::failure::Failure;
use experiment::files::look_ahead;
use schemars::JsonSchema;
use serde::Serialize;
use std::path::PathBuf;

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

impl Plain {
    /// Hands over the board's reply.
    fn run<T: Serialize>(
        &self,
        ask: impl FnOnce(&mut Connection<Serial>) -> Result<(T, Document), Failure>,
    ) -> Result<(), Failure> {
        let out = look_ahead::folder(self.out.as_deref(), &["report.html", "answer.json"])?;
        let (found, document) = ask(&mut Connection::open(&self.port)?)?;
        let wanted = (out.as_deref(), self.json);
        hand_over(wanted, no_files, |_| {
            document.with_figures("answer.json", &WithProvenance::of(&found))
        })
    }
}

/// `board clear` answers with the provenance only.
#[derive(Serialize, JsonSchema)]
pub struct Cleared {}
