//! Whether a test may be run: what becomes of small motions of its loop, and the planned motion itself on the simulated rig.
//!
//! | loop | decided by |
//! |---|---|
//! | fixed force and predictor, linear specimen | small motions, and the planned motion |
//! | the same, and a specimen that yields | both have to agree |
//! | variable damping, corrected force, a predictor that learns | the planned motion |
//! | two coupled actuators | the planned motion |
//!
//! The planned motion runs with the noise, the bits, the yielding and the effects of the test file, on the rig as it is
//! and on two that differ from it by a standard deviation, later and stronger, sooner and weaker; with `amb`, which learns
//! from the noise, also under ten other noises.
//!
//! # Limitations
//! The rig is the simulated one. What is not in `[plant]` is in no verdict.

use crate::compensation::Compensation;
use crate::experiment::Experiment;
use crate::failure::Failure;
use crate::files::test::TestFile;
use crate::numbers::{growth_percent, percent, percent_or_lost};
use crate::stability::growth::is_linear;
use crate::stability::perturbed::Spread;
use crate::stability::small_motion::Learning;
use crate::stability::structure_modes::StructureModes;
use crate::stability::variation::Variation;
use crate::summary::{GOOD_EPS_RMS, POOR_EPS_RMS, Summary, TestVerdict};
use crate::trace::Response;
use crate::watch::WatchReport;
use outerloop_core::config::Amb;
use outerloop_core::{Config, Prediction};
use plant::actuator::ActuatorKind;
use plant::specimen::SpecimenKind;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

/// The answer. In this order the exit status is 0, 1 and 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SoundnessVerdict {
    /// It may be run; its error is the expected one, `expected_eps_rms`.
    Stable,
    /// It may run away, or its result would not be the structure's.
    Doubtful,
    /// It runs away.
    Unstable,
}

impl SoundnessVerdict {
    /// The word in JSON and tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Doubtful => "doubtful",
            Self::Unstable => "unstable",
        }
    }

    /// What the exit status says of it, with `said`.
    ///
    /// # Errors
    /// Every verdict but stable.
    pub fn outcome(self, said: String) -> Result<(), Failure> {
        match self {
            Self::Stable => Ok(()),
            Self::Doubtful => Err(Failure::test(said)),
            Self::Unstable => Err(Failure::Unstable(said)),
        }
    }
}

/// A verdict and its reasons.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Judgement {
    /// The answer.
    pub verdict: SoundnessVerdict,
    /// Why.
    pub reason: String,
    /// eps_rms of the planned motion on the rig as it is; infinite (null in JSON) where it does not run to its end.
    pub expected_eps_rms: f64,
    /// The larger eps_rms on the two rigs that differ from it; infinite (null in JSON) likewise.
    pub expected_eps_rms_differing: f64,
    /// What the rig watch says of the planned motion on the rig as it is, and what it would name; null if it is off.
    pub watch: Option<WatchReport>,
}

impl Judgement {
    /// Says which other compensations the planned motion would be good with, unless it is good as it is.
    ///
    /// # Errors
    /// A test that cannot run.
    pub fn add_alternatives(&mut self, e: &Experiment) -> Result<(), Failure> {
        if self.verdict == SoundnessVerdict::Stable {
            return Ok(());
        }
        let others: Vec<String> = alternatives(e, GOOD_EPS_RMS)?
            .into_iter()
            .take(3)
            .map(|(name, eps)| format!("{name} ({})", percent(eps)))
            .collect();
        if !others.is_empty() {
            self.reason += &format!(
                "; the planned motion is good with the compensations {}",
                others.join(", ")
            );
        }
        Ok(())
    }
}

/// What small motions of a loop do, as far as a verdict needs it.
#[derive(Clone, Copy, Debug)]
struct Small {
    stable: bool,
    /// 1/s of model time.
    growth_per_s: f64,
}

impl Small {
    fn of(e: &Experiment) -> Result<Self, Failure> {
        let question = e.small_motions(Learning::On)?;
        let structure = StructureModes::of(&e.test.config)?;
        let row = question.small_motions(&structure, &Variation::NONE)?;
        Ok(Self {
            stable: row.stable,
            growth_per_s: row.growth_per_s,
        })
    }
}

/// Largest motion, m, for which the published gains of `amb` are: that of the benchmark problem, 8 mm, and some more. Its law
/// is scaled by the square of the jerk.
const PUBLISHED_AMB_PEAK_M: f64 = 0.01;

/// Number of other noises under which the planned motion runs: what is learnt may be right by chance.
const OTHER_NOISES: u64 = 10;

/// True where `amb` has its published gains and the motion is not one that they are for.
fn amb_gains_of_another_motion(config: &Config, peak_m: f64) -> bool {
    let c = &config.compensation;
    c.kind.predictor == Prediction::Amb
        && c.amb.gains == Amb::default().gains
        && peak_m > PUBLISHED_AMB_PEAK_M
}

/// True where the loop is linear but for its specimen. That of two coupled actuators turns forces with the interface.
pub fn fixed(test: &TestFile) -> bool {
    let random = test.plant.actuator.kind == ActuatorKind::RandomMultiplier;
    test.coupled.is_none() && is_linear(test.config.compensation.kind) && !random
}

/// The test on the rig as it is, and on two others.
struct Runs {
    own: Summary,
    later: Summary,
    sooner: Summary,
}

fn runs(
    e: &Experiment,
    ideal: &Response,
    spread: &Spread,
    one_done: impl Fn() + Sync,
) -> Result<Runs, Failure> {
    let by = |sign: f64| Variation {
        delay: 1.0 + sign * spread.delay,
        gain: 1.0 + sign * spread.gain,
        ..Variation::NONE
    };
    let rigs = [Variation::NONE, by(1.0), by(-1.0)];
    let run = |(i, vary): (usize, &Variation)| {
        let seed = spread.seed.wrapping_add(i as u64);
        let summary = planned(&e.on_rig(vary), ideal, seed);
        one_done();
        summary
    };
    let summaries: Result<Vec<_>, _> = rigs.par_iter().enumerate().map(run).collect();
    let [own, later, sooner] = <[Summary; 3]>::try_from(summaries?)
        .map_err(|_| Failure::test("three rigs gave another number of tests".to_owned()))?;
    Ok(Runs { own, later, sooner })
}

/// False where small motions of a loop that they decide over grow.
///
/// # Errors
/// A test that cannot run.
pub fn small_motions_decay(e: &Experiment) -> Result<bool, Failure> {
    Ok(!fixed(&e.test) || Small::of(e)?.stable)
}

/// The figures of the planned motion.
///
/// # Errors
/// A test that cannot run.
pub fn planned(e: &Experiment, ideal: &Response, seed: u64) -> Result<Summary, Failure> {
    Ok(e.run(e.test.compensation(), ideal, seed, false, ())?
        .summary)
}

/// True where a test ran away or was stopped when it did.
pub fn ran_away(s: &Summary) -> bool {
    match s.verdict {
        TestVerdict::Diverged => true,
        // A limit that stops a sound test is a matter of the limit.
        TestVerdict::Tripped => s.eps_max.is_nan() || s.eps_max > 1.0,
        TestVerdict::Completed | TestVerdict::Stopped => false,
    }
}

/// Judges a test. `one_done` is called after each of its three runs.
///
/// # Errors
/// A test that cannot run.
pub fn judge(
    e: &Experiment,
    spread: &Spread,
    one_done: impl Fn() + Sync,
) -> Result<Judgement, Failure> {
    let ideal = e.ideal()?;
    let runs = runs(e, &ideal, spread, one_done)?;
    let small = match e.test.coupled {
        None => Some(Small::of(e)?),
        Some(_) => None,
    };
    let (mut verdict, mut reason) = decide(e, small.as_ref(), spread, &runs);
    if verdict == SoundnessVerdict::Stable
        && let Some(doubt) = of_learnt_noise(e, &ideal, &runs.own, spread.seed)?
    {
        (verdict, reason) = (SoundnessVerdict::Doubtful, doubt);
    }
    Ok(Judgement {
        verdict,
        reason,
        expected_eps_rms: runs.own.error(),
        expected_eps_rms_differing: runs.later.error().max(runs.sooner.error()),
        watch: runs.own.watch,
    })
}

fn decide(
    e: &Experiment,
    small: Option<&Small>,
    spread: &Spread,
    runs: &Runs,
) -> (SoundnessVerdict, String) {
    let fixed = fixed(&e.test);
    let elastic = e.test.plant.specimen.kind == SpecimenKind::Linear;
    of_small_and_planned_motion(small, &runs.own, fixed, elastic)
        .or_else(|| of_rigs_that_differ(spread, runs))
        .unwrap_or_else(|| {
            let by = match small {
                Some(_) if fixed && elastic => "small motions decay, and the planned motion",
                Some(_) => "small motions do not decide over such a loop; the planned motion",
                None => "the planned motion",
            };
            let said = format!(
                "{by} ran to its end on the simulated rig, and on two that differ from it, with an error of {} rms",
                percent(runs.own.eps_rms)
            );
            (SoundnessVerdict::Stable, said)
        })
}

/// What is wrong on the simulated rig itself.
fn of_small_and_planned_motion(
    small: Option<&Small>,
    own: &Summary,
    fixed: bool,
    elastic: bool,
) -> Option<(SoundnessVerdict, String)> {
    use SoundnessVerdict::{Doubtful, Unstable};
    let grows =
        small
            .filter(|small| !small.stable)
            .map(|small| match small.growth_per_s.exp_m1() {
                a_second if a_second.is_finite() => {
                    format!(
                        "small motions grow by {} a second",
                        growth_percent(a_second)
                    )
                }
                _ => "small motions grow at once".to_owned(),
            });
    if ran_away(own) {
        let grows = grows.map_or_else(String::new, |grows| format!(", and {grows}"));
        let said = format!(
            "the planned motion runs away on the simulated rig: the error grows to {} of the largest ideal \
             displacement{grows}",
            percent(own.eps_max)
        );
        return Some((Unstable, said));
    }
    let grows = grows.filter(|_| fixed);
    if let Some(grows) = grows.clone().filter(|_| elastic) {
        return Some((Unstable, grows));
    }
    if let (TestVerdict::Tripped, Some(t)) = (own.verdict, own.trip_detail) {
        let (what, against) = own.trip_in_words(t);
        let said = format!("the planned motion trips on {what} on the simulated rig: {against}");
        return Some((Doubtful, said));
    }
    if own.eps_rms > POOR_EPS_RMS {
        let said = format!(
            "the planned motion stays bounded, but its error is {} rms: that is not the structure's response",
            percent(own.eps_rms)
        );
        return Some((Doubtful, said));
    }
    grows.map(|grows| {
        let said = format!(
            "{grows} while the specimen is elastic; the planned motion ran to its end with {} rms only because it yields",
            percent(own.eps_rms)
        );
        (Doubtful, said)
    })
}

/// What is wrong on the two that differ from it.
fn of_rigs_that_differ(spread: &Spread, runs: &Runs) -> Option<(SoundnessVerdict, String)> {
    for (run, sign, how) in [
        (&runs.later, '+', "later and stronger"),
        (&runs.sooner, '-', "sooner and weaker"),
    ] {
        if ran_away(run) {
            let said = format!(
                "the planned motion runs away on a rig that is {how} (delay {sign}{}, gain {sign}{})",
                percent(spread.delay),
                percent(spread.gain)
            );
            return Some((SoundnessVerdict::Doubtful, said));
        }
    }
    None
}

/// What may be wrong under other noise with `amb`, which learns from the noise, most of all while the test does not move.
fn of_learnt_noise(
    e: &Experiment,
    ideal: &Response,
    own: &Summary,
    seed: u64,
) -> Result<Option<String>, Failure> {
    let config = &e.test.config;
    if config.compensation.kind.predictor != Prediction::Amb {
        return Ok(None);
    }
    // It learns from the measured displacement; hum is the same in every run.
    let sensors = &e.test.plant.sensors;
    if sensors
        .displacement_noise_mm
        .max(sensors.displacement_coloured_noise_mm)
        > 0.0
    {
        return under_other_noise(e, ideal, seed);
    }
    let untried = amb_gains_of_another_motion(config, own.peak_displacement_m);
    Ok(untried.then(|| {
        format!(
            "the planned motion has an error of {} rms, but `amb` has the gains published for motions of {:.0} mm, this one is \
             of {:.0} mm, and plant.sensors has no displacement noise: with noise such a test may run away; state it, or \
             compensation.amb.gains",
            percent(own.eps_rms),
            PUBLISHED_AMB_PEAK_M * 1e3,
            own.peak_displacement_m * 1e3
        )
    }))
}

/// Doubts about the planned motion under other noise.
///
/// # Errors
/// A test that cannot run.
pub(crate) fn under_other_noise(
    e: &Experiment,
    ideal: &Response,
    seed: u64,
) -> Result<Option<String>, Failure> {
    // The first seeds belong to the rig itself and to the two that differ.
    let seeds = (0..OTHER_NOISES)
        .into_par_iter()
        .map(|i| seed.wrapping_add(10 + i));
    let errors = seeds.map(|seed| Ok(planned(e, ideal, seed)?.error()));
    let errors = errors.collect::<Result<Vec<_>, Failure>>()?;
    Ok(poor(&errors).map(|(count, worst)| {
        format!(
            "under {count} of {OTHER_NOISES} other noises the planned motion has an error above {}, at worst {worst}",
            percent(POOR_EPS_RMS),
        )
    }))
}

/// The number of poor errors among these, and the worst in words; `None` if none is poor.
pub(crate) fn poor(errors: &[f64]) -> Option<(usize, String)> {
    let count = errors.iter().filter(|eps| **eps > POOR_EPS_RMS).count();
    let worst = errors.iter().copied().fold(0.0, f64::max);
    (count > 0).then(|| (count, percent_or_lost(worst)))
}

/// The other compensations with which the planned motion runs to its end with an error of at most `eps_rms`, the best
/// first.
///
/// # Errors
/// A test that cannot run.
pub fn alternatives(e: &Experiment, eps_rms: f64) -> Result<Vec<(&'static str, f64)>, Failure> {
    let ideal = e.ideal()?;
    let own = e.test.compensation();
    let mut others = Compensation::all(e.test.coupled.is_some());
    others.retain(|other| *other != own);
    let mut good = others
        .into_par_iter()
        .map(|other| {
            let summary = e.run(other, &ideal, 1, false, ())?.summary;
            Ok((other.name(), summary.error()))
        })
        .collect::<Result<Vec<_>, Failure>>()?;
    good.retain(|(_, eps)| *eps <= eps_rms);
    good.sort_by(|a, b| a.1.total_cmp(&b.1));
    Ok(good)
}

#[cfg(test)]
mod tests {
    use super::*;
    use outerloop_core::Method;

    #[test]
    fn amb_with_its_published_gains_is_for_small_motions_alone() {
        let mut config = Config::shear_frame([1000.0], [158e3], [0.02]);
        config.compensation.kind = Method::Amb;
        assert!(amb_gains_of_another_motion(&config, 0.02));
        assert!(!amb_gains_of_another_motion(&config, 0.008));
        config.compensation.kind = Method::Paper.behind(Prediction::Amb);
        assert!(amb_gains_of_another_motion(&config, 0.02));
        config.compensation.amb.gains = [1e6, 1e4, 1.0, 0.1];
        assert!(!amb_gains_of_another_motion(&config, 0.02));
        config.compensation = Default::default();
        assert!(!amb_gains_of_another_motion(&config, 0.02));
    }
}
