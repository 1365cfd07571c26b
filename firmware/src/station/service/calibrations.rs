//! The calibration of each actuator: shown, replaced, zeroed, kept.

use super::{CommandResult, Pending, Service};
use crate::station::order::Order;
use crate::station::settings::{Made, Wiring};
use crate::station::twice::Twice;
use link::channel::{Calibration, ChannelCalibration};
use link::command::{BoardTest, Channel};
use link::limits::CalibratedRange;
use link::reply::{Obstacle, RefusedParameter, Reply};
use outerloop_core::{Fault, Mode};

/// The copies of a calibration differ; sending a whole one, or a reset, repairs it.
const WRONG_BIT: Option<Obstacle> = Some(Obstacle::Fault(Fault::Memory));

impl Service {
    /// The range of a test's actuators, or of all on the board.
    pub(super) fn shown(&self, test: Option<&BoardTest>) -> CalibratedRange {
        let used = self.used(test).iter();
        CalibratedRange::by_all(used.map(|c| c.0.first()), &self.board.codes)
    }

    /// True if every actuator of the test in force, or else of the board, has been calibrated.
    pub(super) fn is_calibrated(&self) -> bool {
        self.used(self.test.as_ref())
            .iter()
            .all(|c| c.1 == Made::BySomebody)
    }

    /// In a test of two coupled actuators, nothing is connected to the others.
    fn used(&self, test: Option<&BoardTest>) -> &[(Twice<Calibration>, Made)] {
        let coupled = test.filter(|t| t.coupled.is_some());
        let used = coupled.and_then(|t| self.calibrations.get(..t.actuators()));
        used.unwrap_or(&self.calibrations)
    }

    pub(super) fn last_codes(&self, actuator: usize) -> [u16; 2] {
        let windows = self.windows.get(actuator);
        windows.map_or([0; 2], |[displacement, force]| {
            [displacement.last(), force.last()]
        })
    }

    pub(super) fn calibrate(
        &mut self,
        actuator: u8,
        calibration: Calibration,
        zeroed: Option<(f32, u16)>,
    ) -> CommandResult {
        if usize::from(actuator) >= self.calibrations.len() {
            return self.no_actuator(actuator);
        }
        match calibration.check(&self.board.codes) {
            Ok(()) => self.order(
                Order::Calibrate(actuator, calibration),
                Pending::Calibrate(actuator, calibration, zeroed),
            ),
            Err(refusal) => self.reply(refusal.into()),
        }
    }

    pub(super) fn no_actuator(&mut self, actuator: u8) -> CommandResult {
        self.reply(Reply::Refused(RefusedParameter::new(
            "actuator",
            f64::from(actuator) + 1.0,
            "1 to the number of the board's actuators",
        )))
    }

    pub(super) fn zero(&mut self, actuator: u8, channel: Channel, value: f32) -> CommandResult {
        let which = usize::from(actuator);
        let (Some((own, made)), Some([displacement, force])) =
            (self.calibrations.get(which), self.windows.get(which))
        else {
            return self.no_actuator(actuator);
        };
        // The unchanged lines are sent again with the new one: none may have a wrong bit.
        let Some(&(mut calibration)) = own.agreed() else {
            return self.reply(self.rejected(None, WRONG_BIT));
        };
        if *made != Made::BySomebody {
            return self.reply(self.rejected(None, Some(Obstacle::NotCalibrated)));
        }
        let window = match channel {
            Channel::Displacement => displacement,
            Channel::Force => force,
        };
        let Some((code, spread)) = window.mean_and_spread() else {
            return self.reply(Reply::Refused(RefusedParameter::new(
                "zero",
                f64::NAN,
                "a channel that has been sampled for a while",
            )));
        };
        let line: &mut ChannelCalibration = match channel {
            Channel::Displacement => &mut calibration.displacement,
            Channel::Force => &mut calibration.force,
        };
        line.zero_code = code - value / line.per_code;
        self.calibrate(actuator, calibration, Some((code, spread)))
    }

    pub(super) fn save(&mut self) -> CommandResult {
        if self.mode != Mode::Idle {
            return self.reply(self.rejected(None, None));
        }
        if self.test.is_none() && self.calibrations.iter().all(|c| c.1 == Made::ByNobody) {
            return self.reply(self.rejected(None, Some(Obstacle::NotCalibrated)));
        }
        if self.calibrations.iter().any(|c| c.0.agreed().is_none()) {
            return self.reply(self.rejected(None, WRONG_BIT));
        }
        let wiring = |(calibration, made): &(Twice<Calibration>, Made)| {
            let board = &self.board;
            let wiring = Wiring::new(*calibration.first(), &board.codes, board.actuators);
            (*made != Made::ByNobody).then_some(wiring)
        };
        let wirings = self.calibrations.iter().map(wiring).collect();
        CommandResult::Save(self.test.clone(), wirings)
    }
}
