//! The board: an STM32F429 to the extent that the image uses it, its clock, its supply and its serial line.

use crate::core_bits::CoreBits;
use crate::processor::with_flash;
use crate::wire::{BoardEnd, Wire};
use rigless::machine::armv7m::{Core, Fpu, MpuRegions, Variant};
use rigless::machine::{Board, Target};
use rigless::mcu::{Mcu, Operate};
use rigless::snapshot::Store;
use rigless::soc::Error;
use rigless::soc::stm32f427::Stm32f427;
use std::num::{NonZeroU32, NonZeroU64};

/// The ADC's reference in the emulator, "mV": ten a code, so that every code can be set exactly. Its highest code, 4095, is
/// the whole reference: with 4096 times ten every code above the middle was one too low, a step of 24 um and 5 N at zero
/// that a diagnosis took for an effect.
pub const REFERENCE: u32 = 10 * 4095;

/// USART3 in the chip's list.
const USART3: usize = 2;

/// The board's one MCU.
const MCU: &str = "stm32f429";

/// Instructions per second. On the chip an instruction of the control step takes 1.8 cycles of 168 MHz on average: its own,
/// and those of a flash with five wait states behind a cache of 64 lines, which is too small for the step.
pub const INSTRUCTIONS_PER_SECOND: u64 = 168_000_000 * 10 / 18;

/// The watchdog's typical clock, Hz; the data sheet gives 17 to 47 kHz.
pub const USUAL_LSI_HZ: u64 = 32_000;

/// The clock that the ST-LINK feeds in, Hz.
pub const RIGHT_CRYSTAL_HZ: u64 = 8_000_000;

/// The board's supply, mV.
pub const HEALTHY_MV: u32 = 3300;

/// A NUCLEO-F429ZI.
#[derive(Debug)]
pub struct Nucleo {
    /// The chip.
    pub chip: Stm32f427,
    /// Access to the processor's bits.
    core_bits: Option<CoreBits>,
}

impl Nucleo {
    /// A board with its power on, a clock of `crystal_hz` on its input, a slow clock of its own of `lsi_hz`, and `wire` on its
    /// serial port.
    ///
    /// # Errors
    /// The chip's description is inconsistent.
    pub fn new(crystal_hz: u64, lsi_hz: u64, wire: Wire) -> Result<Self, Error> {
        let mut chip = Stm32f427::new()?;
        chip.rcc.attach_crystals(crystal_hz, 0);
        chip.rcc.calibrate_lsi(lsi_hz);
        chip.set_supply(HEALTHY_MV);
        for converter in &mut chip.adc {
            converter.set_reference(REFERENCE);
        }
        chip.usart[USART3].attach(BoardEnd(wire));
        Ok(Self {
            chip,
            core_bits: None,
        })
    }

    /// Sets the supply, mV; 3300 on a healthy board.
    #[must_use]
    pub fn supplied(mut self, supply_mv: u32) -> Self {
        self.chip.set_supply(supply_mv);
        self
    }

    /// Adds access to the processor's bits.
    #[must_use]
    pub fn with_core_bits(mut self, bits: CoreBits) -> Self {
        self.core_bits = Some(bits);
        self
    }
}

// Snapshots are not taken.
impl Store for Nucleo {}

impl Board for Nucleo {
    fn name(&self) -> &'static str {
        "nucleo-f429zi"
    }

    fn target_names(&self) -> Vec<&'static str> {
        vec![MCU]
    }

    fn mcu(&mut self, target: usize) -> Option<&mut dyn Mcu> {
        (target == 0).then_some(&mut self.chip)
    }

    fn targets(&mut self) -> Vec<Target<'_>> {
        let lines = u32::from(Operate::cpu(&self.chip).interrupt_lines);
        let core = Core {
            variant: Variant::M4,
            clock_hz: const { NonZeroU64::new(168_000_000).unwrap() },
            interrupt_lines: NonZeroU32::new(lines).unwrap_or(NonZeroU32::MIN),
            priority_bits: 4,
            refclk_divider: const { NonZeroU32::new(8).unwrap() },
            instructions_per_second: const { NonZeroU64::new(INSTRUCTIONS_PER_SECOND).unwrap() },
            boot: "flash",
        };
        let windows = rigless::cpu::armv7m::windows(Mcu::bus(&self.chip));
        let spec = core.spec_with_parts(&windows, Fpu::FpV4Sp, MpuRegions::Eight);
        let spec = with_flash(spec, self.core_bits.clone());
        vec![Target::new(MCU, &mut self.chip, spec)]
    }
}
