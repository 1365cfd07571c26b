//! A test that is run and judged.

use crate::bench::{Bench, PlantBench};
use crate::experiment::Experiment;
use crate::failure::Failure;
use crate::score::Score;
use crate::summary::Summary;
use crate::trace::{Response, TestObserver, Trace};
use outerloop_core::Method;

/// A test that has run.
#[derive(Clone, Debug)]
pub struct JudgedRun {
    /// Its figures.
    pub summary: Summary,
    /// Every step, where they were to be kept.
    pub trace: Option<Trace>,
}

impl Experiment {
    /// Runs the test with `method` on its simulated rig and judges it against `ideal`. `keep`: every step is kept.
    ///
    /// # Errors
    /// A parameter that is refused, with its name and value.
    pub fn run(
        &self,
        method: Method,
        ideal: &Response,
        seed: u64,
        keep: bool,
        mut observer: impl TestObserver,
    ) -> Result<JudgedRun, Failure> {
        self.simulated(method, ideal, seed, keep, &mut observer)
    }

    /// As [`run`](Self::run), compiled here and once.
    fn simulated(
        &self,
        method: Method,
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
        self.run_on(&bench, method, ideal, keep, observer)
    }

    /// Runs the test with `method` on `bench` and judges it against `ideal`. `keep`: every step is kept.
    ///
    /// # Errors
    /// A parameter that is refused, with its name and value; a bench that cannot be set up.
    pub fn run_on(
        &self,
        bench: &impl Bench,
        method: Method,
        ideal: &Response,
        keep: bool,
        observer: impl TestObserver,
    ) -> Result<JudgedRun, Failure> {
        let mut config = self.test.config.clone();
        config.compensation.kind = method;
        if keep {
            self.check_memory(self.memory_bytes(keep))?;
        }
        let trace = keep.then(|| Trace::new(config.degrees_of_freedom(), config.timing.rate_hz));
        let mut observers = (Score::against(ideal), (trace, observer));
        let ending = self.run_config(bench, &config, &mut observers)?;
        let (score, (trace, _)) = observers;
        Ok(JudgedRun {
            summary: Summary::of(self, method, &score, &ending),
            trace,
        })
    }
}
