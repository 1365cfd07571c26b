//! The rig's part of a period: the actuators' commands, their motion, and the sensors' readings.

use super::Laboratory;
use crate::chain::{self, Converters, Shown};
use crate::log::InjectedFault;
use crate::nucleo::Nucleo;
use link::MAX_ACTUATORS;
use rigless::session::Session;

/// A rig that sinks comes to rest at this fraction of its stroke.
const SUNK_SHARE: f64 = 0.6;

impl Laboratory {
    /// One step of the rig, which moves only on a closed contact; returns the codes of its sensors. A floating pin commands
    /// the worst: the lower end of the stroke.
    pub(super) fn step_rig(
        &mut self,
        session: &mut Session<Nucleo>,
        at_ns: u64,
        period_ns: u64,
    ) -> Shown {
        let actuators = self.chain.converters().actuators();
        let closed = self.permission.closed(at_ns, period_ns);
        let dead = self.active == Some(InjectedFault::DeadValve);
        let victim = self.victim;
        let moves = |actuator: usize| closed && !(dead && actuator == victim);
        let period_s = period_ns as f64 * 1e-9;
        let codes = self.chain.converters().widths();
        let mut pins = [None; MAX_ACTUATORS];
        for (actuator, pin) in pins.iter_mut().enumerate().take(actuators) {
            *pin = self.chain.pin(session, &self.registers, actuator);
            let (wired, stands_at_m) = (&self.wired[actuator], &mut self.stands_at_m[actuator]);
            let fault = self.active.filter(|_| actuator == self.victim);
            let told_m = chain::command_m(wired, pin.unwrap_or(0));
            let told_m = self.servos[actuator].follow(told_m, fault);
            let told_m = match fault {
                Some(InjectedFault::Runaway { up }) => {
                    chain::command_m(wired, if up { codes.command_top } else { 0 })
                }
                _ => told_m,
            };
            let spool_m = &mut self.spool_m[actuator];
            if moves(actuator) {
                let most_m = self.valve_m_per_s * period_s;
                *spool_m += (told_m - *spool_m).clamp(-most_m, most_m);
                *stands_at_m = *spool_m;
            } else {
                let lowest_m = SUNK_SHARE * chain::command_m(wired, 0);
                let sunk_m = *stands_at_m - self.sinks_m_per_s * period_s;
                *stands_at_m = sunk_m.max(lowest_m.min(*stands_at_m));
                *spool_m = *stands_at_m;
            }
        }
        if self.four_wires {
            return self.wired_shown(pins);
        }
        let reading = self.rig.step(&self.stands_at_m[..actuators], closed);
        let followed = self.rig.goes_where_it_is_sent();
        let mut shown = Shown::default();
        for (actuator, wired) in self.wired.iter().enumerate().take(actuators) {
            let [at_m, n] = reading[actuator];
            if followed && moves(actuator) {
                self.stands_at_m[actuator] = at_m;
            }
            shown.displacement[actuator] = chain::sensor_code(wired.displacement, at_m);
            shown.force[actuator] = chain::sensor_code(wired.force, n);
        }
        shown.second_displacement = shown.displacement[0];
        let ([[at_m, _], ..], [last_m, before_m]) = (reading, self.was_at_m);
        shown.acceleration_m_per_s2 = (at_m - 2.0 * last_m + before_m) / (period_s * period_s);
        self.was_at_m = [at_m, last_m];
        self.keep(pins, at_m);
        shown
    }

    /// Each output is wired to the displacement and the force of its actuator; with external converters for one actuator, also to
    /// the second displacement. Two resistors hold an output that is off in the middle.
    fn wired_shown(&mut self, pins: [Option<u16>; MAX_ACTUATORS]) -> Shown {
        let codes = self.chain.converters().widths();
        let [sensor_top, command_top] = [codes.sensor_top, codes.command_top].map(f64::from);
        let volts = pins.map(|pin| pin.map_or(0.5, |code| f64::from(code) / command_top));
        let read = volts.map(|share| share * sensor_top);
        let at_m = chain::command_m(&self.wired[0], pins[0].unwrap_or(codes.command_top / 2));
        self.keep(pins, at_m);
        let mut shown = Shown {
            displacement: read,
            force: read,
            ..Shown::default()
        };
        if self.chain.converters() == Converters::External {
            shown.second_displacement = read[0];
        }
        shown
    }

    fn keep(&self, [pin, other_pins @ ..]: [Option<u16>; MAX_ACTUATORS], at_m: f64) {
        let mut log = self.log_mut();
        log.pin.push(pin);
        log.other_pins.push(other_pins);
        log.position_m.push(at_m);
        log.permitted.push(self.permission.level());
    }
}
