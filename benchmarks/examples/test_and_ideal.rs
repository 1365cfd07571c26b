//! The cost of one test of a Monte Carlo: the test itself, and the ideal that it is compared with, once through the whole loop
//! and once by core's integration alone. Both ideals agree to the bit (a test in `core/src/ideal.rs` and an assertion here).
//!
//! `cargo run --release -p benchmarks --example test_and_ideal`. The ways run in turn, and the best of several runs counts for
//! each: other work can slow a run down, but nothing makes it faster.

use outerloop_core::{
    Config, Design, Event, GroundMotion, IdealTest, Method, Mode, OuterLoop, Sample,
};
use plant::actuator::ActuatorKind;
use plant::{Rig, RigSpec};
use std::time::Instant;

/// Short, so that a run fits between two interruptions.
const STEPS: usize = 20_000;
const RUNS: usize = 300;
const STIFFNESS_N_PER_M: f64 = 158e3;
/// Time of a control step of a test with its ideal in the first version, on an otherwise idle core, ns.
const FIRST_NS: f64 = 200.0;
/// How many times as fast it should become.
const ASKED: f64 = 4.0;

fn rig(kind: ActuatorKind) -> Rig {
    let mut spec = RigSpec::default();
    spec.actuator.kind = kind;
    if kind == ActuatorKind::Delay {
        spec.actuator.delay_ms = 4.0.into();
    }
    Rig::new(&spec, &[STIFFNESS_N_PER_M], 2000.0, 1).expect("a possible rig")
}

fn design(method: Method) -> Design<1> {
    let mut config = Config::shear_frame([1000.0], [STIFFNESS_N_PER_M], [0.02]);
    config.compensation.kind = method;
    Design::new(&config).expect("a possible test")
}

/// Runs a test through the whole loop; returns the sum of its commands.
fn whole(method: Method, kind: ActuatorKind, ground: &GroundMotion<'_>) -> f64 {
    let (mut outer, mut rig) = (OuterLoop::new(design(method)), rig(kind));
    let (mut sent_m, mut sum, mut done) = ([0.0; 1], 0.0, 0);
    while done < STEPS {
        let reading = rig.step(&sent_m);
        let sample = Sample::new(
            [reading.displacement_m[0] as f32],
            [reading.force_n[0] as f32],
        );
        let running = outer.mode() == Mode::Running;
        sent_m = outer.step(&sample, ground).command_m.map(f64::from);
        if running {
            sum += sent_m[0];
            done += 1;
        }
        match outer.mode() {
            Mode::Idle => drop(outer.handle(Event::Arm)),
            Mode::Armed => drop(outer.handle(Event::Start)),
            _ => {}
        }
    }
    sum
}

/// Runs the ideal by the integration alone.
fn alone(ground: &GroundMotion<'_>) -> f64 {
    let (mut test, mut rig) = (
        IdealTest::new(&design(Method::None)),
        rig(ActuatorKind::Ideal),
    );
    let mut sum = 0.0;
    for _ in 0..STEPS {
        let reading = rig.step(&test.command_m().map(f64::from));
        let force_n = [reading.force_n[0] as f32];
        test.step(force_n, ground);
        sum += f64::from(test.command_m()[0]);
    }
    sum
}

/// Runs the ideal on a linear spring, without a simulated rig.
fn on_a_spring(ground: &GroundMotion<'_>) -> f64 {
    let mut test = IdealTest::new(&design(Method::None));
    let mut sum = 0.0;
    for _ in 0..STEPS {
        let force_n = STIFFNESS_N_PER_M * f64::from(test.command_m()[0]);
        test.step([force_n as f32], ground);
        sum += f64::from(test.command_m()[0]);
    }
    sum
}

/// Runs the ideals of four tests on springs, step by step in turn: while one waits for a result, the others compute.
fn in_turn(ground: &GroundMotion<'_>) -> f64 {
    let design = design(Method::None);
    let mut tests: [IdealTest<1>; 4] = core::array::from_fn(|_| IdealTest::new(&design));
    let mut sum = 0.0;
    for _ in 0..STEPS / 4 {
        for test in &mut tests {
            let force_n = STIFFNESS_N_PER_M * f64::from(test.command_m()[0]);
            test.step([force_n as f32], ground);
        }
        sum += f64::from(tests[0].command_m()[0]);
    }
    sum
}

fn main() {
    let points: Vec<f32> = (0..STEPS / 20 + 2)
        .map(|i| 2.0 * (i as f32 * 0.07).sin() + (i as f32 * 0.31).sin())
        .collect();
    let ground = GroundMotion::new(&points, 0.01, 5e-4).expect("a possible record");
    let method = Method::from_name("tangent").expect("a method of core");
    let none = Method::None;
    let ways: [(&str, &dyn Fn() -> f64); 5] = [
        ("the test, `tangent` on a delay of 4 ms", &|| {
            whole(method, ActuatorKind::Delay, &ground)
        }),
        ("its ideal through the whole loop", &|| {
            whole(none, ActuatorKind::Ideal, &ground)
        }),
        ("its ideal by the integration alone", &|| alone(&ground)),
        ("the same on a spring", &|| on_a_spring(&ground)),
        ("four of them in turn", &|| in_turn(&ground)),
    ];
    let mut best_ns = [f64::INFINITY; 5];
    let mut sums = [0.0; 5];
    for _ in 0..RUNS {
        for (way, (_, run)) in ways.iter().enumerate() {
            let began = Instant::now();
            sums[way] = run();
            best_ns[way] = best_ns[way].min(began.elapsed().as_secs_f64() * 1e9 / STEPS as f64);
        }
    }
    assert_eq!(sums[1].to_bits(), sums[2].to_bits(), "the same ideal");
    assert_eq!(sums[2].to_bits(), sums[3].to_bits(), "the same spring");
    for ((name, _), ns) in ways.iter().zip(best_ns) {
        println!("{name:42} {ns:6.1} ns a control step");
    }
    let [through_the_loop, now] = [best_ns[0] + best_ns[1], best_ns[0] + best_ns[4]];
    println!(
        "a test with its ideal: {through_the_loop:.0} ns a control step with the ideal through the whole loop, {now:.0} as it is: \
         {:.1} million steps a second of a core",
        1e3 / now
    );
    let faster = FIRST_NS / now;
    let said = if faster >= ASKED {
        "reached".to_owned()
    } else {
        format!(
            "missed by a factor of {:.1}: the test itself takes {:.0} ns and is not run in lanes, since core's step branches by \
             what the loop is doing; with nothing beside it, it would be {:.1} times",
            ASKED / faster,
            best_ns[0],
            FIRST_NS / best_ns[0]
        )
    };
    println!(
        "at first {FIRST_NS:.0} ns: {faster:.1} times as fast, asked for {ASKED:.0} times: {said}"
    );
}
