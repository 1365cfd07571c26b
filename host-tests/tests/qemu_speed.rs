//! Speed of the closed loop with QEMU. In a file of its own, so that no other test runs at the same time.
#![allow(missing_docs)]

use host_tests::qemu::bench::{self, emulated, rig, shaking};
use host_tests::qemu::image::image;
use host_tests::qemu::machine::{Clock, Test};
use host_tests::{Scenario, table1};
use outerloop_core::config::Filter;
use std::time::Instant;

#[test]
fn twenty_times_faster_than_real_time() {
    let Some(image) = image("qemu", "qemu") else {
        return;
    };
    let mut scenario = Scenario::delayed(table1(), 4.0);
    scenario.config.estimation.kind = Filter::Kalman;
    let shaking = shaking(20.0);
    let test = Test::new(&scenario.config, &shaking);
    let ticks = 40_000;
    let loop_s = f64::from(ticks) / scenario.config.timing.rate_hz;
    let mut best = 0.0_f64;
    // The best of several: other work on the machine slows a run down, nothing makes it faster.
    for _ in 0..8 {
        let begin = Instant::now();
        emulated::<1>(
            &image,
            Clock::Free,
            &test,
            ticks,
            &bench::plain,
            rig(&scenario, 1),
        )
        .unwrap();
        best = best.max(loop_s / begin.elapsed().as_secs_f64());
        if best >= 20.0 {
            break;
        }
    }
    println!("closed loop with QEMU: {best:.0} times faster than real time");
    assert!(best >= 20.0, "{best} times");
}
