//! What the verdicts and the monitor are worth, over many drawn tests.

use super::Check;
use crate::provenance::WithProvenance;
use crate::terminal::{Progress, table};
use crate::verb::json;
use experiment::failure::Failure;
use experiment::soundness::monitor;
use experiment::soundness::promise::{MonitorPromise, SurveyPromise};
use experiment::soundness::survey::{self, SurveyCase};
use serde::Serialize;

/// What the monitor did, as JSON.
#[derive(Serialize)]
struct Watched<'a> {
    promise: MonitorPromise,
    rows: &'a [monitor::StopCounts],
    cases: &'a [monitor::MonitorCase],
}

/// A survey as JSON.
#[derive(Serialize)]
struct Survey<'a> {
    promise: SurveyPromise,
    rows: &'a [survey::VerdictCounts],
    cases: &'a [SurveyCase],
}

impl Check {
    /// The monitor over many tests.
    pub(super) fn monitor(&self, sound: usize) -> Result<(), Failure> {
        if !(10..=1_000_000).contains(&sound) {
            return Err(Failure::input(format!(
                "--monitor {sound}: accepted are 10 to 1000000"
            )));
        }
        let plans = monitor::draw(sound, sound / 4, self.seed);
        let cases = {
            let progress = Progress::over("tests", plans.len() as u64);
            monitor::run(&plans, || progress.add(1))?
        };
        let rows = monitor::table(&cases);
        let promise = MonitorPromise::of(&rows);
        let watched = Watched {
            promise,
            rows: &rows,
            cases: &cases,
        };
        if self.json {
            answer!("{}", json(&WithProvenance::seeded(&watched, self.seed))?);
        } else {
            let [energy, hsem, displacement, tracking, reading] = monitor::INDICATORS;
            let mut t = table(&[
                "tests",
                "",
                "not counted",
                energy,
                displacement,
                tracking,
                reading,
                "any of the four",
                hsem,
            ]);
            for r in &rows {
                let [energy, hsem, displacement, tracking, reading] =
                    r.stopped.map(|n| n.to_string());
                t.add_row([
                    r.kind.name().to_owned(),
                    r.count.to_string(),
                    r.others.to_string(),
                    energy,
                    displacement,
                    tracking,
                    reading,
                    r.together.to_string(),
                    hsem,
                ]);
            }
            println!("{t}");
            let [energy, hsem, displacement, tracking, reading] =
                rows.first().map_or([0.0; 5], |r| r.largest);
            println!(
                "Stopped at an energy error of {} of the energy in the test, or where {} of the planned peak are sent or {:.3} of it are read, \
                 or at {} of the planned tracking; broken tests before {} of the peak.\nSound tests came to {energy:.3} by core's indicator, {hsem:.3} by the published one, \
                 {displacement:.3} of the planned peak sent and {reading:.3} of it read, {tracking:.3} of the planned tracking.",
                monitor::ENERGY_TRIP,
                monitor::DISPLACEMENT,
                monitor::thresholds()[4],
                monitor::TRACKING,
                monitor::TOO_FAR,
            );
            println!("{}", promise.sentence());
        }
        Ok(())
    }

    /// The verdicts over many rigs.
    pub(super) fn survey(&self, rigs: usize) -> Result<(), Failure> {
        if !(1..=1_000_000).contains(&rigs) {
            return Err(Failure::input(format!(
                "--survey {rigs}: accepted are 1 to 1000000"
            )));
        }
        let tests = survey::draw(rigs, self.seed);
        let cases = {
            let progress = Progress::over("rigs", rigs as u64);
            survey::run(&tests, || progress.add(1))?
        };
        let rows = survey::table(&cases);
        let promise = SurveyPromise::of(&rows);
        let surveyed = Survey {
            promise,
            rows: &rows,
            cases: &cases,
        };
        if self.json {
            answer!("{}", json(&WithProvenance::seeded(&surveyed, self.seed))?);
        } else {
            let mut t = table(&["tests", "which", "", "stable", "doubtful", "unstable"]);
            for r in rows.iter().filter(|r| r.count > 0) {
                let [stable, doubtful, unstable] = r.called.map(|n| n.to_string());
                t.add_row([
                    r.tests.clone(),
                    r.truth.words().to_owned(),
                    r.count.to_string(),
                    stable,
                    doubtful,
                    unstable,
                ]);
            }
            println!("{t}");
            println!("{}", promise.sentence());
        }
        let missed = promise.ran_away_called_stable;
        if missed > 0 {
            return Err(Failure::test(format!(
                "{missed} tests were called stable and ran away"
            )));
        }
        Ok(())
    }
}
