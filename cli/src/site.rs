//! Where a test runs: on the simulated rig, on a board, or on an emulated one.

use crate::board::limits::PlannedMotion;
use crate::board::{BoardBench, BoardConnection, Operator, Trajectory, commission, identify};
use crate::scope::Scope;
use crate::serve::{Mover, serve_on_board, simulated};
use experiment::Experiment;
use experiment::bench::{self, Played};
use experiment::compensation::Compensation;
use experiment::failure::Failure;
use experiment::files::test::TestFile;
use experiment::judged::JudgedRun;
use experiment::trace::{Response, TestObserver};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The kind of rig that a test ran on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum RigKind {
    /// The simulated rig, in this process.
    Simulated,
    /// An emulated board, with the simulated rig behind its converters.
    Emulated,
    /// A board.
    Board,
}

/// An actuator that was moved alone.
pub struct MovedActuator {
    /// Its index, from 0.
    pub actuator: usize,
    /// How many are moved, one after the other.
    pub of: usize,
    /// Its record.
    pub played: Played,
}

/// A board, and the operator who is asked before it moves.
pub type ConnectedBoard = (BoardConnection, Operator);

/// Where tests run, one after the other; defined by the connection to its board.
pub trait TestSite {
    /// What kind of rig it is.
    fn kind(&self) -> RigKind;

    /// A connection to the board, and the operator who is asked before it moves; `None` for the simulated rig.
    ///
    /// # Errors
    /// A port that cannot be opened; a test that the image cannot run; nobody at the keyboard.
    fn connect(
        &self,
        test: &TestFile,
        plan: &PlannedMotion,
        seed: u64,
    ) -> Result<Option<ConnectedBoard>, Failure>;

    /// Runs a test; see [`Experiment::run`].
    ///
    /// # Errors
    /// Those of the test; a rig or board that cannot be reached.
    fn run(
        &self,
        experiment: &Experiment,
        compensation: impl Into<Compensation>,
        ideal: &Response,
        seed: u64,
        keep: bool,
        observer: impl TestObserver,
    ) -> Result<JudgedRun, Failure> {
        let plan = PlannedMotion::of(experiment, ideal);
        let Some((connection, operator)) = self.connect(&experiment.test, &plan, seed)? else {
            return experiment.run(compensation, ideal, seed, keep, observer);
        };
        let bench = BoardBench::new(connection, plan, operator)
            .expecting(experiment.test.board.calibration.clone())
            .with_bits(experiment.test.board.converter_bits);
        experiment.run_on(&bench, compensation, ideal, keep, observer)
    }

    /// Moves the first actuator by `trajectory` under the limits of `test`.
    ///
    /// # Errors
    /// A trajectory beyond a limit of the test; a rig or board that cannot be set up.
    fn play(
        &self,
        test: &TestFile,
        trajectory: &Trajectory,
        seed: u64,
        observer: &mut dyn TestObserver,
    ) -> Result<Played, Failure> {
        trajectory.check(&test.config)?;
        let plan = PlannedMotion::of_trajectory(test, trajectory, 0);
        match (self.connect(test, &plan, seed)?, trajectory) {
            (Some((mut board, operator)), _) => {
                commission(&mut board, test, (trajectory, 0), &operator, observer)
            }
            (None, Trajectory::Points(signal)) => {
                let limits = plan.without_board(&test.config.limits);
                bench::play(test, limits, signal, seed, observer)
            }
            (None, Trajectory::Formula(_)) => Err(Failure::input(
                "the simulated rig makes no signals by itself: accepted is a file with time_s and command_mm",
            )),
        }
    }

    /// Moves actuators of a board by `trajectory` under the limits of `test`: `wanted`, from 0, or each in turn. `keep`
    /// is given each result; if it fails, the next actuator does not move.
    ///
    /// # Errors
    /// A trajectory beyond a limit of the test; a board that cannot be set up; an error of `keep`.
    fn commission(
        &self,
        test: &TestFile,
        trajectory: &Trajectory,
        wanted: Option<usize>,
        seed: u64,
        observer: &mut dyn TestObserver,
        mut keep: impl FnMut(MovedActuator) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        trajectory.check(&test.config)?;
        let storeys = test.config.physical_storeys();
        let plans =
            (0..storeys).map(|actuator| PlannedMotion::of_trajectory(test, trajectory, actuator));
        let widest = plans.max_by(|a, b| a.force_n.total_cmp(&b.force_n));
        let plan = widest.unwrap_or_else(|| PlannedMotion::of_trajectory(test, trajectory, 0));
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
            let played = commission(
                &mut board,
                test,
                (trajectory, actuator),
                &operator,
                observer,
            )?;
            keep(MovedActuator {
                actuator,
                of,
                played,
            })?;
        }
        Ok(())
    }

    /// Serves the rig to an external model; `keep`: every step is kept.
    ///
    /// # Errors
    /// A parameter that is refused; a test that the board cannot serve.
    fn serve(
        &self,
        test: &TestFile,
        seed: u64,
        keep: bool,
        scope: Option<Scope>,
    ) -> Result<Box<dyn Mover>, Failure> {
        match self.connect(test, &PlannedMotion::of_served(test), seed)? {
            None => simulated(test, seed, keep, scope),
            Some((connection, operator)) => {
                let real = self.kind() == RigKind::Board;
                serve_on_board(test, connection, operator, real, keep, scope)
            }
        }
    }
}
