//! Every compensation on a Cortex-M4F: the same bits as here, and its cost beyond the loop.

use host_tests::qemu::bench::{self, emulated, first_difference, here, rig, shaking};
use host_tests::qemu::image::image;
use host_tests::qemu::machine::{Clock, Test};
use host_tests::{Scenario, table1, whole_pipeline};
use outerloop_core::Method;
use outerloop_core::Prediction;
use std::path::Path;

/// Instructions that a method may add to a step.
const MOST: f64 = 400.0;

/// The paper's damping with a predictor is two methods.
const MOST_OF_TWO: f64 = 650.0;

/// Instructions that the estimation of four parameters may add: a model of fifth order, its sensitivities and recursive
/// least squares.
const MOST_OF_AN_ESTIMATE: f64 = 300.0;

/// Instructions that `name` may add to a step.
fn most(name: &str) -> f64 {
    let laws = if name.starts_with("paper+") {
        MOST_OF_TWO
    } else {
        MOST
    };
    if name.ends_with("hydraulic") {
        laws + MOST_OF_AN_ESTIMATE
    } else {
        laws
    }
}

/// The whole pipeline on a specimen that yields, so that tangents change and predictors learn.
fn base() -> Scenario {
    let mut scenario = whole_pipeline(Scenario::delayed(table1(), 4.0));
    scenario.specimen = "kind = 'bilinear'\nyield_mm = 20.0\nhardening_ratio = 0.05".into();
    scenario
}

/// A name and the test: every method, the paper's damping with every predictor, the tangent force without one.
fn variants() -> Vec<(String, Scenario)> {
    let alone = Method::ALL
        .into_iter()
        .map(|method| (method.name().to_owned(), base().with(method)));
    let behind = Prediction::ALL[1..].iter().map(|&predictor| {
        let method = Method::Paper.behind(predictor);
        (method.name().to_owned(), base().with(method))
    });
    let tangent = Method::Tangent.behind(Prediction::None);
    let last = (tangent.name().to_owned(), base().with(tangent));
    alone.chain(behind).chain([last]).collect()
}

/// Largest number of instructions of a control period, including copying sample and command. The test must run to its end:
/// the step that stops a test takes more, which is not due to the method.
fn worst_instructions(image: &Path, scenario: &Scenario) -> f64 {
    let mut scenario = scenario.clone();
    // The published gains of `amb` are for motions below 10 mm; in this one it would learn more and more of the noise.
    for gain in &mut scenario.config.compensation.amb.gains {
        *gain *= 1e-3;
    }
    let shaking = shaking(1.5);
    let test = Test::new(&scenario.config, &shaking);
    let rig = rig(&scenario, 1);
    let run = emulated::<1>(image, Clock::Counting, &test, 3200, &bench::plain, rig);
    let (records, summary) = run.expect("a test that runs");
    let last = records.last().map(|words| words[2]);
    let fault = last.map(|flags| flags >> 8 & 0xff);
    let name = scenario.config.compensation.kind.name();
    assert_eq!(fault, Some(0), "{name}: stopped by this fault");
    summary.instructions(f64::from(summary.worst_ticks))
}

#[test]
fn each_has_the_same_bits_here_and_there() {
    let Some(image) = image("qemu", "qemu") else {
        return;
    };
    let shaking = shaking(3.0);
    let mut hashes = Vec::new();
    for (name, scenario) in variants() {
        let test = Test::new(&scenario.config, &shaking);
        let ticks = 6400;
        let (here, hash, _) = here::<1>(&test, ticks, &bench::plain, rig(&scenario, 1)).unwrap();
        let rig = rig(&scenario, 1);
        let run = emulated::<1>(&image, Clock::Free, &test, ticks, &bench::plain, rig);
        let (there, summary) = run.unwrap();
        assert_eq!(
            first_difference(&here, &there),
            None,
            "{name}: control period and word of the record"
        );
        assert_eq!((summary.hash, summary.steps), (hash, ticks), "{name}");
        println!("{name:34} {hash:016x} in QEMU and here");
        hashes.push(hash);
    }
    // All records differ: a name that is not wired up would repeat another's.
    hashes.sort_unstable();
    let before = hashes.len();
    hashes.dedup();
    assert_eq!(hashes.len(), before);
}

#[test]
fn what_each_costs() {
    let Some(image) = image("qemu", "qemu") else {
        return;
    };
    let loop_alone = worst_instructions(&image, &base().with(Method::None));
    println!(
        "one degree of freedom, two-stage filter, every interlock      worst  beyond `none`   kHz at 168 MHz"
    );
    let mut dear = Vec::new();
    for (name, scenario) in variants() {
        let worst = worst_instructions(&image, &scenario);
        let beyond = worst - loop_alone;
        // Assumed: 1.25 cycles an instruction. Loads, taken branches and divisions take more than one.
        let highest_khz = 168e3 / (1.25 * worst);
        println!("{name:62} {worst:5.0} {beyond:8.0} {highest_khz:16.0}");
        if beyond > most(&name) {
            dear.push(name);
        }
    }
    assert_eq!(dear, Vec::<String>::new());
}
