//! The rig watch over tests not used for tuning: what it says of sound ones, and of tests with an effect.
//!
//! | file | what is there |
//! |---|---|
//! | `draw.rs`, `rig.rs` | a rig whose true values differ from the declared ones within tolerance, and a test on it |
//! | `effect.rs` | effects, from mid-test or from the start, and their accepted names |
//! | `trial.rs` | one test, and what is kept of it |
//! | `table.rs` | targets, results, and by how much they are missed |
//!
//! Sound rigs: 0.5 to 4 Hz, 5 to 100 mm, a delay of 3 to 30 ms, from a delay with a lag to a servo-hydraulic actuator; linear,
//! bilinear and Bouc-Wen specimens with up to 0.5 % of the structure's mass at their load cell, one in four of those that yield
//! degrading, one in three of the linear ones hardening, softening or degrading; 12 or 16 bits or no converters, noise of 0.01
//! to 0.5 % of the peak; sixteen compensations; one in eight with two actuators.

mod draw;
mod effect;
mod rig;
mod table;
mod trial;

pub use effect::Kind;
pub use table::{Target, by_effect, targets};
pub use trial::{FaultTrial, SoundTrial};

use crate::data;
use experiment::failure::Failure;
use experiment::files::ground_motion::GroundMotionFile;
use outerloop_core::Method;
use rayon::prelude::*;

/// Distance of the seeds of tests with an effect in mid-test from those of sound ones; the other lots are twice and three
/// times as far.
const FAULTS_FROM: u64 = 1_000_000;
const ANY_FROM: u64 = 2 * FAULTS_FROM;
const RECORDED_FROM: u64 = 3 * FAULTS_FROM;
/// One in this many tests with an effect has two at once.
const TWO_IN: u64 = 10;
/// One in four is also run with `ats`, and one in four with another adaptive method.
const ADAPTIVE_IN: u64 = 4;
const LEARN: [Method; 6] = [
    Method::AdaptiveInverse,
    Method::Afp,
    Method::Amb,
    Method::Darby,
    Method::Hydraulic,
    Method::Mcs,
];

/// The lots of tests of a survey.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Lot {
    /// Nothing goes wrong.
    Sound,
    /// Something goes wrong in mid-test.
    MidTest,
    /// An effect of any kind, from the start or in mid-test.
    AnyKind,
    /// Nothing goes wrong, and the ground moves as it was recorded.
    Recorded,
}

impl Lot {
    /// The seed of its test `i`, from 0, in the survey of `seed`.
    pub fn seed(self, seed: u64, i: u64) -> u64 {
        let from = match self {
            Self::Sound => 0,
            Self::MidTest => FAULTS_FROM,
            Self::AnyKind => ANY_FROM,
            Self::Recorded => RECORDED_FROM,
        };
        seed + from + i
    }

    /// Test file and ground motion of its test `i` in the survey of `seed`, to look at a single test; `None` if there is no
    /// recorded ground motion.
    pub fn test(self, seed: u64, i: u64) -> Option<(String, GroundMotionFile)> {
        let own = self.seed(seed, i);
        Some(match self {
            Self::Sound => trial::sound_test(own, None),
            Self::MidTest => trial::test_with(own, |rig, draw| in_mid_test(i, rig, draw)),
            Self::AnyKind => trial::test_with(own, of_any_effect),
            Self::Recorded => trial::sound_test(own, Some(of_turn(&data::recorded(), i)?)),
        })
    }
}

/// The motion of test `i`, taken in turn.
fn of_turn(motions: &[GroundMotionFile], i: u64) -> Option<&GroundMotionFile> {
    motions.get(i as usize % motions.len().max(1))
}

/// One effect in mid-test; two in one test of ten.
fn in_mid_test(i: u64, rig: &rig::DrawnRig, draw: &mut draw::Draw) -> Vec<effect::DrawnEffect> {
    let first = effect::DrawnEffect::new(rig, draw);
    let second = i
        .is_multiple_of(TWO_IN)
        .then(|| effect::DrawnEffect::new(rig, draw));
    let second = second.filter(|s| s.kind != first.kind);
    std::iter::once(first).chain(second).collect()
}

/// The adaptive compensation with which test `i` is run in addition to its own.
fn learns(i: u64) -> Option<Method> {
    match i % ADAPTIVE_IN {
        1 => Some(Method::Ats),
        3 => LEARN.get((i / ADAPTIVE_IN) as usize % LEARN.len()).copied(),
        _ => None,
    }
}

fn of_any_effect(rig: &rig::DrawnRig, draw: &mut draw::Draw) -> Vec<effect::DrawnEffect> {
    vec![effect::DrawnEffect::any(rig, draw)]
}

/// This many sound tests, starting at a seed. `one_done` is called after each.
///
/// # Errors
/// A test that cannot run.
pub fn sound(
    tests: u64,
    seed: u64,
    one_done: impl Fn() + Sync,
) -> Result<Vec<SoundTrial>, Failure> {
    (0..tests)
        .into_par_iter()
        .map(|i| {
            let trial = SoundTrial::run(Lot::Sound.seed(seed, i), None);
            one_done();
            trial
        })
        .collect()
}

/// This many sound tests with `motions` in turn; none if there are no motions.
///
/// # Errors
/// A test that cannot run.
pub fn recorded(
    tests: u64,
    seed: u64,
    motions: &[GroundMotionFile],
    one_done: impl Fn() + Sync,
) -> Result<Vec<SoundTrial>, Failure> {
    let trials = (0..tests).into_par_iter().map(|i| {
        one_done();
        let motion = of_turn(motions, i)?;
        Some(SoundTrial::run(Lot::Recorded.seed(seed, i), Some(motion)))
    });
    trials.flatten().collect()
}

/// This many tests with an effect in mid-test.
///
/// # Errors
/// A test that cannot run.
pub fn faulty(
    tests: u64,
    seed: u64,
    one_done: impl Fn() + Sync,
) -> Result<Vec<FaultTrial>, Failure> {
    (0..tests)
        .into_par_iter()
        .map(|i| {
            let own = Lot::MidTest.seed(seed, i);
            let effects = |rig: &_, draw: &mut _| in_mid_test(i, rig, draw);
            let trial = FaultTrial::run(own, effects, learns(i));
            one_done();
            trial
        })
        .collect()
}

/// This many tests with an effect of any kind, from the start or in mid-test.
///
/// # Errors
/// A test that cannot run.
pub fn of_any_kind(
    tests: u64,
    seed: u64,
    one_done: impl Fn() + Sync,
) -> Result<Vec<FaultTrial>, Failure> {
    (0..tests)
        .into_par_iter()
        .map(|i| {
            let trial = FaultTrial::run(Lot::AnyKind.seed(seed, i), of_any_effect, None);
            one_done();
            trial
        })
        .collect()
}
