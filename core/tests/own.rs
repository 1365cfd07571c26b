//! A predictor and a force law that a program brings itself go through the same loop as those of the list.
#![cfg(feature = "own-methods")]
#![allow(missing_docs)]

mod common;

use common::{Rig, shaking, started, table1};
use outerloop_core::config::{Compensation, Timing};
use outerloop_core::own::{AlreadyRegistered, OwnMethods, Pod, Zeroable};
use outerloop_core::{
    ActuatorContext, AxisLaw, AxisOutput, AxisStep, Config, Design, GroundMotion, LastCommand,
    Method, PredictAxis, Refusal, TargetMotion,
};

/// A share of the delay ahead, and how often it was asked.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Lead {
    asked: f32,
}

impl PredictAxis for Lead {
    type Constants = f32;

    fn check(c: &Compensation, _: &Timing) -> Result<(), Refusal> {
        let share = c.own.first().copied().unwrap_or(f64::NAN);
        outerloop_core::accept("compensation.own", share, share <= 2.0, "one, at most 2")
    }

    fn design(context: &ActuatorContext<'_>) -> f32 {
        (context.parameters.own[0] * context.delay_steps()) as f32
    }

    fn at_rest(_: &f32) -> Self {
        Self { asked: 0.0 }
    }

    fn command(&mut self, steps: &f32, _: &LastCommand, ahead: &TargetMotion) -> f32 {
        self.asked += 1.0;
        // From its second step on: the memory is kept.
        ahead.after(if self.asked > 1.0 { *steps } else { 0.0 })
    }
}

/// The measured force and a constant damping.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Damped;

impl AxisLaw for Damped {
    type Constants = f32;

    fn design(context: &ActuatorContext<'_>) -> f32 {
        context.parameters.own.get(1).map_or(0.0, |&c| c as f32)
    }

    fn at_rest(_: &f32) -> Self {
        Self
    }

    fn act(&mut self, damping: &f32, reached: &AxisStep) -> AxisOutput {
        AxisOutput {
            force_n: reached.force_n,
            damping_n_s_per_m: *damping,
        }
    }
}

static METHODS: OwnMethods = OwnMethods::NONE
    .with_predictor::<Lead>()
    .with_force::<Damped>();

fn config(kind: &str, own: &[f64]) -> Config {
    let mut config = table1();
    config.compensation.kind = Method::from_name(kind).unwrap();
    config.compensation.own = own.iter().copied().collect();
    config
}

/// The hash of all records of a test on an actuator 8 steps late, and its largest displacement, m.
fn run(config: &Config) -> (u64, f32) {
    run_late(config, 8)
}

fn run_late(config: &Config, steps: usize) -> (u64, f32) {
    let points = shaking(4.0);
    let ground = GroundMotion::new(&points, 0.01, config.model_step_s()).unwrap();
    let mut rig = Rig::new(steps);
    let mut outer = started(config, &mut rig, &ground);
    let (mut hash, mut peak_m) = (0, 0.0_f32);
    for _ in 0..7000 {
        let record = rig.step(&mut outer, &ground).record;
        hash = record.hash(hash);
        peak_m = peak_m.max(record.command_m[0].abs());
    }
    (hash, peak_m)
}

// One test: what a program brings it brings once.
#[test]
fn what_a_program_brings_goes_through_the_loop_as_any_method_does() {
    let refused = |config: &Config| Design::<1>::new(config).err().unwrap().to_string();
    for kind in ["own", "own-force"] {
        let said = refused(&config(kind, &[1.0]));
        assert!(said.contains("brings none of its own"), "{said}");
    }
    METHODS.register().unwrap();
    static OTHERS: OwnMethods = OwnMethods::NONE;
    assert_eq!(OTHERS.register(), Err(AlreadyRegistered));

    assert!(refused(&config("own", &[3.0])).contains("at most 2"));
    assert!(refused(&config("own", &[f64::NAN])).contains("compensation.own"));

    // What does nothing leaves every bit as it is.
    let (none, none_m) = run(&config("none", &[]));
    assert_eq!(run(&config("own", &[0.0])).0, none);
    assert_eq!(run(&config("own-force", &[])).0, none);
    assert_eq!(run(&config("own-force+own", &[0.0])).0, none);

    // A whole delay ahead, the motion is nearly that of an actuator without one, which it was not.
    let ideal_m = run_late(&config("none", &[]), 0).1;
    let led_m = run(&config("own", &[1.0])).1;
    let off = |m: f32| (m - ideal_m).abs() / ideal_m;
    assert!(
        off(led_m) < 0.02 && off(none_m) > 0.1,
        "{led_m} m, {none_m} m of {ideal_m} m"
    );
    // A damping takes from it.
    let damped_m = run(&config("own-force+own", &[1.0, 2000.0])).1;
    assert!(damped_m < 0.9 * led_m, "{damped_m} m of {led_m} m");
    assert_ne!(run(&config("paper+own", &[1.0])).0, none);
}
