//! The timers for external converters: CONVST, BUSY and the control interrupt on TIM2, LDAC on TIM4.

use super::clocks::CORE_HZ;
use super::period::TICKS_PER_US;
use embassy_stm32::gpio::{AfType, Flex, OutputType, Pull, Speed};
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::pac::timer::vals::{CcmrInputCcs, Ocm};
use embassy_stm32::peripherals::{PB10, PB11, PD12};
use embassy_stm32::{Peri, interrupt, pac};

/// Two microseconds, in cycles: longer than an output converter needs between any two edges, and after a reset.
pub const WAIT: u32 = CORE_HZ / 500_000;

/// TIM2's alternate function on PB10 and PB11.
const AF_TIM2: u8 = 1;

/// TIM4's alternate function on PD12.
const AF_TIM4: u8 = 2;

/// The step begins this many microseconds after its trigger.
pub const INTERRUPT_US: u32 = 6;

/// Its latest start, us.
pub const LATEST_BEGIN_US: u32 = 12;

/// Duration of the CONVST pulse, us: more than the required 25 ns.
const CONVST_US: u32 = 2;

// Channels of TIM2, counted from 0.
const INTERRUPT: usize = 0;
const CONVST: usize = 2;
const BUSY: usize = 3;

/// Hands the pins over to the timers; a code waiting in the output converter is loaded by hand first.
pub fn take_pins(ldac: LoadPin, line: ConversionPins) {
    channels();
    ldac.give_pin_to_timer();
    line.give_pin_to_timer();
}

/// Sets up the timers' channels.
fn channels() {
    let tim2 = pac::TIM2;
    tim2.ccr(INTERRUPT).write_value(INTERRUPT_US * TICKS_PER_US);
    tim2.ccr(CONVST).write_value(CONVST_US * TICKS_PER_US);
    // High from the update until its compare.
    tim2.ccmr_output(1)
        .modify(|w| w.set_ocm(CONVST - 2, Ocm::PWM_MODE1));
    tim2.ccmr_input(1)
        .modify(|w| w.set_ccs(BUSY - 2, CcmrInputCcs::TI4));
    tim2.ccer().modify(|w| {
        w.set_cce(CONVST, true);
        w.set_cce(BUSY, true);
        // The falling edge.
        w.set_ccp(BUSY, true);
    });
    tim2.dier().modify(|w| w.set_ccie(INTERRUPT, true));
    // TIM4's channel 1 is high from its compare on; LDAC falls there.
    pac::TIM4.ccer().modify(|w| {
        w.set_cce(0, true);
        w.set_ccp(0, true);
    });
}

/// Enables the control interrupt, with the highest priority.
///
/// # Safety
/// Everything its handler uses must be in place.
pub unsafe fn enable_interrupt() {
    pac::TIM2.sr().write(|_| ());
    interrupt::TIM2.unpend();
    interrupt::TIM2.set_priority(Priority::P0);
    // SAFETY: by the caller.
    unsafe { interrupt::TIM2.enable() };
}

/// True if BUSY has fallen since the last query, and before the step could begin: a later fall belongs to the previous
/// conversion, whose frame was read too early.
#[inline]
pub fn conversion_has_ended() -> bool {
    let ended = pac::TIM2.sr().read().ccif(BUSY);
    pac::TIM2.sr().write(|_| ());
    ended && pac::TIM2.ccr(BUSY).read() < INTERRUPT_US * TICKS_PER_US
}

/// LDAC before it is handed to the timer.
pub struct LoadPin(Flex<'static>);

impl LoadPin {
    /// High: nothing is loaded.
    pub fn new(load: Peri<'static, PD12>) -> Self {
        let mut load = Flex::new(load);
        load.set_high();
        load.set_as_output(Speed::VeryHigh);
        Self(load)
    }

    /// Loads a waiting code, then hands the line to the timer.
    fn give_pin_to_timer(mut self) {
        cortex_m::asm::delay(WAIT);
        self.0.set_low();
        cortex_m::asm::delay(WAIT);
        self.0.set_high();
        let timed = AfType::output(OutputType::PushPull, Speed::VeryHigh);
        self.0.set_as_af_unchecked(AF_TIM4, timed);
        core::mem::forget(self.0);
    }
}

/// CONVST and BUSY before they are handed to the timer.
pub struct ConversionPins {
    convst: Flex<'static>,
    busy: Flex<'static>,
}

impl ConversionPins {
    /// CONVST low.
    pub fn new(convst: Peri<'static, PB10>, busy: Peri<'static, PB11>) -> Self {
        let (mut convst, mut busy) = (Flex::new(convst), Flex::new(busy));
        convst.set_low();
        convst.set_as_output(Speed::VeryHigh);
        // A missing converter always reads as busy.
        busy.set_as_input(Pull::Up);
        Self { convst, busy }
    }

    /// Sets CONVST by hand.
    pub fn set_convst(&mut self, high: bool) {
        if high {
            self.convst.set_high();
        } else {
            self.convst.set_low();
        }
    }

    /// True while BUSY is high.
    pub fn is_busy(&self) -> bool {
        self.busy.is_high()
    }

    /// Hands them to the timer.
    fn give_pin_to_timer(mut self) {
        let convst = AfType::output(OutputType::PushPull, Speed::VeryHigh);
        self.convst.set_as_af_unchecked(AF_TIM2, convst);
        self.busy
            .set_as_af_unchecked(AF_TIM2, AfType::input(Pull::Up));
        core::mem::forget((self.convst, self.busy));
    }
}
