//! The image in QEMU has the same bits as the loop on this machine. `LAB_QEMU` names it.

use host_tests::qemu::bench::{self, emulated, first_difference, here, rig};
use host_tests::qemu::machine::{Clock, Test};
use host_tests::{Scenario, table1};
use outerloop_core::Method;

#[test]
fn our_method_has_the_same_bits_in_qemu() {
    lab::METHODS.register().unwrap();
    let Some(image) = std::env::var_os("LAB_QEMU") else {
        println!("not run: LAB_QEMU names no image");
        return;
    };
    let mut config = table1();
    config.compensation.kind = Method::from_name("paper+own").unwrap();
    config.compensation.own = [0.8].into_iter().collect();
    let scenario = Scenario::delayed(config, 4.0);
    let shaking = bench::shaking(3.0);
    let test = Test::new(&scenario.config, &shaking);
    let (here, hash, _) = here::<1>(&test, 6400, &bench::plain, rig(&scenario, 1)).unwrap();
    let there = emulated::<1>(
        image.as_ref(),
        Clock::Free,
        &test,
        6400,
        &bench::plain,
        rig(&scenario, 1),
    );
    let (there, account) = there.unwrap();
    assert_eq!(
        first_difference(&here, &there),
        None,
        "control period and word of the record"
    );
    assert_eq!(account.hash, hash);
    println!("{hash:016x} in QEMU and here");
}
