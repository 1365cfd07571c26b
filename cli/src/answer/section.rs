//! A test as a part of a result.

use experiment::Experiment;
use experiment::summary::{Summary, TestVerdict};
use experiment::trace::{Response, Trace};

/// The data of a test for its page.
#[derive(Clone, Copy, Debug)]
pub struct TestSection<'a> {
    /// The test itself.
    pub experiment: &'a Experiment,
    /// Its figures.
    pub summary: &'a Summary,
    /// Its trace.
    pub trace: &'a Trace,
    /// The ideal response with which it is compared.
    pub ideal: &'a Response,
}

/// The structure, the duration and the compensation.
pub(super) fn lead(experiment: &Experiment, summary: &Summary) -> String {
    let c = &experiment.test.config;
    let floors = match (c.degrees_of_freedom(), c.physical_storeys()) {
        (n, _) if summary.coupled.is_some() => format!(
            "Two coupled actuators move the interface of {n} degrees of freedom in x and in rotation"
        ),
        (1, _) => "One degree of freedom".to_owned(),
        (n, p) if n == p => format!("{n} degrees of freedom, an actuator at each"),
        (n, p) => format!("{n} degrees of freedom, {p} of them in the laboratory"),
    };
    let pace = match c.timing.time_scale {
        1.0 => "in real time".to_owned(),
        scale => format!("{scale} times slower than real time"),
    };
    format!(
        "{floors}, {} Hz, {pace}. {:.1} s of the ground motion {}{}, compensation **{}**.",
        c.timing.rate_hz,
        summary.steps as f64 / c.timing.rate_hz / c.timing.time_scale,
        summary.record,
        match experiment.scale {
            1.0 => String::new(),
            scale => format!(" times {scale:.3}"),
        },
        summary.compensation,
    )
}

/// Sorts completed tests first, then by their error.
pub(super) fn rank<T>(tests: &mut [&T], of: impl Fn(&T) -> (TestVerdict, f64)) {
    let wrong = |test: &T| {
        let (verdict, eps_rms) = of(test);
        (verdict != TestVerdict::Completed, eps_rms)
    };
    tests.sort_by(|a, b| {
        let (a, b) = (wrong(a), wrong(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
}
