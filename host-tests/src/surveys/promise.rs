//! Targets of verdicts and monitor, and by how much they are missed.

use super::monitor::{BreakageKind, StopCounts};
use super::verdicts::{ActualOutcome, Known, VerdictCounts};
use outerloop_core::Prediction;
use serde::Serialize;

/// Largest fraction of sound tests that may be called doubtful or unstable.
const MOST_DOUBTFUL: f64 = 0.05;
/// Standard deviations above it that only one night in twenty reaches by chance.
const BY_CHANCE: f64 = 1.64;

/// Required of the verdicts: no test that runs away is called stable, and few sound ones are called anything else.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct SurveyPromise {
    /// Tests that ran away.
    pub ran_away: usize,
    /// How many of them are called stable.
    pub ran_away_called_stable: usize,
    /// Sound tests.
    pub sound: usize,
    /// How many of them are called doubtful.
    pub sound_called_doubtful: usize,
    /// How many of them are called unstable.
    pub sound_called_unstable: usize,
    /// How many of the sound tests called doubtful or unstable use `amb`.
    pub of_them_amb: usize,
}

impl SurveyPromise {
    /// Counts the rows of [`super::verdicts::table`].
    pub fn of(rows: &[VerdictCounts]) -> Self {
        let of = |tests: &str, truth| {
            let row = rows.iter().find(|r| r.tests == tests && r.truth == truth);
            row.map_or((0, [0; 3]), |r| (r.count, r.called))
        };
        let (ran_away, [stable, ..]) = of("all", ActualOutcome::RanAway);
        let (sound, [_, doubtful, unstable]) = of("all", ActualOutcome::Sound);
        let amb = format!("predictor {}", Prediction::Amb.name());
        let (_, [_, amb_doubtful, amb_unstable]) = of(&amb, ActualOutcome::Sound);
        Self {
            ran_away,
            ran_away_called_stable: stable,
            sound,
            sound_called_doubtful: doubtful,
            sound_called_unstable: unstable,
            of_them_amb: amb_doubtful + amb_unstable,
        }
    }

    /// Whether no test that ran away was called stable, and few enough sound ones anything else, but for chance. With `Known::AsDeclared` only
    /// the first is required: which actuators within their spread make a test go wrong cannot be known beforehand.
    pub fn is_kept(&self, known: Known) -> bool {
        let not_stable = (self.sound_called_doubtful + self.sound_called_unstable) as f64;
        let sound = self.sound as f64;
        let by_chance = BY_CHANCE * (MOST_DOUBTFUL * (1.0 - MOST_DOUBTFUL) * sound).sqrt();
        let few = not_stable <= MOST_DOUBTFUL * sound + by_chance;
        self.ran_away_called_stable == 0 && (few || matches!(known, Known::AsDeclared))
    }

    /// Reached, or missed by how much.
    pub fn sentence(&self) -> String {
        let share = |n: usize| 100.0 * n as f64 / self.sound.max(1) as f64;
        let (doubtful, unstable) = (self.sound_called_doubtful, self.sound_called_unstable);
        let not_stable = share(doubtful + unstable);
        let over = not_stable - 100.0 * MOST_DOUBTFUL;
        let said = match self.ran_away_called_stable {
            0 if over <= 0.0 => "reached".to_owned(),
            0 if self.of_them_amb == 0 => format!("missed by {over:.1} points"),
            0 => format!(
                "missed by {over:.1} points: {} of them have `amb`, which learns from the noise",
                self.of_them_amb
            ),
            wrong => format!("missed: {wrong} tests ran away after a yes"),
        };
        format!(
            "Ran away and called stable: {} of {} (asked for: none). Sound and called doubtful: {doubtful} of {}, {:.1} %, \
             with {unstable} called unstable {not_stable:.1} % (asked for: at most {:.0} %): {said}.",
            self.ran_away_called_stable,
            self.ran_away,
            self.sound,
            share(doubtful),
            100.0 * MOST_DOUBTFUL,
        )
    }
}

/// Smallest fraction of broken tests that must be stopped in time.
const LEAST_STOPPED: f64 = 0.99;

/// Required of the monitor: no sound test is stopped, and a broken one in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct MonitorPromise {
    /// Sound tests that count.
    pub sound: usize,
    /// How many of them are stopped.
    pub sound_stopped: usize,
    /// Broken tests that count.
    pub broken: usize,
    /// How many of them are stopped in time.
    pub broken_stopped: usize,
}

impl MonitorPromise {
    /// Counts the rows of [`super::monitor::table`].
    pub fn of(rows: &[StopCounts]) -> Self {
        let mut promise = Self {
            sound: 0,
            sound_stopped: 0,
            broken: 0,
            broken_stopped: 0,
        };
        for row in rows {
            let (all, stopped) = match row.kind {
                BreakageKind::Sound => (&mut promise.sound, &mut promise.sound_stopped),
                _ => (&mut promise.broken, &mut promise.broken_stopped),
            };
            *all += row.count;
            *stopped += row.together;
        }
        promise
    }

    /// Reached, or missed by how much.
    pub fn sentence(&self) -> String {
        let share = self.broken_stopped as f64 / self.broken.max(1) as f64;
        let said = match self.sound_stopped {
            0 if self.broken == 0 || share >= LEAST_STOPPED => "reached".to_owned(),
            0 => format!("missed by {:.1} points", 100.0 * (LEAST_STOPPED - share)),
            stopped => format!("missed: {stopped} sound tests were stopped"),
        };
        format!(
            "Sound and stopped: {} of {} (asked for: none). Broken and stopped in time: {} of {}, {:.1} % (asked for: at least \
             {:.0} %): {said}.",
            self.sound_stopped,
            self.sound,
            self.broken_stopped,
            self.broken,
            100.0 * share,
            100.0 * LEAST_STOPPED
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_survey_that_misses_says_by_how_much() {
        let row = |tests: &str, truth, called: [usize; 3]| VerdictCounts {
            tests: tests.into(),
            truth,
            count: called.iter().sum(),
            called,
        };
        let rows = |doubtful| {
            [
                row(
                    "all",
                    ActualOutcome::Sound,
                    [100 - doubtful - 1, doubtful, 1],
                ),
                row("predictor amb", ActualOutcome::Sound, [1, 3, 0]),
                row("all", ActualOutcome::RanAway, [0, 3, 7]),
            ]
        };
        let kept = SurveyPromise::of(&rows(4)).sentence();
        assert!(
            kept.contains("0 of 10") && kept.ends_with("reached."),
            "{kept}"
        );
        // Of 100 tests 8 by chance.
        let of = |doubtful| SurveyPromise::of(&rows(doubtful));
        assert!(of(7).is_kept(Known::Rig) && !of(8).is_kept(Known::Rig));
        assert!(of(8).is_kept(Known::AsDeclared));
        let missed = of(6).sentence();
        assert!(
            missed.contains("6 of 100, 6.0 %, with 1 called unstable 7.0 %"),
            "{missed}"
        );
        assert!(
            missed.contains("missed by 2.0 points: 3 of them have `amb`"),
            "{missed}"
        );
    }

    #[test]
    fn a_monitor_that_misses_says_by_how_much() {
        let row = |kind, count, together| StopCounts {
            kind,
            count,
            others: 0,
            stopped: [0; 5],
            together,
            largest: [0.0; 5],
        };
        let sentence = |stopped| {
            MonitorPromise::of(&[
                row(BreakageKind::Sound, 900, 0),
                row(BreakageKind::Gain, 100, stopped),
                row(BreakageKind::DeadSensor, 100, 100),
            ])
            .sentence()
        };
        assert!(sentence(99).contains("0 of 900") && sentence(99).ends_with("reached."));
        assert!(
            sentence(90).contains("190 of 200, 95.0 %")
                && sentence(90).contains("missed by 4.0 points")
        );
    }
}
