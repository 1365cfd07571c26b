//! What the control interrupt requires of the converters of an image: the chip's own ([`internal`](super::internal)), or
//! external ones of 16 bits for one actuator ([`nucleo_f429zi_16`](crate::board::nucleo_f429zi_16)) or for three
//! ([`nucleo_f429zi_3`](crate::board::nucleo_f429zi_3)).

use super::period::Period;
use embassy_stm32::Peri;
use embassy_stm32::peripherals::{
    ADC1, ADC2, DAC1, PA3, PA4, PA5, PA6, PB10, PB11, PC0, PC2, PC3, PC10, PC11, PC12, PD2, PD12,
    PD14, PF12, SPI1, SPI3, TIM2, TIM4,
};
use link::telemetry::MAX_INPUTS;
use link::{CodeRange, Input};

/// Two inputs and an output for each of `A` actuators around one sampling timer.
pub trait Converters<const A: usize = 1>: Sized {
    /// The board's name with these converters.
    const NAME: &'static str;
    /// Widths of their codes.
    const CODES: CodeRange;
    /// What is recorded beside displacement and force.
    const INPUTS: &'static [Input];
    /// By how much a command read back may be off, in codes of the command.
    const READ_BACK_OFF: u16;
    /// Volts at the ends of their codes.
    const INPUT_SPAN_V: [f32; 2];
    /// From the sampling trigger to the instant at which the output takes the command over, us.
    const OUTPUT_DELAY_US: u32;
    /// From the sampling trigger to the beginning of the step, at most, us.
    const BEGINS_US: u32;
    /// Where the timer stands at the latest when a step begins, us: a step that begins later than this was held up.
    const LATEST_BEGIN_US: u32;
    /// Cycles that reading the sample and writing the command take beside the step, with the board's own work around it.
    const AROUND_STEP_CYCLES: u32;

    /// Ready, with a period of `ticks` and the timer standing. Each output stands at the code that `standing` gives for its
    /// actuator and that one's first displacement.
    fn new(
        resources: Resources,
        ticks: u32,
        standing: impl Fn(usize, u16) -> u16,
    ) -> StartedConverters<Self, A>;

    /// Switches the control interrupt on, with the highest priority.
    ///
    /// # Safety
    /// What its handler uses has been put in place.
    unsafe fn enable_interrupt();

    /// The sample of this step, displacement and force of each actuator; `None` if there is none.
    fn codes(&mut self) -> Option<[[u16; 2]; A]>;

    /// The further inputs of that sample.
    fn inputs(&self) -> [u16; MAX_INPUTS];

    /// The converters' own registers, read now, hold what the start has put there: an external chip that lost its supply,
    /// and a peripheral that was reset with another one, do not.
    fn is_set_up(&mut self) -> bool;

    /// The code that an actuator's output shows from its next instant on.
    fn write(&mut self, actuator: usize, code: u16);
}

/// Converters that have just been set up.
pub struct StartedConverters<C, const A: usize = 1> {
    /// The converters.
    pub converters: C,
    /// The control period, which does not run yet.
    pub period: Period,
    /// Codes of a first sample.
    pub first: [[u16; 2]; A],
    /// All that can answer has answered.
    pub answered: bool,
}

/// What the chip has for converters; each kind takes what it needs.
#[expect(missing_docs, reason = "named after the chip's own parts")]
pub struct Resources {
    pub adc1: Peri<'static, ADC1>,
    pub adc2: Peri<'static, ADC2>,
    pub dac1: Peri<'static, DAC1>,
    pub spi1: Peri<'static, SPI1>,
    pub spi3: Peri<'static, SPI3>,
    pub tim2: Peri<'static, TIM2>,
    pub tim4: Peri<'static, TIM4>,
    pub pa3: Peri<'static, PA3>,
    pub pa4: Peri<'static, PA4>,
    pub pa5: Peri<'static, PA5>,
    pub pa6: Peri<'static, PA6>,
    pub pb10: Peri<'static, PB10>,
    pub pb11: Peri<'static, PB11>,
    pub pc0: Peri<'static, PC0>,
    pub pc2: Peri<'static, PC2>,
    pub pc3: Peri<'static, PC3>,
    pub pc10: Peri<'static, PC10>,
    pub pc11: Peri<'static, PC11>,
    pub pc12: Peri<'static, PC12>,
    pub pd2: Peri<'static, PD2>,
    pub pd12: Peri<'static, PD12>,
    pub pd14: Peri<'static, PD14>,
    pub pf12: Peri<'static, PF12>,
}
