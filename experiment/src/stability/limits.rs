//! How much later, stronger or faster a loop can become before it is unstable.

use super::growth::Question;
use super::small_motion::lateness_s;
use super::structure_modes::StructureModes;
use super::variation::Variation;
use crate::failure::Failure;
use crate::rig::{Departures, Quantity};
use outerloop_core::Prediction;
use outerloop_core::config::Filter;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

/// A quantity, its limit and the margin between them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct StabilityLimit {
    /// As it is.
    pub present: f64,
    /// Where small motions begin to grow, of two coupled actuators where the planned motion becomes poor; null: nowhere within
    /// the range that was searched.
    pub limit: Option<f64>,
    /// Distance to the limit, per cent of the present value; negative: beyond it; null: no limit, or no present value above 0.
    pub margin_percent: Option<f64>,
}

impl StabilityLimit {
    pub(crate) fn new(present: f64, limit: Option<f64>) -> Self {
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
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct StabilityLimits {
    /// Delay of the measured behind the commanded displacement at the first natural frequency, ms of the laboratory.
    pub delay: StabilityLimit,
    /// Force that is fed back, relative to the one that would be right.
    pub gain: StabilityLimit,
    /// The smallest time scale at which it is stable; null: none up to 1000.
    pub time_scale_needed: Option<f64>,
}

/// A part of the delay.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct DelayPart {
    /// Which.
    pub part: &'static str,
    /// ms of the laboratory; negative: it leads.
    pub ms: f64,
    /// Where the figure comes from.
    pub from: &'static str,
}

/// Largest factor searched.
const MOST: f64 = 100.0;
/// Longest extra delay searched, in periods of the first mode.
const LONGEST_PERIODS: f64 = 0.5;
/// Number of bisections: to a thousandth of the last step.
const BISECTIONS: usize = 10;

/// Delay of the measured displacement behind the command for the latest actuator at the first natural frequency, s of
/// the laboratory, on the rig with `vary`.
///
/// # Errors
/// A rig that cannot be built.
pub fn lateness_of(
    question: &Question<'_>,
    structure: &StructureModes,
    vary: &Variation,
) -> Result<f64, Failure> {
    let config = question.config;
    let omega = structure.omega[0] / config.timing.time_scale;
    lateness_s(
        &vary.of(question.rig, config),
        config,
        omega,
        &structure.first_shape,
    )
}

/// All limits.
///
/// # Errors
/// A test that cannot be set up.
pub fn of(question: &Question<'_>, structure: &StructureModes) -> Result<StabilityLimits, Failure> {
    let stable = |vary: Variation| Ok(question.small_motions(structure, &vary)?.stable);
    let late_ms = |vary: Variation| Ok(lateness_of(question, structure, &vary)? * 1e3);
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
    let period_s = std::f64::consts::TAU / structure.omega[0] * question.config.timing.time_scale;
    let delay = if now {
        let shortest = 0.5 / question.config.timing.rate_hz;
        beyond(shortest, LONGEST_PERIODS * period_s, BISECTIONS, |s| {
            stable(later(s))
        })?
        .map(|s| late_ms(later(s)))
        .transpose()?
    } else {
        // Scale all times of the actuator together.
        below(1.0, 1e-3, |f| stable(sooner(f)))?
            .map(|f| late_ms(sooner(f)))
            .transpose()?
    };
    let gain = if now {
        beyond(0.01, MOST, BISECTIONS, |extra| {
            stable(stronger(1.0 + extra))
        })?
        .map(|extra| 1.0 + extra)
    } else {
        below(1.0, 1e-3, |g| stable(stronger(g)))?
    };
    Ok(StabilityLimits {
        delay: StabilityLimit::new(present_ms, delay),
        gain: StabilityLimit::new(1.0, gain),
        time_scale_needed: time_scale(question)?,
    })
}

/// Number of points of [`over_delay`].
const POINTS: usize = 40;

/// Growth of the fastest growing motion over the delay: ms of the laboratory at the first natural frequency, 1/s of
/// model time. From a fifth of the actuator's own times to half as much again beyond the limit, or to twice the present
/// delay if no limit was found.
///
/// # Errors
/// A test that cannot be set up.
pub fn over_delay(
    question: &Question<'_>,
    limits: &StabilityLimits,
) -> Result<Vec<(f64, f64)>, Failure> {
    let structure = StructureModes::of(question.config)?;
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
            let late_s = lateness_of(question, &structure, &vary)?;
            let row = question.small_motions(&structure, &vary)?;
            Ok((1e3 * late_s, row.growth_per_s))
        })
        .collect()
}

/// The value above 0 up to which `stable` holds, searched in growing steps from `from`, at most to `to`; a rig that is
/// refused ends the search.
pub(crate) fn beyond(
    from: f64,
    to: f64,
    bisections: usize,
    stable: impl Fn(f64) -> Result<bool, Failure>,
) -> Result<Option<f64>, Failure> {
    let (mut good, mut step) = (0.0, from);
    loop {
        let next = f64::min(good + step, to);
        match stable(next) {
            Ok(true) => {}
            Ok(false) => return bisect(good, next, bisections, stable).map(Some),
            Err(_) => return Ok(None),
        }
        if next >= to {
            return Ok(None);
        }
        good = next;
        step *= 1.5;
    }
}

/// The largest value below `from`, down to `to`, at which `stable` holds; a rig that is refused ends the search.
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
        match stable(next) {
            Ok(true) => return bisect(next, bad, BISECTIONS, stable).map(Some),
            Ok(false) => bad = next,
            Err(_) => return Ok(None),
        }
    }
}

fn bisect(
    mut good: f64,
    mut bad: f64,
    bisections: usize,
    stable: impl Fn(f64) -> Result<bool, Failure>,
) -> Result<f64, Failure> {
    for _ in 0..bisections {
        let middle = 0.5 * (good + bad);
        if stable(middle)? {
            good = middle;
        } else {
            bad = middle;
        }
    }
    Ok(good)
}

/// The smallest time scale at which the test is stable; below the present one if that is already stable.
fn time_scale(question: &Question<'_>) -> Result<Option<f64>, Failure> {
    let stable = |scale: f64| {
        let mut config = question.config.clone();
        config.timing.time_scale = scale;
        // A scale refused by core does not count: too fast for the explicit integration.
        if config.check().is_err() {
            return Ok(false);
        }
        let question = Question {
            config: &config,
            ..*question
        };
        let structure = StructureModes::of(&config)?;
        let row = question.small_motions(&structure, &Variation::NONE)?;
        Ok(row.stable)
    };
    let present = question.config.timing.time_scale;
    if stable(present)? {
        let mut good = present;
        // Faster until it fails; a test that is stable even a hundred times faster needs no limit.
        loop {
            let next = good / 1.3;
            if next < present / MOST {
                return Ok(Some(good));
            }
            if !stable(next)? {
                // The slower side is stable: the sides are reversed.
                return bisect(good, next, BISECTIONS, stable).map(Some);
            }
            good = next;
        }
    }
    let mut bad = present;
    while bad < 1e3 {
        let next = bad * 1.3;
        if stable(next)? {
            return bisect(next, bad, BISECTIONS, stable).map(Some);
        }
        bad = next;
    }
    Ok(None)
}

/// Sampling of both channels on the board.
const CONVERSION_MS: f64 = 0.02;
/// A step of the loop on the board: 900 instructions and 400 of a method, at two cycles each at 168 MHz.
const COMPUTING_MS: f64 = 0.0155;

/// The contributions to the delay at the first natural frequency.
///
/// # Errors
/// A test that cannot be set up.
pub fn budget(
    question: &Question<'_>,
    structure: &StructureModes,
    limits: &StabilityLimits,
) -> Result<Vec<DelayPart>, Failure> {
    let config = question.config;
    let period_ms = 1e3 / config.timing.rate_hz;
    let mut parts = vec![
        DelayPart {
            part: "conversion",
            ms: CONVERSION_MS,
            from: "assumed: both channels sampled within 20 us; not simulated",
        },
        DelayPart {
            part: "computing",
            ms: COMPUTING_MS,
            from: "assumed: 1300 instructions of two cycles at 168 MHz; not simulated",
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
            // Group delay of a second-order Butterworth at zero frequency: sqrt(2) / (2 pi f_c).
            ms: 1e3 * std::f64::consts::SQRT_2
                / (std::f64::consts::TAU * config.estimation.cutoff_hz),
            from: "estimation: low-pass",
        });
    }
    if config.compensation.kind.predictor != Prediction::None
        && let Some(left_s) = question.remaining_lateness_s(structure)?
    {
        parts.push(DelayPart {
            part: "predictor",
            ms: left_s * 1e3 - limits.delay.present,
            from: "compensation: what it takes out in the first mode",
        });
    }
    Ok(parts)
}
