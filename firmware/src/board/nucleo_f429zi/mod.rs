//! The NUCLEO-F429ZI (MB1137): every pin and every register that the image uses.
//!
//! # Wiring
//! | signal | pin | connector | peripheral | level |
//! |---|---|---|---|---|
//! | displacement | PA3 | CN9-1, A0 | ADC1 channel 3, ranks 1 and 4 | 0 to 3.3 V |
//! | restoring force | PC0 | CN9-3, A1 | ADC1 channel 10, ranks 2 and 3 | 0 to 3.3 V |
//! | command | PA4 | CN7-17, D24 | DAC channel 1, buffered; read back by ADC2 channel 4, rank 1 | 0.2 to 3.1 V into 5 kOhm and more |
//! | second displacement | PC3 | CN9-5, A2 | ADC2 channel 13, rank 2; recorded only | 0 to 3.3 V |
//! | head acceleration | PC2 | CN10-9, A7 | ADC2 channel 12, rank 3; recorded only | 0 to 3.3 V |
//! | PERMIT | PE9 | CN10-4, D6 | output | high: the actuator may move; pull it down outside |
//! | PERMIT pulse | PE14 | CN10-28, D38 | output | turns over in every step with PERMIT: for a relay that falls when the pulses stop |
//! | permit chain | PE15 | CN10-30, D37 | input with pull-down | high: the contact of what hangs on PERMIT is closed; without one, a bridge to PE9 |
//! | emergency stop | PE11 | CN10-6, D5 | input with pull-up | low: closed contact to ground; high: pressed, or a broken wire |
//! | step | PE13 | CN10-10, D3 | output | high from the interrupt's begin until the command is in the converter: for a scope |
//! | hold | PC13 | on the board | input | the blue button: high while pressed; holds a running test |
//! | LD1 green | PB0 | on the board | output | see `docs/wiring.md` |
//! | LD2 blue | PB7 | on the board | output | PERMIT |
//! | LD3 red | PB14 | on the board | output | fault |
//! | to the PC | PD8 | ST-LINK | USART3 TX, DMA1 stream 3 | 1 Mbit/s, 8N1 |
//! | from the PC | PD9 | ST-LINK | USART3 RX, DMA1 stream 1 | |
//! | clock | PH0 | ST-LINK | HSE bypass, 8 MHz | |
//! | nothing | PA12 | CN13 | held low: reading flash bank 2 needs it on chips before revision 3 | leave USB OTG unplugged |
//!
//! # Timers
//! | timer | does |
//! |---|---|
//! | TIM2 | the control period: its update starts the four injected conversions of ADC1 and the three of ADC2 |
//! | TIM4 | one pulse behind each update of TIM2: its compare hands the command to the DAC's output |
//! | TIM3 | embassy's time, 1 us, 16 bits |
//!
//! # One control period
//! ```text
//!  0 us      TIM2 update: conversions d f f d, 3.24 us each; both channels' mean instant is 6.5 us + half a sampling time
//!  12.95 us  end of conversion: the control interrupt, whose command goes into the DAC's holding register
//!  40 us     TIM4 compare: the DAC takes the command over
//! ```
//!
//! # Priorities
//! The control interrupt has priority 0, the highest. Everything else has less and is all that a critical section masks
//! ([`critical`]). So nothing that runs on this board delays the control interrupt, and it calls nothing that needs a
//! critical section: no embassy, no defmt.

use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::{bind_interrupts, dma, flash, interrupt, pac, peripherals, usart};

pub mod boot;
pub mod clocks;
pub mod control;
pub mod converters;
mod core_coupled;
mod critical;
pub mod drill;
pub mod fatal;
pub mod further_adc;
pub mod internal;
pub mod kept;
pub mod metal;
pub mod period;
mod stack_guard;
pub mod store;
pub mod tasks;

bind_interrupts!(
    /// Embassy's interrupts. The control interrupt is none of them.
    pub struct Irqs {
        USART3 => usart::InterruptHandler<peripherals::USART3>;
        DMA1_STREAM1 => dma::InterruptHandler<peripherals::DMA1_CH1>;
        DMA1_STREAM3 => dma::InterruptHandler<peripherals::DMA1_CH3>;
        FLASH => flash::InterruptHandler;
    }
);

/// Of everything but the control interrupt.
pub const BACKGROUND: Priority = Priority::P8;

/// Puts embassy's interrupts, whose default is the highest priority, below the control interrupt's.
pub fn lower_priorities() {
    interrupt::TIM3.set_priority(BACKGROUND);
    interrupt::USART3.set_priority(BACKGROUND);
    interrupt::DMA1_STREAM1.set_priority(BACKGROUND);
    interrupt::DMA1_STREAM3.set_priority(BACKGROUND);
    interrupt::FLASH.set_priority(BACKGROUND);
}

/// Watches the supply: below 2.9 V the program ends while it still can. It needs 2.7 V at 168 MHz, and the chip's own reset
/// waits for 1.8.
pub fn guard_supply() {
    pac::RCC.apb1enr().modify(|w| w.set_pwren(true));
    pac::PWR.cr1().modify(|w| {
        w.set_pls(SUPPLY_2_9_V);
        w.set_pvde(true);
    });
    // A supply that is low from the start makes no edge: nothing begins until it is there.
    while pac::PWR.csr1().read().pvdo() {}
    pac::EXTI.rtsr(0).modify(|w| w.set_line(SUPPLY_LINE, true));
    pac::EXTI.pr(0).write(|w| w.set_line(SUPPLY_LINE, true));
    pac::EXTI.imr(0).modify(|w| w.set_line(SUPPLY_LINE, true));
    interrupt::PVD.set_priority(Priority::P0);
    // SAFETY: its handler uses nothing that has to be put in place.
    unsafe { interrupt::PVD.enable() };
}

/// The supply's threshold, PLS = 111.
const SUPPLY_2_9_V: u8 = 7;

/// The supply's line among the external interrupts.
const SUPPLY_LINE: usize = 16;
