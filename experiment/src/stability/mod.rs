//! Stability of a test, before the oil is on: closed-loop eigenvalues of integrator, filter, compensation and
//! actuator in discrete time.
//!
//! | look in | for |
//! |---|---|
//! | [`blocks`] | delays and lags as linear systems whose signals are rows |
//! | [`rig`] | the simulated rig in small motion |
//! | [`filter`] | the loop's own filter |
//! | [`predictor`] | core's predictors |
//! | [`interpolation`] | the command between targets |
//! | [`closed_loop`] | all of it over one integration step, as a matrix |
//! | [`spectrum`] | its eigenvalues |
//! | [`largest`] | the largest of them, where there are many |
//! | [`limits`] | how much later, stronger or faster it may become |
//! | [`perturbed`] | the worst of many rigs |
//!
//! # Limitations
//! Small motion about rest: a specimen that yields has its initial stiffness, which is the stiffest and the one that
//! lateness makes unstable first. Variable damping is what it comes to over a cycle (see [`closed_loop`]); a predictor
//! that learns is what it comes to at the first natural frequency (see [`predictor`]). Noise,
//! quantisation and saturation move no eigenvalue; effects of `plant.effects` that are no gain, delay, lag, mass or viscous
//! damping are not in them, and it is said.

pub mod blocks;
pub mod closed_loop;
pub mod filter;
pub mod interpolation;
pub mod largest;
pub mod limits;
pub mod linear_verdict;
pub mod perturbed;
pub mod predictor;
pub mod rig;
pub mod spectrum;
pub mod structure_matrices;

use crate::failure::Failure;
use crate::files::test::TestFile;
use crate::numbers::percent;
use crate::rig::Departures;
use closed_loop::Question;
use limits::{DelayPart, StabilityLimits};
use linear_verdict::{LinearVerdict, linear_verdict};
use outerloop_core::Method;
use outerloop_core::linear::LinearForce;
use perturbed::{Perturbed, Spread};
use predictor::Knowledge;
use rayon::prelude::*;
use rig::Variation;
use serde::Serialize;
use spectrum::LoopMode;
use structure_matrices::StructureMatrices;

/// What is found out about a test.
#[derive(Clone, Debug, Serialize)]
pub struct Stability {
    /// The compensation that was asked about, and its eigenvalues.
    #[serde(flatten)]
    pub row: LinearVerdict,
    /// The same before an adaptive predictor has learnt anything; null: it does not learn.
    pub at_start: Option<LinearVerdict>,
    /// Control rate, Hz.
    pub rate_hz: f64,
    /// Laboratory time per model time.
    pub time_scale: f64,
    /// Integration step, s of model time.
    pub step_s: f64,
    /// States of the loop.
    pub states: usize,
    /// First natural frequency of the structure, Hz of model time.
    pub first_hz: f64,
    /// The structure's modes in the loop.
    pub modes: Vec<LoopMode>,
    /// Delay, gain and time scale: present and limit.
    #[serde(flatten)]
    pub limits: StabilityLimits,
    /// Where the delay comes from.
    pub delay_budget: Vec<DelayPart>,
    /// The worst of many rigs.
    pub perturbed: Perturbed,
    /// The other compensations on the same rig.
    pub alternatives: Vec<LinearVerdict>,
    /// Why it cannot be stable by its eigenvalues; `None` where it can.
    #[serde(skip)]
    pub reason: Option<String>,
    /// What else is to be known.
    pub notes: Vec<String>,
}

/// Everything about `test` with its own compensation. `one_done` is called after every perturbed rig.
///
/// # Errors
/// A test or rig that cannot be written down.
pub fn answer(
    test: &TestFile,
    spread: &Spread,
    one_done: impl Fn() + Sync,
) -> Result<Stability, Failure> {
    let config = &test.config;
    let question = Question {
        config,
        rig: &test.plant,
        law: Knowledge::Learnt,
    };
    let frame = StructureMatrices::of(config)?;
    // A rig that cannot be built is refused by its own words.
    let storeys = &config.structure.stiffness_n_per_m[..config.physical_storeys()];
    plant::Rig::new(&test.plant, storeys, config.timing.rate_hz, 0).map_err(Failure::input)?;
    let z = question.eigenvalues(&frame, &Variation::NONE)?;
    let row = linear_verdict(&question, &frame, &Variation::NONE)?;
    // One after the other, and many at once.
    let (limits, perturbed) = rayon::join(
        || limits::of(&question, &frame),
        || perturbed::of(&question, &frame, spread, &one_done),
    );
    let limits = limits?;
    let at_start = config
        .compensation
        .kind
        .predictor
        .learns()
        .then(|| {
            let told = Question {
                law: Knowledge::Declared,
                ..question
            };
            self::linear_verdict(&told, &frame, &Variation::NONE)
        })
        .transpose()?;
    let alternatives = Method::ALL
        .into_par_iter()
        .map(|kind| {
            let mut config = config.clone();
            config.compensation.kind = kind;
            let question = Question {
                config: &config,
                ..question
            };
            self::linear_verdict(&question, &frame, &Variation::NONE)
        })
        .filter(|other| !matches!(other, Ok(o) if o.compensation == row.compensation))
        .collect::<Result<Vec<_>, _>>()?;
    let mut answer = Stability {
        row,
        at_start,
        rate_hz: config.timing.rate_hz,
        time_scale: config.timing.time_scale,
        step_s: config.model_step_s(),
        states: question
            .transition(&frame, &Variation::NONE, frame.omega[0], 1)?
            .nrows(),
        first_hz: frame.omega[0] / std::f64::consts::TAU,
        modes: spectrum::modes(&z, &frame.omega, config.model_step_s()),
        delay_budget: limits::budget(&question, &frame, &limits)?,
        limits,
        perturbed: perturbed?,
        alternatives,
        reason: None,
        notes: Vec::new(),
    };
    answer.notes = notes(test, &answer, question.at_bounds(&frame)?);
    answer.reason = (!answer.row.stable).then(|| reason(&answer));
    Ok(answer)
}

/// Why it cannot be stable, and what would be.
fn reason(a: &Stability) -> String {
    let mut would = Vec::new();
    if let Some(ms) = a.limits.delay.limit {
        would.push(format!("a delay below {ms:.3} ms"));
    }
    if let Some(gain) = a.limits.gain.limit {
        would.push(format!("a loop gain below {gain:.3}"));
    }
    if let Some(scale) = a.limits.time_scale_needed {
        would.push(format!("a time scale of at least {scale:.3}"));
    }
    let stable: Vec<_> = a
        .alternatives
        .iter()
        .filter(|r| r.stable)
        .map(|r| r.compensation)
        .collect();
    if !stable.is_empty() {
        would.push(format!("the compensations {}", stable.join(", ")));
    }
    if would.is_empty() {
        would.push("a softer specimen or more damping".into());
    }
    // Where the motion that grows is not of the structure, its own modes may not be among the largest eigenvalues.
    let left = if a.row.damping_ratio.is_nan() {
        String::new()
    } else {
        format!(
            "the first mode has {} of critical damping left in the loop and ",
            percent(a.row.damping_ratio)
        )
    };
    format!(
        "with compensation `{}` the test cannot be stable: its specimen is {:.2} ms late at {:.2} Hz, {left}the response grows \
         by {} a second: accepted are {}",
        a.row.compensation,
        a.limits.delay.present,
        a.first_hz / a.time_scale,
        percent(a.row.growth_per_s.exp_m1()),
        would.join(", or "),
    )
}

fn notes(test: &TestFile, answer: &Stability, at_bounds: bool) -> Vec<String> {
    let c = &test.config.compensation;
    let mut notes = Vec::new();
    let rig = Departures::of_rig(&test.plant, 0);
    let others = rig.others.iter().filter(|e| !rig::is_lag(e));
    let others: Vec<&str> = others.map(|e| e.name.name()).collect();
    if !others.is_empty() {
        notes.push(format!(
            "of plant.effects {} is not in the eigenvalues: run the test to see what it does",
            others.join(", ")
        ));
    }
    if test.plant.specimen.kind != plant::specimen::SpecimenKind::Linear {
        notes.push("the specimen is taken at its initial stiffness".into());
    }
    match c.kind.force.linear(c, test.config.physical_storeys()) {
        LinearForce::Measured => {}
        LinearForce::Damping { .. } => notes.push(
            "variable damping is taken as what it comes to over a cycle; it is not linear: look at a run as well"
                .into(),
        ),
        LinearForce::AtTarget => notes.push(
            "the corrected force is taken as the force at the target, with the stiffness that the specimen has; the \
             declared one may be wrong: look at a run as well"
                .into(),
        ),
    }
    if let Some(start) = &answer.at_start {
        notes.push(format!(
            "the predictor learns: its eigenvalues are those of what it comes to on the rig at the first natural \
             frequency; with what it was told the response {} by {} a second until it has learnt",
            if start.stable { "decays" } else { "grows" },
            percent(start.growth_per_s.exp_m1().abs())
        ));
    }
    if at_bounds {
        notes.push(
            "what the predictor would have to learn is beyond the bounds of compensation.adaptation: it stays there, and \
             what a law at its bounds does is not looked at"
                .into(),
        );
    }
    notes
}
