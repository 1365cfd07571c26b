//! Whether a test of two coupled actuators can be stopped at its fastest.
//!
//! A ramp to a standstill begins with a jump in the target's acceleration, which the inverse of slow actuators turns
//! into a pulse. It may demand more speed of an actuator than its limit, and the stop becomes a trip. In other tests
//! the ramp's target itself is sent.

use super::part::CoupledPart;
use crate::bench::STANDS_STEPS;
use crate::experiment::Experiment;
use crate::failure::Failure;
use crate::numbers::three;
use crate::trace::{AnyRecord, Response, TestObserver};
use outerloop_core::{Event, Mode};

/// Gentler ramps to try, as fractions of the declared deceleration.
const GENTLER: [f64; 6] = [0.5, 0.2, 0.1, 0.05, 0.02, 0.01];

/// Holds a test once after this number of control steps, and stops it when it is at rest.
#[derive(Default)]
struct HeldOnce {
    after_steps: usize,
    done: usize,
    asked: bool,
    target: [f32; 2],
    stood: usize,
}

impl TestObserver for HeldOnce {
    fn on_step(&mut self, _: &AnyRecord<'_>) {
        self.done += 1;
    }

    fn on_idle_step(&mut self, record: &AnyRecord<'_>) {
        if record.mode() != Some(Mode::Holding) {
            return;
        }
        let target = [0, 1].map(|i| record.command_m[i]);
        self.stood = match target == self.target {
            true => self.stood + 1,
            false => 0,
        };
        self.target = target;
    }

    fn requested_event(&mut self) -> Option<Event> {
        if self.stood >= STANDS_STEPS {
            return Some(Event::Stop);
        }
        let now = self.done == self.after_steps && !std::mem::replace(&mut self.asked, true);
        now.then_some(Event::Hold)
    }
}

/// What the test trips on, in words, if it trips when held after this number of control steps.
fn trip(
    e: &Experiment,
    ideal: &Response,
    seed: u64,
    after_steps: usize,
) -> Result<Option<String>, Failure> {
    let held = HeldOnce {
        after_steps,
        ..HeldOnce::default()
    };
    let summary = e
        .run(e.test.compensation(), ideal, seed, false, held)?
        .summary;
    Ok(summary.trip_detail.map(|t| {
        let (what, against) = summary.trip_in_words(t);
        format!("{what}: {against}")
    }))
}

/// The number of control steps after which a stroke is fastest in the ideal motion.
fn fastest_step(part: &CoupledPart, ideal: &Response) -> usize {
    let coupler = &part.declared.coupler;
    let interface = ideal.floor(0).zip(ideal.floor(1));
    let strokes_m: Vec<[f64; 2]> = interface
        .map(|(x, turned)| coupler.strokes_m([x, turned].map(f64::from)))
        .collect();
    let moved_m = strokes_m.windows(2).map(|w| {
        let [first, second] = [0, 1].map(|i| (w[1][i] - w[0][i]).abs());
        first.max(second)
    });
    let fastest = moved_m.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
    fastest.map_or(1, |(step, _)| step + 1)
}

/// Doubts about stopping a test, and a remedy.
///
/// # Errors
/// A test that cannot run.
pub(super) fn doubt(
    e: &Experiment,
    ideal: &Response,
    seed: u64,
) -> Result<Option<String>, Failure> {
    let fastest = fastest_step(e.test.coupled_part()?, ideal);
    let Some(trip_on) = trip(e, ideal, seed, fastest)? else {
        return Ok(None);
    };
    let timing = &e.test.config.timing;
    Ok(Some(format!(
        "a hold where the motion is fastest, after {:.2} s, trips on {trip_on}; {}",
        fastest as f64 / timing.rate_hz,
        what_would_do(e, ideal, seed, fastest)?
    )))
}

/// The steepest of the gentler ramps that would work, or another remedy.
fn what_would_do(
    e: &Experiment,
    ideal: &Response,
    seed: u64,
    after_steps: usize,
) -> Result<String, Failure> {
    let mut gentler = e.clone();
    let declared = e.test.config.timing.hold_deceleration_m_per_s2;
    for share in GENTLER {
        let gentle = share * declared;
        gentler.test.config.timing.hold_deceleration_m_per_s2 = gentle;
        if trip(&gentler, ideal, seed, after_steps)?.is_none() {
            return Ok(format!(
                "with loop.hold_deceleration_m_per_s2 = {} in place of {} it does not",
                three(gentle),
                three(declared)
            ));
        }
    }
    Ok(format!(
        "with a loop.hold_deceleration_m_per_s2 below {} it still does: raise that limit, or move less",
        three(declared)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Shaking;
    use crate::files::near_fault::near_fault;
    use crate::files::test::TestFile;
    use std::path::Path;

    fn example(set: &[&str]) -> Experiment {
        let example = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../examples/coupled-frame.toml"
        );
        let set: Vec<String> = set.iter().map(|s| (*s).to_owned()).collect();
        let test = TestFile::load_any(Path::new(example), &set).unwrap();
        Experiment::new(test, &near_fault(), None).unwrap()
    }

    fn doubt_of(set: &[&str]) -> Option<String> {
        let e = example(set);
        doubt(&e, &e.ideal().unwrap(), 1).unwrap()
    }

    #[test]
    fn a_test_that_cannot_be_held_is_doubtful_and_the_sentence_says_what_would_do() {
        let steep = doubt_of(&["loop.hold_deceleration_m_per_s2=100"]).unwrap();
        assert!(
            steep
                .starts_with("a hold where the motion is fastest, after 3.24 s, trips on velocity"),
            "{steep}"
        );
        assert!(
            steep.contains("with loop.hold_deceleration_m_per_s2 = "),
            "{steep}"
        );
        assert_eq!(doubt_of(&[]), None);
    }

    /// As on a board: nothing follows its last point. If the ground stopped at once the actuators would be asked for
    /// 2.7 m/s, with the motion for 0.34.
    #[test]
    fn a_ground_motion_that_is_cut_while_it_shakes_ends_on_its_ramp() {
        for seconds in [2.55, 3.0, 3.24, 4.72, 5.25] {
            let e = example(&[
                &format!("excitation.duration_s={seconds}"),
                "coupled.limits.velocity_m_per_s=0.6",
            ]);
            let whole = e.shaking();
            let last = (e.seconds / whole.interval_s).ceil() as usize + 1;
            let shaking = Shaking {
                acc_m_per_s2: &whole.acc_m_per_s2[..=last],
                ..whole
            };
            let cut = Experiment::with_shaking(
                e.test.clone(),
                e.record.clone(),
                e.seconds + 1.0,
                e.scale,
                &shaking,
            );
            let run = cut.run(e.test.compensation(), &e.ideal().unwrap(), 1, false, ());
            let summary = run.unwrap().summary;
            assert_eq!(summary.trip, None, "{seconds} s: {}", summary.sentence());
        }
    }
}
