//! The NUCLEO-F429ZI with three actuators: an AD7606 for displacements and forces, an AD5754R for the commands, both -10 to
//! +10 V and 16 bits. All else (PERMIT, emergency stop, lamps, link) is as on the [board itself](super::nucleo_f429zi).
//!
//! # Wiring
//! The pins are those of [one actuator](super::nucleo_f429zi_16); the AD5754R stands in the place of the AD5761R, on the same
//! SCLK, SDO, SDI, SYNC and LDAC.
//!
//! | AD7606 | |
//! |---|---|
//! | V1, V2, V3 | displacements of actuators 1 to 3 |
//! | V4, V5, V6 | forces |
//! | V7 | command of actuator 1, from the AD5754R's output A |
//! | V8 | acceleration of the head of actuator 1 |
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
//!  80 us   TIM4 compare: LDAC falls, all commands leave at once
//! ```
//!
//! # Start
//! After power-up the AD5754R's outputs are clamped to ground, the middle of the stroke, until they get power, and come up
//! there. When only the chip was reset they hold their voltages: it is not set up again, and goes from there to the measured
//! positions. PERMIT is low in both cases.

mod ad5754r;

use super::nucleo_f429zi::converters::{Begun, Converters, Resources};
use super::nucleo_f429zi::period::Period;
use super::nucleo_f429zi_16::CODES;
use super::nucleo_f429zi_16::ad7606::Adc;
use super::nucleo_f429zi_16::output::OutputBus;
use super::nucleo_f429zi_16::timers::{self, INTERRUPT_US, LATEST_BEGIN_US};
use ad5754r::{Dac, OUTPUTS};
use link::telemetry::MAX_INPUTS;
use link::{CodeRange, Input};

/// Inputs of the AD7606.
const INPUTS: usize = 8;

/// The external converters.
pub struct Three {
    adc: Adc,
    dac: Dac,
    period: Period,
    /// V7 and V8 of the last sample.
    further: [u16; MAX_INPUTS],
}

impl Converters<OUTPUTS> for Three {
    const NAME: &'static str = "NUCLEO-F429ZI 3 x 16";
    const CODES: CodeRange = CODES;
    const INPUTS: &'static [Input] = &[Input::CommandReadBack, Input::HeadAcceleration];
    const OUTPUT_DELAY_US: u32 = 80;
    const BEGINS_US: u32 = INTERRUPT_US + 2;
    // Eight words of 16 bits and nine of 8 at 10.5 MHz, 22 us with their waiting loops, and what the board's own take.
    const AROUND_STEP_CYCLES: u32 = 4600;

    fn new(r: Resources, ticks: u32, standing: impl Fn(usize, u16) -> u16) -> Begun<Self, OUTPUTS> {
        let mut adc = Adc::new(r.spi1, r.pa5, r.pa6, r.pd14, r.pf12);
        let (sampled, line) = adc.first(r.pb10, r.pb11);
        let (first, further) = sorted(sampled.unwrap_or([CODES.sensor_top / 2; INPUTS]));
        let wires = (r.pc10, r.pc11, r.pc12);
        let (bus, ldac) = OutputBus::new(r.spi3, wires, r.pd2, r.pd12);
        let mut dac = Dac::new(bus);
        let answered = dac.answered() && sampled.is_some();
        for (actuator, [displacement, _]) in first.into_iter().enumerate() {
            dac.write(actuator, standing(actuator, displacement));
        }
        let period = Period::new(r.tim2, r.tim4, ticks, Self::OUTPUT_DELAY_US);
        timers::take_pins(ldac, line);
        Begun {
            converters: Self {
                adc,
                dac,
                period,
                further,
            },
            first,
            answered,
        }
    }

    fn start(&mut self) {
        self.period.start();
    }

    unsafe fn enable_interrupt() {
        // SAFETY: by the caller.
        unsafe { timers::enable_interrupt() };
    }

    #[inline]
    fn codes(&mut self) -> Option<[[u16; 2]; OUTPUTS]> {
        // A converter that has not converted would only repeat itself.
        if !timers::conversion_has_ended() {
            return None;
        }
        let (codes, further) = sorted(self.adc.read()?);
        self.further = further;
        Some(codes)
    }

    #[inline]
    fn inputs(&self) -> [u16; MAX_INPUTS] {
        self.further
    }

    #[inline]
    fn began_late(&self) -> bool {
        self.period.is_past(LATEST_BEGIN_US)
    }

    #[inline]
    fn write(&mut self, actuator: usize, code: u16) {
        self.dac.write(actuator, code);
    }

    fn set_period(&mut self, ticks: u32) {
        self.period.set(ticks);
    }
}

/// Displacement and force of each actuator, and the further inputs.
#[inline]
fn sorted(
    [d1, d2, d3, f1, f2, f3, v7, v8]: [u16; INPUTS],
) -> ([[u16; 2]; OUTPUTS], [u16; MAX_INPUTS]) {
    ([[d1, f1], [d2, f2], [d3, f3]], [v7, v8, 0])
}
