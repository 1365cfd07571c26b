//! The verdicts against what the tests then do, over many rigs: every method and predictor, delays of 0 to 80 ms, one to
//! three storeys, specimens that yield, noise, converters, and compensations with a wrong declared delay.
//!
//! The test that counts is not the one that was checked: it is run twice with other noise.

use experiment::Experiment;
use experiment::compensation::Compensation;
use experiment::coupled;
use experiment::coupled::table::CoupledCompensation;
use experiment::failure::Failure;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::soundness::{SoundnessVerdict, judge, ran_away};
use experiment::stability::perturbed::Spread;
use experiment::summary::POOR_EPS_RMS;
use outerloop_core::{Force, Method, Prediction};
use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardUniform};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use serde::{Serialize, Serializer};
use std::fmt::Write;
use std::path::Path;

/// Longest delay, ms.
const LONGEST_MS: f64 = 80.0;
/// Duration of a test, s of model time.
const SECONDS: f64 = 20.0;
/// Mass of each storey, kg.
const MASS_KG: f64 = 1000.0;
/// Spread of the rigs on which the verdict tries the planned motion.
const SPREAD: Spread = Spread {
    plants: 0,
    seed: 1,
    delay: 0.10,
    gain: 0.02,
    stiffness: 0.05,
    damping: 0.2,
};

/// Number of rigs drawn around actuators that are known only by declaration.
const COUPLED_PLANTS: usize = 30;

/// What the check knows of a rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Known {
    /// The rig itself.
    Rig,
    /// Two coupled actuators as declared; the test then runs on others.
    AsDeclared,
}

/// What a test did.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ActualOutcome {
    /// It ran to its end, and its result is accurate to 10 % rms.
    Sound,
    /// It tripped, or ran to its end with another result.
    Wrong,
    /// It ran away.
    RanAway,
}

impl ActualOutcome {
    /// What such tests did, as words in tables.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Sound => "were sound",
            Self::Wrong => "were wrong",
            Self::RanAway => "ran away",
        }
    }
}

/// A rig, its verdict, and what it did.
#[derive(Clone, Debug, Serialize)]
pub struct SurveyCase {
    /// Compensation.
    #[serde(serialize_with = "by_name")]
    pub compensation: Compensation,
    /// The test file.
    pub test: String,
    /// The verdict.
    pub verdict: SoundnessVerdict,
    /// Why.
    pub reason: String,
    /// The expected error.
    pub expected_eps_rms: f64,
    /// What it did, the worse of two.
    pub truth: ActualOutcome,
    /// Its error.
    pub eps_rms: f64,
}

fn by_name<S: Serializer>(compensation: &Compensation, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(compensation.name())
}

/// Draws uniformly.
pub(super) struct UniformDraws(Xoshiro256PlusPlus);

impl UniformDraws {
    pub(super) fn new(seed: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        let unit: f64 = StandardUniform.sample(&mut self.0);
        low + unit * (high - low)
    }

    pub(super) fn with_probability(&mut self, share: f64) -> bool {
        self.between(0.0, 1.0) < share
    }

    pub(super) fn one_of<T: Copy>(&mut self, among: &[T]) -> T {
        let place = self.between(0.0, among.len() as f64) as usize;
        among[place.min(among.len() - 1)]
    }
}

/// This many test files, with the methods in turn.
pub fn draw(rigs: usize, seed: u64) -> Vec<String> {
    let mut rng = UniformDraws::new(seed);
    let range = DrawRange {
        seconds: SECONDS,
        latest: |_| LONGEST_MS,
        rightly_declared: 0.6,
        predictors: Prediction::ALL.to_vec(),
    };
    let methods = Method::ALL.into_iter().cycle();
    methods
        .take(rigs)
        .map(|method| test_file(method, &mut rng, &range))
        .collect()
}

/// Range of the draw.
pub(super) struct DrawRange {
    /// Length of the tests, s of model time.
    pub(super) seconds: f64,
    /// Longest delay, ms, by the structure's first frequency, Hz.
    pub(super) latest: fn(f64) -> f64,
    /// Fraction of compensations with the correct declared delay; for the others it is wrong by up to 20 %.
    pub(super) rightly_declared: f64,
    /// Predictors, one of which is used in half of the tests.
    pub(super) predictors: Vec<Prediction>,
}

pub(super) fn test_file(method: Method, rng: &mut UniformDraws, range: &DrawRange) -> String {
    let storeys = rng.one_of(&[1_usize, 1, 2, 3]);
    let first_hz = rng.between(0.5, 4.0);
    // Equal storeys: omega_1 = 2 sqrt(k/m) sin(pi / (4 n + 2)).
    let sine = (std::f64::consts::PI / (4 * storeys + 2) as f64).sin();
    let root = std::f64::consts::TAU * first_hz / (2.0 * sine);
    let stiffness = MASS_KG * root * root;
    let list = |x: f64| format!("{:?}", vec![x; storeys]);
    let damping = rng.between(0.01, 0.05);
    let physical = rng.one_of(&[1, storeys]);
    let mut text = format!(
        "[structure]\nmass_kg = {}\nstiffness_n_per_m = {}\ndamping_ratio = {}\nphysical_storeys = {physical}\n",
        list(MASS_KG),
        list(stiffness),
        list(damping)
    );
    let rate_hz = rng.one_of(&[1000, 2000]);
    let peak_mm = rng.between(10.0, 50.0);
    let _ = write!(
        text,
        "[loop]\nrate_hz = {rate_hz}\n[excitation]\npeak_response_mm = {peak_mm}\nduration_s = {}\n",
        range.seconds
    );

    // Short delays more often than long ones, with which few tests are sound.
    let delay_ms = (range.latest)(first_hz) * rng.between(0.0, 1.0).powi(2);
    let kind = rng.one_of(&["delay", "first_order", "second_order", "lag_delay"]);
    let (delay_ms, lag_ms) = match kind {
        "lag_delay" => (0.6 * delay_ms, 0.4 * delay_ms),
        _ => (delay_ms, 0.0),
    };
    let _ = writeln!(
        text,
        "[plant.actuator]\nkind = '{kind}'\ndelay_ms = {delay_ms}"
    );
    if lag_ms > 0.0 {
        let _ = writeln!(text, "lag_ms = {lag_ms}");
    }

    if rng.with_probability(0.5) {
        let kind = rng.one_of(&["bilinear", "bouc_wen"]);
        let yield_mm = peak_mm * rng.between(0.3, 1.0) / storeys as f64;
        let hardening = rng.between(0.03, 0.3);
        let _ = writeln!(
            text,
            "[plant.specimen]\nkind = '{kind}'\nyield_mm = {yield_mm}\nhardening_ratio = {hardening}"
        );
    }

    let noisy = rng.with_probability(0.7);
    if noisy {
        let noise_mm = rng.between(0.001, 0.03);
        let noise_n = 0.5 * stiffness * noise_mm * 1e-3;
        let _ = writeln!(
            text,
            "[plant.sensors]\ndisplacement_noise_mm = {noise_mm}\nforce_noise_n = {noise_n}"
        );
        if rng.with_probability(0.5) {
            let _ = writeln!(text, "bits = 16\ndisplacement_range_mm = 250");
        }
    }

    let method = if rng.with_probability(0.5) {
        method.behind(rng.one_of(&range.predictors))
    } else {
        method
    };
    let _ = writeln!(text, "[compensation]\nkind = '{}'", method.name());
    if noisy {
        text.push_str("window_steps = 10\n");
    }
    let declared = if rng.with_probability(range.rightly_declared) {
        1.0
    } else {
        rng.between(0.8, 1.2)
    };
    let declared_ms = (declared * (delay_ms + lag_ms)).max(0.01);
    let _ = writeln!(text, "delay_ms = {declared_ms}");
    text
}

/// The verdict of `check`, its reason, and the error that it expects.
fn said(e: &Experiment, plants: usize) -> Result<(SoundnessVerdict, String, f64), Failure> {
    let said = if e.test.coupled_part().is_ok() {
        let spread = Spread { plants, ..SPREAD };
        let (said, ..) = coupled::planned::check(e, &spread, || ())?;
        said.judgement
    } else {
        judge(e, &SPREAD, || ())?
    };
    Ok((said.verdict, said.reason, said.expected_eps_rms))
}

/// The same with the declared actuators in place of the rig's.
fn as_declared(e: &Experiment) -> Result<Experiment, Failure> {
    let part = e.test.coupled_part()?;
    let mut rig = part.rig.clone();
    rig.actuators = part.declared.actuators.clone();
    e.on_coupled_rig(rig)
}

/// Judges `text` and runs it.
fn case(text: &str, known: Known) -> Result<SurveyCase, Failure> {
    let test = TestFile::parse(text, "survey", Path::new(""), &[])?;
    let e = Experiment::new(test, &near_fault(), None)?;
    let compensation = e.test.compensation();
    let (verdict, reason, expected_eps_rms) = match known {
        Known::Rig => said(&e, 0)?,
        Known::AsDeclared => said(&as_declared(&e)?, COUPLED_PLANTS)?,
    };
    let ideal = e.ideal()?;
    let (mut truth, mut eps_rms) = (ActualOutcome::Sound, 0.0_f64);
    for seed in [101, 102] {
        let did = e.run(compensation, &ideal, seed, false, ())?.summary;
        eps_rms = eps_rms.max(did.eps_rms);
        if ran_away(&did) {
            truth = ActualOutcome::RanAway;
        } else if truth == ActualOutcome::Sound
            && (did.error() > POOR_EPS_RMS || did.eps_rms.is_nan())
        {
            truth = ActualOutcome::Wrong;
        }
    }
    Ok(SurveyCase {
        compensation,
        test: text.to_owned(),
        verdict,
        reason,
        expected_eps_rms,
        truth,
        eps_rms,
    })
}

/// All of `tests`, on all cores. `one_done` is called after each.
///
/// # Errors
/// A test that cannot be judged.
pub fn run(
    tests: &[String],
    known: Known,
    one_done: impl Fn() + Sync,
) -> Result<Vec<SurveyCase>, Failure> {
    tests
        .par_iter()
        .map(|text| {
            let case = case(text, known);
            one_done();
            case
        })
        .collect()
}

/// How often each verdict was given to tests with the same outcome.
#[derive(Clone, Debug, Serialize)]
pub struct VerdictCounts {
    /// Which tests.
    pub tests: String,
    /// What they did.
    pub truth: ActualOutcome,
    /// How many.
    pub count: usize,
    /// Called stable, doubtful, unstable.
    pub called: [usize; 3],
}

impl VerdictCounts {
    fn of<'a>(
        tests: &str,
        truth: ActualOutcome,
        cases: impl Iterator<Item = &'a SurveyCase>,
    ) -> Self {
        let mut called = [0; 3];
        for case in cases.filter(|case| case.truth == truth) {
            called[case.verdict as usize] += 1;
        }
        Self {
            tests: tests.to_owned(),
            truth,
            count: called.iter().sum(),
            called,
        }
    }
}

/// All tests, then those of each force law and of each predictor, or of each compensation of coupled actuators.
pub fn table(cases: &[SurveyCase]) -> Vec<VerdictCounts> {
    const TRUTHS: [ActualOutcome; 3] = [
        ActualOutcome::Sound,
        ActualOutcome::Wrong,
        ActualOutcome::RanAway,
    ];
    let all = TRUTHS.map(|truth| VerdictCounts::of("all", truth, cases.iter()));
    let forces = Force::ALL.iter().flat_map(|force| {
        let own = |case: &&SurveyCase| {
            matches!(case.compensation, Compensation::Method(m) if m.force == *force)
        };
        let name = format!("force {}", force.name());
        TRUTHS.map(|truth| VerdictCounts::of(&name, truth, cases.iter().filter(own)))
    });
    let predictors = Prediction::ALL.iter().flat_map(|predictor| {
        let own = |case: &&SurveyCase| {
            matches!(case.compensation, Compensation::Method(m) if m.predictor == *predictor)
        };
        let name = format!("predictor {}", predictor.name());
        TRUTHS.map(|truth| VerdictCounts::of(&name, truth, cases.iter().filter(own)))
    });
    let coupled = CoupledCompensation::ALL.iter().flat_map(|kind| {
        let own = |case: &&SurveyCase| case.compensation == Compensation::Coupled(*kind);
        TRUTHS.map(|truth| VerdictCounts::of(kind.name(), truth, cases.iter().filter(own)))
    });
    let of_frames = all.into_iter().chain(forces).chain(predictors);
    of_frames.chain(coupled).collect()
}
