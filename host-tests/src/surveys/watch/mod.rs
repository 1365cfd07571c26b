//! The rig watch over tests that no tuning has seen: what it says of sound ones, and of such in which something goes wrong.
//!
//! | file | what is there |
//! |---|---|
//! | `draw.rs`, `rig.rs` | a rig with every declared value off inside its tolerance, and a test on it |
//! | `effect.rs` | what goes wrong in mid-test, and what it may be called |
//! | `trial.rs` | one test, and what is kept of it |
//! | `table.rs` | what was aimed at, what was found, and by how much it is missed |
//!
//! Sound rigs: 0.5 to 4 Hz, 5 to 100 mm, 3 to 30 ms of lateness, from a delay with a lag to a servo-hydraulic actuator; linear,
//! bilinear and Bouc-Wen specimens with up to 2 % of the structure's mass at their load cell, one in four of those that yield degrading, one in three of the linear ones hardening, softening or
//! degrading; 12 and 16 bits, noise of 0.01 to 0.5 % of the peak;
//! sixteen compensations; one in eight with two actuators.

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

/// Seeds of tests in which something goes wrong are so far from those of sound ones, those with an effect of any kind twice as far.
const FAULTS_FROM: u64 = 1_000_000;
const ANY_FROM: u64 = 2 * FAULTS_FROM;
const RECORDED_FROM: u64 = 3 * FAULTS_FROM;
/// Of so many tests with an effect, one has two at once.
const TWO_IN: u64 = 10;
/// One in four is run under `ats` as well, and one in four under one of the others that learn.
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

    /// Test file and ground motion of its test `i` in the survey of `seed`, for whoever looks at one test; none where there is no
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

/// The motion of test `i`, each in its turn.
fn of_turn(motions: &[GroundMotionFile], i: u64) -> Option<&GroundMotionFile> {
    motions.get(i as usize % motions.len().max(1))
}

/// One effect in mid-test; in one test of ten two.
fn in_mid_test(i: u64, rig: &rig::DrawnRig, draw: &mut draw::Draw) -> Vec<effect::DrawnEffect> {
    let first = effect::DrawnEffect::new(rig, draw);
    let second = i
        .is_multiple_of(TWO_IN)
        .then(|| effect::DrawnEffect::new(rig, draw));
    let second = second.filter(|s| s.kind != first.kind);
    std::iter::once(first).chain(second).collect()
}

/// Under which compensation that learns test `i` is run beside its own.
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

/// So many sound tests from a seed on. `one_done` is called after each.
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

/// So many sound tests under `motions` in turn; none where there are none.
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

/// So many tests in which something goes wrong.
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

/// So many tests with an effect of any kind, from the start or in mid-test.
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
