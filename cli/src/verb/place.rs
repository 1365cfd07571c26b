//! Where a test runs.

use crate::bench;
use crate::board::emulated::{self, Emulated, Laboratory};
use crate::board::limits::Plan;
use crate::board::{
    BoardBench, BoardConnection, Connection, Course, Operator, Patience, Played, Port, Serial,
    calibrate, commission, identify,
};
use crate::experiment::Experiment;
use crate::failure::Failure;
use crate::files::signal::Signal;
use crate::files::test::TestFile;
use crate::judged::Run;
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

/// An actuator that was moved alone.
pub struct Turn {
    /// Which, from 0.
    pub actuator: usize,
    /// How many are moved, one after the other.
    pub of: usize,
    /// What it left.
    pub played: Played,
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

/// A board and who is asked before it moves.
pub type Board = (BoardConnection, Operator);

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

impl Place {
    /// On the board at a port, else on an emulated one.
    pub fn on_board(port: Option<String>, yes: bool) -> Self {
        Self {
            emulated: port.is_none(),
            port,
            yes,
        }
    }

    /// A connection to the board, and who is asked before it moves; `None` for the simulated rig.
    ///
    /// # Errors
    /// A port that cannot be opened; a test that the image cannot run; nobody at the keyboard.
    pub fn connect(
        &self,
        test: &TestFile,
        plan: &Plan,
        seed: u64,
    ) -> Result<Option<Board>, Failure> {
        if let Some(device) = &self.port {
            let operator = if self.yes {
                Operator::nobody()
            } else {
                Operator::person()?
            };
            let port: Box<dyn Port> = Box::new(Serial::open(device)?);
            return Ok(Some((Connection::new(port, Patience::BOARD), operator)));
        }
        if !self.emulated {
            return Ok(None);
        }
        emulated::can_run(test)?;
        let limits = plan.without_board(&test.config.limits);
        let laboratory = Laboratory::of(test, seed).sized_for(&limits, plan);
        let port: Box<dyn Port> = Box::new(Emulated::start(&laboratory)?);
        let mut connection = Connection::new(port, Patience::EMULATED);
        calibrate(&mut connection, laboratory.calibration)?;
        Ok(Some((connection, Operator::nobody())))
    }

    /// Moves actuators of a board by `course` under the limits of `test`: the one that is wanted, from 0, or each in its
    /// turn. `keep` is given what each has left, and says whether the next one moves.
    ///
    /// # Errors
    /// A course beyond a limit that the test states; a board that cannot be set up; what `keep` says.
    pub fn commission(
        &self,
        test: &TestFile,
        course: &Course,
        wanted: Option<usize>,
        seed: u64,
        witness: &mut impl Witness,
        mut keep: impl FnMut(Turn) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        course.check(&test.config)?;
        let storeys = test.config.physical_storeys();
        let plans = (0..storeys).map(|actuator| Plan::of_course(test, course, actuator));
        let widest = plans.max_by(|a, b| a.force_n.total_cmp(&b.force_n));
        let plan = widest.unwrap_or_else(|| Plan::of_course(test, course, 0));
        let Some((mut board, operator)) = self.connect(test, &plan, seed)? else {
            return Err(Failure::input(
                "the simulated rig makes no signals by itself: accepted is a board",
            ));
        };
        let all = identify(&mut board)?.actuators();
        let (turns, of) = match wanted {
            Some(actuator) => (actuator..actuator + 1, 1),
            None => (0..all, all),
        };
        for actuator in turns {
            let played = commission(&mut board, test, (course, actuator), &operator, witness)?;
            keep(Turn {
                actuator,
                of,
                played,
            })?;
        }
        Ok(())
    }

    /// Moves the first actuator by `course` under the limits of `test`.
    ///
    /// # Errors
    /// A course beyond a limit that the test states; a rig or board that cannot be set up.
    pub fn play_course(
        &self,
        test: &TestFile,
        course: &Course,
        seed: u64,
        witness: &mut impl Witness,
    ) -> Result<Played, Failure> {
        course.check(&test.config)?;
        let plan = Plan::of_course(test, course, 0);
        match (self.connect(test, &plan, seed)?, course) {
            (Some((mut board, operator)), _) => {
                commission(&mut board, test, (course, 0), &operator, witness)
            }
            (None, Course::Points(signal)) => {
                let limits = plan.without_board(&test.config.limits);
                bench::play(test, limits, signal, seed, witness)
            }
            (None, Course::Formula(_)) => Err(Failure::input(
                "the simulated rig makes no signals by itself: accepted is a file with time_s and command_mm",
            )),
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
        let Some((connection, operator)) = self.connect(&experiment.test, &plan, seed)? else {
            return experiment.run(method, ideal, seed, keep, tell);
        };
        let bench = BoardBench::new(connection, plan, operator)
            .expecting(experiment.test.board.calibration.clone())
            .with_bits(experiment.test.board.converter_bits);
        experiment.run_on(&bench, method, ideal, keep, tell)
    }

    fn play(&self, test: &TestFile, signal: &Signal, seed: u64) -> Result<Played, Failure> {
        let course = Course::Points(signal.clone());
        self.play_course(test, &course, seed, &mut ())
    }
}
