//! Whether a test of two coupled actuators may be run: the declared rig, rigs that differ from it, and the limits.

use super::table::CoupledLimits;
use crate::compensation::Compensation;
use crate::experiment::Experiment;
use crate::failure::Failure;
use crate::judged::JudgedRun;
use crate::numbers::percent;
use crate::soundness::SoundnessVerdict;
use crate::stability::perturbed::Spread;
use crate::summary::{POOR_EPS_RMS, Summary, TestVerdict, Validity};
use crate::trace::{Response, Trace};
use plant::coupled::CoupledRigSpec;
use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

/// A limit, and how much of it the planned motion takes.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct LimitUse {
    /// Its key in `[coupled.limits]`.
    pub name: &'static str,
    /// What it is of.
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

/// What the check says. The keys that other checks have, too, mean the same.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct CoupledCheck {
    /// The verdict.
    pub verdict: SoundnessVerdict,
    /// Why.
    pub reason: String,
    /// eps_rms on the rig as declared, worst coordinate.
    pub expected_eps_rms: f64,
    /// The same, worst of the rigs that differ and went to their end.
    pub expected_eps_rms_differing: f64,
    /// Rigs that differ.
    pub plants: usize,
    /// Of those, tests that tripped or ran away.
    pub lost: usize,
    /// The limits.
    pub limits: Vec<LimitUse>,
    /// The test on the rig as declared.
    pub planned: Summary,
}

/// A check, and the test on the rig as declared.
pub type CheckedTrial = (CoupledCheck, Response, JudgedRun);

/// From this share of a limit on, a planned motion is near it.
const NEAR: f64 = 0.9;

/// Plans the test on the rig that the test file declares, with its sensors, and on rigs that differ from it by `spread`: poles,
/// zeros and delays by the spread of the delay, gains and the specimen's stiffness and damping by theirs.
///
/// # Errors
/// A test that cannot be laid out.
pub fn check(
    experiment: &Experiment,
    kind: Compensation,
    spread: &Spread,
    one_done: impl Fn() + Sync,
) -> Result<CheckedTrial, Failure> {
    let part = experiment.test.coupled_part()?;
    let (d, mut rig) = (&part.declared, part.rig.clone());
    rig.ideal = false;
    (rig.actuators, rig.specimen.stiffness) = (d.actuators.clone(), d.specimen.stiffness);
    (rig.specimen.damping, rig.specimen.mass) = (d.specimen.damping, d.specimen.mass);
    let on = |rig: CoupledRigSpec, keep: bool| {
        let own = experiment.on_coupled_rig(rig)?;
        let ideal = own.ideal()?;
        let run = own.run(kind, &ideal, spread.seed, keep, ())?;
        Ok::<_, Failure>((ideal, run))
    };
    let (ideal, run) = on(rig.clone(), true)?;
    let others = (0..spread.plants)
        .into_par_iter()
        .map(|i| {
            let (_, other) = on(differing(&rig, spread, i as u64), false)?;
            one_done();
            Ok(other.summary)
        })
        .collect::<Result<Vec<_>, Failure>>()?;
    let planned = &run.summary;
    let went = |s: &&Summary| s.verdict == TestVerdict::Completed;
    let lost = others.iter().filter(|s| !went(s)).count();
    let worst = others.iter().filter(went).map(|s| s.eps_rms);
    let worst = worst.fold(planned.eps_rms, f64::max);
    let limits = run
        .trace
        .as_ref()
        .map_or_else(Vec::new, |trace| limits(&d.limits, trace));
    let (verdict, reason) = judge(planned, (lost, spread.plants), worst, &limits);
    let check = CoupledCheck {
        verdict,
        reason,
        expected_eps_rms: planned.eps_rms,
        expected_eps_rms_differing: worst,
        plants: spread.plants,
        lost,
        limits,
        planned: planned.clone(),
    };
    Ok((check, ideal, run))
}

fn judge(
    planned: &Summary,
    (lost, plants): (usize, usize),
    worst: f64,
    limits: &[LimitUse],
) -> (SoundnessVerdict, String) {
    if planned.validity() == Validity::Bad {
        return (
            SoundnessVerdict::Unstable,
            format!(
                "the planned motion on the rig as declared: {}",
                planned.sentence()
            ),
        );
    }
    if lost > 0 {
        return (
            SoundnessVerdict::Doubtful,
            format!(
                "{lost} of {plants} rigs that differ from the declared one tripped or ran away"
            ),
        );
    }
    if worst > POOR_EPS_RMS {
        return (
            SoundnessVerdict::Doubtful,
            format!("on a rig that differs the error is {}", percent(worst)),
        );
    }
    if let Some(near) = limits.iter().find(|l| l.share > NEAR) {
        return (
            SoundnessVerdict::Doubtful,
            format!(
                "the planned motion takes {} of coupled.limits.{} ({})",
                percent(near.share),
                near.name,
                near.of
            ),
        );
    }
    (
        SoundnessVerdict::Stable,
        format!(
            "the planned motion stays inside the limits, on the rig as declared and on {plants} that differ"
        ),
    )
}

/// A rig that differs; `index` draws it.
fn differing(declared: &CoupledRigSpec, spread: &Spread, index: u64) -> CoupledRigSpec {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(
        spread.seed ^ (index + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15),
    );
    let mut factor = |share: f64| {
        let normal: f64 = StandardNormal.sample(&mut random);
        // Farther than three deviations would be another machine; a time is not below a twentieth of itself.
        (1.0 + share * normal.clamp(-3.0, 3.0)).max(0.05)
    };
    let mut rig = declared.clone();
    let a = &mut rig.actuators;
    for pole in a.slow_pole_hz.iter_mut().chain(&mut a.fast_pole_hz) {
        *pole *= factor(spread.delay);
    }
    for time in a
        .lead_ms
        .as_flattened_mut()
        .iter_mut()
        .chain(a.path_lead_ms.as_flattened_mut())
        .chain(&mut a.delay_ms)
    {
        *time *= factor(spread.delay);
    }
    a.natural_hz *= factor(spread.delay);
    for gain in a.gain.as_flattened_mut() {
        *gain *= factor(spread.gain);
    }
    let scale =
        |m: &mut [[f64; 2]; 2], by: f64| m.as_flattened_mut().iter_mut().for_each(|x| *x *= by);
    scale(&mut rig.specimen.stiffness, factor(spread.stiffness));
    scale(&mut rig.specimen.damping, factor(spread.damping));
    rig
}

/// What the first limits are of.
const ACTUATOR: &str = "worse actuator";

/// How much of each limit a test took.
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
    // In the order of the limits; the last of them, of readings that stand still, is none of the motion.
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
