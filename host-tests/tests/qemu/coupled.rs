//! The tracker of two coupled actuators on a Cortex-M4F: the same bits as on this machine, and the cost of a step.

#[path = "../../../firmware/examples/qemu_coupled/scenario.rs"]
mod scenario;

use host_tests::qemu::image::example;
use host_tests::qemu::machine::with_image;
use scenario::Scenario;
use std::process::Stdio;

fn on_this_machine() -> Scenario {
    let mut scenario = Scenario::new().unwrap();
    while let Some(input) = scenario.next_input() {
        let tracked = scenario.track(&input);
        scenario.take(&input, &tracked);
    }
    scenario
}

#[test]
fn a_plant_that_is_off_is_tracked_within_a_hundredth() {
    let scenario = on_this_machine();
    let (worst_m, peak_m) = (scenario.worst_error_m(), scenario.peak_m());
    assert!(worst_m < 0.01 * peak_m, "{worst_m} m of {peak_m} m");
}

#[test]
fn two_coupled_actuators_have_the_same_bits_in_qemu() {
    let Some(image) = example("qemu_coupled", "qemu") else {
        return;
    };
    let output = with_image(&image)
        .args(["-icount", "shift=3"])
        .stdin(Stdio::null())
        .output()
        .unwrap();
    assert!(output.status.success(), "{:?}", output.status);
    let bytes = &output.stdout;
    assert_eq!(bytes.len(), 24, "{bytes:?}");
    let hash = u64::from_le_bytes(bytes[..8].try_into().unwrap());
    let count = |i: usize| u32::from_le_bytes(bytes[8 + 4 * i..12 + 4 * i].try_into().unwrap());
    let instructions = |ticks: u32| (ticks - count(3)) * 1024 / count(2);
    println!("hash {hash:016x} in QEMU and here");
    println!(
        "a step of the tracker, 13 parameters estimated: {} instructions at worst, {} on average; state {} bytes",
        instructions(count(0)),
        instructions(count(1)),
        size_of::<outerloop_core::coupled::Tracker>(),
    );
    assert_eq!(hash, on_this_machine().hash());
    // 168 MHz, 1.8 cycles an instruction, 1024 samples a second: a tenth of the period is 9100 instructions.
    assert!(instructions(count(0)) < 9_100);
}
