//! The NUCLEO-F429ZI with external 16-bit converters: an AD7606 for the inputs, an AD5761R for the command, both -10 to
//! +10 V. Everything else (PERMIT, emergency stop, lamps, link) is as on the [board itself](super).
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
//! | AD5761R SDI | PC12 | CN8-10, D47 | SPI3 | pull it down at the chip: all ones are its full reset, zeros no command |
//! | AD5761R SYNC | PD2 | CN8-12, D48 | output | low while it is written; pull it up outside |
//! | AD5761R LDAC | PD12 | CN10-21, D29 | TIM4 channel 1 | falls 60 us after the trigger: the command leaves; pull it up outside |
//!
//! # Timers
//! TIM2's update is the trigger and starts TIM4, as with the chip's own converters. TIM2's channel 1 starts the control
//! interrupt 6 us later: the AD7606 takes at most 4.15 us.
//!
//! # Start
//! After power-up the AD5761R's output is clamped to ground, the middle of the stroke, until its range is selected;
//! then it comes up in the middle. If only the chip was reset, the output holds its voltage throughout: it is not set
//! up again, and moves from there to the measured position. PERMIT is low in both cases.

use super::wiring::wired;
use crate::chip::stm32::board::{Board, Wired};
use crate::chip::stm32::converters::{Converters, StartedConverters};
use crate::chip::this::conversion::{self, ConversionPins, INTERRUPT_US, LoadPin};
use crate::chip::this::period::Period;
use crate::chip::this::spi::Bus;
use crate::converter::ad5761r::Ad5761r;
use crate::converter::ad7606::Ad7606;
use crate::converter::output::OutputBus;
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::peripherals::{
    PA5, PA6, PB10, PB11, PC10, PC11, PC12, PD2, PD12, PD14, PF12, SPI1, SPI3, TIM2, TIM4,
};
use embassy_stm32::{Peri, Peripherals};
use link::telemetry::MAX_INPUTS;
use link::{CodeRange, Input};

/// The codes of this board, 0 at -10 V and the top at +10 V. A rail is 20 mV wide; limits leave half a volt free.
pub(super) const CODES: CodeRange = CodeRange {
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

/// The parts of the chip used for external converters, one actuator's or three's.
pub struct Parts {
    pub spi1: Peri<'static, SPI1>,
    pub spi3: Peri<'static, SPI3>,
    pub tim2: Peri<'static, TIM2>,
    pub tim4: Peri<'static, TIM4>,
    pub pa5: Peri<'static, PA5>,
    pub pa6: Peri<'static, PA6>,
    pub pb10: Peri<'static, PB10>,
    pub pb11: Peri<'static, PB11>,
    pub pc10: Peri<'static, PC10>,
    pub pc11: Peri<'static, PC11>,
    pub pc12: Peri<'static, PC12>,
    pub pd2: Peri<'static, PD2>,
    pub pd12: Peri<'static, PD12>,
    pub pd14: Peri<'static, PD14>,
    pub pf12: Peri<'static, PF12>,
}

/// The parts, taken from the peripherals `$p`.
macro_rules! external_parts {
    ($p:ident) => {
        $crate::board::nucleo_f429zi::external::Parts {
            spi1: $p.SPI1,
            spi3: $p.SPI3,
            tim2: $p.TIM2,
            tim4: $p.TIM4,
            pa5: $p.PA5,
            pa6: $p.PA6,
            pb10: $p.PB10,
            pb11: $p.PB11,
            pc10: $p.PC10,
            pc11: $p.PC11,
            pc12: $p.PC12,
            pd2: $p.PD2,
            pd12: $p.PD12,
            pd14: $p.PD14,
            pf12: $p.PF12,
        }
    };
}
pub(super) use external_parts;

/// Everything connected to the parts, ready; the timers do not run yet.
pub(super) struct Started<const W: usize> {
    pub(super) adc: Ad7606,
    /// Codes of a first conversion, if the converter answers.
    pub(super) first: Option<[u16; W]>,
    pub(super) conversion: ConversionPins,
    pub(super) output: OutputBus,
    pub(super) load: LoadPin,
    pub(super) tim2: Peri<'static, TIM2>,
    pub(super) tim4: Peri<'static, TIM4>,
}

impl Parts {
    /// Converts by hand, and prepares the output's bus.
    pub(super) fn start<const W: usize>(self) -> Started<W> {
        // External pull-ups and pull-downs must act before a bus moves.
        let select = Output::new(self.pd14, Level::High, Speed::VeryHigh);
        let bus = Bus::of_input(self.spi1, self.pa5, self.pa6);
        let reset = Output::new(self.pf12, Level::Low, Speed::Low);
        let mut adc = Ad7606::new(bus, select, reset);
        let mut conversion = ConversionPins::new(self.pb10, self.pb11);
        let first = adc.first(&mut conversion);
        let sync = Output::new(self.pd2, Level::High, Speed::VeryHigh);
        let load = LoadPin::new(self.pd12);
        let bus = Bus::of_output(self.spi3, self.pc10, self.pc11, self.pc12);
        Started {
            adc,
            first,
            conversion,
            output: OutputBus { bus, sync },
            load,
            tim2: self.tim2,
            tim4: self.tim4,
        }
    }
}

/// The board with external converters.
pub struct WithExternal;

impl Board for WithExternal {
    type Converters = External;

    const NAME: &'static str = "NUCLEO-F429ZI 16 bits";

    fn wire(p: Peripherals) -> Wired<Parts> {
        let parts = external_parts!(p);
        wired!(p, parts)
    }
}

impl Converters for External {
    type Parts = Parts;

    const CODES: CodeRange = CODES;
    const INPUTS: &'static [Input] = &[
        Input::CommandReadBack(0),
        Input::SecondDisplacement,
        Input::HeadAcceleration,
    ];
    // 0.5 % of the range, 100 mV: the errors of both converters are a fifth of it.
    const READ_BACK_OFF: u16 = 328;
    // Twice that fifth, 40 mV.
    const READ_BACK_LEAST: u16 = 131;
    const INPUT_SPAN_V: [f32; 2] = SPAN_V;
    const OUTPUT_DELAY_US: u32 = 60;
    const BEGINS_US: u32 = INTERRUPT_US + 2;
    const LATEST_BEGIN_US: u32 = conversion::LATEST_BEGIN_US;
    // Six 16-bit and three 8-bit words at 10.5 MHz, 13 us with their waiting loops, plus the board's own work.
    const AROUND_STEP_CYCLES: u32 = 2600;

    fn new(
        parts: Parts,
        ticks: u32,
        standing: impl Fn(usize, u16) -> u16,
    ) -> StartedConverters<Self> {
        let started = parts.start();
        let first = started.first.map_or(
            [CODES.sensor_top / 2; 2],
            |[displacement, force, ..]: [u16; INPUTS]| [displacement, force],
        );
        let mut dac = Ad5761r::new(started.output);
        let answered = dac.is_set_up() && started.first.is_some();
        if started.first.is_some() || !dac.has_held() {
            dac.write(standing(0, first[0]));
        }
        let period = Period::new(started.tim2, started.tim4, ticks, Self::OUTPUT_DELAY_US);
        conversion::take_pins(started.load, started.conversion);
        StartedConverters {
            converters: Self {
                adc: started.adc,
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
        unsafe { conversion::enable_interrupt() };
    }

    #[inline]
    fn codes(&mut self) -> Option<[[u16; 2]; 1]> {
        // A converter that has not converted would only repeat its last result.
        if !conversion::conversion_has_ended() {
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
        self.adc.converts() && self.dac.is_set_up()
    }

    #[inline]
    fn write(&mut self, _: usize, code: u16) {
        self.dac.write(code);
    }
}
