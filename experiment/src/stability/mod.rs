//! Stability of a test before it is run: the evolution of small motions of the real loop on the simulated rig.
//!
//! | look in | for |
//! |---|---|
//! | [`small_motion`] | the run after a blow: its size, and what is left out of the rig |
//! | [`pencil`] | the components of a free motion |
//! | [`growth`] | its growth, and the damping of the structure's modes in the loop |
//! | [`structure_modes`] | those modes without the loop |
//! | [`variation`] | a rig that differs from the declared one |
//! | [`limits`] | how much later, stronger or faster the loop can become |
//! | [`perturbed`] | the worst of many rigs |
//!
//! # Limitations
//! Small motion about rest: a specimen that yields has its initial stiffness, which is the largest and the first to
//! become unstable by delay. With variable damping or a predictor that learns, small motions are not conclusive: their
//! effect depends on the size and history of the motion. Effects of `plant.effects` that have no small motion are left
//! out, and this is reported.

pub mod growth;
pub mod limits;
pub mod pencil;
pub mod perturbed;
pub mod small_motion;
pub mod structure_modes;
pub mod variation;

use crate::experiment::Experiment;
use crate::failure::Failure;
use crate::numbers::{growth_percent, percent};
use crate::rig::Departures;
use growth::{LoopMode, Question, SmallMotions};
use limits::{DelayPart, StabilityLimits};
use outerloop_core::Method;
use perturbed::{Perturbed, Spread};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use small_motion::Learning;
use structure_modes::StructureModes;
use variation::Variation;

/// The stability of a test.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Stability {
    /// The compensation that was asked about, and its small motions.
    #[serde(flatten)]
    pub row: SmallMotions,
    /// The same before an adaptive predictor has learnt anything; null: it does not learn.
    pub at_start: Option<SmallMotions>,
    /// Control rate, Hz.
    pub rate_hz: f64,
    /// Laboratory time per model time.
    pub time_scale: f64,
    /// Integration step, s of model time.
    pub step_s: f64,
    /// First natural frequency of the structure, Hz of model time.
    pub first_hz: f64,
    /// The structure's modes in the loop.
    pub modes: Vec<LoopMode>,
    /// Delay, gain and time scale: present and limit.
    #[serde(flatten)]
    pub limits: StabilityLimits,
    /// Where the delay comes from.
    pub delay_budget: Vec<DelayPart>,
    /// The perturbed rigs.
    pub perturbed: Perturbed,
    /// The other compensations on the same rig.
    pub alternatives: Vec<SmallMotions>,
    /// Why small motions grow; `None` where they do not, or do not decide.
    #[serde(skip)]
    pub reason: Option<String>,
    /// Notes.
    pub notes: Vec<String>,
}

impl Experiment {
    /// The test's small motions; `learning` says what an adaptive predictor does in them.
    ///
    /// # Errors
    /// A test that cannot run on an ideal rig.
    pub fn small_motions(&self, learning: Learning) -> Result<Question<'_>, Failure> {
        let peaks_m = self.ideal()?.peaks_m();
        Ok(Question {
            config: &self.test.config,
            rig: &self.test.plant,
            planned_peak_m: peaks_m.into_iter().fold(0.0, f64::max),
            learning,
        })
    }
}

/// All results for a test with its own compensation; `unstable`: it is known to be, and so has no margins. `one_done` is called
/// after each perturbed rig.
///
/// # Errors
/// A test that cannot be run.
pub fn answer(
    question: &Question<'_>,
    spread: &Spread,
    unstable: bool,
    one_done: impl Fn() + Sync,
) -> Result<Stability, Failure> {
    let config = question.config;
    let structure = StructureModes::of(config)?;
    let row = question.small_motions(&structure, &Variation::NONE)?;
    let none = match (unstable, row.stable) {
        (true, _) => Some("the test is unstable"),
        (false, false) => Some("small motions grow on the rig as it is"),
        (false, true) => None,
    };
    // The limits one after the other, and the rigs in parallel.
    let (limits, perturbed) = rayon::join(
        || limits::of(question, &structure, none),
        || perturbed::of(question, &structure, spread, &one_done),
    );
    let limits = limits?;
    let learns = config.compensation.kind.predictor.learns();
    let at_start = learns
        .then(|| {
            let declared = Question {
                learning: Learning::Off,
                ..*question
            };
            declared.small_motions(&structure, &Variation::NONE)
        })
        .transpose()?;
    let others = Method::ALL
        .into_par_iter()
        .filter(|other| *other != config.compensation.kind);
    let alternatives = others
        .map(|kind| {
            let mut config = config.clone();
            config.compensation.kind = kind;
            let other = Question {
                config: &config,
                ..*question
            };
            other.small_motions(&structure, &Variation::NONE)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let mut answer = Stability {
        at_start,
        rate_hz: config.timing.rate_hz,
        time_scale: config.timing.time_scale,
        step_s: config.model_step_s(),
        first_hz: structure.omega[0] / std::f64::consts::TAU,
        modes: row.modes.clone(),
        delay_budget: limits::budget(question, &structure, &limits)?,
        limits,
        perturbed: perturbed?,
        alternatives,
        reason: None,
        notes: notes(question),
        row,
    };
    if let Some(start) = &answer.at_start {
        answer.notes.push(format!(
            "the predictor learns: its small motions are those of what it has learnt; as it was declared the response {} by \
             {} a second until then",
            if start.stable { "decays" } else { "grows" },
            growth_percent(start.growth_per_s.exp_m1().abs())
        ));
    }
    if !answer.row.stable && answer.row.decides {
        let would = limits::remedies(question, &structure)?;
        answer.reason = Some(reason(&answer, would));
    }
    Ok(answer)
}

/// Why small motions grow, and what would prevent it: the remedies `would`, and other compensations.
fn reason(a: &Stability, mut would: Vec<String>) -> String {
    let stable: Vec<_> = a
        .alternatives
        .iter()
        .filter(|r| r.stable && r.decides)
        .map(|r| r.compensation)
        .collect();
    if !stable.is_empty() {
        would.push(format!("the compensations {}", stable.join(", ")));
    }
    if would.is_empty() {
        would.push("a softer specimen or more damping".into());
    }
    // If the growing motion is not the structure's, the structure's own modes may be hidden by it.
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
        growth_percent(a.row.growth_per_s.exp_m1()),
        would.join(", or "),
    )
}

fn notes(question: &Question<'_>) -> Vec<String> {
    let mut notes = Vec::new();
    let rig = Departures::of_rig(question.rig, 0);
    let others = rig
        .others
        .iter()
        .filter(|e| !small_motion::is_small(e.name));
    let others: Vec<&str> = others.map(|e| e.name.name()).collect();
    if !others.is_empty() {
        notes.push(format!(
            "small motions are without {} of plant.effects: the planned motion has it",
            others.join(", ")
        ));
    }
    if question.rig.specimen.kind != plant::specimen::SpecimenKind::Linear {
        notes.push("in small motions the specimen has its initial stiffness".into());
    }
    if !growth::is_linear(question.config.compensation.kind) {
        notes.push(
            "small motions of such a loop do not decide what larger ones do: the planned motion does".into(),
        );
    }
    notes
}
