//! The dearest step of a test with each method, for the cycle model.

use super::bench::{rig, told};
use super::cycles::{Code, Course};
use super::machine::Test;
use super::traced::traced;
use crate::{Scenario, Shaking, table1, whole_pipeline};
use outerloop_core::watch::Actions;
use outerloop_core::{Config, Event, Fault, Method, Mode};
use std::io::{Error, Result};
use std::path::Path;

/// Control periods from power-up on: idle, armed, then strong motion.
const PERIODS: u32 = 90;

/// Five metres a second squared from the first point on, so that predictors learn and dampings act after some steps.
fn shaking() -> Shaking {
    let point = |i: usize| (5.0 * (18.0 * i as f64 * 0.01).cos()) as f32;
    Shaking {
        acc_m_per_s2: (0..200).map(point).collect(),
        interval_s: 0.01,
    }
}

fn script(tick: u32, mode: Mode) -> (Option<Event>, Option<Fault>) {
    let event = match mode {
        Mode::Idle if tick >= 2 => Some(Event::Arm),
        Mode::Armed => Some(Event::Start),
        _ => None,
    };
    (event, None)
}

/// The whole pipeline on `N` storeys, the lowest `physical` of which stand in the laboratory and yield.
fn scenario<const N: usize>(method: Method, physical: u8) -> Scenario {
    let mut config = table1();
    if N > 1 {
        config = Config::shear_frame([1000.0; N], [797.3e3; N], [0.02; N]);
        config.structure.physical_storeys = Some(physical);
    }
    let mut scenario = whole_pipeline(Scenario::delayed(config, 4.0)).with(method);
    scenario.specimen = "kind = 'bilinear'\nyield_mm = 2.0\nhardening_ratio = 0.05".into();
    // What is measured has noise from the first step on.
    scenario.config.limits.increment_m = Some(1.0);
    scenario.config.limits.velocity_m_per_s = Some(100.0);
    scenario
}

/// The dearest of the steps in which an integration step was solved.
///
/// # Errors
/// The emulator or the image in it has gone.
///
/// # Panics
/// Where the trace has another number of steps than the test has control periods.
pub fn dearest<const N: usize>(image: &Path, code: &Code, method: Method) -> Result<Course> {
    of::<N>(image, code, &scenario::<N>(method, 1), None)
}

/// The same with an actuator at each storey; watched where the watch may do something.
///
/// # Errors
/// As [`dearest`].
///
/// # Panics
/// As [`dearest`].
pub fn dearest_watched<const N: usize>(
    image: &Path,
    code: &Code,
    method: Method,
    watched: Option<Actions>,
) -> Result<Course> {
    of::<N>(image, code, &scenario::<N>(method, N as u8), watched)
}

fn of<const N: usize>(
    image: &Path,
    code: &Code,
    scenario: &Scenario,
    watched: Option<Actions>,
) -> Result<Course> {
    let shaking = shaking();
    let about = (12.0, 0.05, 0.004);
    let watched = watched.map(|actions| told(&scenario.config, about, actions));
    let test = Test {
        watched: watched.as_deref().unwrap_or_default(),
        ..Test::new(&scenario.config, &shaking)
    };
    let method = scenario.config.compensation.kind;
    let courses = traced::<N>(image, code, &test, PERIODS, &script, rig(scenario, 1))?;
    assert!(courses.len() > 60, "{method}: {} solved", courses.len());
    let dearest = courses.into_iter().max_by_key(|c| c.cost.cycles);
    dearest.ok_or(Error::other("no step"))
}
