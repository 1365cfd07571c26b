//! The AD5761R: one output of -10 to +10 V, 16 bits, with a reference of its own.
//!
//! By its data sheet (Analog Devices, Rev. C): 24 bits a command, read at the falling edges of SCLK while SYNC is low, in
//! force when SYNC rises: four bits that mean nothing, four of the command, 16 of data. A code waits in the input register
//! for the falling edge of LDAC. After power-up and after a full reset the output is clamped to ground until the control
//! register is written. What a read command asks for comes with the next one.

use super::bus::{Bus, Manner};
use embassy_stm32::gpio::{AfType, Flex, Level, Output, OutputType, Pull, Speed};
use embassy_stm32::pac::spi::vals::{Br, Cpha, Cpol, Dff};
use embassy_stm32::peripherals::{PC10, PC11, PC12, PD2, PD12, SPI3};
use embassy_stm32::{Peri, pac, rcc};

// Commands.
const NOTHING: u8 = 0x0;
const WRITE_INPUT: u8 = 0x1;
const WRITE_CONTROL: u8 = 0x4;
const READ_CONTROL: u8 = 0xc;
const FULL_RESET: u8 = 0xf;

/// Clear voltage and power-up voltage in the middle, shut down when too hot, own reference, range -10 to +10 V, straight
/// binary.
const CONTROL: u16 = 1 << 9 | 1 << 6 | 1 << 5 | 1 << 3;

/// What is compared of the control register: all that is written, and the brown-out flag above it, which must be clear.
const CONTROL_MASK: u32 = 0xfff;

/// SPI3's alternate function, TIM4's on PD12.
const AF_SPI3: u8 = 6;
const AF_TIM4: u8 = 2;

/// Two microseconds, in cycles: longer than the chip needs between any two edges, and after a reset.
const WAIT: u32 = super::super::nucleo_f429zi::clocks::CORE_HZ / 500_000;

/// The converter.
pub struct Dac {
    bus: Bus,
    sync: Output<'static>,
    answered: bool,
}

/// LDAC while it is not the timer's yet.
pub struct Load(Flex<'static>);

impl Dac {
    /// Set up, unless it already is and holds its voltage.
    pub fn new(
        _spi: Peri<'static, SPI3>,
        clock: Peri<'static, PC10>,
        from: Peri<'static, PC11>,
        to: Peri<'static, PC12>,
        sync: Peri<'static, PD2>,
        load: Peri<'static, PD12>,
    ) -> (Self, Load) {
        let sync = Output::new(sync, Level::High, Speed::VeryHigh);
        let mut load = Flex::new(load);
        load.set_high();
        load.set_as_output(Speed::VeryHigh);
        rcc::enable_and_reset::<SPI3>();
        // 42 MHz / 4 = 10.5 MHz.
        let manner = Manner {
            idle: Cpol::IDLE_LOW,
            edge: Cpha::SECOND_EDGE,
            bits: Dff::BITS8,
            divider: Br::DIV4,
        };
        let bus = Bus::new(pac::SPI3, &manner);
        let push = AfType::output(OutputType::PushPull, Speed::VeryHigh);
        let (mut clock, mut from, mut to) = (Flex::new(clock), Flex::new(from), Flex::new(to));
        clock.set_as_af_unchecked(AF_SPI3, push);
        // No answer is all ones, which the control register cannot be.
        from.set_as_af_unchecked(AF_SPI3, AfType::input(Pull::Up));
        to.set_as_af_unchecked(
            AF_SPI3,
            AfType::output(OutputType::PushPull, Speed::VeryHigh),
        );
        core::mem::forget((clock, from, to));
        let mut dac = Self {
            bus,
            sync,
            answered: false,
        };
        if !dac.is_set_up() {
            dac.frame(FULL_RESET, 0);
            cortex_m::asm::delay(WAIT);
            dac.frame(WRITE_CONTROL, CONTROL);
            cortex_m::asm::delay(WAIT);
        }
        dac.answered = dac.is_set_up();
        (dac, Load(load))
    }

    /// It has said that it is set up as it should be.
    pub fn answered(&self) -> bool {
        self.answered
    }

    fn is_set_up(&mut self) -> bool {
        self.frame(READ_CONTROL, 0);
        cortex_m::asm::delay(WAIT);
        let answer = self.frame(NOTHING, 0);
        cortex_m::asm::delay(WAIT);
        answer.is_some_and(|bits| bits & CONTROL_MASK == u32::from(CONTROL))
    }

    /// The code that the output shows from LDAC's next fall on.
    #[inline]
    pub fn write(&mut self, code: u16) {
        self.frame(WRITE_INPUT, code);
    }

    /// A command; gives what the one before it asked for.
    #[inline]
    fn frame(&mut self, command: u8, data: u16) -> Option<u32> {
        self.sync.set_low();
        let [high, low] = data.to_be_bytes();
        let answer = self.bytes([command, high, low]);
        self.sync.set_high();
        answer
    }

    #[inline]
    fn bytes(&self, bytes: [u8; 3]) -> Option<u32> {
        let mut answer = 0;
        for byte in bytes {
            answer = answer << 8 | u32::from(self.bus.exchange(u16::from(byte))? & 0xff);
        }
        Some(answer)
    }
}

impl Load {
    /// Loads what waits, then gives the line to the timer.
    pub fn hand_over(mut self) {
        cortex_m::asm::delay(WAIT);
        self.0.set_low();
        cortex_m::asm::delay(WAIT);
        self.0.set_high();
        let timed = AfType::output(OutputType::PushPull, Speed::VeryHigh);
        self.0.set_as_af_unchecked(AF_TIM4, timed);
        core::mem::forget(self.0);
    }
}
