//! A numerical part outside core gives the targets.
#![allow(missing_docs)]

mod common;

use common::{Rig, STIFFNESS_N_PER_M, shaking, stopping_and_going, table1};
use outerloop_core::{
    Config, Design, Event, Fault, GroundMotion, Method, Mode, OuterLoop, Pace, flag,
};

/// Ten control steps to an integration step of 5 ms, four of them extrapolated.
fn config(method: Method) -> Config {
    let mut config = table1();
    (config.timing.substeps, config.timing.solve_substeps) = (10, 4);
    config.compensation.kind = method;
    config.compensation.delay_ms = 4.0.into();
    config
}

/// The explicit Newmark integration of Table 1 in f64, written as a program outside would have it.
struct Outside {
    u: f64,
    v: f64,
    /// Acceleration of the last step; none before the first.
    a: Option<f64>,
    last: f64,
    dt: f64,
}

impl Outside {
    /// The next displacement, from the force at the last one.
    fn next(&mut self, force_n: f64, ground: f64) -> f64 {
        let (m, k) = (1000.0, STIFFNESS_N_PER_M);
        let c = 2.0 * 0.02 * (m * k).sqrt();
        let mean_v = (self.u - self.last) / self.dt;
        let a = (-m * ground - force_n - c * mean_v) / (m + 0.5 * self.dt * c);
        self.v += self.a.map_or(0.0, |last| 0.5 * self.dt * (last + a));
        self.a = Some(a);
        self.last = self.u;
        self.u += self.dt * self.v + 0.5 * self.dt * self.dt * a;
        self.u
    }
}

/// The targets of a test with the integration outside; an answer is given after `late(step)` control steps.
fn outside(
    config: &Config,
    points: &[f32],
    steps: usize,
    late: impl Fn(usize) -> usize,
) -> Result<(Vec<f32>, Vec<f32>), Fault> {
    let mut rig = Rig::new(8);
    let mut outer = OuterLoop::<1>::new(Design::new(config).unwrap());
    let none = GroundMotion::none();
    let ground = GroundMotion::new(points, 0.01, config.model_step_s()).unwrap();
    rig.step(&mut outer, &none);
    outer.set_pace(Some(Pace::Continuous));
    outer.handle(Event::Arm).unwrap();
    rig.step(&mut outer, &none);
    assert_eq!(outer.handle(Event::Start), Ok(Mode::Running));
    let mut model = Outside {
        u: 0.0,
        v: 0.0,
        a: None,
        last: 0.0,
        dt: config.model_step_s(),
    };
    let (mut targets, mut commands, mut due) = (Vec::new(), Vec::new(), None);
    while targets.len() < steps {
        if due == Some(0) {
            let at = ground.at(targets.len() as u32 - 1);
            let next = model.next(f64::from(outer.answer_n()[0]), f64::from(at));
            outer.set_next_target([next as f32]);
        }
        due = due.and_then(|d: usize| d.checked_sub(1));
        let record = *rig.step(&mut outer, &none).record;
        commands.push(record.command_m[0]);
        if let Some(trip) = outer.trip() {
            return Err(trip.fault);
        }
        if record.has(flag::SOLVED) {
            targets.push(record.command_m[0]);
            due = Some(late(targets.len()));
        }
    }
    Ok((targets, commands))
}

#[test]
fn the_same_integration_outside_gives_the_same_test() {
    let points = shaking(20.0);
    for method in [Method::None, Method::Paper] {
        let config = config(method);
        let ground = GroundMotion::new(&points, 0.01, config.model_step_s()).unwrap();
        let mut rig = Rig::new(8);
        let mut outer = common::started(&config, &mut rig, &ground);
        let mut inside = Vec::new();
        while inside.len() < 1000 {
            let record = *rig.step(&mut outer, &ground).record;
            if record.has(flag::SOLVED) {
                inside.push(record.command_m[0]);
            }
        }
        let (outside, _) = outside(&config, &points, 1000, |_| 1).unwrap();
        let peak = inside.iter().fold(0.0_f32, |p, u| p.max(u.abs()));
        let apart = inside.iter().zip(&outside).map(|(a, b)| (a - b).abs());
        let apart = apart.fold(0.0, f32::max) / peak;
        // f32 against f64; the added damping is implicit inside and a force outside: dt C_cor / 2 M, some 0.3 %.
        let bound = if method == Method::None { 2e-5 } else { 0.01 };
        assert!(apart < bound, "{method:?}: {apart}");
        assert!(
            peak > 0.01 && (method == Method::None || peak < 0.4),
            "{peak}"
        );
    }
}

#[test]
fn a_model_that_is_late_holds_the_actuator_and_costs_nothing_but_time() {
    let points = shaking(20.0);
    let config = config(Method::Paper);
    let punctual = outside(&config, &points, 400, |_| 1).unwrap();
    let sometimes = |step| if step % 50 == 49 { 150 } else { 1 };
    let late = outside(&config, &points, 400, sometimes).unwrap();
    let peak = punctual.0.iter().fold(0.0_f32, |p, u| p.max(u.abs()));
    let apart = |a: &[f32], b: &[f32]| {
        let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        apart.fold(0.0, f32::max)
    };
    assert!(
        late.1.len() > punctual.1.len() + 7 * 140,
        "it held and went on"
    );
    assert!(apart(&punctual.0, &late.0) < 0.1 * peak, "the same test");
    // No jump: the punctual command's own largest step is not passed by more than the way back within the interval.
    let largest = |c: &[f32]| {
        let steps = c.windows(2).map(|w| (w[1] - w[0]).abs());
        steps.fold(0.0, f32::max)
    };
    assert!(largest(&late.1) < 1.5 * largest(&punctual.1));
    // Beyond the limit it trips.
    let lost = outside(
        &config,
        &points,
        400,
        |step| if step == 90 { 300 } else { 1 },
    );
    assert_eq!(lost.unwrap_err(), Fault::TargetLate);
}

#[test]
fn stop_and_go_moves_at_the_set_speed_and_stands_at_each_target() {
    let mut config = table1();
    config.timing.approach_m_per_s = 0.02;
    let mut rig = Rig::new(8);
    let mut outer = stopping_and_going(&config, &mut rig);
    let none = GroundMotion::none();
    let mut before = 0.0;
    for target in [0.003_f32, -0.001, 0.0, 0.004] {
        outer.set_next_target([target]);
        for i in 0..1000 {
            let record = *rig.step(&mut outer, &none).record;
            let sent = rig.sent;
            assert!((sent - before).abs() < 1.001e-5, "20 mm/s is 10 um a step");
            assert_eq!(record.has(flag::SOLVED), i == 0, "counted when it is left");
            before = sent;
        }
        assert_eq!(rig.sent, target);
        assert_eq!(rig.sample().displacement_m, [target]);
    }
    // Standing for as long as it takes is no lateness, and a hold changes nothing.
    outer.handle(Event::Hold).unwrap();
    for _ in 0..100_000 {
        rig.step(&mut outer, &none);
    }
    assert_eq!(outer.handle(Event::Start), Ok(Mode::Returning));
    outer.set_next_target([0.001]);
    for _ in 0..1000 {
        rig.step(&mut outer, &none);
    }
    assert_eq!((outer.mode(), rig.sent), (Mode::Running, 0.001));
    outer.handle(Event::Stop).unwrap();
    assert_eq!(outer.mode(), Mode::Finished);
}
