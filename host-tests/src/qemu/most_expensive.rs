//! The most expensive step of a test with each method, for the cycle model.

use super::bench::{rig, told};
use super::cycles::{Code, Course};
use super::machine::Test;
use super::traced::{every, traced};
use crate::{Scenario, Shaking, table1, whole_pipeline};
use outerloop_core::watch::Actions;
use outerloop_core::{Config, Event, Fault, Method, Mode};
use std::io::{Error, Result};
use std::path::Path;

/// Control periods from power-up on: idle, armed, then strong motion.
const PERIODS: u32 = 90;

/// For the watch's instructions: first frequency, rad/s, peak, m, and the actuator's delay, s.
const ABOUT: (f64, f64, f64) = (12.0, 0.05, 0.004);

/// 5 m/s^2 from the first point, so that predictors learn and dampings act after some steps.
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

/// The whole pipeline on `N` storeys, the lowest `physical` of which are in the laboratory and yield.
fn scenario<const N: usize>(method: Method, physical: u8) -> Scenario {
    let mut config = table1();
    if N > 1 {
        config = Config::shear_frame([1000.0; N], [797.3e3; N], [0.02; N]);
        config.structure.physical_storeys = Some(physical);
    }
    let mut scenario = whole_pipeline(Scenario::delayed(config, 4.0)).with(method);
    scenario.specimen = "kind = 'bilinear'\nyield_mm = 2.0\nhardening_ratio = 0.05".into();
    // Measurements have noise from the first step.
    scenario.config.limits.increment_m = Some(1.0);
    scenario.config.limits.velocity_m_per_s = Some(100.0);
    scenario
}

/// The most expensive of the steps in which an integration step was solved.
///
/// # Errors
/// The emulator or the image in it has ended.
///
/// # Panics
/// The number of steps in the trace is not that of the control periods.
pub fn most_expensive<const N: usize>(image: &Path, code: &Code, method: Method) -> Result<Course> {
    of::<N>(image, code, &scenario::<N>(method, 1), None)
}

/// The same with an actuator at each storey; watched if the watch's actions are given.
///
/// # Errors
/// As [`most_expensive`].
///
/// # Panics
/// As [`most_expensive`].
pub fn most_expensive_watched<const N: usize>(
    image: &Path,
    code: &Code,
    method: Method,
    watched: Option<Actions>,
) -> Result<Course> {
    of::<N>(image, code, &scenario::<N>(method, N as u8), watched)
}

/// Control periods of a test in which a sensor freezes from [`STANDS_FROM`]: the watch learns the noise in the first second, and
/// stops the test soon after the freeze.
const PERIODS_OF_A_STOP: u32 = 4000;
const STANDS_FROM: u32 = 3000;

/// The most expensive run of `code` in a test in which the watch's orders change: it stops the test because a displacement is
/// frozen.
///
/// # Errors
/// As [`most_expensive`].
///
/// # Panics
/// As [`most_expensive`], or the watch does not stop the test.
pub fn most_expensive_stop<const N: usize>(image: &Path, code: &Code) -> Result<Course> {
    let mut scenario = scenario::<N>(Method::Paper, N as u8);
    // The force keeps changing while the displacement is frozen; that of a yielding specimen might not.
    scenario.specimen.clear();
    let limits = &mut scenario.config.limits;
    (limits.stale_steps, limits.tracking_m) = (Some(u16::MAX), Some(1.0));
    let actions = Actions {
        trip: true,
        ..Actions::default()
    };
    let watched = told(&scenario.config, ABOUT, actions);
    let shaking = shaking();
    let test = Test {
        watched: &watched,
        ..Test::new(&scenario.config, &shaking)
    };
    let (mut sound, mut period, mut stands_m) = (rig(&scenario, 1), 0_u32, [0.0; N]);
    let rig = |command_m: &[f32; N]| {
        let mut sample = sound(command_m);
        period += 1;
        if period == STANDS_FROM {
            stands_m = sample.displacement_m;
        } else if period > STANDS_FROM {
            // It keeps its noise, because a reading that is frozen to the bit is not integrated.
            let noise_m = 2e-5 * ((period % 3) as f32 - 1.0);
            sample.displacement_m = stands_m.map(|m| m + noise_m);
        }
        sample
    };
    let (courses, records) = every::<N>(image, code, &test, PERIODS_OF_A_STOP, &script, rig)?;
    let fault = records.last().map(|words| words[2] >> 8 & 0xff);
    assert_eq!(fault, Some(u32::from(Fault::Watch.code())), "the fault");
    let most_expensive = courses.into_iter().max_by_key(|c| c.cost.cycles);
    most_expensive.ok_or(Error::other("no period"))
}

fn of<const N: usize>(
    image: &Path,
    code: &Code,
    scenario: &Scenario,
    watched: Option<Actions>,
) -> Result<Course> {
    let shaking = shaking();
    let watched = watched.map(|actions| told(&scenario.config, ABOUT, actions));
    let test = Test {
        watched: watched.as_deref().unwrap_or_default(),
        ..Test::new(&scenario.config, &shaking)
    };
    let method = scenario.config.compensation.kind;
    let courses = traced::<N>(image, code, &test, PERIODS, &script, rig(scenario, 1))?;
    assert!(courses.len() > 60, "{method}: {} solved", courses.len());
    let most_expensive = courses.into_iter().max_by_key(|c| c.cost.cycles);
    most_expensive.ok_or(Error::other("no step"))
}
