//! Where a bit flips.

use crate::image::Firmware;
use crate::registers::{KEPT, MPU_CTRL, PWR_CR, TIM2_ARR, TIM2_CCR1, TIM2_CCR3};
use crate::registers::{RCC_AHB1ENR, RCC_APB1ENR, RCC_APB2ENR};
use rand_core::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;
use std::ops::Range;

/// What a bit belongs to. Each gets the same number of flips.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Target {
    /// A core register of the processor, or its status.
    Core,
    /// The stack in use.
    Stack,
    /// The running loop, its constants, and the control interrupt's own variables.
    Loop,
    /// Any variable: buffers, queues, the ground motion, what is kept through a reset.
    Variables,
    /// The image in the flash.
    Flash,
    /// A register of a peripheral, including the interrupt controller and the memory protection.
    Peripheral,
    /// A bit on its way from the input converter or to the output converter.
    Bus,
}

impl Target {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Core,
        Self::Stack,
        Self::Loop,
        Self::Variables,
        Self::Flash,
        Self::Peripheral,
        Self::Bus,
    ];

    /// Its name in a table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Core => "core registers",
            Self::Stack => "stack in use",
            Self::Loop => "state of the loop",
            Self::Variables => "any variable",
            Self::Flash => "flash words",
            Self::Peripheral => "peripherals' registers",
            Self::Bus => "codes on the bus",
        }
    }
}

/// A bit, and when it flips.
#[derive(Clone, Copy, Debug)]
pub struct Flip {
    /// ns since power-up.
    pub at_ns: u64,
    /// What it belongs to.
    pub target: Target,
    /// Which bit of it.
    pub place: Place,
}

/// Which bit.
#[derive(Clone, Copy, Debug)]
pub enum Place {
    /// A bit of a core register, by a number modulo the number of bits of all registers.
    Core(u32),
    /// A bit of the stack, by a number modulo the number of bits between the stack pointer and the top of the stack.
    Stack(u32),
    /// A bit of a byte of memory.
    Memory(u64, u32),
    /// A bit of a register of a peripheral.
    Peripheral(u64, u32),
    /// A bit of a register of the processor's own peripherals.
    System(u64, u32),
    /// A bit of the next frame from the input converter; 0 is the first on the line.
    Input(u32),
    /// A bit of the next command to the output converter; 0 is the last on the line.
    Output(u32),
}

/// Ranges of memory in which bits flip.
#[derive(Clone, Debug)]
pub struct Memory {
    loops: Vec<Range<u64>>,
    variables: Vec<Range<u64>>,
    flash: Vec<Range<u64>>,
    /// Where the stack begins.
    pub stack_top: u64,
}

impl Memory {
    /// The ranges of an image.
    ///
    /// # Errors
    /// A sentence: the image lacks a symbol.
    pub fn of(firmware: &Firmware) -> Result<Self, String> {
        let variables = firmware.symbol("__sdata")?..firmware.symbol("__euninit")?;
        Ok(Self {
            // The first test is placed in the spare slot.
            loops: vec![firmware.variable("5SPARE")?, firmware.variable("7CONTROL")?],
            variables: vec![variables],
            flash: firmware.stored(),
            stack_top: firmware.symbol("_stack_start")?,
        })
    }
}

/// Registers of peripherals that the emulator models, in addition to [`KEPT`]: clocks, the flash, serial port, its DMA,
/// embassy's timer, SPI3, the ports' outputs.
const FURTHER: [u64; 20] = [
    0x4002_3800, // RCC_CR
    0x4002_3804, // RCC_PLLCFGR
    0x4002_3808, // RCC_CFGR
    RCC_AHB1ENR,
    RCC_APB1ENR,
    RCC_APB2ENR,
    0x4002_3c00, // FLASH_ACR
    0x4000_4808, // USART3_BRR
    0x4000_480c, // USART3_CR1
    0x4000_4814, // USART3_CR3
    0x4002_6028, // DMA1_S1CR
    0x4002_6034, // DMA1_S1M0AR
    0x4002_6058, // DMA1_S3CR
    0x4000_040c, // TIM3_DIER
    0x4000_0428, // TIM3_PSC
    0x4000_3c04, // SPI3_CR2
    0x4002_0414, // GPIOB_ODR
    0x4002_0c14, // GPIOD_ODR
    0x4002_1014, // GPIOE_ODR
    0x4002_1414, // GPIOF_ODR
];

/// Of the processor: enabled interrupts and their priorities, vectors, coprocessor, lazy stacking, memory protection, faults.
const SYSTEM: [u64; 16] = [
    0xe000_e100,
    0xe000_e104,
    0xe000_e108,
    0xe000_e410,
    0xe000_e41c,
    0xe000_e424,
    0xe000_e400,
    0xe000_ed08,
    0xe000_ed10,
    0xe000_ed14,
    0xe000_ed20,
    0xe000_ed24,
    0xe000_ed88,
    MPU_CTRL,
    0xe000_ed9c,
    0xe000_ef34,
];

/// Number of bits of a register.
fn bits(register: u64) -> u32 {
    match register {
        // ARR and CCR of TIM2 have 32.
        TIM2_ARR | TIM2_CCR1 | TIM2_CCR3 => 32,
        0x4000_0000..0x4000_5000 | 0x4000_7400..0x4000_7800 | 0x4001_3000..0x4001_3400 => 16,
        PWR_CR => 16,
        0x4001_3c00..0x4001_4000 => 23,
        0x4002_0014..0x4002_2000 if register & 0x3ff == 0x14 => 16,
        _ => 32,
    }
}

fn below(rng: &mut Xoshiro256PlusPlus, count: u64) -> u64 {
    rng.next_u64() % count.max(1)
}

fn one_of<T: Copy>(rng: &mut Xoshiro256PlusPlus, all: &[T]) -> T {
    all[below(rng, all.len() as u64) as usize]
}

/// A bit of one of `ranges`, all equally likely.
fn memory(rng: &mut Xoshiro256PlusPlus, ranges: &[Range<u64>]) -> Place {
    let bytes = ranges.iter().map(|range| range.end - range.start).sum();
    let mut byte = below(rng, bytes);
    let mut address = 0;
    for range in ranges {
        let length = range.end - range.start;
        if byte < length {
            address = range.start + byte;
            break;
        }
        byte -= length;
    }
    Place::Memory(address, below(rng, 8) as u32)
}

impl Place {
    /// Draws a bit of `target`.
    pub fn draw(target: Target, from: &Memory, rng: &mut Xoshiro256PlusPlus) -> Self {
        match target {
            Target::Core => Self::Core(rng.next_u32()),
            Target::Stack => Self::Stack(rng.next_u32()),
            Target::Loop => memory(rng, &from.loops),
            Target::Variables => memory(rng, &from.variables),
            Target::Flash => memory(rng, &from.flash),
            Target::Peripheral => {
                let place = below(rng, (KEPT.len() + FURTHER.len() + SYSTEM.len()) as u64);
                let mut all = KEPT.iter().chain(&FURTHER);
                match all.nth(place as usize) {
                    Some(&register) => {
                        Self::Peripheral(register, below(rng, bits(register).into()) as u32)
                    }
                    None => Self::System(one_of(rng, &SYSTEM), below(rng, 32) as u32),
                }
            }
            Target::Bus => match below(rng, 2) {
                0 => Self::Input(below(rng, 6 * 16) as u32),
                _ => Self::Output(below(rng, 24) as u32),
            },
        }
    }
}
