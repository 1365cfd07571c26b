//! The hands of the control interrupt.

use super::kept;
use super::sampling::{Command, Period, Sensors};
use super::{drill, drill::Drill};
use crate::converters::Stopwatch;
use crate::station::{Hardware, Sign};
use cortex_m::peripheral::DWT;
use embassy_stm32::gpio::{Input, Output};
use embassy_stm32::peripherals::IWDG;
use embassy_stm32::wdg::IndependentWatchdog;
use link::status::{Cause, LastWords};
use link::{AdcCode, DacCode};
use outerloop_core::State;

/// The watchdog bites so long after it was fed last, us; its clock, and so this time, is good to a factor of two.
pub const WATCHDOG_US: u32 = 25_000;

/// The processor's cycles.
#[derive(Clone, Copy)]
pub struct Cycles;

impl Stopwatch for Cycles {
    #[inline]
    fn between(earlier: u32, later: u32) -> u32 {
        later.wrapping_sub(earlier)
    }

    #[inline]
    fn now(&self) -> u32 {
        DWT::cycle_count()
    }
}

/// What the control interrupt owns of the board.
pub struct Metal {
    /// Displacement and force.
    pub sensors: Sensors,
    /// The command to the servo valve.
    pub command: Command,
    /// The control period.
    pub period: Period,
    /// The PERMIT line.
    pub permit: Output<'static>,
    /// The emergency stop's contact.
    pub stop: Input<'static>,
    /// High while the step runs.
    pub step: Output<'static>,
    /// The watchdog.
    pub watchdog: IndependentWatchdog<'static, IWDG>,
    /// A task's starvation has been kept.
    pub starving: bool,
}

impl Hardware for Metal {
    type Watch = Cycles;

    #[inline]
    fn watch(&self) -> Cycles {
        Cycles
    }

    #[inline]
    fn codes(&mut self) -> Option<(AdcCode, AdcCode)> {
        self.step.set_high();
        if drill::asked() == Drill::Overrun {
            drill::overrun();
        }
        self.sensors.codes()
    }

    #[inline]
    fn output(&mut self, code: DacCode) {
        self.command.write(code);
        self.step.set_low();
    }

    #[inline]
    fn permit(&mut self, on: bool) {
        if on {
            self.permit.set_high();
        } else {
            self.permit.set_low();
        }
    }

    #[inline]
    fn emergency_stop(&self) -> bool {
        self.stop.is_high()
    }

    fn set_period(&mut self, ticks: u32) {
        self.period.set(ticks);
    }

    #[inline]
    fn feed(&mut self) {
        self.starving = false;
        self.watchdog.pet();
    }

    #[cold]
    fn starving(&mut self, task: Sign, tick: u32, state: State) {
        if !core::mem::replace(&mut self.starving, true) {
            kept::keep(&LastWords {
                cause: Cause::Starved,
                tick,
                state,
                text: link::reply::cut(match task {
                    Sign::Listen => "the task that hears commands",
                    Sign::Report => "the task that sends reports",
                    Sign::Heard => "the PC",
                }),
            });
        }
    }
}
