//! The timers, the converters, and how they hang on each other.

use super::clocks::TIMER_HZ;
use cortex_m::peripheral::DWT;
use embassy_stm32::adc::{Adc, AdcChannel, Exten, InjectedAdc, SampleTime};
use embassy_stm32::gpio::Flex;
use embassy_stm32::pac;
use embassy_stm32::peripherals::{ADC1, DAC1, PA3, PA4, PC0, TIM2, TIM4};
use embassy_stm32::rcc;
use embassy_stm32::timer::Channel;
use embassy_stm32::timer::low_level::{
    MasterMode, OutputCompareMode, SlaveMode, Timer, TriggerSource,
};
use embassy_stm32::triggers::TIM2_TRGO;
use embassy_stm32::{Peri, interrupt::InterruptExt};
use link::CodeRange;

/// From the start of the conversions to the instant at which the DAC takes the command over, us.
pub const OUTPUT_DELAY_US: u32 = 40;

/// The codes of this board: sensors are two conversions of 12 bits, added; ranks displacement, force, force, displacement
/// have the same mean instant, so each channel's code is the sum of its pair.
pub const CODES: CodeRange = CodeRange {
    sensor_top: 2 * 4095,
    sensor_rail: 8,
    sensor_spare: 600,
    command_top: 4095,
    command_spare: 300,
};

/// A step begins so many ticks of TIM2 behind its trigger at the latest: 13 us of conversions, and room for the entry.
const LATEST_BEGIN_TICKS: u32 = 20 * (TIMER_HZ / 1_000_000);

/// The DAC's trigger for which TIM4 stands.
const DAC_TRIGGER_TIM4: u8 = 5;

/// Cycles that a first conversion of four may take: 13 us, and much more.
const FIRST_SAMPLE_CYCLES: u32 = 100_000;

/// Displacement and force.
pub struct Sensors(InjectedAdc<'static, ADC1, 4>);

impl Sensors {
    /// Ready for TIM2, which does not run yet.
    pub fn new(
        adc: Peri<'static, ADC1>,
        displacement: Peri<'static, PA3>,
        force: Peri<'static, PC0>,
    ) -> Self {
        // SAFETY: each pin is named twice in one sequence of one converter and used by nothing else.
        let (displacement_again, force_again) =
            unsafe { (displacement.clone_unchecked(), force.clone_unchecked()) };
        // 56 cycles of 21 MHz: a source of up to 10 kOhm settles to half a code.
        let sampling = SampleTime::CYCLES56;
        // In this order both channels have the same mean instant.
        let ranks = [
            (displacement.degrade_adc(), sampling),
            (force.degrade_adc(), sampling),
            (force_again.degrade_adc(), sampling),
            (displacement_again.degrade_adc(), sampling),
        ];
        Self(Adc::new(adc).setup_injected_conversions(ranks, TIM2_TRGO, Exten::RISING_EDGE, true))
    }

    /// A sample by request, before the timer runs. `None`: the converter does not answer.
    pub fn first(&mut self) -> Option<[u16; 2]> {
        pac::ADC1.cr2().modify(|w| w.set_jswstart(true));
        let begin = DWT::cycle_count();
        while !pac::ADC1.sr().read().jeoc() {
            if DWT::cycle_count().wrapping_sub(begin) > FIRST_SAMPLE_CYCLES {
                return None;
            }
        }
        let codes = self.codes();
        embassy_stm32::interrupt::ADC.unpend();
        codes
    }

    /// The sample that has just been converted; `None` if there is none.
    #[inline]
    pub fn codes(&mut self) -> Option<[u16; 2]> {
        let fresh = pac::ADC1.sr().read().jeoc();
        let [d1, f1, f2, d2] = self.0.read_injected_samples();
        fresh.then_some([d1 + d2, f1 + f2])
    }
}

/// Channel 1 of the DAC: what is written waits for TIM4.
pub struct Command;

impl Command {
    /// Puts the pin at `code` at once, then leaves it to TIM4.
    pub fn new(_dac: Peri<'static, DAC1>, pin: Peri<'static, PA4>, code: u16) -> Self {
        rcc::enable_and_reset::<DAC1>();
        let mut pin = Flex::new(pin);
        pin.set_as_analog();
        core::mem::forget(pin);
        let dac = pac::DAC1;
        let command = Self;
        // An enabled channel shows its holding register at once as long as no trigger is on; without a code in it,
        // that would be the end of the stroke.
        command.write(code);
        dac.cr().modify(|w| w.set_tsel(0, DAC_TRIGGER_TIM4));
        dac.cr().modify(|w| w.set_en(0, true));
        command.write(code);
        dac.cr().modify(|w| w.set_ten(0, true));
        command
    }

    /// The code that the pin shows from TIM4's next pulse on.
    #[inline]
    pub fn write(&self, code: u16) {
        pac::DAC1.dhr12r(0).write(|w| w.set_dhr(code));
    }
}

/// The control period.
pub struct Period(Timer<'static, TIM2>);

impl Period {
    /// Stopped, with TIM4 behind it.
    pub fn new(tim2: Peri<'static, TIM2>, tim4: Peri<'static, TIM4>, ticks: u32) -> Self {
        let output = Timer::new(tim4);
        let delay = (OUTPUT_DELAY_US * (TIMER_HZ / 1_000_000)) as u16;
        output.set_trigger_source(TriggerSource::ITR1);
        output.set_slave_mode(SlaveMode::TRIGGER_MODE);
        output.set_output_compare_mode(Channel::Ch1, OutputCompareMode::PwmMode2);
        output.set_compare_value(Channel::Ch1, delay);
        pac::TIM4.arr().write(|w| w.set_arr(delay + delay / 8));
        output.regs_core().cr1().modify(|w| w.set_opm(true));
        output.set_master_mode(MasterMode::COMPARE_OC1);
        core::mem::forget(output);

        // Registers are written, not embassy's ways: those end in an update event, which is a trigger. Without preload the
        // period is in force at once; from then on a new one waits for the update.
        let period = Timer::new(tim2);
        pac::TIM2.arr().write_value(ticks - 1);
        period.set_autoreload_preload(true);
        period.set_master_mode(MasterMode::UPDATE);
        Self(period)
    }

    /// Lets it run: the first sample is taken one period from now.
    pub fn start(&mut self) {
        self.0.start();
    }

    /// Another period, from the end of the present one on.
    #[inline]
    pub fn set(&mut self, ticks: u32) {
        pac::TIM2.arr().write_value(ticks - 1);
    }

    /// Asked at the beginning of a step: the timer has run on further since its trigger than it can have.
    #[inline]
    pub fn step_began_late(&self) -> bool {
        pac::TIM2.cnt().read() > LATEST_BEGIN_TICKS
    }
}
