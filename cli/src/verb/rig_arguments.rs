//! Command-line arguments for where a test runs.

use crate::board::emulated::{self, Emulated, EmulatedRig};
use crate::board::limits::PlannedMotion;
use crate::board::{Connection, Operator, PistonsAt, Port, Serial, Timeouts, calibrate};
use crate::site::{ConnectedBoard, RigKind, TestSite};
use crate::terminal::interrupt;
use experiment::failure::Failure;
use experiment::files::test::TestFile;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// On the simulated rig, on a board, or on an emulated one.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct RigArguments {
    /// Run on the board at this serial port instead of the simulated rig
    #[arg(long, value_name = "DEV", conflicts_with = "emulated")]
    port: Option<String>,
    /// Run on an emulated board: the image as it is flashed, with the simulated rig behind its converters. The first time
    /// it builds image and emulator, which takes some minutes
    #[arg(long)]
    emulated: bool,
    /// Do not ask before a board is armed, nor between the approach and the start of the test
    #[arg(long, requires = "port")]
    yes: bool,
    /// Positions of the pistons on their scales, mm, from actuator 1 on, separated by commas: the board is armed, once, if it
    /// reads the same within 1 mm. `none` if no piston is connected. Needed with --yes, unless the board has one actuator and
    /// the test states `limits.disagree_m`
    #[arg(long, value_name = "MM", requires = "yes", allow_hyphen_values = true)]
    piston_at: Option<PistonsAt>,
    /// The board has been armed with that.
    #[arg(skip)]
    piston_said: Arc<AtomicBool>,
    /// An emulated board goes by the wall clock.
    #[arg(skip)]
    real_time: bool,
}

impl RigArguments {
    /// On an emulated board.
    pub fn emulated() -> Self {
        Self {
            emulated: true,
            ..Self::default()
        }
    }

    /// The serial port, if the test runs on a board.
    ///
    /// # Errors
    /// A port that cannot be opened.
    pub fn serial(&self) -> Result<Option<Box<dyn Port>>, Failure> {
        let Some(device) = &self.port else {
            return Ok(None);
        };
        Ok(Some(Box::new(Serial::open(device)?)))
    }

    /// The operator who is asked before anything moves.
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

    /// The same, watched by somebody or not: if so, an emulated board runs no faster than a real one.
    #[must_use]
    pub fn watched(&self, somebody: bool) -> Self {
        Self {
            real_time: somebody,
            ..self.clone()
        }
    }
}

impl TestSite for RigArguments {
    fn kind(&self) -> RigKind {
        match (&self.port, self.emulated) {
            (Some(_), _) => RigKind::Board,
            (None, true) => RigKind::Emulated,
            (None, false) => RigKind::Simulated,
        }
    }

    fn connect(
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
}
