//! Whether a test of two coupled actuators may be run: the verdict of any test, its limits, a stop, and drawn rigs.

use super::stop;
use super::table::CoupledLimits;
use crate::drawn::DrawnRigs;
use crate::experiment::Experiment;
use crate::failure::Failure;
use crate::judged::JudgedRun;
use crate::numbers::percent;
use crate::soundness::{self, Judgement, SoundnessVerdict};
use crate::stability::perturbed::Spread;
use crate::summary::{POOR_EPS_RMS, Summary};
use crate::trace::{Response, Trace};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

/// A limit, and how much of it the planned motion takes.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct LimitUse {
    /// Its key in `[coupled.limits]`.
    pub name: &'static str,
    /// What it limits: an actuator, x or the rotation.
    pub of: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Largest value of the planned motion.
    pub planned: f64,
    /// The limit.
    pub limit: f64,
    /// The first over the second.
    pub share: f64,
}

/// The answer of the check. Keys that other checks also have mean the same.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct CoupledCheck {
    /// The verdict and its reasons.
    #[serde(flatten)]
    pub judgement: Judgement,
    /// Number of rigs drawn around the simulated one. They count for the verdict if its actuators are the declared ones.
    pub plants: usize,
    /// How many of their tests tripped or ran away.
    pub lost: usize,
    /// Largest eps_rms on the drawn rigs on which the test ran to its end.
    pub drawn_eps_rms: f64,
    /// The limits.
    pub limits: Vec<LimitUse>,
    /// The test on the simulated rig.
    pub planned: Summary,
}

/// The check, and the test on the simulated rig.
pub type CheckedTrial = (CoupledCheck, Response, JudgedRun);

/// A planned motion is near a limit from this fraction of it.
const NEAR: f64 = 0.9;

/// Judges a test like any other, and by its limits and a stop. It also runs on rigs drawn around the simulated one,
/// which count if its actuators are the declared ones. Each of their numbers varies independently: poles, zeros and
/// delays with the spread of the delay, gains and the specimen's stiffness and damping with their own. The test file
/// declares the actuators' spreads in `[coupled.spread]`.
///
/// # Errors
/// A test that cannot be set up.
pub fn check(
    e: &Experiment,
    spread: &Spread,
    one_done: impl Fn() + Sync,
) -> Result<CheckedTrial, Failure> {
    let part = e.test.coupled_part()?;
    let rigs = DrawnRigs::around(e, spread);
    let spread = rigs.spread();
    let mut judgement = soundness::judge(e, spread, || ())?;
    let kind = e.test.compensation();
    let ideal = e.ideal()?;
    let run = e.run(kind, &ideal, spread.seed, true, ())?;
    let limits = run
        .trace
        .as_ref()
        .map_or_else(Vec::new, |trace| limits(&part.declared.limits, trace));
    let drawn = (0..spread.plants)
        .into_par_iter()
        .map(|i| {
            let own = rigs.test(i)?;
            let summary = own
                .run(kind, &own.ideal()?, spread.seed, false, ())?
                .summary;
            one_done();
            Ok(summary.error())
        })
        .collect::<Result<Vec<_>, Failure>>()?;
    if judgement.verdict == SoundnessVerdict::Stable {
        let mut doubt = near_a_limit(&limits);
        if doubt.is_none() {
            doubt = soundness::under_other_noise(e, &ideal, spread.seed)?;
        }
        if doubt.is_none() {
            doubt = stop::doubt(e, &ideal, spread.seed)?;
        }
        // If nobody says what the rig's actuators are, they may be any of those.
        if doubt.is_none() && part.rig.actuators == part.declared.actuators {
            doubt = on_a_drawn_rig(&drawn);
        }
        if let Some(reason) = doubt {
            (judgement.verdict, judgement.reason) = (SoundnessVerdict::Doubtful, reason);
        }
    }
    let went = drawn.iter().filter(|eps| eps.is_finite());
    let check = CoupledCheck {
        judgement,
        plants: spread.plants,
        lost: spread.plants - went.clone().count(),
        drawn_eps_rms: went.copied().fold(0.0, f64::max),
        limits,
        planned: run.summary.clone(),
    };
    Ok((check, ideal, run))
}

/// Doubts about a test with the declared actuators, from its errors on rigs drawn around them.
fn on_a_drawn_rig(drawn: &[f64]) -> Option<String> {
    soundness::poor(drawn).map(|(count, worst)| {
        format!(
            "on {count} of {} rigs that differ from the declared actuators by their spread the planned motion has an error above {}, at worst \
             {worst}: the test file leaves out what the rig's are ([plant.coupled.actuators])",
            drawn.len(),
            percent(POOR_EPS_RMS),
        )
    })
}

fn near_a_limit(limits: &[LimitUse]) -> Option<String> {
    let near = limits.iter().find(|l| l.share > NEAR)?;
    Some(format!(
        "the planned motion takes {} of coupled.limits.{} ({})",
        percent(near.share),
        near.name,
        near.of
    ))
}

/// What the first limits refer to.
const ACTUATOR: &str = "worse actuator";

/// The fraction of each limit that a test used.
fn limits(l: &CoupledLimits, trace: &Trace) -> Vec<LimitUse> {
    let Some(interface) = &trace.interface else {
        return Vec::new();
    };
    let (floors, rate) = (&trace.floors, trace.rate_hz);
    let most = |x: &[f32]| x.iter().fold(0.0, |m, u| f64::from(u.abs()).max(m));
    let fastest = |x: &[f32]| {
        x.windows(2)
            .fold(0.0, |m, w| (rate * f64::from((w[1] - w[0]).abs())).max(m))
    };
    let farthest = |a: &[f32], b: &[f32]| {
        a.iter()
            .zip(b)
            .fold(0.0, |m, (a, b)| f64::from((a - b).abs()).max(m))
    };
    let worse = |of: &dyn Fn(usize) -> f64| of(0).max(of(1));
    // In the order of the limits; the last one, for constant readings, does not concern the motion.
    let planned = [
        (ACTUATOR, "m", worse(&|i| most(&floors[i].sent_m))),
        (ACTUATOR, "m/s", worse(&|i| fastest(&floors[i].sent_m))),
        (ACTUATOR, "N", worse(&|i| most(&floors[i].force_n))),
        (
            ACTUATOR,
            "m",
            worse(&|i| farthest(&floors[i].displacement_m, &interface.wanted_m[i])),
        ),
        ("x", "m", most(&floors[0].command_m)),
        ("x", "m/s", fastest(&floors[0].command_m)),
        ("x", "N", most(&floors[0].estimated_force_n)),
        (
            "x",
            "m",
            farthest(&floors[0].estimated_displacement_m, &floors[0].command_m),
        ),
        ("rotation", "rad", most(&floors[1].command_m)),
        ("rotation", "rad/s", fastest(&floors[1].command_m)),
        ("rotation", "N m", most(&floors[1].estimated_force_n)),
        (
            "rotation",
            "rad",
            farthest(&floors[1].estimated_displacement_m, &floors[1].command_m),
        ),
    ];
    let row = |((name, limit), (of, unit, planned))| LimitUse {
        name,
        of,
        unit,
        planned,
        limit,
        share: planned / limit,
    };
    l.named().into_iter().zip(planned).map(row).collect()
}
