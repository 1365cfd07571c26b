//! `outerloop run`: one closed-loop test.

use super::rig_arguments::RigArguments;
use super::{CommonArguments, MethodName, hand_over};
use crate::answer::{of_played, of_run};
use crate::archive::{self, FinishedTest};
use crate::board::Trajectory;
use crate::order_recorder::{OperatorOrder, OrderRecorder};
use crate::provenance::WithProvenance;
use crate::scope::Scoped;
use crate::site::{RigKind, TestSite};
use crate::terminal::interrupt::{self, StopBySignal};
use crate::terminal::{self, Progress};
use diagnosis::ForceUnit;
use experiment::Experiment;
use experiment::compensation::Compensation;
use experiment::failure::Failure;
use experiment::files::measured::in_mm_of;
use experiment::files::signal::SignalPoints;
use experiment::files::test::TestFile;
use experiment::files::{look_ahead, model, output, record_csv};
use experiment::judged::JudgedRun;
use experiment::rig::improvement;
use experiment::summary::Summary;
use experiment::trace::Response;
use experiment::watch::agreement;
use schemars::JsonSchema;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Run one closed-loop test
#[derive(clap::Args, Debug)]
pub struct Run {
    #[command(flatten)]
    common: CommonArguments,
    /// The ground motion: CSV, AT2, or one acceleration a line
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Instead of the test: move the actuator by this file's command (time_s, command_mm; `diagnose --next` writes such
    /// files) under the test's limits, and record it
    #[arg(long, value_name = "FILE", conflicts_with_all = ["record", "compensation", "archive", "model", "duration"])]
    signal: Option<PathBuf>,
    /// The compensation, instead of the test file's
    #[arg(long, value_name = "NAME", value_parser = MethodName, hide_possible_values = true)]
    compensation: Option<String>,
    /// Write report.html, record.csv, record.h5 (HDF5 and MAT v7.3; not of a signal) and summary.json there, and inputs.csv of
    /// a board with further inputs
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write everything that is needed to judge and to repeat the test into this file; `outerloop replay` reads it
    #[arg(long, value_name = "FILE")]
    archive: Option<PathBuf>,
    /// What is known of the rig, for example from `diagnose --save-model`: taken into account in this test
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    #[command(flatten)]
    place: RigArguments,
    #[command(flatten)]
    scope: Scoped,
}

/// The files in a test's folder.
const FILES: [&str; 5] = [
    "report.html",
    "record.csv",
    "record.h5",
    "summary.json",
    "inputs.csv",
];

impl Run {
    /// Runs the test.
    ///
    /// # Errors
    /// Bad input, or a test that tripped, ran away, or is not the structure's response.
    pub fn run(&self) -> Result<(), Failure> {
        let out = look_ahead::folder(self.out.as_deref(), &FILES)?;
        let out = out.as_deref();
        // Done first: it reads the existing file, which is refused once that is an output.
        if let Some(file) = &self.archive {
            archive::refuse_to_replace(file)?;
        }
        look_ahead::file(self.archive.as_deref())?;
        let mut test = self.common.load_any()?;
        if test.coupled.is_some() {
            super::coupled::refuse(&[
                ("--signal", self.signal.is_some()),
                ("--model", self.model.is_some()),
                ("--scope", self.scope.is_wanted()),
            ])?;
        }
        if let Some(path) = &self.signal {
            return self.play(&test, path, out);
        }
        let mut remarks: Vec<String> = test.warning_of_true_delay().into_iter().collect();
        if let Some(path) = &self.model {
            remarks.extend(take_into_account(path, &mut test)?);
        }
        let experiment = self.common.experiment(&test, self.record.as_deref())?;
        let compensation = match &self.compensation {
            Some(name) => test.compensation_named(name)?,
            None => test.compensation(),
        };
        remarks.extend(experiment.under(compensation)?.remarks());
        let ran = self.test(&experiment, compensation, out.is_some())?;
        let summary = &ran.run.summary;
        let page = ran.run.trace.as_ref().filter(|_| out.is_some());
        let page = page.map(|trace| (trace, &ran.ideal));
        let mut document = of_run(&experiment, summary, &remarks, page);
        if let Some(board) = &summary.board {
            document.tell(board.sentence());
        }
        let archived = self.archived(&experiment, &ran)?;
        let files = || Ok(ran.files(archived, experiment.test.config.timing.rate_hz));
        let wanted = (out, self.common.json);
        let remarks = &remarks;
        let figures = RunAnswer { summary, remarks };
        hand_over(wanted, files, |_| {
            document.with_figures(
                "summary.json",
                &WithProvenance::seeded(&figures, self.common.seed),
            )
        })?;
        summary.outcome()
    }

    /// Runs the test; for a page or an archive every step is kept.
    fn test(
        &self,
        experiment: &Experiment,
        compensation: Compensation,
        with_page: bool,
    ) -> Result<Ran, Failure> {
        let test = &experiment.test;
        let keep = with_page || self.archive.is_some();
        experiment.check_memory(experiment.memory_bytes(keep))?;
        if let Some(note) = experiment.note_of_size(keep) {
            eprintln!("outerloop: note: {note}");
        }
        let progress = Progress::over(&experiment.record, experiment.control_steps() as u64);
        let ideal = experiment.ideal()?;
        let rate_hz = test.config.timing.rate_hz;
        let title = format!("{} under {}", self.common.test.display(), experiment.record);
        let simulated = self.place.kind() == RigKind::Simulated;
        let scope = self.scope.open(&title, rate_hz, simulated)?;
        // A repeatable test is stopped by a request that a replay can repeat.
        let repeats = self.place.kind() != RigKind::Board;
        let by_signal = repeats.then_some(StopBySignal);
        if simulated {
            interrupt::watch_rig();
        }
        let mut recorder = OrderRecorder::new((scope, by_signal));
        let observer = (progress.observer(), &mut recorder);
        let seed = self.common.seed;
        let place = self.place.watched(self.scope.is_wanted());
        let mut run = place.run(experiment, compensation, &ideal, seed, keep, observer)?;
        if self.out.is_some() {
            compare_with_diagnosis(test, &mut run);
        }
        Ok(Ran {
            compensation,
            ideal,
            run,
            orders: recorder.orders(),
        })
    }

    /// Plays a signal instead of running a test.
    fn play(&self, test: &TestFile, path: &Path, out: Option<&Path>) -> Result<(), Failure> {
        let signal = SignalPoints::load(path)?;
        let rate_hz = test.config.timing.rate_hz;
        let title = format!("{} under {}", path.display(), self.common.test.display());
        let simulated = self.place.kind() == RigKind::Simulated;
        let scope = self.scope.open(&title, rate_hz, simulated)?;
        let mut observer = (scope, simulated.then_some(StopBySignal));
        if simulated {
            interrupt::watch_rig();
        }
        let began = Instant::now();
        let trajectory = Trajectory::Points(signal);
        let seed = self.common.seed;
        let played = terminal::while_waiting("playing the signal", || {
            self.place
                .watched(self.scope.is_wanted())
                .play(test, &trajectory, seed, &mut observer)
        })?;
        let played_signal = PlayedSignal {
            signal: path,
            place: self.place.kind(),
            steps: played.steps,
            rate_hz,
            verdict: match played.early {
                None => "completed",
                Some(_) if played.is_stopped() => "stopped",
                Some(_) => "tripped",
            },
            trip: played.early.as_deref().filter(|_| !played.is_stopped()),
            peak_displacement_m: played.peak_m,
            peak_force_n: played.peak_n,
            wall_s: began.elapsed().as_secs_f64(),
        };
        let files = || Ok(vec![("record.csv", played.text.clone())]);
        let wanted = (out, self.common.json);
        hand_over(wanted, files, |page| {
            of_played(&path.display().to_string(), &played, page).with_figures(
                "summary.json",
                &WithProvenance::seeded(&played_signal, seed),
            )
        })?;
        played.early.map_or(Ok(()), |why| {
            Err(Failure::test(format!(
                "the signal ended early: {why}; what was received is kept"
            )))
        })
    }

    /// The archive, written if requested; empty for a test whose steps were not kept.
    fn archived(&self, experiment: &Experiment, ran: &Ran) -> Result<Vec<u8>, Failure> {
        let Some(trace) = &ran.run.trace else {
            return Ok(Vec::new());
        };
        let archived = archive::to_bytes(&FinishedTest {
            experiment,
            compensation: ran.compensation,
            place: self.place.kind(),
            seed: self.common.seed,
            orders: &ran.orders,
            summary: &ran.run.summary,
            trace,
        })?;
        if let Some(file) = &self.archive {
            output::write(file, &archived)?;
        }
        Ok(archived)
    }
}

/// The contents of a test's summary.json.
#[derive(Serialize, JsonSchema)]
pub struct RunAnswer<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    /// What is to be known of the test file, the rig and the model beside the figures, in sentences.
    remarks: &'a [String],
}

/// A completed test.
struct Ran {
    compensation: Compensation,
    ideal: Response,
    run: JudgedRun,
    /// The operator's requests.
    orders: Vec<OperatorOrder>,
}

impl Ran {
    /// The files besides the page and the figures.
    fn files(&self, archived: Vec<u8>, rate_hz: f64) -> Vec<(&'static str, Vec<u8>)> {
        let mut files = vec![("record.h5", archived)];
        if let Some(trace) = &self.run.trace {
            files.push(("record.csv", record_csv::to_csv(trace).into_bytes()));
        }
        let board = self.run.summary.board.as_ref();
        if let Some(further) = board.and_then(|b| b.further.as_ref()) {
            files.push(("inputs.csv", further.to_csv(rate_hz).into_bytes()));
        }
        files
    }
}

/// Checks whether the diagnosis of the test's record finds what the watch has named.
fn compare_with_diagnosis(test: &TestFile, run: &mut JudgedRun) {
    let (Some(watch), Some(trace)) = (&mut run.summary.watch, &run.trace) else {
        return;
    };
    // The record covers only the lowest floor.
    let Some(model) = test.declared.as_ref().filter(|_| trace.floors.len() == 1) else {
        return;
    };
    let record = in_mm_of(trace);
    watch.diagnosis = terminal::while_waiting("diagnosing what the watch has named", || {
        agreement(model, &record, watch, test.config.timing.time_scale)
    });
}

/// Applies the model file at `path` to the test, and reports the changes.
fn take_into_account(path: &Path, test: &mut TestFile) -> Result<Vec<String>, Failure> {
    let mut known = model::load(path)?;
    let without = known
        .specimen
        .take_if(|s| s.force_unit == ForceUnit::Without);
    let mut remarks = Vec::new();
    if without.is_some() {
        remarks.push(format!(
            "{}: was fitted to a force without a unit (specimen.force_unit = \"1\"): nothing of its specimen is taken into \
             account.",
            path.display()
        ));
    }
    let done = improvement::apply(&known, &mut test.config);
    remarks.extend(done.iter().map(|d| format!("{}: {d}", path.display())));
    Ok(remarks)
}

/// The result of a played signal.
#[derive(Serialize, JsonSchema)]
pub struct PlayedSignal<'a> {
    signal: &'a Path,
    place: RigKind,
    steps: usize,
    rate_hz: f64,
    verdict: &'static str,
    trip: Option<&'a str>,
    peak_displacement_m: f64,
    peak_force_n: f64,
    wall_s: f64,
}
