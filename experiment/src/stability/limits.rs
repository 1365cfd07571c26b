//! How much later, stronger or faster a loop may become before it is unstable.

use super::closed_loop::Question;
use super::linear_verdict::linear_verdict;
use super::predictor::Knowledge;
use super::rig::Variation;
use super::structure_matrices::StructureMatrices;
use crate::failure::Failure;
use crate::files::test::TestFile;
use crate::rig::{Departures, Quantity};
use outerloop_core::Prediction;
use outerloop_core::config::Filter;
use rayon::prelude::*;
use serde::Serialize;

/// A quantity, its limit and what is between.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StabilityLimit {
    /// As it is.
    pub present: f64,
    /// Where the loop becomes unstable; null: nowhere within the range that was searched.
    pub limit: Option<f64>,
    /// What is left of it, per cent of the present value; negative: it is beyond.
    pub margin_percent: Option<f64>,
}

impl StabilityLimit {
    fn new(present: f64, limit: Option<f64>) -> Self {
        Self {
            present,
            limit,
            margin_percent: limit
                .filter(|_| present > 0.0)
                .map(|l| (l / present - 1.0) * 100.0),
        }
    }
}

/// The limits of a loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StabilityLimits {
    /// Delay of the measured behind the commanded displacement at the first natural frequency, ms of the laboratory.
    pub delay: StabilityLimit,
    /// Force that is fed back, relative to the one that would be right.
    pub gain: StabilityLimit,
    /// The smallest time scale at which it is stable; null: none up to 1000.
    pub time_scale_needed: Option<f64>,
}

/// A part of the delay.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DelayPart {
    /// Which.
    pub part: &'static str,
    /// ms of the laboratory; negative: it leads.
    pub ms: f64,
    /// Where the figure comes from.
    pub from: &'static str,
}

/// Largest factor that is searched to.
const MOST: f64 = 100.0;
/// Longest extra delay that is searched to, in periods of the first mode.
const LONGEST_PERIODS: f64 = 0.5;
/// Bisections: a thousandth of a per mille.
const BISECTIONS: usize = 20;

/// All limits.
///
/// # Errors
/// A test that cannot be written down.
pub fn of(question: &Question<'_>, frame: &StructureMatrices) -> Result<StabilityLimits, Failure> {
    let stable = |vary: Variation| Ok(linear_verdict(question, frame, &vary)?.stable);
    let late_ms = |vary: Variation| Ok(question.lateness(frame, &vary)?.0 * 1e3);
    let now = stable(Variation::NONE)?;
    let present_ms = late_ms(Variation::NONE)?;
    let later = |s: f64| Variation {
        extra_s: s,
        ..Variation::NONE
    };
    let sooner = |f: f64| Variation {
        delay: f,
        ..Variation::NONE
    };
    let stronger = |g: f64| Variation {
        gain: g,
        ..Variation::NONE
    };
    let period_s = std::f64::consts::TAU / frame.omega[0] * question.config.timing.time_scale;
    let delay = if now {
        let shortest = 0.5 / question.config.timing.rate_hz;
        beyond(shortest, LONGEST_PERIODS * period_s, |s| stable(later(s)))?
            .map(|s| late_ms(later(s)))
            .transpose()?
    } else {
        // All times of the actuator shrink together.
        below(1.0, 1e-3, |f| stable(sooner(f)))?
            .map(|f| late_ms(sooner(f)))
            .transpose()?
    };
    let gain = if now {
        beyond(0.01, MOST, |extra| stable(stronger(1.0 + extra)))?.map(|extra| 1.0 + extra)
    } else {
        below(1.0, 1e-3, |g| stable(stronger(g)))?
    };
    Ok(StabilityLimits {
        delay: StabilityLimit::new(present_ms, delay),
        gain: StabilityLimit::new(1.0, gain),
        time_scale_needed: time_scale(question)?,
    })
}

/// Points of [`over_delay`].
const POINTS: usize = 40;

/// The fastest growing motion over the delay: ms of the laboratory at the first natural frequency, 1/s of model time.
/// From a fifth of the actuator's own times to half as much again as the limit, or to twice the present delay where no
/// limit was found.
///
/// # Errors
/// A test that cannot be written down.
pub fn over_delay(test: &TestFile, limits: &StabilityLimits) -> Result<Vec<(f64, f64)>, Failure> {
    let question = Question {
        config: &test.config,
        rig: &test.plant,
        law: Knowledge::Learnt,
    };
    let frame = StructureMatrices::of(&test.config)?;
    let present_ms = limits.delay.present;
    let further_ms = match limits.delay.limit {
        Some(limit) if limit > present_ms => 1.5 * (limit - present_ms),
        _ => present_ms,
    };
    let shorter = (0..POINTS / 4).map(|k| Variation {
        delay: 0.2 + 0.8 * k as f64 / (POINTS / 4) as f64,
        ..Variation::NONE
    });
    let longer = (0..=POINTS).map(|k| Variation {
        extra_s: 1e-3 * further_ms * k as f64 / POINTS as f64,
        ..Variation::NONE
    });
    let rigs: Vec<Variation> = shorter.chain(longer).collect();
    rigs.into_par_iter()
        .map(|vary| {
            let (late_s, _) = question.lateness(&frame, &vary)?;
            let row = linear_verdict(&question, &frame, &vary)?;
            Ok((1e3 * late_s, row.growth_per_s))
        })
        .collect()
}

/// The first value above 0 at which `stable` fails, sought in steps that double from `from`, at most to `to`.
fn beyond(
    from: f64,
    to: f64,
    stable: impl Fn(f64) -> Result<bool, Failure>,
) -> Result<Option<f64>, Failure> {
    let (mut good, mut step) = (0.0, from);
    loop {
        let next = f64::min(good + step, to);
        if !stable(next)? {
            return bisect(good, next, stable).map(Some);
        }
        if next >= to {
            return Ok(None);
        }
        good = next;
        step *= 1.5;
    }
}

/// The largest value below `from`, down to `to`, at which `stable` holds.
fn below(
    from: f64,
    to: f64,
    stable: impl Fn(f64) -> Result<bool, Failure>,
) -> Result<Option<f64>, Failure> {
    let mut bad = from;
    loop {
        let next = bad * 0.8;
        if next < to {
            return Ok(None);
        }
        if stable(next)? {
            return bisect(next, bad, stable).map(Some);
        }
        bad = next;
    }
}

fn bisect(
    mut good: f64,
    mut bad: f64,
    stable: impl Fn(f64) -> Result<bool, Failure>,
) -> Result<f64, Failure> {
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (good + bad);
        if stable(middle)? {
            good = middle;
        } else {
            bad = middle;
        }
    }
    Ok(good)
}

/// The smallest time scale at which the test is stable: below the present one where it already is.
fn time_scale(question: &Question<'_>) -> Result<Option<f64>, Failure> {
    let stable = |scale: f64| {
        let mut config = question.config.clone();
        config.timing.time_scale = scale;
        // A scale that core refuses is none: too fast for the explicit integration.
        if config.check().is_err() {
            return Ok(false);
        }
        let question = Question {
            config: &config,
            ..*question
        };
        let frame = StructureMatrices::of(&config)?;
        Ok(linear_verdict(&question, &frame, &Variation::NONE)?.stable)
    };
    let present = question.config.timing.time_scale;
    if stable(present)? {
        let mut good = present;
        // Faster until it fails; a test that is stable a hundred times faster needs no limit.
        loop {
            let next = good / 1.3;
            if next < present / MOST {
                return Ok(Some(good));
            }
            if !stable(next)? {
                // Stable is what is slower: the sides are turned round.
                return bisect(good, next, stable).map(Some);
            }
            good = next;
        }
    }
    let mut bad = present;
    while bad < 1e3 {
        let next = bad * 1.3;
        if stable(next)? {
            return bisect(next, bad, stable).map(Some);
        }
        bad = next;
    }
    Ok(None)
}

/// Sampling of both channels on the board.
const CONVERSION_MS: f64 = 0.02;
/// A step of the loop on the board: 900 instructions and 400 of a method, at two cycles each at 168 MHz.
const COMPUTING_MS: f64 = 0.0155;

/// Where the delay at the first natural frequency comes from.
///
/// # Errors
/// A test that cannot be written down.
pub fn budget(
    question: &Question<'_>,
    frame: &StructureMatrices,
    limits: &StabilityLimits,
) -> Result<Vec<DelayPart>, Failure> {
    let config = question.config;
    let period_ms = 1e3 / config.timing.rate_hz;
    let mut parts = vec![
        DelayPart {
            part: "conversion",
            ms: CONVERSION_MS,
            from: "assumed: both channels sampled within 20 us; not in the eigenvalues",
        },
        DelayPart {
            part: "computing",
            ms: COMPUTING_MS,
            from: "assumed: 1300 instructions of two cycles at 168 MHz; not in the eigenvalues",
        },
        DelayPart {
            part: "dac",
            ms: 0.5 * period_ms,
            from: "a command is held for a control period",
        },
        DelayPart {
            part: "integration",
            ms: -period_ms,
            from: "explicit: the next target is sent a control period before its time",
        },
        DelayPart {
            part: "actuator",
            ms: limits.delay.present + 0.5 * period_ms,
            from: "plant.actuator, phase at the first natural frequency",
        },
    ];
    let skew = Departures::of_rig(question.rig, 0)[Quantity::ForceLate];
    if skew != 0.0 {
        parts.push(DelayPart {
            part: "skew",
            ms: skew,
            from: "plant.sensors.skew_ms, force behind displacement",
        });
    }
    if config.estimation.kind == Filter::LowPass {
        parts.push(DelayPart {
            part: "filter",
            // Group delay of a second-order Butterworth at rest: sqrt(2) / (2 pi f_c).
            ms: 1e3 * std::f64::consts::SQRT_2
                / (std::f64::consts::TAU * config.estimation.cutoff_hz),
            from: "estimation: low-pass",
        });
    }
    if config.compensation.kind.predictor != Prediction::None {
        parts.push(DelayPart {
            part: "predictor",
            ms: question.remaining_lateness(frame, &Variation::NONE)? * 1e3 - limits.delay.present,
            from: "compensation: what it takes out at the first natural frequency",
        });
    }
    Ok(parts)
}
