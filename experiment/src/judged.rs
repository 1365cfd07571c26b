//! A test that is run and judged.

use crate::bench::{Bench, PlantBench};
use crate::compensation::Compensation;
use crate::coupled::interface::InterfaceScore;
use crate::experiment::Experiment;
use crate::failure::Failure;
use crate::score::Score;
use crate::summary::Summary;
use crate::trace::{Response, TestObserver, Trace};
use crate::watch::{Place, TestWatch};

/// A test that has run.
#[derive(Clone, Debug)]
pub struct JudgedRun {
    /// Its figures.
    pub summary: Summary,
    /// Every step, where they were to be kept.
    pub trace: Option<Trace>,
}

impl Experiment {
    /// Runs the test under a compensation on its simulated rig and judges it against `ideal`. `keep`: every step is kept.
    ///
    /// # Errors
    /// A parameter that is refused, with its name and value.
    pub fn run(
        &self,
        compensation: impl Into<Compensation>,
        ideal: &Response,
        seed: u64,
        keep: bool,
        mut observer: impl TestObserver,
    ) -> Result<JudgedRun, Failure> {
        self.simulated(compensation.into(), ideal, seed, keep, &mut observer)
    }

    /// The same test under this compensation.
    ///
    /// # Errors
    /// A compensation of the other kind of test.
    pub fn under(&self, compensation: Compensation) -> Result<Self, Failure> {
        let mut own = self.clone();
        match (compensation, &mut own.test.coupled) {
            (Compensation::Method(method), None) => {
                // Another method that learns has nothing left for the watch to correct; the test's own is refused with it.
                if method != own.test.config.compensation.kind && method.predictor.learns() {
                    own.test.watch.correct.retain(|one| one == "late_sensor");
                }
                own.test.config.compensation.kind = method;
            }
            (Compensation::Coupled(kind), Some(part)) => part.declared.compensation = kind,
            (Compensation::Method(_), Some(_)) | (Compensation::Coupled(_), None) => {
                // By its name it would have been found among those of this test, or refused.
                Compensation::named(compensation.name(), self.test.coupled.is_some())?;
            }
        }
        Ok(own)
    }

    /// As [`run`](Self::run), compiled here and once.
    fn simulated(
        &self,
        compensation: Compensation,
        ideal: &Response,
        seed: u64,
        keep: bool,
        observer: &mut dyn TestObserver,
    ) -> Result<JudgedRun, Failure> {
        let bench = PlantBench {
            spec: &self.test.plant,
            seed,
            stop_beyond_m: ideal.runaway_m(),
            breaks: None,
        };
        self.run_on(&bench, compensation, ideal, keep, observer)
    }

    /// Runs the test under a compensation on `bench` and judges it against `ideal`. `keep`: every step is kept.
    ///
    /// # Errors
    /// A parameter that is refused, with its name and value; a bench that cannot be set up.
    pub fn run_on<B: Bench>(
        &self,
        bench: &B,
        compensation: impl Into<Compensation>,
        ideal: &Response,
        keep: bool,
        observer: impl TestObserver,
    ) -> Result<JudgedRun, Failure> {
        let compensation = compensation.into();
        let own = self.under(compensation)?;
        let config = &own.test.config;
        if keep {
            self.check_memory(self.memory_bytes(keep))?;
        }
        let trace = keep.then(|| self.test.trace());
        let hz = self.natural_frequencies_hz().first().copied();
        let place = Place {
            ideal,
            first_hz: hz.unwrap_or_default(),
            seconds: self.seconds,
        };
        let watch = TestWatch::of(&own.test, &place)?;
        let interface = own.test.coupled.as_deref().map(InterfaceScore::of);
        let scores = (Score::against(ideal), interface);
        let mut observers = (scores, (watch, (trace, observer)));
        let ending = own.run_config(bench, config, &mut observers)?;
        let ((score, interface), (watch, (trace, _))) = observers;
        Ok(JudgedRun {
            summary: Summary {
                watch: watch.map(TestWatch::report),
                ..Summary::of(&own, compensation, (&score, interface.as_ref()), &ending)
            },
            trace,
        })
    }
}
