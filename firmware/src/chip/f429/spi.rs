//! A serial interface of the chip as a master: words are exchanged one by one with a short, bounded wait.

use cortex_m::peripheral::DWT;
use embassy_stm32::gpio::{AfType, Flex, OutputType, Pull, Speed};
use embassy_stm32::pac::spi::Spi;
use embassy_stm32::pac::spi::vals::{Br, Cpha, Cpol, Dff, Mstr};
use embassy_stm32::peripherals::{PA5, PA6, PC10, PC11, PC12, SPI1, SPI3};
use embassy_stm32::{Peri, pac, rcc};

/// Cycles allowed for a word: 16 bits at 10.5 MHz are 256.
const TIMEOUT_CYCLES: u32 = 1000;

/// Divider of SPI3's 42 MHz clock for commands: 10.5 MHz.
pub const WRITING: Br = Br::DIV4;

/// For replies, which leave the converter up to 40 ns after their edge and travel over a wire: 2.6 MHz.
pub const ASKING: Br = Br::DIV16;

/// SPI1's alternate function on its pins.
const AF_SPI1: u8 = 5;

/// SPI3's alternate function on its pins.
const AF_SPI3: u8 = 6;

/// A bus with one chip on it.
pub struct Bus(Spi);

/// Clock, edge and word length required by the chip.
struct SpiMode {
    /// The clock's level between words.
    idle: Cpol,
    /// The edge at which both sides sample.
    edge: Cpha,
    /// Bits of a word.
    bits: Dff,
    /// Divider of the peripheral clock.
    divider: Br,
}

impl Bus {
    /// Sets up an interface whose clock and pins are ready.
    fn new(spi: Spi, mode: &SpiMode) -> Self {
        spi.cr1().write(|w| {
            w.set_cpol(mode.idle);
            w.set_cpha(mode.edge);
            w.set_dff(mode.bits);
            w.set_br(mode.divider);
            w.set_mstr(Mstr::MASTER);
            // The chip is selected by a separate pin.
            w.set_ssm(true);
            w.set_ssi(true);
        });
        // The word length must not change while the interface is on.
        spi.cr1().modify(|w| w.set_spe(true));
        Self(spi)
    }

    /// SPI1 with its pins, set up for an AD7606: 10.5 MHz, idle high, sampled at the falling edge.
    pub fn of_input(
        _spi: Peri<'static, SPI1>,
        clock: Peri<'static, PA5>,
        data: Peri<'static, PA6>,
    ) -> Self {
        rcc::enable_and_reset::<SPI1>();
        // 84 MHz / 8 = 10.5 MHz.
        let mode = SpiMode {
            idle: Cpol::IDLE_HIGH,
            edge: Cpha::FIRST_EDGE,
            bits: Dff::BITS16,
            divider: Br::DIV8,
        };
        let bus = Self::new(pac::SPI1, &mode);
        let (mut clock, mut data) = (Flex::new(clock), Flex::new(data));
        clock.set_as_af_unchecked(
            AF_SPI1,
            AfType::output(OutputType::PushPull, Speed::VeryHigh),
        );
        data.set_as_af_unchecked(AF_SPI1, AfType::input(Pull::None));
        // The pins must stay configured.
        core::mem::forget((clock, data));
        bus
    }

    /// SPI3 with its pins, set up for the output converters: 10.5 MHz, idle low, sampled at the falling edge.
    pub fn of_output(
        _spi: Peri<'static, SPI3>,
        clock: Peri<'static, PC10>,
        from: Peri<'static, PC11>,
        to: Peri<'static, PC12>,
    ) -> Self {
        rcc::enable_and_reset::<SPI3>();
        let mode = SpiMode {
            idle: Cpol::IDLE_LOW,
            edge: Cpha::SECOND_EDGE,
            bits: Dff::BITS8,
            divider: WRITING,
        };
        let bus = Self::new(pac::SPI3, &mode);
        let push = || AfType::output(OutputType::PushPull, Speed::VeryHigh);
        let (mut clock, mut from, mut to) = (Flex::new(clock), Flex::new(from), Flex::new(to));
        clock.set_as_af_unchecked(AF_SPI3, push());
        // No answer reads as all ones, which is impossible for their registers.
        from.set_as_af_unchecked(AF_SPI3, AfType::input(Pull::Up));
        to.set_as_af_unchecked(AF_SPI3, push());
        core::mem::forget((clock, from, to));
        bus
    }

    /// Discards a word that has arrived since the last exchange.
    #[inline]
    pub fn empty(&self) {
        let _ = self.0.dr().read();
        // Reading the status after the data clears an overrun.
        let _ = self.0.sr().read();
    }

    /// Changes the divider of the peripheral clock, between two words.
    pub fn set_divider(&self, divider: Br) {
        self.0.cr1().modify(|w| w.set_br(divider));
    }

    /// 24 bits each way, the first byte first.
    #[inline]
    pub fn exchange_24(&self, bytes: [u8; 3]) -> Option<u32> {
        let mut answer = 0;
        for byte in bytes {
            answer = answer << 8 | u32::from(self.exchange(u16::from(byte))? & 0xff);
        }
        Some(answer)
    }

    /// One word each way; `None` if the interface does not complete it.
    #[inline]
    pub fn exchange(&self, word: u16) -> Option<u16> {
        self.0.dr().write(|w| w.set_dr(word));
        let begin = DWT::cycle_count();
        while !self.0.sr().read().rxne() {
            if DWT::cycle_count().wrapping_sub(begin) > TIMEOUT_CYCLES {
                return None;
            }
        }
        Some(self.0.dr().read().dr())
    }
}
