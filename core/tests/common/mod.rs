//! What the tests of the whole loop share: the structure of Table 1 and a specimen without sensors.
#![allow(missing_docs, dead_code)]

use outerloop_core::{Config, Design, Event, GroundMotion, Mode, OuterLoop, Pace, Sample, Step};

pub const STIFFNESS_N_PER_M: f64 = 158e3;

/// Table 1 of the paper.
pub fn table1() -> Config {
    Config::shear_frame([1000.0], [STIFFNESS_N_PER_M], [0.02])
}

/// A ground motion of a few strong sines.
pub fn shaking(seconds: f64) -> Vec<f32> {
    (0..(seconds / 0.01) as usize)
        .map(|i| {
            let t = i as f64 * 0.01;
            (3.0 * (11.0 * t).sin() * (0.7 * t).sin() + 2.0 * (4.0 * t).cos()) as f32
        })
        .collect()
}

/// One actuator that is some whole control steps late, and a linear spring.
pub struct Rig {
    line: Vec<f32>,
    delay: usize,
    pub sent: f32,
}

impl Rig {
    pub fn new(delay: usize) -> Self {
        Self {
            line: vec![0.0; delay + 1],
            delay,
            sent: 0.0,
        }
    }

    pub fn sample(&mut self) -> Sample<1> {
        self.line.rotate_right(1);
        self.line[0] = self.sent;
        let u = self.line[self.delay];
        Sample::new([u], [STIFFNESS_N_PER_M as f32 * u])
    }

    pub fn step<'a>(
        &mut self,
        outer: &'a mut OuterLoop<1>,
        ground: &GroundMotion<'_>,
    ) -> Step<'a, 1> {
        let sample = self.sample();
        let step = outer.step(&sample, ground);
        self.sent = step.command_m[0];
        step
    }
}

/// A loop that has been armed and started at rest.
pub fn started(config: &Config, rig: &mut Rig, ground: &GroundMotion<'_>) -> OuterLoop<1> {
    let mut outer = OuterLoop::new(Design::new(config).unwrap());
    rig.step(&mut outer, ground);
    outer.handle(Event::Arm).unwrap();
    rig.step(&mut outer, ground);
    assert_eq!(outer.handle(Event::Start), Ok(Mode::Running));
    outer
}

/// Points of a ground motion every 10 ms, at 2 kHz.
pub fn ground(points: &[f32]) -> GroundMotion<'_> {
    GroundMotion::new(points, 0.01, 5e-4).unwrap()
}

/// A loop that runs and stands at each target from outside.
pub fn stopping_and_going(config: &Config, rig: &mut Rig) -> OuterLoop<1> {
    let none = GroundMotion::none();
    let mut outer = OuterLoop::new(Design::new(config).unwrap());
    rig.step(&mut outer, &none);
    outer.set_pace(Some(Pace::StopAndGo));
    outer.handle(Event::Arm).unwrap();
    rig.step(&mut outer, &none);
    outer.handle(Event::Start).unwrap();
    outer
}
