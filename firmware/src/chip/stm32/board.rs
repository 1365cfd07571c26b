//! The start's requirements of a board: [`Board`].

use super::converters::Converters;
use super::metal::Pins;
use super::tasks::lights::Lamps;
use crate::board::this::Serial;
use embassy_stm32::peripherals::{FLASH, IWDG};
use embassy_stm32::{Peri, Peripherals};

/// A board with `A` actuators.
pub trait Board<const A: usize = 1> {
    /// The converters for its samples and commands.
    type Converters: Converters<A>;

    /// Its name with these converters, as reported to the PC.
    const NAME: &'static str;

    /// Everything connected to the chip: PERMIT is low, the lamps are dark, and nothing else has started.
    fn wire(p: Peripherals) -> Wired<<Self::Converters as Converters<A>>::Parts>;
}

/// Which part of the chip has which function.
pub struct Wired<P> {
    /// The pins of the control interrupt.
    pub pins: Pins,
    /// The lamps.
    pub lamps: Lamps,
    /// The port to the PC.
    pub serial: Serial,
    /// The flash, for saved data.
    pub flash: Peri<'static, FLASH>,
    /// The watchdog.
    pub watchdog: Peri<'static, IWDG>,
    /// The parts for the converters.
    pub converters: P,
}
