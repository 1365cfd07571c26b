//! The chip's 12-bit converters, with injected conversions started by the sampling timer's update: ADC1 for
//! displacement and force, ADC2 for additionally recorded channels.

use cortex_m::peripheral::DWT;
use embassy_stm32::adc::{Adc, AdcChannel, AnyAdcChannel, Exten, InjectedAdc, SampleTime};
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::peripherals::{ADC1, ADC2};
use embassy_stm32::triggers::TIM2_TRGO;
use embassy_stm32::{Peri, PeripheralType, interrupt, pac, rcc};

/// The sum of two 12-bit conversions.
pub const TOP: u16 = 2 * 4095;

/// Cycles allowed for a first set of four conversions: 13 us, with a large margin.
const FIRST_SAMPLE_CYCLES: u32 = 100_000;

/// Displacement and force.
pub struct Sensors(InjectedAdc<'static, ADC1, 4>);

impl Sensors {
    /// Ready for TIM2, which does not run yet.
    pub fn new<D: PeripheralType, F: PeripheralType>(
        adc: Peri<'static, ADC1>,
        displacement: Peri<'static, D>,
        force: Peri<'static, F>,
    ) -> Self
    where
        Peri<'static, D>: AdcChannel<ADC1>,
        Peri<'static, F>: AdcChannel<ADC1>,
    {
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

    /// A sample on request, before the timer runs. `None`: the converter does not answer.
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

    /// Enables its interrupt, with the highest priority.
    ///
    /// # Safety
    /// Everything its handler uses must be in place.
    pub unsafe fn enable_interrupt() {
        // No conversion has been requested: a flag set here does not come from the timer.
        pac::ADC1.sr().modify(|w| w.set_jeoc(false));
        interrupt::ADC.unpend();
        interrupt::ADC.set_priority(Priority::P0);
        // SAFETY: by the caller.
        unsafe { interrupt::ADC.enable() };
    }

    /// True if the converter is on, and TIM2's update starts its four conversions.
    pub fn is_set_up(&self) -> bool {
        injected_by_tim2(pac::ADC1, 4)
    }

    /// The sample just converted; `None` if there is none.
    #[inline]
    pub fn codes(&mut self) -> Option<[u16; 2]> {
        let fresh = pac::ADC1.sr().read().jeoc();
        let [d1, f1, f2, d2] = self.0.read_injected_samples();
        fresh.then_some([d1 + d2, f1 + f2])
    }
}

/// Inputs of the further converter.
pub const FURTHER: usize = 3;

/// True if the converter is on, and TIM2's update starts this many injected conversions. The chip's three converters
/// share one reset bit: setting up one may reset another.
fn injected_by_tim2(adc: pac::adc::Adc, conversions: u32) -> bool {
    const ON: u32 = 1;
    // JEXTSEL 3, TIM2_TRGO, and JEXTEN 1, its rising edge.
    const STARTED: u32 = 3 << 16 | 1 << 20;
    const MASK: u32 = ON | 0xf << 16 | 3 << 20;
    let ranks = adc.jsqr().read().0 >> 20 & 3;
    adc.cr2().read().0 & MASK == ON | STARTED && ranks + 1 == conversions
}

/// The further converter, ADC2: recorded channels outside the control path, converted with the sample.
pub struct FurtherAdc(());

impl FurtherAdc {
    /// Ready for TIM2, which does not run yet. The inputs are converted in their order.
    pub fn new(adc: Peri<'static, ADC2>, inputs: [AnyAdcChannel<'static, ADC2>; FURTHER]) -> Self {
        // Enables the registers shared by the converters, including their clock divider, through ADC1.
        rcc::enable_and_reset::<ADC1>();
        // As slow as the sensors, so that equal sources settle: 9.7 us for all three, and nobody waits for them.
        let ranks = inputs.map(|input| (input, SampleTime::CYCLES56));
        let injected =
            Adc::new(adc).setup_injected_conversions(ranks, TIM2_TRGO, Exten::RISING_EDGE, false);
        core::mem::forget(injected);
        Self(())
    }

    /// True if the converter is on, and TIM2's update starts its conversions.
    pub fn is_set_up(&self) -> bool {
        injected_by_tim2(pac::ADC2, FURTHER as u32)
    }

    /// The codes of the latest conversions, 0 to 4095; valid from 10 us after the sample.
    #[inline]
    pub fn codes(&self) -> [u16; FURTHER] {
        core::array::from_fn(|rank| pac::ADC2.jdr(rank).read().jdata())
    }
}
