//! Steps per second on this machine: the integration alone, the closed loop, the closed loop with everything on.
//!
//! `cargo bench -p host-tests --bench closed_loop`. Each line is the best of several runs: other work slows a run
//! down, nothing makes it faster.
#![allow(missing_docs)]

use host_tests::qemu::bench::{rig, shaking};
use host_tests::{Scenario, table1, whole_pipeline};
use outerloop_core::{
    Coefficients, Design, Event, GroundMotion, Mode, Newmark, OuterLoop, Structure,
};
use std::hint::black_box;
use std::time::Instant;

const STEPS: usize = 2_000_000;
const RUNS: usize = 5;

/// Steps per second, the best of several runs of `STEPS`.
fn best(mut run: impl FnMut()) -> f64 {
    let rate = |_| {
        let begin = Instant::now();
        run();
        STEPS as f64 / begin.elapsed().as_secs_f64()
    };
    (0..RUNS).map(rate).fold(0.0, f64::max)
}

fn integration() {
    let structure = Structure {
        mass: [[1000.0]],
        damping: [[502.8]],
        stiffness: [[158e3]],
        numerical_stiffness: [[0.0]],
        influence: [1.0],
        physical: 1,
        physical_mass_kg: [0.0],
    };
    let k = Coefficients::new(&structure, 5e-4, 1.0).expect("a possible structure");
    let mut motion = Newmark::starting([1e-2], [0.0]);
    for _ in 0..STEPS {
        let force_n = [158e3 * motion.displacement_m()[0]];
        motion.advance(&k, &[0.0], &force_n, &[0.0]);
    }
    black_box(motion.displacement_m());
}

fn closed_loop(scenario: &Scenario) {
    let motion = shaking(STEPS as f64 / scenario.config.timing.rate_hz);
    let step_s = scenario.config.model_step_s();
    let ground = GroundMotion::new(&motion.acc_m_per_s2, motion.interval_s, step_s);
    let ground = ground.expect("a possible record");
    let design = Design::new(&scenario.config).expect("a possible test");
    let mut outer = OuterLoop::<1>::new(design);
    let mut rig = rig::<1>(scenario, 1);
    let mut command_m = [0.0];
    for tick in 0..STEPS {
        command_m = outer.step(&rig(&command_m), &ground).command_m;
        match outer.mode() {
            Mode::Idle if tick >= 200 => drop(outer.handle(Event::Arm)),
            Mode::Armed => drop(outer.handle(Event::Start)),
            _ => {}
        }
    }
    assert_eq!(outer.mode(), Mode::Running, "the whole loop was at work");
}

fn main() {
    let plain = Scenario::delayed(table1(), 4.0);
    let whole = whole_pipeline(plain.clone());
    let line = |name: &str, rate: f64| {
        println!("{name:66} {:7.2} million steps/s", rate * 1e-6);
    };
    line(
        "explicit Newmark alone, its specimen a product",
        best(integration),
    );
    line(
        "closed loop with plant: energies, Eq 20, interlocks, record",
        best(|| closed_loop(&plain)),
    );
    line(
        "the same with two-stage filter and noise on both sensors",
        best(|| closed_loop(&whole)),
    );
}
