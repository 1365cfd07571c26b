//! One test of the survey, and what is kept of it.

use super::draw::Draw;
use super::effect::{DrawnEffect, Kind, Name};
use super::rig::DrawnRig;
use experiment::Experiment;
use experiment::failure::Failure;
use experiment::files::ground_motion::GroundMotionFile;
use experiment::files::test::TestFile;
use experiment::summary::{POOR_EPS_RMS, Summary, TestVerdict};
use experiment::trace::Response;
use experiment::watch::{WatchEvent, WatchReport};
use outerloop_core::Method;
use serde::Serialize;
use std::f64::consts::TAU;
use std::path::Path;

/// What the loop may correct for; less with a compensation that learns delay and gain itself.
const CORRECT: &str = "[watch]\ncorrect = ['lateness', 'gain', 'late_sensor']\n";
const CORRECT_BESIDE: &str = "[watch]\ncorrect = ['late_sensor']\n";
const UNGUARDED: &str = "[watch]\nguard = false\n";
const UNWATCHED: &str = "[watch]\non = false\n";
/// The energy monitor, for comparison with the watch: the default of `limits.energy_trip`.
const ENERGY_TRIP: f64 = 3.0;
/// Fraction of a recorded motion's sum of squares at which its strong part begins.
const BEGUN: f32 = 0.01;
/// Largest error of a test, as a fraction of the peak: that of a test that ran away.
const LOST: f64 = 1.0;

/// A sound test.
#[derive(Clone, Debug, Serialize)]
pub struct SoundTrial {
    /// Description of its rig.
    pub kind: String,
    /// False if the compensation does not fit the rig even with the specimen as declared: the test is not sound.
    pub counts: bool,
    /// It yields.
    pub yields: bool,
    /// It is declared elastic.
    pub declared_elastic: bool,
    /// It hardens, softens or degrades, and is declared linear.
    pub bends: bool,
    /// A name, which is false, and when it came.
    pub named: Option<String>,
    /// Its energy error passed the published threshold of 0.2.
    pub energy: bool,
    /// Error, as a fraction of the peak.
    pub eps: f64,
    /// The same if the loop may correct, which it does only after a name.
    pub corrected_eps: f64,
}

/// A test with one or two effects.
#[derive(Clone, Debug, Serialize)]
pub struct FaultTrial {
    /// Description of its rig.
    pub rig: String,
    /// The effect; the first of two.
    pub kind: Kind,
    /// The second of two.
    pub beside: Option<Kind>,
    /// It has two actuators.
    pub several: bool,
    /// The specimen is elastic, as declared.
    pub elastic: bool,
    /// False if even the test without the effect is not sound.
    pub counts: bool,
    /// Error without the effect, with it, and corrected, as a fraction of the peak.
    pub eps: [f64; 3],
    /// With an adaptive compensation, if requested.
    pub adaptive: Option<Learning>,
    /// The same without the watch, if the watch stopped the test.
    pub unwatched: Option<Unwatched>,
    /// The corrected test ran away or was stopped, and the other did not.
    pub unstable: bool,
    /// The other was stopped, and the corrected one went on, so its error is of a longer duration.
    pub longer: bool,
    /// The compensation learns delay and gain itself: only a late sensor is corrected for.
    pub learns: bool,
    /// The first name, in words.
    pub named: Option<String>,
    /// The last name, in words.
    pub last: Option<String>,
    /// The first set contains a correct name; the last does; the last contains nothing else.
    pub right: [bool; 3],
    /// Time from the start of the effect to the first correct name, cycles of the structure.
    pub cycles: Option<f64>,
    /// The energy monitor stopped the test, or would have.
    pub energy: bool,
}

/// Errors of a test with an adaptive compensation, as a fraction of the peak.
#[derive(Clone, Debug, Serialize)]
pub struct Learning {
    /// Its method.
    pub method: &'static str,
    /// The error without the effect.
    pub sound: f64,
    /// The error with the effect, while the watch holds the adaptation.
    pub guarded: f64,
    /// The error with the effect, while it keeps adapting.
    pub unguarded: f64,
}

/// A test without the watch that stopped it.
#[derive(Clone, Debug, Serialize)]
pub struct Unwatched {
    /// Error, as a fraction of the peak.
    pub eps: f64,
    /// Something else stopped it.
    pub stopped: bool,
}

impl FaultTrial {
    /// What the effect adds to the error, as a fraction of the peak.
    pub fn added(&self) -> f64 {
        self.eps[1] - self.eps[0]
    }

    /// Whether the effect adds more than this. A frozen sensor always counts, since the test is stopped soon, as do noise
    /// and hum, which add little.
    pub fn adds(&self, more: f64) -> bool {
        let always = matches!(self.kind, Kind::Frozen | Kind::Noise | Kind::Hum);
        self.counts && (always || self.added() > more)
    }
}

/// The sound test of a seed, with another motion if one is given.
pub(super) fn sound_test(
    seed: u64,
    motion: Option<&GroundMotionFile>,
) -> (String, GroundMotionFile) {
    let rig = Planned::new(seed).under(motion).rig;
    (rig.text, rig.shaking)
}

/// The test of a seed with what `effects` draws.
pub(super) fn test_with(
    seed: u64,
    effects: impl FnOnce(&DrawnRig, &mut Draw) -> Vec<DrawnEffect>,
) -> (String, GroundMotionFile) {
    let planned = Planned::new(seed);
    let effects = planned.effects(effects);
    let text = effects.iter().map(|e| e.text.as_str());
    let text = std::iter::once(planned.rig.text.as_str()).chain(text);
    (text.collect(), planned.rig.shaking)
}

/// A drawn test with its planned motion.
struct Planned {
    rig: DrawnRig,
    seed: u64,
    ideal: Option<Response>,
}

impl Planned {
    fn new(seed: u64) -> Self {
        Self {
            rig: DrawnRig::new(seed),
            seed,
            ideal: None,
        }
    }

    /// With the strong part of another motion, as long as the drawn one.
    fn under(mut self, motion: Option<&GroundMotionFile>) -> Self {
        if let Some(motion) = motion {
            let all = motion.acc_m_per_s2.iter();
            let squares: f32 = all.clone().map(|a| a * a).sum();
            let begun = |sum: &mut f32, a: &f32| {
                *sum += a * a;
                Some(*sum > BEGUN * squares)
            };
            let from = all.clone().scan(0.0, begun).take_while(|begun| !begun);
            let samples = (self.rig.seconds / motion.interval_s) as usize;
            self.rig.shaking = GroundMotionFile {
                acc_m_per_s2: all.skip(from.count()).take(samples).copied().collect(),
                ..motion.clone()
            };
        }
        self
    }

    /// The same with the specimen as declared; `None` if it already is.
    fn without_bend(&self) -> Option<Self> {
        let mut straight = Self::new(self.seed);
        straight.rig.shaking.clone_from(&self.rig.shaking);
        let text = &mut straight.rig.text;
        text.truncate(text.len() - straight.rig.bend.len());
        (!straight.rig.bend.is_empty()).then_some(straight)
    }

    fn effects(
        &self,
        draw: impl FnOnce(&DrawnRig, &mut Draw) -> Vec<DrawnEffect>,
    ) -> Vec<DrawnEffect> {
        draw(&self.rig, &mut Draw::new(self.seed ^ 0xf0))
    }

    fn run(&mut self, more: &str, method: Option<Method>) -> Result<Summary, Failure> {
        let text = format!("{}{more}", self.rig.text);
        let mut test = TestFile::parse(&text, "drawn", Path::new(""), &[])?;
        if let Some(method) = method {
            test.config.compensation.kind = method;
        }
        let method = test.config.compensation.kind;
        let experiment = Experiment::new(test, &self.rig.shaking, None)?;
        if self.ideal.is_none() {
            self.ideal = Some(experiment.ideal()?);
        }
        let ideal = self
            .ideal
            .as_ref()
            .ok_or_else(|| Failure::test("no motion"))?;
        Ok(experiment.run(method, ideal, self.seed, false, ())?.summary)
    }
}

fn eps(s: &Summary) -> f64 {
    match s.verdict {
        TestVerdict::Diverged => LOST,
        TestVerdict::Completed | TestVerdict::Tripped | TestVerdict::Stopped => {
            if s.eps_rms.is_nan() {
                LOST
            } else {
                s.eps_rms.min(LOST)
            }
        }
    }
}

fn survived(s: &Summary) -> bool {
    s.verdict == TestVerdict::Completed && eps(s) < LOST
}

fn in_words(event: &WatchEvent) -> String {
    let names: Vec<String> = event.set.iter().map(|c| c.in_words()).collect();
    format!("{:.2} s {}", event.t_s, names.join(" | "))
}

fn first(watch: Option<&WatchReport>) -> Option<&WatchEvent> {
    watch?.events.iter().find(|e| !e.set.is_empty())
}

impl SoundTrial {
    /// The test of a seed, with another motion if one is given.
    ///
    /// # Errors
    /// A test that cannot run.
    pub fn run(seed: u64, motion: Option<&GroundMotionFile>) -> Result<Self, Failure> {
        let mut planned = Planned::new(seed).under(motion);
        let s = planned.run("", None)?;
        let mut fits = s.eps_rms <= POOR_EPS_RMS;
        // The deviation caused by a nonlinear specimen says nothing about the compensation.
        if let Some(mut straight) = planned.without_bend() {
            fits = straight.run("", None)?.eps_rms <= POOR_EPS_RMS;
        }
        let counts = s.verdict == TestVerdict::Completed && fits || s.trip == Some("watch");
        let named = first(s.watch.as_ref()).map(in_words);
        let corrected_eps = match named {
            None => eps(&s),
            Some(_) => eps(&planned.run(allowed(&planned)?, None)?),
        };
        let rig = planned.rig;
        Ok(Self {
            counts,
            yields: rig.yields,
            declared_elastic: rig.declared_elastic,
            bends: !rig.bend.is_empty(),
            named,
            energy: s.energy_ratio > 0.2,
            eps: eps(&s),
            corrected_eps,
            kind: rig.kind,
        })
    }
}

impl FaultTrial {
    /// The test of a seed, with what `effects` draws; `adaptive`: also with this method, guarded and not.
    ///
    /// # Errors
    /// A test that cannot run.
    pub(super) fn run(
        seed: u64,
        effects: impl FnOnce(&DrawnRig, &mut Draw) -> Vec<DrawnEffect>,
        adaptive: Option<Method>,
    ) -> Result<Self, Failure> {
        let planned = Planned::new(seed);
        match &planned.effects(effects)[..] {
            [] => Err(Failure::test("no effect")),
            [effect] => Self::with(planned, effect, None, adaptive),
            [effect, beside, ..] => Self::with(planned, effect, Some(beside), adaptive),
        }
    }

    fn with(
        mut planned: Planned,
        effect: &DrawnEffect,
        beside: Option<&DrawnEffect>,
        adaptive: Option<Method>,
    ) -> Result<Self, Failure> {
        let text = match beside {
            None => effect.text.clone(),
            Some(second) => format!("{}{}", effect.text, second.text),
        };
        let sound = planned.run("", None)?;
        let faulty = planned.run(&text, None)?;
        let learns = learns(&planned)?;
        let corrected = planned.run(&format!("{text}{}", allowed(&planned)?), None)?;
        let adaptive = adaptive.map(|method| {
            let mut run = |more: &str| planned.run(more, Some(method)).map(|s| eps(&s));
            Ok::<_, Failure>(Learning {
                method: method.name(),
                sound: run("")?,
                guarded: run(&text)?,
                unguarded: run(&format!("{text}{UNGUARDED}"))?,
            })
        });
        let adaptive = adaptive.transpose()?;
        let unwatched = (faulty.trip == Some("watch")).then(|| {
            let alone = planned.run(&format!("{text}{UNWATCHED}"), None)?;
            Ok::<_, Failure>(Unwatched {
                eps: eps(&alone),
                stopped: alone.verdict == TestVerdict::Tripped,
            })
        });
        let unwatched = unwatched.transpose()?;
        let rig = &planned.rig;
        let of_both = |names: fn(&DrawnEffect) -> &[Name]| -> Vec<Name> {
            let both = std::iter::once(effect).chain(beside);
            both.flat_map(|e| names(e).iter().copied()).collect()
        };
        let (right, at_first) = (of_both(|e| &e.right), of_both(|e| &e.at_first));
        let from_s = beside.map_or(effect.from_s, |b| effect.from_s.min(b.from_s));
        let holds = |e: &WatchEvent| e.set.iter().any(|c| right.contains(&(c.name, c.side)));
        let early = |e: &WatchEvent| {
            let mut names = e.set.iter().map(|c| (c.name, c.side));
            holds(e) || names.any(|name| at_first.contains(&name))
        };
        let watch = faulty.watch.as_ref();
        let all = watch.map_or(&[][..], |w| &w.events);
        let last = all.last().filter(|e| !e.set.is_empty());
        Ok(Self {
            rig: rig.kind.clone(),
            kind: effect.kind,
            beside: beside.map(|b| b.kind),
            several: rig.storeys > 1,
            elastic: !rig.yields && rig.bend.is_empty(),
            counts: sound.verdict == TestVerdict::Completed && sound.eps_rms <= POOR_EPS_RMS,
            eps: [&sound, &faulty, &corrected].map(eps),
            adaptive,
            unwatched,
            unstable: !survived(&corrected) && survived(&faulty),
            longer: corrected.steps > faulty.steps,
            learns,
            named: first(watch).map(in_words),
            last: last.map(in_words),
            right: [
                first(watch).is_some_and(early),
                last.is_some_and(holds),
                last.is_some_and(|e| holds(e) && e.set.len() == 1),
            ],
            cycles: all
                .iter()
                .find(|e| early(e))
                .map(|e| (e.t_s - from_s) * rig.omega / TAU),
            energy: faulty.trip == Some("energy") || faulty.energy_ratio > ENERGY_TRIP,
        })
    }
}

/// The corrections that are allowed.
fn allowed(planned: &Planned) -> Result<&'static str, Failure> {
    Ok(match learns(planned)? {
        true => CORRECT_BESIDE,
        false => CORRECT,
    })
}

fn learns(planned: &Planned) -> Result<bool, Failure> {
    let test = TestFile::parse(&planned.rig.text, "drawn", Path::new(""), &[])?;
    Ok(test.config.compensation.kind.predictor.learns())
}
