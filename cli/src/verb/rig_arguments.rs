//! Where a test runs.

use crate::board::emulated::{self, Emulated, EmulatedRig};
use crate::board::limits::PlannedMotion;
use crate::board::{
    BoardBench, BoardConnection, Connection, Operator, PistonsAt, Port, Serial, Timeouts,
    Trajectory, calibrate, commission, identify,
};
use crate::improve::TestSite;
use crate::terminal::interrupt;
use experiment::Experiment;
use experiment::bench;
use experiment::bench::Played;
use experiment::compensation::Compensation;
use experiment::failure::Failure;
use experiment::files::signal::SignalPoints;
use experiment::files::test::TestFile;
use experiment::judged::JudgedRun;
use experiment::trace::{Response, TestObserver};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// On the simulated rig, on a board, or on an emulated one.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct RigArguments {
    /// Run on the board at this serial port instead of the simulated rig
    #[arg(long, value_name = "DEV", conflicts_with = "emulated")]
    port: Option<String>,
    /// Run on an emulated board: the image as it is flashed, with the simulated rig behind its converters. Builds both
    /// the first time, some minutes
    #[arg(long)]
    emulated: bool,
    /// Do not ask for confirmation between the approach and the start of a test on a board
    #[arg(long, requires = "port")]
    yes: bool,
    /// Where the pistons stand on their scales, mm, one for each actuator with commas between them, or none where none hangs on
    /// the board; compared with what the board reads before it is armed, once. Needed with --yes where the test states no
    /// `limits.disagree_m`
    #[arg(long, value_name = "MM", requires = "yes", allow_hyphen_values = true)]
    piston_at: Option<PistonsAt>,
    /// The board has been armed with that.
    #[arg(skip)]
    piston_said: Arc<AtomicBool>,
    /// An emulated board goes by the wall clock.
    #[arg(skip)]
    real_time: bool,
}

/// An actuator that was moved alone.
pub struct MovedActuator {
    /// Which, from 0.
    pub actuator: usize,
    /// How many are moved, one after the other.
    pub of: usize,
    /// What it left.
    pub played: Played,
}

/// The kind of rig that a test ran on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RigKind {
    /// The simulated rig, in this process.
    Simulated,
    /// An emulated board, with the simulated rig behind its converters.
    Emulated,
    /// A board.
    Board,
}

/// A board and who is asked before it moves.
pub type ConnectedBoard = (BoardConnection, Operator);

impl RigArguments {
    /// What kind of rig it is.
    pub fn kind(&self) -> RigKind {
        match (&self.port, self.emulated) {
            (Some(_), _) => RigKind::Board,
            (None, true) => RigKind::Emulated,
            (None, false) => RigKind::Simulated,
        }
    }
}

impl RigArguments {
    /// On an emulated board.
    pub fn emulated() -> Self {
        Self {
            emulated: true,
            ..Self::default()
        }
    }

    /// The serial port, where the test runs on a board.
    ///
    /// # Errors
    /// A port that cannot be opened.
    pub fn serial(&self) -> Result<Option<Box<dyn Port>>, Failure> {
        let Some(device) = &self.port else {
            return Ok(None);
        };
        Ok(Some(Box::new(Serial::open(device)?)))
    }

    /// Who is asked before something moves.
    ///
    /// # Errors
    /// Nobody at the keyboard.
    pub fn operator(&self) -> Result<Operator, Failure> {
        if self.port.is_none() {
            return Ok(Operator::not_asked());
        }
        if self.yes {
            return Ok(Operator::script(
                self.piston_at.clone(),
                Arc::clone(&self.piston_said),
            ));
        }
        Operator::at_keyboard()
    }

    /// The same where somebody watches: an emulated board goes no faster than a board would.
    #[must_use]
    pub fn watched(&self, somebody: bool) -> Self {
        Self {
            real_time: somebody,
            ..self.clone()
        }
    }

    /// A connection to the board, and who is asked before it moves; `None` for the simulated rig.
    ///
    /// # Errors
    /// A port that cannot be opened; a test that the image cannot run; nobody at the keyboard.
    pub fn connect(
        &self,
        test: &TestFile,
        plan: &PlannedMotion,
        seed: u64,
    ) -> Result<Option<ConnectedBoard>, Failure> {
        let operator = self.operator()?;
        if let Some(port) = self.serial()? {
            interrupt::watch_before_arming();
            return Ok(Some((Connection::new(port, Timeouts::BOARD), operator)));
        }
        if !self.emulated {
            return Ok(None);
        }
        emulated::can_run(test)?;
        interrupt::watch_before_arming();
        let limits = plan.without_board(&test.config.limits);
        let laboratory = EmulatedRig::of(test, seed)
            .sized_for(&limits, plan)
            .in_real_time(self.real_time);
        let port: Box<dyn Port> = Box::new(Emulated::start(&laboratory)?);
        let mut connection = Connection::new(port, Timeouts::BOARD);
        calibrate(&mut connection, laboratory.calibration)?;
        Ok(Some((connection, operator)))
    }

    /// Moves actuators of a board by `trajectory` under the limits of `test`: the one that is wanted, from 0, or each in its
    /// turn. `keep` is given what each has left, and says whether the next one moves.
    ///
    /// # Errors
    /// A trajectory beyond a limit that the test states; a board that cannot be set up; what `keep` says.
    pub fn commission(
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

    /// Moves the first actuator by `trajectory` under the limits of `test`.
    ///
    /// # Errors
    /// A trajectory beyond a limit that the test states; a rig or board that cannot be set up.
    pub fn play_trajectory(
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
}

impl TestSite for RigArguments {
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

    fn play(&self, test: &TestFile, signal: &SignalPoints, seed: u64) -> Result<Played, Failure> {
        let trajectory = Trajectory::Points(signal.clone());
        self.play_trajectory(test, &trajectory, seed, &mut ())
    }
}
