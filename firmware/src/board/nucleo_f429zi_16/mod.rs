//! The NUCLEO-F429ZI with external converters of 16 bits: an AD7606 for the inputs, an AD5761R for the command, both -10 to
//! +10 V. All else (PERMIT, emergency stop, lamps, link) is as on the [board itself](super::nucleo_f429zi).
//!
//! # Wiring
//! | signal | pin | connector | peripheral | level |
//! |---|---|---|---|---|
//! | AD7606 CONVST A and B | PB10 | CN10-32, D36 | TIM2 channel 3 | rises at the sampling trigger; pull it down outside |
//! | AD7606 BUSY | PB11 | CN10-34, D35 | TIM2 channel 4, capture | its fall proves that a conversion has ended |
//! | AD7606 SCLK | PA5 | CN7-10, D13 | SPI1, 10.5 MHz | idles high |
//! | AD7606 DOUTA | PA6 | CN7-12, D12 | SPI1 | V1 displacement, V2 force, V3 command read back, V4 second displacement, V5 head acceleration, V6 half of 3.3 V |
//! | AD7606 CS | PD14 | CN7-16, D10 | output | low while it is read; pull it up outside |
//! | AD7606 RESET | PF12 | CN7-20, D8 | output | high for a microsecond at the start; pull it down outside |
//! | AD5761R SCLK | PC10 | CN8-6, D45 | SPI3, 10.5 MHz | idles low |
//! | AD5761R SDO | PC11 | CN8-8, D46 | SPI3 | its control register is read back at the start |
//! | AD5761R SDI | PC12 | CN8-10, D47 | SPI3 | |
//! | AD5761R SYNC | PD2 | CN8-12, D48 | output | low while it is written; pull it up outside |
//! | AD5761R LDAC | PD12 | CN10-21, D29 | TIM4 channel 1 | falls 60 us after the trigger: the command leaves; pull it up outside |
//!
//! # Timers
//! TIM2's update is the trigger and starts TIM4, as with the chip's own converters. TIM2's channel 1 begins the control
//! interrupt 6 us later: the AD7606 takes 4.15 us at most.
//!
//! # Start
//! After power-up the AD5761R's output is clamped to ground, the middle of the stroke, until its range is chosen, and comes
//! up in the middle then. When only the chip was reset it holds its voltage all the while: it is not set up again, and goes
//! from there to the measured position. PERMIT is low in both cases.

mod ad5761r;
pub(super) mod ad7606;
mod bus;
pub(super) mod output;
pub(super) mod timers;

use super::nucleo_f429zi::converters::{Converters, Resources, StartedConverters};
use super::nucleo_f429zi::period::Period;
use ad5761r::Ad5761r;
use ad7606::Ad7606;
use link::telemetry::MAX_INPUTS;
use link::{CodeRange, Input};
use output::OutputBus;
use timers::INTERRUPT_US;

/// The codes of this board, -10 V at 0 and +10 V at the top. A rail is 20 mV wide; limits leave half a volt free.
pub const CODES: CodeRange = CodeRange {
    sensor_top: u16::MAX,
    sensor_rail: 65,
    sensor_spare: 1638,
    command_top: u16::MAX,
    command_spare: 1638,
};

/// Volts at the ends of the AD7606's codes.
pub(super) const SPAN_V: [f32; 2] = [-10.0, 10.0];

/// Inputs of the AD7606 that are read.
const INPUTS: usize = 6;

/// The external converters.
pub struct External {
    adc: Ad7606,
    dac: Ad5761r,
    /// V3 to V5 of the last sample.
    further: [u16; MAX_INPUTS],
}

impl Converters for External {
    const NAME: &'static str = "NUCLEO-F429ZI 16 bits";
    const CODES: CodeRange = CODES;
    const INPUTS: &'static [Input] = &[
        Input::CommandReadBack(0),
        Input::SecondDisplacement,
        Input::HeadAcceleration,
    ];
    // Half a hundredth of the range, 100 mV: the errors of both converters are a fifth of it.
    const READ_BACK_OFF: u16 = 328;
    const INPUT_SPAN_V: [f32; 2] = SPAN_V;
    const OUTPUT_DELAY_US: u32 = 60;
    const BEGINS_US: u32 = INTERRUPT_US + 2;
    const LATEST_BEGIN_US: u32 = timers::LATEST_BEGIN_US;
    // Six words of 16 bits and three of 8 at 10.5 MHz, 13 us with their waiting loops, and what the board's own take.
    const AROUND_STEP_CYCLES: u32 = 2600;

    fn new(
        r: Resources,
        ticks: u32,
        standing: impl Fn(usize, u16) -> u16,
    ) -> StartedConverters<Self> {
        let mut adc = Ad7606::new(r.spi1, r.pa5, r.pa6, r.pd14, r.pf12);
        let (sampled, line) = adc.first(r.pb10, r.pb11);
        let first = sampled.map_or(
            [CODES.sensor_top / 2; 2],
            |[displacement, force, ..]: [u16; INPUTS]| [displacement, force],
        );
        let wires = (r.pc10, r.pc11, r.pc12);
        let (bus, ldac) = OutputBus::new(r.spi3, wires, r.pd2, r.pd12);
        let mut dac = Ad5761r::new(bus);
        let answered = dac.is_set_up() && sampled.is_some();
        dac.write(standing(0, first[0]));
        let period = Period::new(r.tim2, r.tim4, ticks, Self::OUTPUT_DELAY_US);
        timers::take_pins(ldac, line);
        StartedConverters {
            converters: Self {
                adc,
                dac,
                further: [0; MAX_INPUTS],
            },
            period,
            first: [first],
            answered,
        }
    }

    unsafe fn enable_interrupt() {
        // SAFETY: by the caller.
        unsafe { timers::enable_interrupt() };
    }

    #[inline]
    fn codes(&mut self) -> Option<[[u16; 2]; 1]> {
        // A converter that has not converted would only repeat itself.
        if !timers::conversion_has_ended() {
            return None;
        }
        let [displacement, force, v3, v4, v5, _]: [u16; INPUTS] = self.adc.read()?;
        self.further = [v3, v4, v5, 0, 0];
        Some([[displacement, force]])
    }

    #[inline]
    fn inputs(&self) -> [u16; MAX_INPUTS] {
        self.further
    }

    fn is_set_up(&mut self) -> bool {
        self.dac.is_set_up()
    }

    #[inline]
    fn write(&mut self, _: usize, code: u16) {
        self.dac.write(code);
    }
}
