//! Cost of a step on a Cortex-M4F: instructions, state and stack.

use host_tests::qemu::bench::{self, emulated, rig, shaking};
use host_tests::qemu::cycles::Code;
use host_tests::qemu::image::image;
use host_tests::qemu::machine::{Clock, Test};
use host_tests::qemu::profile::{self, Counts, PARTS};
use host_tests::qemu::traced::traced;
use host_tests::{Scenario, table1, whole_pipeline};
use outerloop_core::Config;
use outerloop_core::{Design, OuterLoop};
use std::sync::OnceLock;

/// Two-stage filter, integration, three energy errors, Eq 20, every interlock, record.
fn single() -> Scenario {
    whole_pipeline(Scenario::delayed(table1(), 4.0))
}

fn three() -> Scenario {
    whole_pipeline(Scenario::delayed(
        Config::shear_frame([1000.0; 3], [797.3e3; 3], [0.02; 3]),
        4.0,
    ))
}

/// [`parts`] of one degree of freedom, traced once for all tests.
fn parts_of_one() -> Option<&'static [Counts]> {
    static TRACED: OnceLock<Option<Vec<Counts>>> = OnceLock::new();
    TRACED.get_or_init(|| parts::<1>(&single())).as_deref()
}

/// Instructions by part, of every control period in which an integration step was solved.
fn parts<const N: usize>(scenario: &Scenario) -> Option<Vec<Counts>> {
    let image = image("qemu", "qemu")?;
    let code = Code::new(&std::fs::read(&image).unwrap()).unwrap();
    let shaking = shaking(2.0);
    let test = Test::new(&scenario.config, &shaking);
    let rig = rig(scenario, 1);
    let steps = traced::<N>(&image, &code, &test, 2000, &bench::plain, rig).unwrap();
    Some(profile::parts(&image, &steps).unwrap())
}

/// Worst and mean of `of` over all steps.
fn worst_and_mean(steps: &[Counts], of: impl Fn(&Counts) -> u32) -> (u32, f64) {
    let counts: Vec<u32> = steps.iter().map(of).collect();
    let sum: u32 = counts.iter().sum();
    let worst = counts.iter().max().copied().unwrap_or(0);
    (worst, f64::from(sum) / counts.len() as f64)
}

fn print_parts(title: &str, steps: &[Counts]) -> u32 {
    println!("{title:26} worst   mean   (instructions)");
    for (i, part) in PARTS.iter().enumerate() {
        let (worst, mean) = worst_and_mean(steps, |counts| counts[i]);
        println!("  {part:24} {worst:5} {mean:6.0}");
    }
    let (worst, mean) = worst_and_mean(steps, |counts| counts.iter().sum());
    println!("  {:24} {worst:5} {mean:6.0}", "whole step");
    worst
}

#[test]
fn instructions_of_a_step() {
    let Some(one) = parts_of_one() else {
        return;
    };
    let three = parts::<3>(&three()).expect("the image is there");
    let worst = print_parts("one degree of freedom", one);
    let of_three = print_parts("three degrees of freedom", &three);
    assert!(one.len() > 1500, "{} steps were looked at", one.len());
    // As many as before there was a rig watch.
    assert!(worst <= 825, "{worst} instructions at worst");
    assert!(of_three <= 2569, "{of_three} instructions at worst");
}

/// A second way to count: the emulated clock advances with every instruction, and the image reads it.
#[test]
fn the_image_counts_the_same() {
    let Some(image) = image("qemu", "qemu") else {
        return;
    };
    let scenario = single();
    let shaking = shaking(2.0);
    let test = Test::new(&scenario.config, &shaking);
    let run = || {
        emulated::<1>(
            &image,
            Clock::Counting,
            &test,
            2000,
            &bench::plain,
            rig(&scenario, 1),
        )
    };
    let (_, summary) = run().unwrap();
    assert_eq!(run().unwrap().1, summary, "the count repeats");
    let counted = summary.instructions(f64::from(summary.worst_ticks));
    let traced = parts_of_one().expect("the image is there");
    let (worst, _) = worst_and_mean(traced, |counts| counts.iter().sum());
    println!(
        "worst step: {counted:.0} instructions by the clock of the image, {worst} by its trace"
    );
    // The image's own count includes copying sample and command.
    let copying = counted - f64::from(worst);
    assert!((0.0..=30.0).contains(&copying), "{counted} and {worst}");
}

#[test]
fn state_and_stack() {
    let Some(image) = image("qemu", "qemu") else {
        return;
    };
    fn of<const N: usize>(image: &std::path::Path, scenario: &Scenario) -> [u32; 3] {
        let shaking = shaking(2.0);
        let test = Test::new(&scenario.config, &shaking);
        let (_, summary) = emulated::<N>(
            image,
            Clock::Free,
            &test,
            2000,
            &bench::plain,
            rig(scenario, 1),
        )
        .unwrap();
        let (state, period) = (summary.state_bytes, summary.period_stack_bytes);
        println!(
            "{N} DOF: state {state} bytes, stack of a control period {period} bytes, of an event {} bytes",
            summary.event_stack_bytes
        );
        [state, period, summary.event_stack_bytes]
    }
    let [state, period, event] = of::<1>(&image, &single());
    // The aim was 4096; the eight blocks and eight orders between the loop and the rig watch take 500 more.
    assert!(state <= 4608);
    assert!(period <= 1024 && event <= 8192);
    let [_, period, event] = of::<3>(&image, &three());
    assert!(period <= 2048 && event <= 24_576);
    // Pointers are twice as wide here; there is no other difference.
    assert!(size_of::<OuterLoop<1>>() as u32 >= state);
    assert!(Design::<1>::new(&single().config).is_ok());
}
