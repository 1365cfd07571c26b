//! The AD7606: eight inputs of -10 to +10 V, sampled at one instant, 16 bits, read serially over one line.
//!
//! According to its data sheet (Analog Devices, Rev. F): the rising edge of CONVST samples all inputs; BUSY is high for
//! at most 4.15 us (no oversampling, OS0 to OS2 low) and its fall puts the results into the output registers; the
//! falling edge of CS brings the first bit of V1, each rising edge of SCLK the next; SCLK is at most 14.5 MHz at VDRIVE
//! of 3 V. Results are in two's complement.

use crate::chip::this::clocks::CORE_HZ;
use crate::chip::this::conversion::ConversionPins;
use crate::chip::this::spi::Bus;
use cortex_m::peripheral::DWT;
use embassy_stm32::gpio::Output;

/// Converts two's complement to codes that count from the lower end, and back.
const SIGN: u16 = 0x8000;

/// A microsecond, in cycles.
const US: u32 = CORE_HZ / 1_000_000;

/// Time allowed for a conversion while nothing else waits for it.
const CONVERSION_CYCLES: u32 = 100 * US;

/// Start-up conversions until the reference is ready, and the pause between them: the converter's own reference takes
/// some 30 ms from power-up.
const FIRST_CONVERSIONS: usize = 50;
const PAUSE_CYCLES: u32 = 1000 * US;

/// Required reading of the last input read, and its tolerance: half of the board's 3.3 V by two resistors of 10 kOhm, a
/// tenth for supply, resistors and the input's 1 MOhm. It proves select, clock, order, bit position and reference of
/// its frame; a line that is dead or stuck reads 0 or -1 there, which at a sensor is the middle of its range.
const KNOWN: u16 = SIGN + 5406;
const KNOWN_OFF: u16 = 541;

/// Consecutive frames in which the known voltage may have the same code, if that lasts this long. The converter's noise
/// is half a code rms: a converter that claims to have converted but repeats an earlier result has none.
const STANDS_FRAMES: u16 = 100;
const STANDS_CYCLES: u32 = 500_000 * US;

/// The converter.
pub struct Ad7606 {
    bus: Bus,
    select: Output<'static>,
    /// The last code of the known voltage, since when it has been unchanged, in cycles, and for how many frames.
    known: u16,
    since: u32,
    same: u16,
    /// True if it has been unchanged for too long.
    stands: bool,
}

impl Ad7606 {
    /// Reset and ready, on a bus that is ready; it is not selected.
    pub fn new(bus: Bus, select: Output<'static>, mut reset: Output<'static>) -> Self {
        reset.set_high();
        cortex_m::asm::delay(US);
        reset.set_low();
        cortex_m::asm::delay(US);
        // The pin must stay configured.
        core::mem::forget(reset);
        Self {
            bus,
            select,
            known: 0,
            since: 0,
            same: 0,
            stands: false,
        }
    }

    /// A conversion by hand, before the timer runs: the first `W` inputs, the last of them the known voltage. `None`:
    /// the converter does not answer.
    pub fn first<const W: usize>(&mut self, pins: &mut ConversionPins) -> Option<[u16; W]> {
        for _ in 0..FIRST_CONVERSIONS {
            cortex_m::asm::delay(US);
            pins.set_convst(true);
            cortex_m::asm::delay(US);
            let begin = DWT::cycle_count();
            let mut ended = false;
            while !ended && DWT::cycle_count().wrapping_sub(begin) < CONVERSION_CYCLES {
                ended = !pins.is_busy();
            }
            let codes = if ended { self.read() } else { None };
            if codes.is_some() {
                return codes;
            }
            pins.set_convst(false);
            cortex_m::asm::delay(PAUSE_CYCLES);
        }
        None
    }

    /// The first `W` inputs of the last conversion, V1 first; `None` if the last of them does not show the known voltage.
    #[inline]
    pub fn read<const W: usize>(&mut self) -> Option<[u16; W]> {
        // A late word of an earlier frame would shift this one.
        self.bus.empty();
        self.select.set_low();
        let codes = self.words();
        self.select.set_high();
        codes.filter(|codes: &[u16; W]| {
            let known = codes.last().copied().unwrap_or(0);
            let is_frame = known.abs_diff(KNOWN) <= KNOWN_OFF;
            if is_frame {
                self.look_at(known);
            }
            is_frame
        })
    }

    /// Checks that the known voltage still has its noise.
    fn look_at(&mut self, known: u16) {
        let now = DWT::cycle_count();
        if known != self.known {
            (self.known, self.since, self.same, self.stands) = (known, now, 0, false);
            return;
        }
        self.same = self.same.saturating_add(1);
        let lasts = now.wrapping_sub(self.since) >= STANDS_CYCLES;
        self.stands |= self.same >= STANDS_FRAMES && lasts;
    }

    /// True if its results are new, as far as their noise shows.
    pub fn converts(&self) -> bool {
        !self.stands
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
