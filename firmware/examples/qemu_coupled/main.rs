//! The scenario beside this file in QEMU: writes its hash and what a step of the tracker took to the standard output.
//!
//! 24 bytes, little endian: hash (8), worst ticks of a step, mean ticks, ticks of 1024 instructions, ticks of a measurement
//! of nothing (4 each). Exit status: 0, 1 the scenario was refused or the host took nothing, 2 panic, 3 fault.

#![no_std]
#![no_main]

#[allow(dead_code, reason = "the test on the host asks for more of it")]
mod scenario;

use cortex_m::Peripherals;
use firmware::board::qemu::{File, HostGone, Mode, SysTick, exit};
use scenario::{SAMPLES, Scenario};

#[cortex_m_rt::entry]
fn main() -> ! {
    exit(match run() {
        Ok(()) => 0,
        Err(HostGone) => 1,
    })
}

fn run() -> Result<(), HostGone> {
    let watch = SysTick::start(Peripherals::take().ok_or(HostGone)?.SYST);
    let (per_1024, overhead) = watch.ticks_per_1024_instructions();
    let mut scenario = Scenario::new().map_err(|_| HostGone)?;
    let (mut worst, mut total) = (0, 0);
    while let Some(input) = scenario.next_input() {
        let begin = watch.now();
        let tracked = scenario.track(&input);
        let ticks = SysTick::between(begin, watch.now());
        worst = ticks.max(worst);
        total += ticks;
        scenario.take(&input, &tracked);
    }
    let mut out = [0; 24];
    let (hash, counts) = out.split_at_mut(8);
    hash.copy_from_slice(&scenario.hash().to_le_bytes());
    let all = [worst, total / SAMPLES, per_1024, overhead];
    for (place, count) in counts.chunks_exact_mut(4).zip(all) {
        place.copy_from_slice(&count.to_le_bytes());
    }
    File::open(c":tt", Mode::Write)?.write(&out)
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    exit(2)
}

#[cortex_m_rt::exception]
unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
    exit(3)
}
