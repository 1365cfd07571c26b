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

/// A quantity and its limit.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct StabilityLimit {
    /// As it is.
    pub present: f64,
    /// Where the search for the limit ended.
    #[serde(flatten)]
    pub search: LimitSearch,
}

/// Where a search for a limit ended.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "search", rename_all = "snake_case")]
pub enum LimitSearch {
    /// At the limit.
    Found {
        /// Where small motions begin to grow, of two coupled actuators where the planned motion becomes poor.
        limit: f64,
        /// Distance to it, per cent of the present value, of a time scale per cent of the limit; null: no present value above 0.
        margin_percent: Option<f64>,
    },
    /// At the end of the range, without a limit.
    BeyondRange {
        /// That end.
        searched_to: f64,
    },
    /// Without a limit, at a rig or a test that is refused.
    Refused {
        /// The last value that is not refused.
        searched_to: f64,
        /// The refusal.
        why: String,
    },
    /// It was not begun: there is no margin.
    NoMargin {
        /// Why not.
        why: String,
    },
}

impl StabilityLimit {
    /// Searches for the change above 0 up to which `good` holds, in growing steps from `from`, at most to `to`, and by bisection.
    /// `value`: the quantity after such a change; `none`: why there is no margin.
    pub(crate) fn search(
        (present, none): (f64, Option<&str>),
        (from, to, bisections): (f64, f64, usize),
        value: impl Fn(f64) -> f64,
        good: impl Fn(f64) -> Result<bool, Failure>,
    ) -> Self {
        let (mut at, mut step) = (0.0, from);
        let search = loop {
            if let Some(why) = none {
                break LimitSearch::NoMargin { why: why.into() };
            }
            if at >= to {
                let searched_to = value(to);
                break LimitSearch::BeyondRange { searched_to };
            }
            let next = f64::min(at + step, to);
            match good(next) {
                Ok(true) => (at, step) = (next, 1.5 * step),
                bad => {
                    let (at, bad) = bisect(at, (next, bad), bisections, good);
                    break ended(present, value(at), bad);
                }
            }
        };
        Self { present, search }
    }
}

/// The end of a search at `limit`, and what is just beyond.
fn ended(present: f64, limit: f64, beyond: Result<bool, Failure>) -> LimitSearch {
    match beyond {
        Err(refusal) => LimitSearch::Refused {
            searched_to: limit,
            why: refusal.to_string(),
        },
        Ok(_) => LimitSearch::Found {
            limit,
            margin_percent: (present > 0.0)
                .then(|| 100.0 * ((limit / present).max(present / limit) - 1.0)),
        },
    }
}

/// The limits of a loop.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct StabilityLimits {
    /// Delay of the measured behind the commanded displacement at the first natural frequency, ms of the laboratory.
    pub delay: StabilityLimit,
    /// Force that is fed back, relative to the one that would be right.
    pub gain: StabilityLimit,
    /// Time scale: the limit is the smallest.
    pub time_scale_needed: StabilityLimit,
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

/// All limits. The rig alone changes, not what the loop knows of it; the time scale is the loop's. `none`: why the test has no
/// margins.
///
/// # Errors
/// A test that cannot be set up.
pub fn of(
    question: &Question<'_>,
    structure: &StructureModes,
    none: Option<&str>,
) -> Result<StabilityLimits, Failure> {
    let timing = &question.config.timing;
    let stable = |vary: Variation| Ok(question.small_motions(structure, &vary)?.stable);
    let present_ms = 1e3 * lateness_of(question, structure, &Variation::NONE)?;
    let period_s = std::f64::consts::TAU / structure.omega[0] * timing.time_scale;
    let longest_s = LONGEST_PERIODS * period_s;
    Ok(StabilityLimits {
        delay: StabilityLimit::search(
            (present_ms, none),
            (0.5 / timing.rate_hz, longest_s, BISECTIONS),
            |s| present_ms + 1e3 * s,
            |s| stable(Variation::later(s)),
        ),
        gain: StabilityLimit::search(
            (1.0, none),
            (0.01, MOST - 1.0, BISECTIONS),
            |x| 1.0 + x,
            |x| stable(Variation::stronger(1.0 + x)),
        ),
        time_scale_needed: StabilityLimit::search(
            (timing.time_scale, none),
            (0.3, MOST - 1.0, BISECTIONS),
            |x| timing.time_scale / (1.0 + x),
            |x| stable_in_time(question, timing.time_scale / (1.0 + x)),
        ),
    })
}

/// What would make growing small motions decay, in words: a shorter delay, a weaker force, a slower test.
///
/// # Errors
/// A rig that cannot be built.
pub fn remedies(
    question: &Question<'_>,
    structure: &StructureModes,
) -> Result<Vec<String>, Failure> {
    let stable = |vary: Variation| Ok(question.small_motions(structure, &vary)?.stable);
    // Scales all times of the actuator together.
    let sooner = |f: f64| Variation {
        delay: f,
        ..Variation::NONE
    };
    let slower = |f: f64| question.config.timing.time_scale / f;
    let mut would = Vec::new();
    if let Some(f) = below(|f| stable(sooner(f))) {
        let ms = 1e3 * lateness_of(question, structure, &sooner(f))?;
        would.push(format!("a delay below {ms:.3} ms"));
    }
    if let Some(gain) = below(|f| stable(Variation::stronger(f))) {
        would.push(format!("a loop gain below {gain:.3}"));
    }
    if let Some(f) = below(|f| stable_in_time(question, slower(f))) {
        would.push(format!("a time scale of at least {:.3}", slower(f)));
    }
    Ok(would)
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
    let further_ms = match limits.delay.search {
        LimitSearch::Found { limit, .. } => 1.5 * (limit - present_ms),
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

/// The largest factor below 1, down to a thousandth, at which `stable` holds; a refusal ends the search.
fn below(stable: impl Fn(f64) -> Result<bool, Failure>) -> Option<f64> {
    let mut bad = 1.0;
    while bad > 1e-3 {
        let next = 0.8 * bad;
        match stable(next) {
            Ok(true) => return Some(bisect(next, (bad, Ok(false)), BISECTIONS, stable).0),
            Ok(false) => bad = next,
            Err(_) => return None,
        }
    }
    None
}

/// Brings a value at which `stable` holds and one at which it does not nearer to each other: the former, and what is just beyond.
fn bisect(
    mut good: f64,
    mut bad: (f64, Result<bool, Failure>),
    bisections: usize,
    stable: impl Fn(f64) -> Result<bool, Failure>,
) -> (f64, Result<bool, Failure>) {
    for _ in 0..bisections {
        let middle = 0.5 * (good + bad.0);
        match stable(middle) {
            Ok(true) => good = middle,
            beyond => bad = (middle, beyond),
        }
    }
    (good, bad.1)
}

/// True if small motions decay at another time scale; refused: one that core refuses, as too fast for the explicit integration.
fn stable_in_time(question: &Question<'_>, scale: f64) -> Result<bool, Failure> {
    let mut config = question.config.clone();
    config.timing.time_scale = scale;
    config.check().map_err(Failure::input)?;
    let structure = StructureModes::of(&config)?;
    let question = Question {
        config: &config,
        ..*question
    };
    let row = question.small_motions(&structure, &Variation::NONE)?;
    Ok(row.stable)
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
