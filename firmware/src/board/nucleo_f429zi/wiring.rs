//! Common to all converters: interrupts and their priorities, PERMIT for the ways out, the port to the PC, pins.

use crate::chip::stm32::BACKGROUND;
use embassy_stm32::gpio::{Flex, Speed};
use embassy_stm32::interrupt::InterruptExt;
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{DMA1_CH1, DMA1_CH3, PD8, PD9, USART3};
use embassy_stm32::usart::{Config, Uart};
use embassy_stm32::{Peri, bind_interrupts, dma, flash, interrupt, pac, peripherals, usart};

bind_interrupts!(
    /// Embassy's interrupts. The control interrupt is none of them.
    pub struct Irqs {
        USART3 => usart::InterruptHandler<peripherals::USART3>;
        DMA1_STREAM1 => dma::InterruptHandler<peripherals::DMA1_CH1>;
        DMA1_STREAM3 => dma::InterruptHandler<peripherals::DMA1_CH3>;
        FLASH => flash::InterruptHandler;
    }
);

/// Lowers embassy's interrupts, by default at the highest priority, below the control interrupt.
pub fn lower_priorities() {
    interrupt::TIM3.set_priority(BACKGROUND);
    interrupt::USART3.set_priority(BACKGROUND);
    interrupt::DMA1_STREAM1.set_priority(BACKGROUND);
    interrupt::DMA1_STREAM3.set_priority(BACKGROUND);
    interrupt::FLASH.set_priority(BACKGROUND);
}

/// For the ways out, which may use nothing else: the register that drops PERMIT, port E's BSRR, and the value to write,
/// the reset of pin 9.
pub const PERMIT_REGISTER: u32 = 0x4002_1018;
/// See [`PERMIT_REGISTER`].
pub const PERMIT_RESET: u32 = 1 << (16 + 9);

/// PERMIT, low: an output whose level can be read at its pin.
pub(super) fn permit_line(pin: Peri<'static, peripherals::PE9>) -> Flex<'static> {
    let mut line = Flex::new(pin);
    line.set_low();
    line.set_as_output(Speed::Low);
    line
}

/// The red lamp, whoever owns its pin.
pub fn fault_lamp_on() {
    pac::GPIOB.bsrr().write(|w| w.set_bs(14, true));
}

/// The port to the PC, before it is open.
pub struct Serial {
    pub(super) usart: Peri<'static, USART3>,
    pub(super) rx: Peri<'static, PD9>,
    pub(super) tx: Peri<'static, PD8>,
    pub(super) tx_dma: Peri<'static, DMA1_CH3>,
    pub(super) rx_dma: Peri<'static, DMA1_CH1>,
}

impl Serial {
    /// Opens it at the link's rate.
    pub fn open(self) -> Uart<'static, Async> {
        let mut config = Config::default();
        config.baudrate = link::BAUD;
        let uart = Uart::new(
            self.usart,
            self.rx,
            self.tx,
            self.tx_dma,
            self.rx_dma,
            Irqs,
            config,
        );
        defmt::unwrap!(uart)
    }
}

/// The parts common to all converters, from the peripherals `$p`.
macro_rules! wired {
    ($p:ident, $parts:expr) => {{
        use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
        let wired = $crate::chip::stm32::board::Wired {
            pins: $crate::chip::stm32::metal::Pins {
                permit: $crate::board::nucleo_f429zi::wiring::permit_line($p.PE9),
                pulse: Output::new($p.PE14, Level::Low, Speed::Low),
                chain: Input::new($p.PE15, Pull::Down),
                button: Input::new($p.PC13, Pull::Down),
                stop: Input::new($p.PE11, Pull::Up),
                step: Output::new($p.PE13, Level::Low, Speed::Medium),
            },
            lamps: $crate::chip::stm32::tasks::lights::Lamps {
                green: Output::new($p.PB0, Level::Low, Speed::Low),
                blue: Output::new($p.PB7, Level::Low, Speed::Low),
                red: Output::new($p.PB14, Level::Low, Speed::Low),
            },
            serial: $crate::board::nucleo_f429zi::wiring::Serial {
                usart: $p.USART3,
                rx: $p.PD9,
                tx: $p.PD8,
                tx_dma: $p.DMA1_CH3,
                rx_dma: $p.DMA1_CH1,
            },
            flash: $p.FLASH,
            watchdog: $p.IWDG,
            converters: $parts,
        };
        // See the wiring: required on early chips for reading the second bank of the flash.
        core::mem::forget(Output::new($p.PA12, Level::Low, Speed::Low));
        wired
    }};
}
pub(super) use wired;
