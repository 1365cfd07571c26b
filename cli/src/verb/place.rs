//! Where a test runs.

use crate::board::emulated::{Emulated, Laboratory};
use crate::board::{BoardBench, Connection, Patience, Port, Serial, calibrate};
use crate::experiment::{Experiment, Run};
use crate::failure::Failure;
use crate::story::Site;
use crate::trace::{Response, Witness};
use outerloop_core::Method;

/// On the simulated rig, on a board, or on an emulated one.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Place {
    /// Run on the board at this serial port instead of the simulated rig
    #[arg(long, value_name = "DEV", conflicts_with = "emulated")]
    port: Option<String>,
    /// Run on an emulated board: the image as it is flashed, with the simulated rig behind its converters
    #[arg(long)]
    emulated: bool,
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
        let connection = if let Some(device) = &self.port {
            let port: Box<dyn Port> = Box::new(Serial::open(device)?);
            Connection::new(port, Patience::BOARD)
        } else if self.emulated {
            let laboratory = Laboratory::of(&experiment.test, seed).sized_for(ideal);
            let port: Box<dyn Port> = Box::new(Emulated::start(&laboratory)?);
            let mut connection = Connection::new(port, Patience::EMULATED);
            calibrate(&mut connection, laboratory.calibration)?;
            connection
        } else {
            return experiment.run(method, ideal, seed, keep, tell);
        };
        experiment.run_on(&BoardBench::new(connection), method, ideal, keep, tell)
    }
}
