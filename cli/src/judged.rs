//! A test that is run and judged.

use crate::bench::{Bench, PlantBench};
use crate::experiment::Experiment;
use crate::failure::Failure;
use crate::score::Score;
use crate::summary::Summary;
use crate::trace::{Response, Trace, Witness};
use outerloop_core::Method;

/// A test that has run.
#[derive(Clone, Debug)]
pub struct Run {
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
        tell: impl Witness,
    ) -> Result<Run, Failure> {
        let bench = PlantBench {
            spec: &self.test.plant,
            seed,
            stop_beyond_m: ideal.runaway_m(),
            breaks: None,
        };
        self.run_on(&bench, method, ideal, keep, tell)
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
        tell: impl Witness,
    ) -> Result<Run, Failure> {
        let mut config = self.test.config.clone();
        config.compensation.kind = method;
        let trace = keep.then(|| Trace::new(config.degrees_of_freedom(), config.timing.rate_hz));
        let mut witnesses = (Score::against(ideal), trace, tell);
        let ending = self.on(bench, &config, &mut witnesses)?;
        let (score, trace, _) = witnesses;
        Ok(Run {
            summary: Summary::of(self, method, &score, &ending),
            trace,
        })
    }
}
