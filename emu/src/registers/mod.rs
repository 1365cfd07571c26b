//! The registers that the analogue path and the guards depend on, as the image writes them, and what they must hold before
//! the first trigger: with the chip's own converters ([`internal`]), with external ones ([`external`]), for the inputs outside
//! the control path ([`beside`]), and always ([`GUARDS`]). By RM0090 rev 19; names are the manual's.
//!
//! The emulator has no DAC, no external interrupts and no trigger lines between timers and converters. What the image writes
//! into their registers is kept here, and the laboratory acts on it.

pub mod beside;
mod clocks;
pub mod external;
pub mod internal;

pub use clocks::ResetLine;
use std::collections::HashMap;

pub const TIM2_CR1: u64 = 0x4000_0000;
pub const TIM2_CR2: u64 = 0x4000_0004;
pub const TIM2_EGR: u64 = 0x4000_0014;
pub const TIM2_PSC: u64 = 0x4000_0028;
pub const TIM2_ARR: u64 = 0x4000_002c;
pub const TIM4_CR1: u64 = 0x4000_0800;
pub const TIM4_CR2: u64 = 0x4000_0804;
pub const TIM4_SMCR: u64 = 0x4000_0808;
pub const TIM4_CCMR1: u64 = 0x4000_0818;
pub const TIM4_CCR1: u64 = 0x4000_0834;
pub const PWR_CR: u64 = 0x4000_7000;
pub const DAC_CR: u64 = 0x4000_7400;
pub const DAC_DHR12R1: u64 = 0x4000_7408;
pub const ADC1_CR1: u64 = 0x4001_2004;
pub const ADC1_CR2: u64 = 0x4001_2008;
pub const ADC1_SMPR1: u64 = 0x4001_200c;
pub const ADC1_SMPR2: u64 = 0x4001_2010;
pub const ADC1_JSQR: u64 = 0x4001_2038;
pub const ADC2_CR1: u64 = 0x4001_2104;
pub const ADC2_CR2: u64 = 0x4001_2108;
pub const ADC2_SMPR1: u64 = 0x4001_210c;
pub const ADC2_SMPR2: u64 = 0x4001_2110;
pub const ADC2_JSQR: u64 = 0x4001_2138;
pub const ADC_CCR: u64 = 0x4001_2304;
pub const EXTI_IMR: u64 = 0x4001_3c00;
pub const EXTI_RTSR: u64 = 0x4001_3c08;
pub const RCC_AHB1ENR: u64 = 0x4002_3830;
pub const RCC_APB1ENR: u64 = 0x4002_3840;
pub const RCC_APB2ENR: u64 = 0x4002_3844;
pub const GPIOA_MODER: u64 = 0x4002_0000;
pub const GPIOC_MODER: u64 = 0x4002_0800;
pub const GPIOE_MODER: u64 = 0x4002_1000;
pub const GPIOE_PUPDR: u64 = 0x4002_100c;
pub const GPIOE_BSRR: u64 = 0x4002_1018;
pub const TIM2_DIER: u64 = 0x4000_000c;
pub const TIM2_CCMR2: u64 = 0x4000_001c;
pub const TIM2_CCER: u64 = 0x4000_0020;
pub const TIM2_CCR1: u64 = 0x4000_0034;
pub const TIM2_CCR3: u64 = 0x4000_003c;
pub const TIM4_CCER: u64 = 0x4000_0820;
pub const SPI3_CR1: u64 = 0x4000_3c00;
pub const SPI1_CR1: u64 = 0x4001_3000;
pub const GPIOA_AFRL: u64 = 0x4002_0020;
pub const GPIOB_MODER: u64 = 0x4002_0400;
pub const GPIOB_BSRR: u64 = 0x4002_0418;
pub const GPIOB_AFRH: u64 = 0x4002_0424;
pub const GPIOC_AFRH: u64 = 0x4002_0824;
pub const GPIOD_MODER: u64 = 0x4002_0c00;
pub const GPIOD_BSRR: u64 = 0x4002_0c18;
pub const GPIOD_AFRH: u64 = 0x4002_0c24;
pub const GPIOF_MODER: u64 = 0x4002_1400;
pub const GPIOF_BSRR: u64 = 0x4002_1418;
pub const DBGMCU_APB1_FZ: u64 = 0xe004_2008;
/// Of the processor, not kept: control of the memory protection.
pub(crate) const MPU_CTRL: u64 = 0xe000_ed94;

/// DBG_IWDG_STOP: the watchdog stops while a debugger halts the core.
const WATCHDOG_STANDS: u64 = 1 << 12;

/// Every register that is kept.
pub(crate) const KEPT: [u64; 45] = [
    ADC2_CR1,
    ADC2_CR2,
    ADC2_SMPR1,
    ADC2_SMPR2,
    ADC2_JSQR,
    TIM2_CR1,
    TIM2_CR2,
    TIM2_PSC,
    TIM2_ARR,
    TIM4_CR1,
    TIM4_CR2,
    TIM4_SMCR,
    TIM4_CCMR1,
    TIM4_CCR1,
    PWR_CR,
    DAC_CR,
    DAC_DHR12R1,
    ADC1_CR1,
    ADC1_CR2,
    ADC1_SMPR1,
    ADC1_SMPR2,
    ADC1_JSQR,
    ADC_CCR,
    EXTI_IMR,
    EXTI_RTSR,
    GPIOA_MODER,
    GPIOC_MODER,
    GPIOE_MODER,
    GPIOE_PUPDR,
    TIM2_DIER,
    TIM2_CCMR2,
    TIM2_CCER,
    TIM2_CCR1,
    TIM2_CCR3,
    TIM4_CCER,
    SPI1_CR1,
    SPI3_CR1,
    GPIOA_AFRL,
    GPIOB_MODER,
    GPIOB_AFRH,
    GPIOC_AFRH,
    GPIOD_MODER,
    GPIOD_AFRH,
    GPIOF_MODER,
    DBGMCU_APB1_FZ,
];

/// A field of a register, what it must hold, and what fails on the hardware otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Demand {
    /// Register and field.
    pub name: &'static str,
    /// The register.
    pub address: u64,
    /// The field.
    pub mask: u64,
    /// What it must hold.
    pub value: u64,
    /// What would fail.
    pub fails: &'static str,
}

const fn demand(
    name: &'static str,
    address: u64,
    mask: u64,
    value: u64,
    fails: &'static str,
) -> Demand {
    Demand {
        name,
        address,
        mask,
        value,
        fails,
    }
}

// The timers, for all converters: TIM2 samples, TIM4 loads the command.

const UPDATE_LEAVES: Demand = demand(
    "TIM2_CR2.MMS",
    TIM2_CR2,
    7 << 4,
    2 << 4,
    "the timer's update does not leave it",
);
const PRESCALER: Demand = demand(
    "TIM2_PSC",
    TIM2_PSC,
    0xffff,
    0,
    "the period is a multiple of what was asked for",
);

const FOLLOWS: Demand = demand(
    "TIM4_SMCR.TS",
    TIM4_SMCR,
    7 << 4,
    1 << 4,
    "TIM4 does not follow TIM2",
);

const STARTED: Demand = demand(
    "TIM4_SMCR.SMS",
    TIM4_SMCR,
    7,
    6,
    "TIM4 is not started by TIM2",
);

const ONE_PULSE: Demand = demand(
    "TIM4_CR1.OPM",
    TIM4_CR1,
    1 << 3,
    1 << 3,
    "TIM4 runs on: the command is shown at other instants",
);

const EDGE: Demand = demand(
    "TIM4_CCMR1.OC1M",
    TIM4_CCMR1,
    7 << 4,
    7 << 4,
    "TIM4's compare makes no edge: the command is not shown at its instant",
);

/// Without these a guard does not work; for all converters.
pub const GUARDS: [Demand; 9] = [
    demand(
        "GPIOE_MODER.PE9",
        GPIOE_MODER,
        3 << 18,
        1 << 18,
        "PERMIT drives nothing",
    ),
    demand(
        "GPIOE_MODER.PE14",
        GPIOE_MODER,
        3 << 28,
        1 << 28,
        "PERMIT's pulses drive nothing",
    ),
    demand(
        "GPIOE_MODER.PE11",
        GPIOE_MODER,
        3 << 22,
        0,
        "the emergency stop is not an input",
    ),
    demand(
        "GPIOE_PUPDR.PE11",
        GPIOE_PUPDR,
        3 << 22,
        1 << 22,
        "a broken wire of the emergency stop is not seen",
    ),
    demand(
        "GPIOE_PUPDR.PE15",
        GPIOE_PUPDR,
        3 << 30,
        2 << 30,
        "a broken wire of the permit chain's contact is not seen",
    ),
    demand(
        "PWR_CR.PLS and PVDE",
        PWR_CR,
        0xf << 4,
        0xf << 4,
        "the supply is not watched at 2.9 V",
    ),
    demand(
        "EXTI_RTSR.TR16",
        EXTI_RTSR,
        1 << 16,
        1 << 16,
        "a falling supply makes no edge",
    ),
    demand(
        "EXTI_IMR.MR16",
        EXTI_IMR,
        1 << 16,
        1 << 16,
        "a falling supply interrupts nobody",
    ),
    demand(
        "DBGMCU_APB1_FZ.DBG_IWDG_STOP",
        DBGMCU_APB1_FZ,
        WATCHDOG_STANDS,
        0,
        "PERMIT stays where a debugger has halted the core",
    ),
];

/// A demand that is not met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Violation {
    /// Which.
    pub demand: Demand,
    /// What the field holds.
    pub found: u64,
}

impl std::fmt::Display for Violation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Demand {
            name,
            mask,
            value,
            fails,
            ..
        } = self.demand;
        let shift = mask.trailing_zeros();
        let (found, value) = (self.found >> shift, value >> shift);
        write!(f, "{name} is {found}, not {value}: {fails}")
    }
}

/// Corrupts the image's writes to one register: the image with this register wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mutant {
    /// The register.
    pub address: u64,
    /// Bits that are cleared in every write to it.
    pub clear: u64,
    /// Bits that are set in it.
    pub set: u64,
}

impl Mutant {
    /// What `value`, written to `address`, becomes.
    pub fn of(&self, address: u64, value: u64) -> u64 {
        if address == self.address {
            value & !self.clear | self.set
        } else {
            value
        }
    }
}

/// The registers as written since the last reset.
#[derive(Clone, Debug, Default)]
pub struct Registers(HashMap<u64, u64>);

impl Registers {
    /// Writes a whole register; returns whether its peripheral has its clock and so accepts the write.
    pub fn write(&mut self, address: u64, value: u64) -> bool {
        for peripheral in clocks::put_back(address, value) {
            self.0.retain(|kept, _| !peripheral.contains(kept));
        }
        let takes = clocks::is_clocked(address, |enable| self.read(enable));
        if takes && (KEPT.contains(&address) || clocks::is_enable(address)) {
            self.0.insert(address, value);
        }
        takes
    }

    /// What the register holds. Reset values are zero except for the debug pins of ports A and B, and for what a debugger has
    /// left, which no reset clears.
    pub fn read(&self, address: u64) -> u64 {
        let at_reset = match address {
            GPIOA_MODER => 0xa800_0000,
            GPIOB_MODER => 0x280,
            DBGMCU_APB1_FZ => WATCHDOG_STANDS,
            _ => 0,
        };
        self.0.get(&address).copied().unwrap_or(at_reset)
    }

    /// Resets all registers.
    pub fn reset(&mut self) {
        self.0.clear();
    }

    /// The demands that are not met.
    pub fn violations<'a>(&'a self, demands: &'a [Demand]) -> impl Iterator<Item = Violation> + 'a {
        demands.iter().filter_map(|demand| {
            let found = self.read(demand.address) & demand.mask;
            (found != demand.value).then_some(Violation {
                demand: *demand,
                found,
            })
        })
    }

    /// Whether all demands of a list are met.
    pub fn meet(&self, demands: &[Demand]) -> bool {
        self.violations(demands).next().is_none()
    }
}
