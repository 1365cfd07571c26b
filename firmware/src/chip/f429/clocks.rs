//! 168 MHz from the ST-LINK's 8 MHz, and what happens if the latter is wrong.
//!
//! All rates of a test depend on the external clock. Before it is used it is compared with the chip's own 16 MHz (1 %),
//! both counted against a third clock: the time that the independent watchdog's 32 kHz takes to accept a new reload
//! value. A board whose external clock is missing or wrong runs from its own, answers the PC, and cannot be armed.

use cortex_m::peripheral::DWT;
use embassy_stm32::pac;
use embassy_stm32::pac::iwdg::vals::Key;
use embassy_stm32::rcc::{
    APBPrescaler, Hse, HseMode, LsConfig, Pll, PllMul, PllPDiv, PllPreDiv, PllSource, Sysclk,
};
use embassy_stm32::time::Hertz;

/// Processor clock, Hz.
pub const CORE_HZ: u32 = 168_000_000;

/// Clock of TIM2, TIM3 and TIM4, Hz.
pub const TIMER_HZ: u32 = CORE_HZ / 2;

/// The external clock, Hz.
const EXTERNAL_HZ: u32 = 8_000_000;

/// The chip's own clock, Hz.
const INTERNAL_HZ: u32 = 16_000_000;

/// Number of watchdog reloads counted; each takes at most five periods of its clock.
const RELOADS: u32 = 16;

/// Cycles after which a clock that does not answer is given up: 60 ms at the chip's own 16 MHz, before any change of
/// the clocks.
const TIMEOUT_CYCLES: u32 = INTERNAL_HZ / 1000 * 60;

/// Starts the watchdog with its reset time, some 0.5 s, and compares the external clock with the chip's own. The chip
/// must run on its own clock, as after a reset, and does so again afterwards.
pub fn external_clock_is_right() -> bool {
    pac::IWDG.kr().write(|w| w.set_key(Key::START));
    let rcc = pac::RCC;
    let own = reload_cycles();
    rcc.cr().modify(|w| w.set_hsebyp(true));
    rcc.cr().modify(|w| w.set_hseon(true));
    let there = wait_for(|| rcc.cr().read().hserdy());
    let mut external = None;
    if there {
        rcc.cfgr().modify(|w| w.set_sw(Sysclk::HSE));
        if wait_for(|| rcc.cfgr().read().sws() == Sysclk::HSE) {
            external = reload_cycles();
        }
        rcc.cfgr().modify(|w| w.set_sw(Sysclk::HSI));
        wait_for(|| rcc.cfgr().read().sws() == Sysclk::HSI);
    }
    rcc.cr().modify(|w| w.set_hseon(false));
    match (own, external) {
        // Within 5 %: the chip's own clock is good to 1 %, and the next usual frequency is far away.
        (Some(own), Some(external)) => {
            let expected = own / (INTERNAL_HZ / EXTERNAL_HZ);
            external.abs_diff(expected) < expected / 20
        }
        _ => false,
    }
}

/// Processor cycles that some watchdog reloads take.
fn reload_cycles() -> Option<u32> {
    // The first one starts anywhere in a period of the watchdog's clock and ends with the period.
    reload()?;
    let begin = DWT::cycle_count();
    for _ in 0..RELOADS {
        reload()?;
    }
    Some(DWT::cycle_count().wrapping_sub(begin))
}

fn reload() -> Option<()> {
    pac::IWDG.kr().write(|w| w.set_key(Key::ENABLE));
    pac::IWDG.rlr().write(|w| w.set_rl(0xfff));
    wait_for(|| !pac::IWDG.sr().read().rvu()).then_some(())
}

fn wait_for(condition: impl Fn() -> bool) -> bool {
    let begin = DWT::cycle_count();
    while !condition() {
        if DWT::cycle_count().wrapping_sub(begin) > TIMEOUT_CYCLES {
            return false;
        }
    }
    true
}

/// The clock tree: 168 MHz for the processor, 42 and 84 MHz for the peripherals, 84 MHz for the timers.
pub fn tree(external: bool) -> embassy_stm32::Config {
    let mut config = embassy_stm32::Config::default();
    config.dma_interrupt_priority = crate::chip::stm32::BACKGROUND;
    let rcc = &mut config.rcc;
    rcc.ls = LsConfig::off();
    if external {
        rcc.hse = Some(Hse {
            freq: Hertz(EXTERNAL_HZ),
            mode: HseMode::Bypass,
        });
        rcc.pll_src = PllSource::HSE;
    } else {
        rcc.pll_src = PllSource::HSI;
    }
    rcc.pll = Some(Pll {
        // 2 MHz into the PLL, 336 MHz out of it.
        prediv: if external {
            PllPreDiv::DIV4
        } else {
            PllPreDiv::DIV8
        },
        mul: PllMul::MUL168,
        divp: Some(PllPDiv::DIV2),
        divq: None,
        divr: None,
    });
    rcc.sys = Sysclk::PLL1_P;
    rcc.apb1_pre = APBPrescaler::DIV4;
    rcc.apb2_pre = APBPrescaler::DIV2;
    config
}

/// After embassy's start: the flash caches, which embassy leaves off, and the guard of the external clock, which raises
/// the NMI if that clock stops.
pub fn finish(external: bool) {
    pac::FLASH.acr().modify(|w| {
        w.set_icen(true);
        w.set_dcen(true);
        w.set_prften(true);
    });
    if external {
        pac::RCC.cr().modify(|w| w.set_csson(true));
    }
}
