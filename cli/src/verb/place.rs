//! Where a test runs.

use crate::board::emulated::{self, Emulated, Laboratory};
use crate::board::limits::Plan;
use crate::board::{BoardBench, Connection, Operator, Patience, Port, Serial, calibrate};
use crate::experiment::{Experiment, Run};
use crate::failure::Failure;
use crate::story::Site;
use crate::trace::{Response, Witness};
use outerloop_core::Method;
use serde::{Deserialize, Serialize};

/// On the simulated rig, on a board, or on an emulated one.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Place {
    /// Run on the board at this serial port instead of the simulated rig
    #[arg(long, value_name = "DEV", conflicts_with = "emulated")]
    port: Option<String>,
    /// Run on an emulated board: the image as it is flashed, with the simulated rig behind its converters. Builds both
    /// the first time, some minutes
    #[arg(long)]
    emulated: bool,
    /// Ask nobody between the approach and the start of a test on a board
    #[arg(long, requires = "port")]
    yes: bool,
}

/// The kind of rig that a test ran on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Where {
    /// The simulated rig, in this process.
    Simulated,
    /// An emulated board, with the simulated rig behind its converters.
    Emulated,
    /// A board.
    Board,
}

impl Place {
    /// A simulated or emulated rig; of a board the port is not known.
    pub fn at(place: Where) -> Self {
        Self {
            emulated: place == Where::Emulated,
            ..Self::default()
        }
    }

    /// What kind of rig it is.
    pub fn kind(&self) -> Where {
        match (&self.port, self.emulated) {
            (Some(_), _) => Where::Board,
            (None, true) => Where::Emulated,
            (None, false) => Where::Simulated,
        }
    }
}

impl Site for Place {
    fn run(
        &self,
        experiment: &Experiment,
        method: Method,
        ideal: &Response,
        seed: u64,
        keep: bool,
        tell: impl Witness,
    ) -> Result<Run, Failure> {
        let plan = Plan::of(experiment, ideal);
        let (connection, operator) = if let Some(device) = &self.port {
            let operator = if self.yes {
                Operator::nobody()
            } else {
                Operator::person()?
            };
            let port: Box<dyn Port> = Box::new(Serial::open(device)?);
            (Connection::new(port, Patience::BOARD), operator)
        } else if self.emulated {
            let config = &experiment.test.config;
            emulated::can_run(&experiment.test)?;
            let limits = plan.without_board(&config.limits);
            let laboratory = Laboratory::of(&experiment.test, seed).sized_for(&limits, &plan);
            let port: Box<dyn Port> = Box::new(Emulated::start(&laboratory)?);
            let mut connection = Connection::new(port, Patience::EMULATED);
            calibrate(&mut connection, laboratory.calibration)?;
            (connection, Operator::nobody())
        } else {
            return experiment.run(method, ideal, seed, keep, tell);
        };
        let bench = BoardBench::new(connection, plan, operator)
            .expecting(experiment.test.board.calibration.clone())
            .with_bits(experiment.test.board.converter_bits);
        experiment.run_on(&bench, method, ideal, keep, tell)
    }
}
