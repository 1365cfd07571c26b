//! The NUCLEO-F429ZI with three actuators: an AD7606 for displacements and forces, an AD5754R for the commands, both
//! -10 to +10 V and 16 bits. Everything else (PERMIT, emergency stop, lamps, link) is as on the [board itself](super).
//!
//! # Wiring
//! The pins are those of [one actuator](super::external); the AD5754R replaces the AD5761R, on the same SCLK, SDO, SDI,
//! SYNC and LDAC.
//!
//! | AD7606 | |
//! |---|---|
//! | V1, V2, V3 | displacements of actuators 1 to 3 |
//! | V4, V5, V6 | forces |
//! | V7 | second displacement of actuator 1 |
//! | V8 | half of 3.3 V: a frame without it is rejected |
//!
//! | the chip's ADC2 | each through an amplifier of gain 0.15 around 1.65 V |
//! |---|---|
//! | PA3 (CN9-1, A0), PC0 (CN9-3, A1), PC3 (CN9-5, A2) | commands of actuators 1 to 3, read back from the AD5754R's outputs A to C |
//!
//! | AD5754R | |
//! |---|---|
//! | outputs A, B, C | commands of actuators 1 to 3; D is not powered |
//! | BIN/2sCOMP | ground: a code of zero is 0 V |
//! | CLR | DVCC |
//!
//! # One control period
//! ```text
//!  0 us    TIM2 update: CONVST rises, all eight inputs are sampled
//!  6 us    control interrupt: eight words are read, the step, three codes are written
//!  80 us   TIM4 compare: LDAC falls, all commands leave at once; of two coupled actuators at 200 us
//! ```
//!
//! # Start
//! After power-up the AD5754R's outputs are clamped to ground, the middle of the stroke, until they are powered, and
//! come up there. If only the chip was reset, they hold their voltages: it is not set up again, and moves from there to
//! the measured positions. PERMIT is low in both cases.

use super::external::{CODES, Parts as External, SPAN_V, external_parts};
use super::wiring::wired;
use crate::chip::stm32::board::{Board, Wired};
use crate::chip::stm32::converters::{Converters, StartedConverters};
use crate::chip::this::adc::FurtherAdc;
use crate::chip::this::conversion::{self, INTERRUPT_US};
use crate::chip::this::period::Period;
use crate::converter::ad5754r::{Ad5754r, OUTPUTS};
use crate::converter::ad7606::Ad7606;
use embassy_stm32::adc::AdcChannel;
use embassy_stm32::peripherals::{ADC2, PA3, PC0, PC3};
use embassy_stm32::{Peri, Peripherals};
use link::telemetry::MAX_INPUTS;
use link::{CodeRange, Input};

/// Inputs of the AD7606.
const INPUTS: usize = 8;

/// The external converters.
pub struct ExternalThree {
    adc: Ad7606,
    dac: Ad5754r,
    further_adc: FurtherAdc,
    /// V7 of the last sample.
    second_displacement: u16,
}

/// The parts of the chip that they use.
pub struct Parts {
    pub external: External,
    pub adc2: Peri<'static, ADC2>,
    pub pa3: Peri<'static, PA3>,
    pub pc0: Peri<'static, PC0>,
    pub pc3: Peri<'static, PC3>,
}

/// The board with these converters.
pub struct WithExternalThree;

impl Board<OUTPUTS> for WithExternalThree {
    type Converters = ExternalThree;

    const NAME: &'static str = "NUCLEO-F429ZI 3 x 16";

    fn wire(p: Peripherals) -> Wired<Parts> {
        let parts = Parts {
            external: external_parts!(p),
            adc2: p.ADC2,
            pa3: p.PA3,
            pc0: p.PC0,
            pc3: p.PC3,
        };
        wired!(p, parts)
    }
}

impl Converters<OUTPUTS> for ExternalThree {
    type Parts = Parts;

    const CODES: CodeRange = CODES;
    const INPUTS: &'static [Input] = &[
        Input::CommandReadBack(0),
        Input::CommandReadBack(1),
        Input::CommandReadBack(2),
        Input::SecondDisplacement,
    ];
    // 2 % of the range, 400 mV: the resistors of three amplifiers.
    const READ_BACK_OFF: u16 = 1311;
    const INPUT_SPAN_V: [f32; 2] = SPAN_V;
    const OUTPUT_DELAY_US: u32 = 80;
    // A step of two coupled actuators that identifies 13 of their parameters takes some 10 000 instructions: 110 us.
    const LATE_OUTPUT_DELAY_US: u32 = 200;
    const BEGINS_US: u32 = INTERRUPT_US + 2;
    const LATEST_BEGIN_US: u32 = conversion::LATEST_BEGIN_US;
    // Eight 16-bit and nine 8-bit words at 10.5 MHz, 22 us with their waiting loops, plus the board's own work.
    const AROUND_STEP_CYCLES: u32 = 4600;

    fn new(
        parts: Parts,
        ticks: u32,
        standing: impl Fn(usize, u16) -> u16,
    ) -> StartedConverters<Self, OUTPUTS> {
        let started = parts.external.start();
        let (first, second_displacement) =
            sorted(started.first.unwrap_or([CODES.sensor_top / 2; INPUTS]));
        let mut dac = Ad5754r::new(started.output);
        let answered = dac.is_set_up() && started.first.is_some();
        if started.first.is_some() || !dac.has_held() {
            for (actuator, [displacement, _]) in first.into_iter().enumerate() {
                dac.write(actuator, standing(actuator, displacement));
            }
        }
        let outputs = [
            parts.pa3.degrade_adc(),
            parts.pc0.degrade_adc(),
            parts.pc3.degrade_adc(),
        ];
        let further_adc = FurtherAdc::new(parts.adc2, outputs);
        let period = Period::new(started.tim2, started.tim4, ticks, Self::OUTPUT_DELAY_US);
        conversion::take_pins(started.load, started.conversion);
        StartedConverters {
            converters: Self {
                adc: started.adc,
                dac,
                further_adc,
                second_displacement,
            },
            period,
            first,
            answered,
        }
    }

    unsafe fn enable_interrupt() {
        // SAFETY: by the caller.
        unsafe { conversion::enable_interrupt() };
    }

    #[inline]
    fn codes(&mut self) -> Option<[[u16; 2]; OUTPUTS]> {
        // A converter that has not converted would only repeat its last result.
        if !conversion::conversion_has_ended() {
            return None;
        }
        let codes;
        (codes, self.second_displacement) = sorted(self.adc.read()?);
        Some(codes)
    }

    #[inline]
    fn inputs(&self) -> [u16; MAX_INPUTS] {
        let [first, second, third] = self.further_adc.codes().map(read_back);
        [first, second, third, self.second_displacement, 0]
    }

    fn is_set_up(&mut self) -> bool {
        self.adc.converts() && self.dac.is_set_up() && self.further_adc.is_set_up()
    }

    #[inline]
    fn write(&mut self, actuator: usize, code: u16) {
        self.dac.write(actuator, code);
    }
}

/// Converts the reading of the chip's own converter, through an amplifier of gain 0.15 around mid-range, to the
/// command's code: 3.3 V in 4095 codes there, 20 V in 65536 here.
#[inline]
fn read_back(code: u16) -> u16 {
    const CODES_IN_1000: i32 = (3.3 / 4095.0 / 0.15 / 20.0 * 65536.0 * 1000.0) as i32;
    let from_middle = (2 * i32::from(code) - 4095) * CODES_IN_1000 / 2000;
    (from_middle + 0x8000).clamp(0, 0xffff) as u16
}

/// Displacement and force of each actuator, and the second displacement.
#[inline]
fn sorted([d1, d2, d3, f1, f2, f3, v7, _]: [u16; INPUTS]) -> ([[u16; 2]; OUTPUTS], u16) {
    ([[d1, f1], [d2, f2], [d3, f3]], v7)
}
