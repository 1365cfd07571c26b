//! A test, computed and ready to replace another.

use super::any_loop::{AnyLoop, not_coupled};
use super::heartbeats::Timeouts;
use super::sensors::SensorLimits;
use crate::step_time::StepTime;
use link::command::BoardTest;
use outerloop_core::{Config, Refusal};

/// The limits of the board's clocks.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    /// Clock of the sampling timer, Hz.
    pub timer_hz: u32,
    /// The slowest control rate, Hz; each step feeds the watchdog.
    pub slowest_rate_hz: u32,
    /// The fastest control rate, Hz; each step is reported over the link.
    pub fastest_rate_hz: u32,
    /// Longest time from the beginning of a step to its command, in stopwatch ticks.
    pub deadline_ticks: u32,
    /// The same if the commands [leave late](crate::hardware::Hardware::leave_late).
    pub late_deadline_ticks: u32,
    /// The part of them outside the outer loop's own step: sample, calibration, code.
    pub around_step_ticks: u32,
    /// Longest additional time of a step if the rig watch corrects command and reading.
    pub correction_ticks: u32,
    /// Stopwatch ticks per second.
    pub stopwatch_hz: u32,
}

/// A test.
pub struct Setup {
    /// The loop.
    pub outer: AnyLoop,
    /// The time of its steps.
    pub time: StepTime,
    /// Period of the sampling timer, in its ticks.
    pub period_ticks: u32,
    /// True if its commands leave late: a step of two coupled actuators takes three times as long as any other.
    pub leaves_late: bool,
    /// Control rate, Hz.
    pub rate_hz: f32,
    /// Integration step in model time, s.
    pub model_step_s: f64,
    /// The timeouts of the tasks and the PC at this rate.
    pub timeouts: Timeouts,
    /// The test's limits for contradicting sensors.
    pub sensors: SensorLimits,
    /// True if its energy error stops it.
    pub stops_by_energy: bool,
    /// True if this test was requested; the initial one of a board cannot be armed.
    pub configured: bool,
}

impl Setup {
    /// Computes `test` in place of this one, which stays if `test` is refused. For a deep stack: nothing large lies on
    /// it.
    ///
    /// # Errors
    /// The first parameter that is not accepted.
    pub fn replace(
        &mut self,
        test: &BoardTest,
        clock: &Clock,
        actuators: usize,
    ) -> Result<(), Refusal> {
        let config = &test.config;
        let period_ticks = period_ticks(config, clock)?;
        check_actuators(test, actuators)?;
        self.outer.replace(test)?;
        self.leaves_late = test.coupled.is_some();
        self.time = StepTime::new(self.deadline_ticks(clock));
        self.period_ticks = period_ticks;
        self.rate_hz = config.timing.rate_hz as f32;
        self.model_step_s = config.model_step_s();
        self.timeouts = Timeouts::at(config.timing.rate_hz);
        self.sensors = SensorLimits::of(test);
        self.stops_by_energy = config.limits.energy_trip.is_some();
        self.configured = true;
        Ok(())
    }

    /// Longest time from the beginning of a step to its command, in ticks.
    pub(super) fn deadline_ticks(&self, clock: &Clock) -> u32 {
        if self.leaves_late {
            clock.late_deadline_ticks
        } else {
            clock.deadline_ticks
        }
    }

    /// The initial test of a board: it samples and reports at 2 kHz and cannot be armed.
    ///
    /// # Errors
    /// The clock does not allow 2 kHz.
    pub fn unconfigured(clock: &Clock, actuators: usize) -> Result<Self, Refusal> {
        let mut config = Config::shear_frame([1.0], [1.0], [0.02]);
        let each = |x: f64| core::iter::repeat_n(x, actuators).collect();
        let frame = &mut config.structure;
        (frame.mass_kg, frame.stiffness_n_per_m) = (each(1.0), each(1.0));
        frame.damping_ratio = each(0.02);
        let period_ticks = period_ticks(&config, clock)?;
        let timeouts = Timeouts::at(config.timing.rate_hz);
        let (rate_hz, model_step_s) = (config.timing.rate_hz as f32, config.model_step_s());
        // Not a closure: the stack would hold the loop once more.
        match AnyLoop::new(&config) {
            Ok(outer) => Ok(Self {
                outer,
                time: StepTime::new(clock.deadline_ticks),
                period_ticks,
                leaves_late: false,
                rate_hz,
                model_step_s,
                timeouts,
                sensors: SensorLimits::NONE,
                stops_by_energy: false,
                configured: false,
            }),
            Err(refusal) => Err(refusal),
        }
    }
}

/// The sampling timer's ticks per period.
fn period_ticks(config: &Config, clock: &Clock) -> Result<u32, Refusal> {
    let rate_hz = config.timing.rate_hz;
    // Whole ticks: the product must equal the timer's clock exactly, or the rate does not divide it.
    let period_ticks = (f64::from(clock.timer_hz) / rate_hz) as u32;
    let divides = f64::from(period_ticks) * rate_hz == f64::from(clock.timer_hz);
    let range = f64::from(clock.slowest_rate_hz)..=f64::from(clock.fastest_rate_hz);
    if !(divides && range.contains(&rate_hz)) {
        return Err(Refusal {
            name: "loop.rate_hz",
            value: rate_hz,
            accepted: "whole divisors of the sampling timer's clock, from 100 Hz to what the link's telemetry carries (see identify)",
        });
    }
    Ok(period_ticks)
}

/// Requires a storey for every actuator of the board: one left out of a test would move with the others' permission.
/// Only if two hold a coupler is nothing connected to the third, whose output is constant.
fn check_actuators(test: &BoardTest, actuators: usize) -> Result<(), Refusal> {
    if test.coupled.is_some() {
        return if cfg!(coupled) && actuators > 2 {
            Ok(())
        } else {
            Err(not_coupled())
        };
    }
    let physical = test.actuators();
    if physical == actuators {
        return Ok(());
    }
    Err(Refusal {
        name: "structure.physical_storeys",
        value: physical as f64,
        accepted: match actuators {
            1 => "1 on this board, which has one actuator",
            2 => "2 on this board, which has two actuators",
            _ => "3 on this board, which has three actuators",
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOCK: Clock = Clock {
        timer_hz: 84_000_000,
        slowest_rate_hz: 100,
        fastest_rate_hz: 3400,
        deadline_ticks: 5000,
        late_deadline_ticks: 5000,
        around_step_ticks: 0,
        correction_ticks: 0,
        stopwatch_hz: 168_000_000,
    };

    fn set_up(config: &Config, actuators: usize) -> Result<Setup, Refusal> {
        let mut setup = Setup::unconfigured(&CLOCK, actuators)?;
        setup.replace(&config.clone().into(), &CLOCK, actuators)?;
        Ok(setup)
    }

    fn with(change: impl FnOnce(&mut Config)) -> Result<Setup, Refusal> {
        let mut config = Config::shear_frame([1000.0], [158e3], [0.02]);
        change(&mut config);
        set_up(&config, 1)
    }

    #[test]
    fn a_rate_that_does_not_divide_the_clock_starves_the_watchdog_or_floods_the_link_is_refused() {
        assert_eq!(with(|_| ()).ok().map(|s| s.period_ticks), Some(42_000));
        assert!(with(|c| c.timing.rate_hz = 1000.0).is_ok());
        assert!(with(|c| c.timing.rate_hz = 2100.0).is_ok());
        let slow = with(|c| c.timing.rate_hz = 100.0).ok().unwrap();
        assert_eq!((slow.period_ticks, slow.timeouts.task_steps), (840_000, 10));
        for rate in [1999.0, 2000.5, 4000.0, 96.0, f64::NAN, -2000.0, 0.0] {
            let refusal = with(|c| c.timing.rate_hz = rate).err().unwrap();
            assert_eq!(refusal.name, "loop.rate_hz", "{rate}");
        }
    }

    #[test]
    fn a_board_with_three_actuators_takes_tests_with_three() {
        let mut config = Config::shear_frame([1000.0; 3], [158e3; 3], [0.02; 3]);
        assert!(set_up(&config, 3).is_ok());
        for one_or_two in [1, 2] {
            config.structure.physical_storeys = Some(one_or_two);
            let refusal = set_up(&config, 3).err().unwrap();
            assert_eq!(refusal.value, f64::from(one_or_two));
            assert!(refusal.accepted.starts_with("3 "), "{refusal}");
        }
        assert!(Setup::unconfigured(&CLOCK, 3).is_ok());
    }

    #[test]
    fn more_actuators_or_floors_than_the_board_has_are_refused() {
        let floors = |n: usize, x: f64| core::iter::repeat_n(x, n).collect();
        let frame = |c: &mut Config, n| {
            c.structure.mass_kg = floors(n, 1000.0);
            c.structure.stiffness_n_per_m = floors(n, 158e3);
            c.structure.damping_ratio = floors(n, 0.02);
        };
        assert!(with(|c| (frame(c, 3), c.structure.physical_storeys = Some(1)).0).is_ok());
        let two = with(|c| frame(c, 2)).err().unwrap();
        assert_eq!(two.name, "structure.physical_storeys");
        let four = with(|c| (frame(c, 4), c.structure.physical_storeys = Some(1)).0);
        assert_eq!(four.err().unwrap().name, "structure.mass_kg");
    }
}
