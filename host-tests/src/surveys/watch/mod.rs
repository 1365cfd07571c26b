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
//! bilinear and Bouc-Wen specimens, one in four of those that yield degrading; 12 and 16 bits, noise of 0.01 to 0.5 % of the peak;
//! seven compensations; one in eight with two actuators.

mod draw;
mod effect;
mod rig;
mod table;
mod trial;

pub use effect::Kind;
pub use table::{Target, by_effect, targets, targets_of_any};
pub use trial::{FaultTrial, SoundTrial};

use experiment::failure::Failure;
use experiment::files::ground_motion::GroundMotionFile;
use rayon::prelude::*;

/// Seeds of tests in which something goes wrong are so far from those of sound ones, those with an effect of any kind twice as far.
const FAULTS_FROM: u64 = 1_000_000;
const ANY_FROM: u64 = 2 * FAULTS_FROM;
/// Of so many tests with an effect, one has two at once, and one is run under `ats` as well.
const TWO_IN: u64 = 10;
const ADAPTIVE_IN: u64 = 4;

/// True if something goes wrong in the test of a seed of the survey.
pub fn is_faulty(seed: u64) -> bool {
    seed >= FAULTS_FROM
}

/// Test file and ground motion of a seed, for whoever looks at one test; `faulty`: with its effect.
pub fn drawn(seed: u64, faulty: bool) -> (String, GroundMotionFile) {
    let rig = rig::DrawnRig::new(seed);
    let mut draw = draw::Draw::new(seed ^ 0xf0);
    let effect = faulty.then(|| match seed >= ANY_FROM {
        true => effect::DrawnEffect::any(&rig, &mut draw),
        false => effect::DrawnEffect::new(&rig, &mut draw),
    });
    let effect = effect.map_or(String::new(), |e| e.text);
    (format!("{}{effect}", rig.text), rig.shaking)
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
            let trial = SoundTrial::run(seed + i);
            one_done();
            trial
        })
        .collect()
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
            let (two, adaptive) = (i % TWO_IN == 0, i % ADAPTIVE_IN == 1);
            let trial = FaultTrial::run(seed + FAULTS_FROM + i, two, adaptive);
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
            let trial = FaultTrial::of_any_kind(seed + ANY_FROM + i);
            one_done();
            trial
        })
        .collect()
}
