//! A serial interface of the chip as a master: words are exchanged one by one and waited for, never for long.

use cortex_m::peripheral::DWT;
use embassy_stm32::pac::spi::Spi;
use embassy_stm32::pac::spi::vals::{Br, Cpha, Cpol, Dff, Mstr};

/// Cycles that a word may take: 16 bits at 10.5 MHz are 256.
const PATIENCE_CYCLES: u32 = 1000;

/// A bus with one chip on it.
pub struct Bus(Spi);

/// How the chip wants to be talked to.
pub struct Manner {
    /// The clock's level between words.
    pub idle: Cpol,
    /// The edge at which both sides read.
    pub edge: Cpha,
    /// Bits of a word.
    pub bits: Dff,
    /// What divides the peripheral clock.
    pub divider: Br,
}

impl Bus {
    /// On an interface that has its clock and its pins.
    pub fn new(spi: Spi, manner: &Manner) -> Self {
        spi.cr1().write(|w| {
            w.set_cpol(manner.idle);
            w.set_cpha(manner.edge);
            w.set_dff(manner.bits);
            w.set_br(manner.divider);
            w.set_mstr(Mstr::MASTER);
            // The chip is selected by a pin of its own.
            w.set_ssm(true);
            w.set_ssi(true);
            w.set_spe(true);
        });
        Self(spi)
    }

    /// One word each way; `None` if the interface does not end it.
    #[inline]
    pub fn exchange(&self, word: u16) -> Option<u16> {
        self.0.dr().write(|w| w.set_dr(word));
        let begin = DWT::cycle_count();
        while !self.0.sr().read().rxne() {
            if DWT::cycle_count().wrapping_sub(begin) > PATIENCE_CYCLES {
                return None;
            }
        }
        Some(self.0.dr().read().dr())
    }
}
