//! The NUCLEO-F429ZI with the chip's own 12-bit converters.

use super::wiring::wired;
use crate::chip::stm32::board::{Board, Wired};
use crate::chip::stm32::converters::{Converters, StartedConverters};
use crate::chip::this::adc::{FurtherAdc, Sensors, TOP};
use crate::chip::this::dac::DacOutput;
use crate::chip::this::period::Period;
use embassy_stm32::adc::AdcChannel;
use embassy_stm32::peripherals::{ADC1, ADC2, DAC1, PA3, PA4, PC0, PC2, PC3, TIM2, TIM4};
use embassy_stm32::{Peri, Peripherals};
use link::telemetry::MAX_INPUTS;
use link::{CodeRange, Input};

/// The codes of this board: sensor codes are the sum of two 12-bit conversions; the ranks displacement, force, force,
/// displacement have the same mean instant for both channels.
pub const CODES: CodeRange = CodeRange {
    sensor_top: TOP,
    sensor_rail: 8,
    sensor_spare: 600,
    command_top: 4095,
    command_spare: 300,
};

/// The chip's own converters.
pub struct Internal {
    sensors: Sensors,
    command: DacOutput,
    further_adc: FurtherAdc,
}

/// The parts of the chip that they use.
pub struct Parts {
    pub adc1: Peri<'static, ADC1>,
    pub adc2: Peri<'static, ADC2>,
    pub dac1: Peri<'static, DAC1>,
    pub tim2: Peri<'static, TIM2>,
    pub tim4: Peri<'static, TIM4>,
    pub pa3: Peri<'static, PA3>,
    pub pa4: Peri<'static, PA4>,
    pub pc0: Peri<'static, PC0>,
    pub pc2: Peri<'static, PC2>,
    pub pc3: Peri<'static, PC3>,
}

/// The board with these converters.
pub struct WithInternal;

impl Board for WithInternal {
    type Converters = Internal;

    const NAME: &'static str = "NUCLEO-F429ZI";

    fn wire(p: Peripherals) -> Wired<Parts> {
        let parts = Parts {
            adc1: p.ADC1,
            adc2: p.ADC2,
            dac1: p.DAC1,
            tim2: p.TIM2,
            tim4: p.TIM4,
            pa3: p.PA3,
            pa4: p.PA4,
            pc0: p.PC0,
            pc2: p.PC2,
            pc3: p.PC3,
        };
        wired!(p, parts)
    }
}

impl Converters for Internal {
    type Parts = Parts;

    const CODES: CodeRange = CODES;
    const INPUTS: &'static [Input] = &[
        Input::CommandReadBack(0),
        Input::SecondDisplacement,
        Input::HeadAcceleration,
    ];
    // 1 % of the range: offset, gain and linearity of both converters.
    const READ_BACK_OFF: u16 = 41;
    const INPUT_SPAN_V: [f32; 2] = [0.0, 3.3];
    const OUTPUT_DELAY_US: u32 = 40;
    // Including 13 us for the four conversions.
    const BEGINS_US: u32 = 15;
    // 13 us of conversions, plus margin for the entry.
    const LATEST_BEGIN_US: u32 = 20;
    // Some 110 instructions and two divisions, from flash that is not cached.
    const AROUND_STEP_CYCLES: u32 = 400;

    fn new(r: Parts, ticks: u32, standing: impl Fn(usize, u16) -> u16) -> StartedConverters<Self> {
        let mut sensors = Sensors::new(r.adc1, r.pa3, r.pc0);
        // If a converter does not answer, the first step will find its samples stale.
        let first = sensors.first().unwrap_or([CODES.sensor_top / 2; 2]);
        // SAFETY: the DAC drives the pin and ADC2 measures it; both need it analogue and nothing else.
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
        // SAFETY: by the caller.
        unsafe { Sensors::enable_interrupt() };
    }

    #[inline]
    fn codes(&mut self) -> Option<[[u16; 2]; 1]> {
        self.sensors.codes().map(|codes| [codes])
    }

    #[inline]
    fn inputs(&self) -> [u16; MAX_INPUTS] {
        // Codes of the command (one conversion), and of sensors (sums of two).
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
