//! What the start requires of a board: [`Board`].

use super::converters::Converters;
use super::metal::Pins;
use super::tasks::lights::Lamps;
use crate::board::this::Serial;
use embassy_stm32::peripherals::{FLASH, IWDG};
use embassy_stm32::{Peri, Peripherals};

/// A board with `A` actuators.
pub trait Board<const A: usize = 1> {
    /// What it samples and commands with.
    type Converters: Converters<A>;

    /// Its name with these converters, as the PC is told it.
    const NAME: &'static str;

    /// All that hangs on the chip: PERMIT is low, the lamps are dark, and nothing else has begun.
    fn wire(p: Peripherals) -> Wired<<Self::Converters as Converters<A>>::Parts>;
}

/// Which part of the chip does what.
pub struct Wired<P> {
    /// The pins of the control interrupt.
    pub pins: Pins,
    /// The lamps.
    pub lamps: Lamps,
    /// The port to the PC.
    pub serial: Serial,
    /// The flash, for what is saved.
    pub flash: Peri<'static, FLASH>,
    /// The watchdog.
    pub watchdog: Peri<'static, IWDG>,
    /// What the converters take.
    pub converters: P,
}
