//! The image for the NUCLEO-F429ZI: start-up, then three tasks and the control interrupt.
//!
//! # Start
//! Nothing may move the actuator: the position is read, the DAC gets it before it is enabled, PERMIT is low, and the
//! sampling timer starts last.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod control;
#[cfg(target_os = "none")]
mod lights;
#[cfg(target_os = "none")]
mod listen;
#[cfg(target_os = "none")]
mod report;
#[cfg(target_os = "none")]
mod start;

/// The host has no such board.
#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("nucleo_f429zi is the board's image: build it with scripts/cross");
    std::process::exit(2);
}
