//! The rig watch in QEMU does what it does here, bit for bit: what it names, what it orders, and how the loop responds.

use host_tests::Scenario;
use host_tests::qemu::bench::{
    self, Records, emulated, first_difference, here, rig, shaking, told,
};
use host_tests::qemu::image::image;
use host_tests::qemu::machine::{Clock, Test};
use outerloop_core::watch::{Actions, Cause, Corrections, State, Watch};
use outerloop_core::{Config, Method, Sample, flag};
use std::collections::VecDeque;

/// Control steps of 14 s; the fault comes after 8 s.
const STEPS: u32 = 28_000;
const FROM: usize = 16_000;

/// The structure of `examples/rig-watch.toml`: a period of 1 s, 2000 steps.
const PERIOD_STEPS: usize = 2000;
const OMEGA_RAD_PER_S: f64 = core::f64::consts::TAU;

/// The example's rig, with a pure delay of `LATE_S`.
const LATE_S: f64 = 0.014;
/// Noise of a frozen displacement, m, about as large as that of the sensor.
const NOISE_M: f32 = 3e-5;

fn scenario<const N: usize>(method: Method) -> Scenario {
    let mut config = Config::shear_frame([4000.0; N], [158e3; N], [0.03; N]);
    config.compensation.kind = method;
    config.compensation.delay_ms = (1e3 * LATE_S).into();
    let mut scenario = Scenario::delayed(config, 1e3 * LATE_S);
    scenario.sensors = "displacement_noise_mm = 0.02\nforce_noise_n = 6.0".into();
    scenario
}

/// A rig with a fault from [`FROM`].
fn spoilt<const N: usize>(
    mut rig: impl FnMut(&[f32; N]) -> Sample<N>,
    wrong: Wrong,
) -> impl FnMut(&[f32; N]) -> Sample<N> {
    let (mut sent, mut now) = (VecDeque::new(), 0);
    let (mut stands_m, mut noise) = ([0.0; N], 1_u32);
    move |command_m| {
        sent.push_front(*command_m);
        now += 1;
        let is_spoilt = now > FROM;
        let late = if is_spoilt { wrong.steps } else { 0 };
        let mut sample = rig(sent.get(late).unwrap_or(command_m));
        sent.truncate(wrong.steps + 1);
        match is_spoilt {
            false => stands_m = sample.displacement_m,
            true if wrong.stands => {
                noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let off_m = NOISE_M * ((noise >> 16) as f32 / 32_768.0 - 1.0);
                sample.displacement_m = stands_m.map(|m| m + off_m);
            }
            true => sample.displacement_m = sample.displacement_m.map(|m| wrong.gain * m),
        }
        sample
    }
}

/// The fault: actuators that are later by some steps, a displacement reading with a wrong gain, or one that freezes with its
/// noise.
#[derive(Clone, Copy)]
struct Wrong {
    steps: usize,
    gain: f32,
    stands: bool,
}

const NOTHING: Wrong = Wrong {
    steps: 0,
    gain: 1.0,
    stands: false,
};

const LATER: Wrong = Wrong {
    steps: 24,
    ..NOTHING
};

/// A test with a fault, and what the watch may do.
struct Case {
    method: Method,
    wrong: Wrong,
    /// Displacement at which the specimen yields, as a fraction of the planned peak.
    yields_at: Option<f64>,
    actions: Actions,
}

impl Case {
    fn new(method: &str, wrong: Wrong) -> Self {
        Self {
            method: Method::from_name(method).unwrap(),
            wrong,
            yields_at: None,
            actions: Actions::default(),
        }
    }
}

/// Runs it in QEMU and here, and compares every word of every record.
fn same<const N: usize>(case: &Case) -> Option<(Records, Vec<Watch>)> {
    let image = image("qemu", "qemu")?;
    let mut scenario = scenario::<N>(case.method);
    let shaking = shaking(14.0);
    let ideal = scenario.ideal::<N>(&shaking, 14.0);
    let targets = ideal
        .records
        .iter()
        .map(|r| f64::from(r.command_m[0].abs()));
    let peak_m = targets.fold(0.0, f64::max);
    if let Some(share) = case.yields_at {
        let yield_mm = 1e3 * share * peak_m;
        scenario.specimen =
            format!("kind = 'bilinear'\nyield_mm = {yield_mm}\nhardening_ratio = 0.1");
    }
    let watched = told(
        &scenario.config,
        (OMEGA_RAD_PER_S, peak_m, LATE_S),
        case.actions,
    );
    let test = Test {
        watched: &watched,
        ..Test::new(&scenario.config, &shaking)
    };
    let rig = || spoilt(rig::<N>(&scenario, 1), case.wrong);
    let (here, hash, watches) = here::<N>(&test, STEPS, &bench::plain, rig()).unwrap();
    let there = emulated::<N>(&image, Clock::Free, &test, STEPS, &bench::plain, rig());
    let (there, summary) = there.unwrap();
    assert_eq!(
        first_difference(&here, &there),
        None,
        "control period and word of the record"
    );
    assert_eq!((summary.hash, summary.steps), (hash, STEPS));
    println!("{N} actuators, {STEPS} control periods: hash {hash:016x} in QEMU and here");
    Some((here, watches))
}

fn flags(records: &Records) -> impl Iterator<Item = u32> {
    records.iter().map(|words| words[2])
}

/// The first control period in which the watch is in this state.
fn first_in(records: &Records, state: State) -> Option<usize> {
    flags(records).position(|flags| flags >> flag::WATCH_STATE_SHIFT & 3 == state as u32)
}

/// Control periods from the start of the fault to the first name.
fn named(records: &Records) -> usize {
    let first = first_in(records, State::Named).expect("something is named");
    println!("named {} control steps after it began", first - FROM);
    first - FROM
}

/// Rms of displacement minus target over the last 3 s, m, with one actuator.
fn error_m(records: &Records) -> f64 {
    let last = &records[records.len() - 6000..];
    let error = |words: &Vec<u32>| f64::from(f32::from_bits(words[6]) - f32::from_bits(words[4]));
    let sum: f64 = last.iter().map(|words| error(words).powi(2)).sum();
    (sum / last.len() as f64).sqrt()
}

#[test]
fn a_delay_that_jumps_is_named_and_corrected_with_the_same_bits() {
    let mut case = Case::new("inverse", LATER);
    let Some((plain, _)) = same::<1>(&case) else {
        return;
    };
    case.actions.correct = Corrections {
        lateness: true,
        ..Corrections::default()
    };
    let (corrected, watches) = same::<1>(&case).unwrap();
    for records in [&plain, &corrected] {
        assert!(named(records) < 2 * PERIOD_STEPS);
        assert!(flags(records).all(|f| f & flag::WATCH_LATE == 0));
    }
    let adjusted = |records| flags(records).filter(|f| f & flag::ADJUSTED != 0).count();
    assert!(adjusted(&plain) == 0 && adjusted(&corrected) > PERIOD_STEPS);
    let [watch] = &watches[..] else {
        panic!("{} watches", watches.len());
    };
    let late = watch.findings().find(|f| f.cause == Cause::ActuatorLate);
    let late_ms = late.expect("it is the actuator's lateness").value;
    let [before, after] = [&plain, &corrected].map(error_m);
    println!(
        "late by {late_ms:.2} ms; rms of displacement less target in the last 3 s: {:.3} mm, corrected {:.3} mm",
        1e3 * before,
        1e3 * after
    );
    assert!((late_ms - 12.0).abs() < 1.0 && after < 0.5 * before);
}

#[test]
fn a_transducer_that_lies_is_named_and_what_was_learnt_held_with_the_same_bits() {
    let lies = Wrong {
        gain: 1.08,
        ..NOTHING
    };
    let mut case = Case::new("ats", lies);
    case.actions.hold = true;
    let Some((records, watches)) = same::<1>(&case) else {
        return;
    };
    named(&records);
    let held = flags(&records).filter(|f| f & flag::GUARDED != 0).count();
    println!("held for {held} control steps");
    assert!(held > PERIOD_STEPS && watches[0].set().has(Cause::DisplacementGain));
}

#[test]
fn a_transducer_that_stands_with_its_noise_stops_the_test_with_the_same_bits() {
    let stands = Wrong {
        stands: true,
        ..NOTHING
    };
    let mut case = Case::new("inverse", stands);
    case.actions.trip = true;
    let Some((records, watches)) = same::<1>(&case) else {
        return;
    };
    let tripped = first_in(&records, State::Trip).expect("the watch stops it") - FROM;
    println!("stopped {tripped} control steps after it began");
    assert!(tripped < PERIOD_STEPS && watches[0].set().has(Cause::FrozenDisplacement));
}

#[test]
fn a_specimen_that_yields_though_declared_elastic_has_no_name_with_the_same_bits() {
    let mut case = Case::new("inverse", NOTHING);
    case.yields_at = Some(0.5);
    let Some((records, watches)) = same::<1>(&case) else {
        return;
    };
    assert_eq!(first_in(&records, State::Named), None);
    assert!(watches[0].set() == outerloop_core::watch::Set::EMPTY);
}

#[test]
fn three_actuators_are_watched_with_the_same_bits() {
    let case = Case::new("inverse", LATER);
    let Some((_, watches)) = same::<3>(&case) else {
        return;
    };
    let late = |watch: &Watch| watch.set().has(Cause::ActuatorLate);
    assert!(watches.len() == 3 && watches.iter().any(late));
}
