//! Whether a test of two coupled actuators can end: where its ground motion does, and where somebody holds it at its fastest.
//!
//! A ramp to a standstill begins with a jump of the target's acceleration, and a ground motion that ends while it shakes with another.
//! The inverse of late actuators makes a pulse of either: it may ask an actuator for more speed than its limit, and the end becomes
//! a trip. What is sent on the ramp of other tests is the target itself.

use super::part::CoupledPart;
use crate::experiment::{Experiment, Shaking};
use crate::failure::Failure;
use crate::numbers::three;
use crate::trace::{AnyRecord, Response, TestObserver};
use outerloop_core::{Event, Mode};

/// So many control steps the target stands before a hold has come to its end.
const STANDS_STEPS: usize = 500;
/// Gentler ramps that are tried, as shares of the declared deceleration.
const GENTLER: [f64; 6] = [0.5, 0.2, 0.1, 0.05, 0.02, 0.01];

/// Holds a test once behind so many control steps, and stops it where it stands.
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

/// How a test ends.
#[derive(Clone, Copy, Debug)]
enum End {
    /// With its ground motion, as a board is given it: nothing follows its last second.
    OfTheMotion,
    /// By a hold behind so many control steps.
    Held(usize),
}

impl End {
    /// What the test trips on when it ends so, if it does, in words.
    fn trip(self, e: &Experiment, ideal: &Response, seed: u64) -> Result<Option<String>, Failure> {
        let kind = e.test.compensation();
        let summary = match self {
            Self::OfTheMotion => cut(e).run(kind, ideal, seed, false, ())?.summary,
            Self::Held(after_steps) => {
                let held = HeldOnce {
                    after_steps,
                    ..HeldOnce::default()
                };
                e.run(kind, ideal, seed, false, held)?.summary
            }
        };
        Ok(summary.trip_detail.map(|t| {
            let (what, against) = summary.trip_in_words(t);
            format!("{what}: {against}")
        }))
    }

    fn in_words(self, rate_hz: f64) -> String {
        match self {
            Self::OfTheMotion => "the end of the ground motion".to_owned(),
            Self::Held(steps) => format!(
                "a hold where the motion is fastest, after {:.2} s,",
                steps as f64 / rate_hz
            ),
        }
    }
}

/// The test with time for a ramp behind the end of its ground motion.
fn cut(e: &Experiment) -> Experiment {
    let whole = e.shaking();
    let points = whole.acc_m_per_s2;
    let last = (e.seconds / whole.interval_s).ceil() as usize + 1;
    let shaking = Shaking {
        acc_m_per_s2: points.get(..=last).unwrap_or(points),
        ..whole
    };
    // The loop ends it a step behind its last point.
    let seconds = e.seconds + 1.0;
    Experiment::with_shaking(e.test.clone(), e.record.clone(), seconds, e.scale, &shaking)
}

/// The control step behind which a stroke is fastest in the ideal motion.
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

/// What is doubtful about the end of a test, and what would mend it.
///
/// # Errors
/// A test that cannot run.
pub(super) fn doubt(
    e: &Experiment,
    ideal: &Response,
    seed: u64,
) -> Result<Option<String>, Failure> {
    let fastest = fastest_step(e.test.coupled_part()?, ideal);
    for end in [End::OfTheMotion, End::Held(fastest)] {
        if let Some(trip) = end.trip(e, ideal, seed)? {
            let timing = &e.test.config.timing;
            return Ok(Some(format!(
                "{} trips on {trip}; {}",
                end.in_words(timing.rate_hz),
                what_would_do(e, ideal, seed, end)?
            )));
        }
    }
    Ok(None)
}

/// The least gentle ramp that would do, or what else.
fn what_would_do(e: &Experiment, ideal: &Response, seed: u64, end: End) -> Result<String, Failure> {
    let mut gentler = e.clone();
    let declared = e.test.config.timing.hold_deceleration_m_per_s2;
    for share in GENTLER {
        let gentle = share * declared;
        gentler.test.config.timing.hold_deceleration_m_per_s2 = gentle;
        if end.trip(&gentler, ideal, seed)?.is_none() {
            return Ok(format!(
                "with loop.hold_deceleration_m_per_s2 = {} in place of {} it does not",
                three(gentle),
                three(declared)
            ));
        }
    }
    Ok(format!(
        "with a loop.hold_deceleration_m_per_s2 below {} it still does: {}",
        three(declared),
        match end {
            End::OfTheMotion =>
                "let the ground motion end where it hardly shakes (excitation.duration_s), or raise that limit",
            End::Held(_) => "raise that limit, or move less",
        }
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::near_fault::near_fault;
    use crate::files::test::TestFile;
    use std::path::Path;

    fn doubt_of(set: &[&str]) -> Option<String> {
        let example = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../examples/coupled-frame.toml"
        );
        let set: Vec<String> = set.iter().map(|s| (*s).to_owned()).collect();
        let test = TestFile::load_any(Path::new(example), &set).unwrap();
        let e = Experiment::new(test, &near_fault(), None).unwrap();
        doubt(&e, &e.ideal().unwrap(), 1).unwrap()
    }

    /// On the emulated board a test that is cut was a trip, too: at 3 s by 2.29 m/s.
    #[test]
    fn a_test_that_cannot_end_is_doubtful_and_the_sentence_says_what_would_do() {
        let tight = "coupled.limits.velocity_m_per_s=2";
        let cut = doubt_of(&["excitation.duration_s=4.72", tight]).unwrap();
        assert!(
            cut.starts_with("the end of the ground motion trips on velocity of actuator 1: 2."),
            "{cut}"
        );
        assert!(cut.contains("excitation.duration_s"), "{cut}");
        let steep = doubt_of(&["loop.hold_deceleration_m_per_s2=100", tight]).unwrap();
        assert!(
            steep
                .starts_with("a hold where the motion is fastest, after 3.24 s, trips on velocity"),
            "{steep}"
        );
        assert!(
            steep.contains("with loop.hold_deceleration_m_per_s2 = "),
            "{steep}"
        );
    }

    #[test]
    fn the_example_ends_wherever_it_is_cut_or_held() {
        for seconds in [2.55, 3.0, 3.02, 3.24, 4.5, 4.74, 5.25, 5.6, 20.0] {
            let set = format!("excitation.duration_s={seconds}");
            assert_eq!(doubt_of(&[&set]), None, "{seconds} s");
        }
    }
}
