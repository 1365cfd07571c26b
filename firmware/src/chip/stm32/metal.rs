//! The control interrupt's access to the chip.

use super::converters::Converters;
use super::{drill, drill::Drill};
use super::{fatal, kept};
use crate::chip::this::debug;
use crate::chip::this::period::Period;
use crate::hardware::Hardware;
use crate::station::Heartbeat;
use cortex_m::peripheral::{DCB, DWT};
use embassy_stm32::gpio::{Flex, Input as Pin, Output};
use embassy_stm32::peripherals::IWDG;
use embassy_stm32::wdg::IndependentWatchdog;
use link::status::{CrashCause, CrashReport};
use link::telemetry::MAX_INPUTS;
use link::{CodeRange, Input};
use outerloop_core::Mode;

/// Time from the last feeding to the watchdog's reset, us; its clock, and so this time, is good to a factor of two.
pub const WATCHDOG_US: u32 = 25_000;

/// Starts the cycle counter. Must be called once, before the clocks are checked.
pub fn start_cycle_counter(core: &mut cortex_m::Peripherals) {
    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();
}

/// TRCENA of DEMCR, needed by the cycle counter.
const TRACE: u32 = 1 << 24;

/// Faults take their way out and the watchdog counts, even if a debugger has set the core to halt at faults: it may be
/// gone, and PERMIT would stay. A debugger's settings survive every reset but power-on.
#[inline]
pub fn no_fault_halts_the_core() {
    // SAFETY: it only takes away events that a debugger asked for, and nothing from the program.
    unsafe { (*DCB::PTR).demcr.write(TRACE) };
    debug::watchdog_goes_on();
}

/// The processor's cycle count.
#[inline]
pub fn cycles() -> u32 {
    DWT::cycle_count()
}

/// The pins of the control interrupt besides those of the converters.
pub struct Pins {
    /// The PERMIT line, an output that is read back.
    pub permit: Flex<'static>,
    /// Toggles in every step with PERMIT, for a relay that drops when the pulses stop.
    pub pulse: Output<'static>,
    /// The contact of the device driven by PERMIT.
    pub chain: Pin<'static>,
    /// High while the hold button is pressed.
    pub button: Pin<'static>,
    /// The emergency stop's contact.
    pub stop: Pin<'static>,
    /// High while the step runs.
    pub step: Output<'static>,
}

/// The control interrupt's part of the board.
pub struct Metal<C> {
    converters: C,
    period: Period,
    pins: Pins,
    watchdog: IndependentWatchdog<'static, IWDG>,
    /// PERMIT as requested in the last step, and whether it has been given since the start.
    asked: bool,
    given: bool,
    /// True if PERMIT's port takes what is written to it, and PERMIT fell when requested.
    permit_follows: bool,
    /// True if the reason for not feeding the watchdog has been kept.
    told: bool,
}

impl<C> Metal<C> {
    /// Before the first step.
    pub fn new(
        converters: C,
        period: Period,
        pins: Pins,
        watchdog: IndependentWatchdog<'static, IWDG>,
    ) -> Self {
        Self {
            converters,
            period,
            pins,
            watchdog,
            asked: false,
            given: false,
            permit_follows: true,
            told: false,
        }
    }

    /// Starts the periods.
    pub fn start<const A: usize>(&mut self, leaves_late: bool)
    where
        C: Converters<A>,
    {
        self.leave_late(leaves_late);
        self.period.start();
    }

    /// Keeps the reason for not feeding the watchdog, once.
    #[cold]
    fn tell(&mut self, cause: CrashCause, tick: u32, mode: Mode, text: &str) {
        if !core::mem::replace(&mut self.told, true) {
            let text = link::reply::cut(text);
            kept::keep(&CrashReport {
                cause,
                tick,
                mode,
                text,
            });
        }
    }
}

impl<C: Converters<A>, const A: usize> Hardware<A> for Metal<C> {
    const CODES: CodeRange = C::CODES;
    const INPUTS: &'static [Input] = C::INPUTS;
    const READ_BACK_OFF: u16 = C::READ_BACK_OFF;
    const READ_BACK_LEAST: u16 = C::READ_BACK_LEAST;
    const INPUT_SPAN_V: [f32; 2] = C::INPUT_SPAN_V;

    #[inline]
    fn now(&self) -> u32 {
        cycles()
    }

    #[inline]
    fn codes(&mut self) -> Option<[[u16; 2]; A]> {
        // The last step's request has had a period to take effect. A line that stays high though it was dropped, and a
        // port that has lost its clock and reads as zeros, can be dropped only by a reset.
        let stays = self.given && !self.asked && self.pins.permit.is_high();
        self.pins.step.set_high();
        if drill::asked() == Drill::Overrun {
            drill::overrun();
        }
        let codes = self.converters.codes();
        self.permit_follows = !stays && self.pins.step.is_set_high();
        codes
    }

    #[inline]
    fn inputs(&self) -> [u16; MAX_INPUTS] {
        self.converters.inputs()
    }

    #[inline(never)]
    fn is_set_up(&mut self) -> bool {
        self.converters.is_set_up()
    }

    #[inline]
    fn began_late(&self) -> bool {
        self.period.has_passed(C::LATEST_BEGIN_US)
    }

    #[inline]
    fn output(&mut self, actuator: usize, code: u16) {
        self.converters.write(actuator, code);
        if actuator + 1 == A {
            self.pins.step.set_low();
        }
    }

    #[inline]
    fn permit(&mut self, on: bool) {
        self.asked = on;
        if on {
            no_fault_halts_the_core();
            self.given = true;
            self.pins.permit.set_high();
            self.pins.pulse.toggle();
        } else {
            self.pins.permit.set_low();
        }
    }

    #[inline]
    fn permit_chain_closed(&self) -> bool {
        self.pins.chain.is_high()
    }

    #[inline]
    fn emergency_stop(&self) -> bool {
        self.pins.stop.is_high()
    }

    #[inline]
    fn hold_pressed(&self) -> bool {
        self.pins.button.is_high()
    }

    fn set_period(&mut self, ticks: u32) {
        self.period.set(ticks);
    }

    fn leave_late(&mut self, late: bool) {
        if C::LATE_OUTPUT_DELAY_US != C::OUTPUT_DELAY_US {
            self.period.leave_after(if late {
                C::LATE_OUTPUT_DELAY_US
            } else {
                C::OUTPUT_DELAY_US
            });
        }
    }

    #[inline]
    fn feed(&mut self) {
        if !self.permit_follows {
            let (tick, mode) = (fatal::noted_tick(), kept::noted_mode());
            let text = "what PERMIT or its port shows is not what was written";
            return self.tell(CrashCause::PermitStays, tick, mode, text);
        }
        if core::mem::take(&mut self.told) {
            kept::forget();
        }
        self.watchdog.pet();
    }

    #[cold]
    fn starving(&mut self, task: Heartbeat, tick: u32, mode: Mode) {
        let text = match task {
            Heartbeat::Listen => "the task that receives commands",
            Heartbeat::Report => "the task that sends reports",
            Heartbeat::Pc => "the PC",
        };
        self.tell(CrashCause::Starved, tick, mode, text);
    }
}
