//! The control period: TIM2, and TIM4 started by it, whose compare is the instant of the command.

use super::clocks::TIMER_HZ;
use embassy_stm32::Peri;
use embassy_stm32::pac;
use embassy_stm32::peripherals::{TIM2, TIM4};
use embassy_stm32::timer::Channel;
use embassy_stm32::timer::low_level::{
    MasterMode, OutputCompareMode, SlaveMode, Timer, TriggerSource,
};

/// Ticks of TIM2 and TIM4 in a microsecond.
pub const TICKS_PER_US: u32 = TIMER_HZ / 1_000_000;

/// The control period.
pub struct Period(Timer<'static, TIM2>);

impl Period {
    /// Stopped, with TIM4 after it, whose channel 1 is high from `output_delay_us` after each update, for 1/8 of that.
    pub fn new(
        tim2: Peri<'static, TIM2>,
        tim4: Peri<'static, TIM4>,
        ticks: u32,
        output_delay_us: u32,
    ) -> Self {
        let output = Timer::new(tim4);
        output.set_trigger_source(TriggerSource::ITR1);
        output.set_slave_mode(SlaveMode::TRIGGER_MODE);
        output.set_output_compare_mode(Channel::Ch1, OutputCompareMode::PwmMode2);
        leave_after(output_delay_us);
        output.regs_core().cr1().modify(|w| w.set_opm(true));
        output.set_master_mode(MasterMode::COMPARE_OC1);
        core::mem::forget(output);

        // Registers are written directly because embassy's functions end in an update event, which is a trigger.
        // Without preload the period takes effect at once; after that a new one waits for the update.
        let period = Timer::new(tim2);
        pac::TIM2.arr().write_value(ticks - 1);
        period.set_autoreload_preload(true);
        period.set_master_mode(MasterMode::UPDATE);
        Self(period)
    }

    /// Starts it: the first update is one period from now.
    pub fn start(&mut self) {
        self.0.start();
    }

    /// Sets another period, from the end of the present one on.
    #[inline]
    pub fn set(&mut self, ticks: u32) {
        pac::TIM2.arr().write_value(ticks - 1);
    }

    /// From now on the commands leave this many microseconds after each update. At the change, one command may leave a
    /// period late: only for an idle board.
    pub fn leave_after(&mut self, us: u32) {
        leave_after(us);
    }

    /// True if at least `us` microseconds of the period have passed.
    #[inline]
    pub fn has_passed(&self, us: u32) -> bool {
        pac::TIM2.cnt().read() > us * TICKS_PER_US
    }
}

/// Sets the compare of TIM4 and its end, the latter first: a pulse in progress is not left without an end.
fn leave_after(us: u32) {
    let delay = (us * TICKS_PER_US) as u16;
    pac::TIM4.arr().write(|w| w.set_arr(delay + delay / 8));
    pac::TIM4.ccr(0).write(|w| w.set_ccr(delay));
}
