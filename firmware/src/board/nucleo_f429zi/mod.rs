//! The NUCLEO-F429ZI (MB1137): every pin that an image uses, and what is connected to it.
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
//! | PERMIT pulse | PE14 | CN10-28, D38 | output | toggles in every step with PERMIT: for a relay that needs pulses |
//! | permit chain | PE15 | CN10-30, D37 | input with pull-down | high: chain closed; if there is none, bridge to PE9 |
//! | emergency stop | PE11 | CN10-6, D5 | input with pull-up | low: closed contact to ground; high: pressed, or a broken wire |
//! | step | PE13 | CN10-10, D3 | output | for a scope: high from interrupt entry until the command is written |
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
//! | timer | function |
//! |---|---|
//! | TIM2 | the control period: its update starts the four injected conversions of ADC1 and the three of ADC2 |
//! | TIM4 | one pulse after each update of TIM2: its compare hands the command to the DAC's output |
//! | TIM3 | embassy's time, 1 us, 16 bits |
//!
//! # One control period
//! ```text
//!  0 us      TIM2 update: conversions d f f d, 3.24 us each; both channels' mean instant is 6.5 us + half a sampling time
//!  12.95 us  end of conversion: the control interrupt, whose command goes into the DAC's holding register
//!  40 us     TIM4 compare: the DAC takes the command over
//! ```

mod external;
mod external_three;
mod internal;
mod wiring;

pub use external::WithExternal;
pub use external_three::WithExternalThree;
pub use internal::{CODES, Internal, WithInternal};
pub use wiring::{Irqs, PERMIT_REGISTER, PERMIT_RESET, Serial, fault_lamp_on, lower_priorities};
