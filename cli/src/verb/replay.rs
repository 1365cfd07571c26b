//! `outerloop replay`: recomputes an archived test and compares every channel, bit by bit.

use super::rig_arguments::RigArguments;
use super::{hand_over, no_files};
use crate::archive;
use crate::document::{Document, Grade, json};
use crate::order_recorder::OrderReplay;
use crate::provenance::{self, WithProvenance};
use crate::site::{RigKind, TestSite};
use crate::terminal::Progress;
use experiment::failure::Failure;
use experiment::files::{channels, look_ahead};
use experiment::trace::Trace;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;
use std::path::PathBuf;

/// Recompute an archived test and compare it bit by bit
#[derive(clap::Args, Debug)]
pub struct Replay {
    /// The archive: the folder of `run --out`, its record.h5, or the file of `run --archive`
    archive: PathBuf,
    /// Write report.html and replay.json there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// One JSON object on standard output and nothing else
    #[arg(long)]
    json: bool,
}

/// What a replay found.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct ReplayResult {
    steps: usize,
    channels: usize,
    values_different: usize,
    /// Parts of the file that were changed after it was written.
    changed: Vec<String>,
    first_difference: Option<String>,
    /// True if events and corrections of the rig watch are those of the archive.
    watch_same: bool,
    archived_by: String,
    replayed_by: String,
}

impl Replay {
    /// Replays the test.
    ///
    /// # Errors
    /// A file that is no archive; a test on a real rig; a different result.
    pub fn run(&self) -> Result<(), Failure> {
        let out = look_ahead::folder(self.out.as_deref(), &["report.html", "replay.json"])?;
        let archived = archive::load(&self.archive)?;
        let file = self.archive.display();
        if archived.repeat.place == RigKind::Board {
            return Err(Failure::input(format!(
                "{file}: ran on a board, and a real rig does not repeat itself: accepted are tests on a simulated rig or an \
                 emulated board; the board's steps were worked out again while it ran, and the summary in the file says with \
                 what result"
            )));
        }
        let orders = &archived.repeat.orders;
        let experiment = &archived.experiment;
        let run = {
            let progress = Progress::over("replay", experiment.control_steps() as u64);
            let ideal = experiment.ideal()?;
            let (compensation, seed) = (archived.compensation(), archived.repeat.seed);
            let observer = (progress.observer(), OrderReplay::new(orders));
            if archived.repeat.place == RigKind::Emulated {
                let board = RigArguments::emulated();
                board.run(experiment, compensation, &ideal, seed, true, observer)?
            } else {
                experiment.run(compensation, &ideal, seed, true, observer)?
            }
        };
        let trace = run
            .trace
            .ok_or_else(|| Failure::test("the replay kept no record"))?;
        let found = ReplayResult {
            watch_same: watch_is_same(&archived.summary, &run.summary)?,
            ..compare(&archived, &trace)
        };
        let outcome = found.outcome(archived.summary["watch"].is_object());
        let wanted = (out.as_deref(), self.json);
        hand_over(wanted, no_files, |page| {
            let lead = format!("`{file}` was worked out again, and every channel compared.");
            let mut d = Document::new("An archived test, worked out again", lead, page);
            match &outcome {
                Ok(same) => d.verdict(Grade::Good, format!("{file}: {same}.")),
                // On a terminal it is printed as the error.
                Err(other) => d.on_page(|d| d.verdict(Grade::Bad, format!("{file}: {other}."))),
            }
            let (then, now) = (&found.archived_by, &found.replayed_by);
            d.say(format!("Archived by {then}, replayed by {now}."));
            d.with_figures("replay.json", &WithProvenance::of(&found))
        })?;
        let differs = |other| Failure::test(format!("{file}: {other}"));
        outcome.map(drop).map_err(differs)
    }
}

impl ReplayResult {
    /// What is the same, or what differs; `watched`: the archive has results of a rig watch.
    fn outcome(&self, watched: bool) -> Result<String, String> {
        let (steps, channels, differ) = (self.steps, self.channels, self.values_different);
        let changed = self.changed.join(", ");
        match &self.first_difference {
            Some(first) => Err(format!("{differ} values differ, the first of them {first}")),
            None if !changed.is_empty() => Err(format!(
                "the steps are the same to the bit, and yet the file was changed after it was written: {changed}"
            )),
            None if !self.watch_same => Err(
                "the steps are the same to the bit, and yet the rig watch says something else of them: compare `watch` of \
                 `run --json` with the summary in the file".into()
            ),
            None => {
                let said = if watched { ", and what the rig watch said of them" } else { "" };
                Ok(format!("all {steps} steps of {channels} channels are the same to the bit{said}"))
            }
        }
    }
}

/// True if events and corrections of the rig watch are those of the archive; the diagnosis of the record is not repeated.
fn watch_is_same(archived: &Value, now: &impl Serialize) -> Result<bool, Failure> {
    // Converted to JSON and back, as the archive was.
    let now: Value = serde_json::from_str(&json(now)?)
        .map_err(|e| Failure::test(format!("the summary of the replay: {e}")))?;
    let parts = ["events", "corrections"];
    Ok({ parts.iter() }.all(|part| archived["watch"][part] == now["watch"][part]))
}

fn compare(archived: &archive::ArchivedTest, trace: &Trace) -> ReplayResult {
    let again = channels::of(trace);
    let mut first: Option<(usize, String)> = None;
    let mut different = 0;
    let flags = archived.flags.iter().zip(&trace.flags);
    if let Some((step, (was, is))) = flags.enumerate().find(|(_, (was, is))| was != is) {
        different += 1;
        let said = format!("flags at step {step}, {was:#010x} in the archive and {is:#010x} now");
        first = Some((step, said));
    }
    for ((name, before), now) in archived.channels.iter().zip(&again) {
        let at = |x: &[f32], i: usize| x.get(i).copied();
        for i in 0..before.len().max(now.values.len()) {
            let (was, is) = (at(before, i), at(now.values, i));
            if was.map(f32::to_bits) == is.map(f32::to_bits) {
                continue;
            }
            different += 1;
            if first.as_ref().is_none_or(|(step, _)| i < *step) {
                let shown = |x: Option<f32>| x.map_or("missing".into(), |x| format!("{x:?}"));
                let said = format!(
                    "{name} at step {i}, {} in the archive and {} now",
                    shown(was),
                    shown(is)
                );
                first = Some((i, said));
            }
        }
    }
    ReplayResult {
        steps: archived.steps,
        channels: again.len(),
        values_different: different,
        changed: archived.changed.clone(),
        first_difference: first.map(|(_, said)| said),
        watch_same: true,
        archived_by: archived.version.clone(),
        replayed_by: provenance::version(),
    }
}

#[cfg(test)]
mod tests {
    use super::watch_is_same;
    use serde_json::json;

    #[test]
    fn the_watch_is_the_same_by_its_events_and_corrections_and_whatever_the_diagnosis_says() {
        let with = |value: f64, corrected: f64, agrees: bool| {
            json!({"watch": {
                "events": [{"t_s": 8.3, "set": [{"name": "delay_error", "value": value}]}],
                "corrections": [{"t_s": 8.4, "corrected": corrected}],
                "diagnosis": {"agrees": agrees},
            }})
        };
        let archived = with(12.1, 11.9, true);
        let same = |now: serde_json::Value| watch_is_same(&archived, &now).unwrap();
        assert!(same(with(12.1, 11.9, false)));
        assert!(!same(with(12.100_000_1, 11.9, true)));
        assert!(!same(with(12.1, 11.8, true)));
        assert!(!same(json!({})));
    }
}
