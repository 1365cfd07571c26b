//! The AD7606: eight inputs of -10 to +10 V, sampled at one instant, 16 bits, read in series over one line.
//!
//! By its data sheet (Analog Devices, Rev. F): the rising edge of CONVST samples all inputs; BUSY is high for 4.15 us at most
//! (no oversampling, OS0 to OS2 low) and its fall puts the results into the output registers; the falling edge of CS brings
//! the first bit of V1, each rising edge of SCLK the next; SCLK is at most 14.5 MHz at VDRIVE of 3 V. Results are in two's
//! complement.

use super::bus::{Bus, SpiMode};
use cortex_m::peripheral::DWT;
use embassy_stm32::gpio::{AfType, Flex, Level, Output, OutputType, Pull, Speed};
use embassy_stm32::pac::spi::vals::{Br, Cpha, Cpol, Dff};
use embassy_stm32::peripherals::{PA5, PA6, PB10, PB11, PD14, PF12, SPI1};
use embassy_stm32::{Peri, pac, rcc};

/// SPI1's alternate function on its pins.
const AF_SPI1: u8 = 5;

/// TIM2's on PB10 and PB11.
const AF_TIM2: u8 = 1;

/// Two's complement to codes that count from the lower end, and back.
const SIGN: u16 = 0x8000;

/// A microsecond, in cycles.
const US: u32 = super::super::nucleo_f429zi::clocks::CORE_HZ / 1_000_000;

/// A conversion may take so long while nothing else waits for it.
const CONVERSION_CYCLES: u32 = 100 * US;

/// Conversions at the start until the reference is there, and the pause between them: the converter's own takes some 30 ms
/// from power-up.
const FIRST_CONVERSIONS: usize = 50;
const PAUSE_CYCLES: u32 = 1000 * US;

/// What the last input that is read has to show, and by how much it may be off: half of the board's 3.3 V by two resistors
/// of 10 kOhm, a tenth for supply, resistors and the input's 1 MOhm. It proves select, clock, order, bit position and
/// reference of the frame that it comes with; a line that is dead or stuck reads 0 or -1 there, which at a sensor is the
/// middle of its range.
const KNOWN: u16 = SIGN + 5406;
const KNOWN_OFF: u16 = 541;

/// The converter.
pub struct Ad7606 {
    bus: Bus,
    select: Output<'static>,
}

/// CONVST and BUSY while they are not the timer's yet.
pub struct ConversionPins {
    convst: Flex<'static>,
    busy: Flex<'static>,
}

impl Ad7606 {
    /// Reset and ready.
    pub fn new(
        _spi: Peri<'static, SPI1>,
        clock: Peri<'static, PA5>,
        data: Peri<'static, PA6>,
        select: Peri<'static, PD14>,
        reset: Peri<'static, PF12>,
    ) -> Self {
        let select = Output::new(select, Level::High, Speed::VeryHigh);
        rcc::enable_and_reset::<SPI1>();
        // 84 MHz / 8 = 10.5 MHz.
        let manner = SpiMode {
            idle: Cpol::IDLE_HIGH,
            edge: Cpha::FIRST_EDGE,
            bits: Dff::BITS16,
            divider: Br::DIV8,
        };
        let bus = Bus::new(pac::SPI1, &manner);
        let mut clock = Flex::new(clock);
        clock.set_as_af_unchecked(
            AF_SPI1,
            AfType::output(OutputType::PushPull, Speed::VeryHigh),
        );
        let mut data = Flex::new(data);
        data.set_as_af_unchecked(AF_SPI1, AfType::input(Pull::None));
        let mut reset = Output::new(reset, Level::High, Speed::Low);
        cortex_m::asm::delay(US);
        reset.set_low();
        cortex_m::asm::delay(US);
        // They stay as they are.
        core::mem::forget((clock, data, reset));
        Self { bus, select }
    }

    /// A conversion by hand, before the timer runs: the first `W` inputs, with the known voltage at the last of them. No codes:
    /// the converter does not answer.
    pub fn first<const W: usize>(
        &mut self,
        convst: Peri<'static, PB10>,
        busy: Peri<'static, PB11>,
    ) -> (Option<[u16; W]>, ConversionPins) {
        let (mut convst, mut busy) = (Flex::new(convst), Flex::new(busy));
        convst.set_low();
        convst.set_as_output(Speed::VeryHigh);
        // A converter that is not there is busy for good.
        busy.set_as_input(Pull::Up);
        let mut codes = None;
        for _ in 0..FIRST_CONVERSIONS {
            cortex_m::asm::delay(US);
            convst.set_high();
            cortex_m::asm::delay(US);
            let begin = DWT::cycle_count();
            let mut ended = false;
            while !ended && DWT::cycle_count().wrapping_sub(begin) < CONVERSION_CYCLES {
                ended = busy.is_low();
            }
            codes = if ended { self.read() } else { None };
            if codes.is_some() {
                break;
            }
            convst.set_low();
            cortex_m::asm::delay(PAUSE_CYCLES);
        }
        (codes, ConversionPins { convst, busy })
    }

    /// The first `W` inputs of the last conversion, V1 first; `None` if the last of them does not show the known voltage.
    #[inline]
    pub fn read<const W: usize>(&mut self) -> Option<[u16; W]> {
        // A word of an earlier frame that came too late would shift this one.
        self.bus.empty();
        self.select.set_low();
        let codes = self.words();
        self.select.set_high();
        codes.filter(|codes: &[u16; W]| {
            let known = codes.last().copied().unwrap_or(0);
            known.abs_diff(KNOWN) <= KNOWN_OFF
        })
    }

    #[inline]
    fn words<const W: usize>(&mut self) -> Option<[u16; W]> {
        let mut words = [0; W];
        for place in &mut words {
            *place = self.bus.exchange(0)? ^ SIGN;
        }
        Some(words)
    }
}

impl ConversionPins {
    /// To the timer.
    pub fn give_pin_to_timer(mut self) {
        let convst = AfType::output(OutputType::PushPull, Speed::VeryHigh);
        self.convst.set_as_af_unchecked(AF_TIM2, convst);
        self.busy
            .set_as_af_unchecked(AF_TIM2, AfType::input(Pull::Up));
        core::mem::forget((self.convst, self.busy));
    }
}
