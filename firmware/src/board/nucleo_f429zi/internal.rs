//! The chip's own converters of 12 bits, and how they hang on the timers.

use super::converters::{Converters, Resources, StartedConverters};
use super::further_adc::{FurtherAdc, injected_by_tim2};
use super::period::Period;
use cortex_m::peripheral::DWT;
use embassy_stm32::adc::{Adc, AdcChannel, Exten, InjectedAdc, SampleTime};
use embassy_stm32::gpio::Flex;
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::pac;
use embassy_stm32::peripherals::{ADC1, DAC1, PA3, PA4, PC0};
use embassy_stm32::rcc;
use embassy_stm32::triggers::TIM2_TRGO;
use embassy_stm32::{Peri, interrupt};
use link::telemetry::MAX_INPUTS;
use link::{CodeRange, Input};

/// The codes of this board: sensors are two conversions of 12 bits, added; ranks displacement, force, force, displacement
/// have the same mean instant, so each channel's code is the sum of its pair.
pub const CODES: CodeRange = CodeRange {
    sensor_top: 2 * 4095,
    sensor_rail: 8,
    sensor_spare: 600,
    command_top: 4095,
    command_spare: 300,
};

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
        interrupt::ADC.unpend();
        codes
    }

    /// The converter is on, and TIM2's update starts its four conversions.
    pub fn is_set_up(&self) -> bool {
        injected_by_tim2(pac::ADC1, 4)
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
pub struct DacOutput;

impl DacOutput {
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

    /// The channel is on and waits for TIM4.
    pub fn is_set_up(&self) -> bool {
        let cr = pac::DAC1.cr().read();
        cr.en(0) && cr.ten(0) && cr.tsel(0) == DAC_TRIGGER_TIM4
    }

    /// The code that the pin shows from TIM4's next pulse on.
    #[inline]
    pub fn write(&self, code: u16) {
        pac::DAC1.dhr12r(0).write(|w| w.set_dhr(code));
    }
}

/// The chip's own converters.
pub struct Internal {
    sensors: Sensors,
    command: DacOutput,
    further_adc: FurtherAdc,
}

impl Converters for Internal {
    const NAME: &'static str = "NUCLEO-F429ZI";
    const CODES: CodeRange = CODES;
    const INPUTS: &'static [Input] = &[
        Input::CommandReadBack(0),
        Input::SecondDisplacement,
        Input::HeadAcceleration,
    ];
    // A hundredth of the range: offset, gain and linearity of both converters.
    const READ_BACK_OFF: u16 = 41;
    const INPUT_SPAN_V: [f32; 2] = [0.0, 3.3];
    const OUTPUT_DELAY_US: u32 = 40;
    // The four conversions take 13 us of it.
    const BEGINS_US: u32 = 15;
    // 13 of conversions, and room for the entry.
    const LATEST_BEGIN_US: u32 = 20;
    // Some 110 instructions and two divisions, from a flash that is not in the cache.
    const AROUND_STEP_CYCLES: u32 = 400;

    fn new(
        r: Resources,
        ticks: u32,
        standing: impl Fn(usize, u16) -> u16,
    ) -> StartedConverters<Self> {
        let mut sensors = Sensors::new(r.adc1, r.pa3, r.pc0);
        // Of a converter that does not answer: the first step will find its samples stale.
        let first = sensors.first().unwrap_or([CODES.sensor_top / 2; 2]);
        // SAFETY: the DAC drives the pin and ADC2 looks at it; both want it analogue and nothing else.
        let command_pin = unsafe { r.pa4.clone_unchecked() };
        let command = DacOutput::new(r.dac1, r.pa4, standing(0, first[0]));
        let inputs = [
            command_pin.degrade_adc(),
            r.pc3.degrade_adc(),
            r.pc2.degrade_adc(),
        ];
        let further_adc = FurtherAdc::new(r.adc2, inputs);
        let period = Period::new(r.tim2, r.tim4, ticks, Self::OUTPUT_DELAY_US);
        let mut converters = Self {
            sensors,
            command,
            further_adc,
        };
        let answered = converters.is_set_up();
        StartedConverters {
            converters,
            period,
            first: [first],
            answered,
        }
    }

    unsafe fn enable_interrupt() {
        // No conversion has been asked for: one that stands here is none of the timer's.
        pac::ADC1.sr().modify(|w| w.set_jeoc(false));
        interrupt::ADC.unpend();
        interrupt::ADC.set_priority(Priority::P0);
        // SAFETY: by the caller.
        unsafe { interrupt::ADC.enable() };
    }

    #[inline]
    fn codes(&mut self) -> Option<[[u16; 2]; 1]> {
        self.sensors.codes().map(|codes| [codes])
    }

    #[inline]
    fn inputs(&self) -> [u16; MAX_INPUTS] {
        // Codes of the command, and of sensors, which are of two conversions.
        let [command, displacement, acceleration] = self.further_adc.codes();
        [command, 2 * displacement, 2 * acceleration, 0, 0]
    }

    fn is_set_up(&mut self) -> bool {
        self.sensors.is_set_up() && self.command.is_set_up() && self.further_adc.is_set_up()
    }

    #[inline]
    fn write(&mut self, _: usize, code: u16) {
        self.command.write(code);
    }
}
