//! The next test: a command within the rig's limits that best separates the causes that remain possible.
//!
//! The steps of a design: [`causes`] (what a diagnosis leaves open, each as a whole model), [`test_limits`] (what the
//! rig may do), [`phase`] (motions to choose from), [`design`] (what a motion tells: how far two models stay apart when
//! each may still move its numbers as far as the records allow), and the choice below, phase by phase.

mod causes;
mod design;
mod numbers;
mod phase;
mod predict;
mod test_limits;

pub use phase::{Form, Phase};
pub use test_limits::{Origin, TestLimits};

use crate::criteria::{CERTAIN, INSEPARABLE, NOISE};
use crate::diagnose::Diagnosis;
use crate::model::Model;
use crate::model::answer::ChannelAnswer;
use crate::model::interval::NINETY;
use crate::numbers::signals::{difference, peak, rms};
use crate::record::recording::Recording;
use crate::record::refusal::Refusal;
use design::{ChannelDesign, Information};
use phase::Played;
use plant::{Channel, Effect};
use predict::Planned;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

/// What one of the possible causes predicts of the next test.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Prediction {
    /// What it has that the declared model lacks; null: nothing.
    pub name: Option<Effect>,
    /// How probable it is, where the diagnosis says so.
    pub probability: Option<f64>,
    /// Largest answer of either sign.
    pub peak: f64,
    /// Area of its loops, input times answer: N mm for a specimen, mm^2 for an actuator.
    pub loop_area: f64,
    /// rms of its difference from the first candidate's answer.
    pub apart_rms: f64,
    /// The rms by which it stays apart from the nearest other, its numbers moved as far as the records let them be, over
    /// what the model leaves.
    pub separation: Option<f64>,
    /// The answer, for pictures.
    #[serde(skip)]
    pub answer: Vec<f64>,
}

/// A number of the model and how well it will be known.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Narrowed {
    /// Its name, ending with its unit.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Half of its 90 % interval as the records leave it.
    pub half_now: f64,
    /// The same with the next test.
    pub half_then: f64,
}

/// What the next test is expected to show of a channel.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Outlook {
    /// Which channel.
    pub channel: Channel,
    /// Unit of its answer.
    pub unit: String,
    /// rms of what the present model leaves.
    pub left_rms: f64,
    /// rms of the noise.
    pub noise_rms: f64,
    /// What each possible cause predicts.
    pub candidates: Vec<Prediction>,
    /// How many times the squares of the right one a wrong one is expected to leave in the next test, at least: from
    /// 2 on a name is certain. Null if it has no rival.
    pub squares_times: Option<f64>,
    /// By how many variances of what is left the nearest two differ at least, all samples of the next test taken together,
    /// ten neighbours as one. Where noise is all that is left, 100 of them decide.
    pub variances: Option<f64>,
    /// Whether the test is expected to decide between all that is possible.
    pub decides: bool,
    /// Whether it is expected to decide between any two.
    pub tells: bool,
    /// The numbers of the preferred model.
    pub parameters: Vec<Narrowed>,
}

/// A designed test.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Next {
    /// What it keeps inside.
    pub limits: TestLimits,
    /// Its phases, one after the other.
    pub phases: Vec<Phase>,
    /// Its length, s.
    pub seconds: f64,
    /// What is expected of it.
    pub channels: Vec<Outlook>,
    /// Sampling interval of the command, s.
    pub interval_s: f64,
    /// The command, mm.
    #[serde(skip)]
    pub command_mm: Vec<f64>,
}

impl Next {
    /// Time of the command's samples, s.
    pub fn time_s(&self) -> Vec<f64> {
        let at = |i| i as f64 * self.interval_s;
        (0..self.command_mm.len()).map(at).collect()
    }
}

/// Highest planned frequency, Hz, and at most a twentieth of the record's rate: no servo-hydraulic rig follows more.
const HIGHEST_HZ: f64 = 15.0;
/// Samples per cycle of the highest frequency.
const A_CYCLE: f64 = 40.0;
/// Rest before and after the motion, s: it determines the noise.
const REST_S: f64 = 2.0;
/// Shortest and longest test, s, without its rests.
const SECONDS: [f64; 2] = [12.0, 60.0];
/// Largest number of phases.
const PHASES: usize = 6;
/// Rest between two phases, s.
const BETWEEN_S: f64 = 0.5;
/// A phase that adds less than this fraction of the present value is omitted.
const WORTH: f64 = 0.02;
/// Fraction of the top speed at which a test moves to its middle.
const GOING: f64 = 0.2;

/// Information from a phase about each channel.
struct PhaseCandidate {
    played: Played,
    information: Vec<Information>,
}

/// Why no test is proposed, in one sentence: everything that `diagnosis` leaves open is caused by something outside its
/// channels. `None` if a test may help.
pub fn why_no_test(diagnosis: &Diagnosis) -> Option<String> {
    let all = || diagnosis.channels.iter();
    let beyond: Vec<&str> = all()
        .filter(|a| a.is_beyond_tests())
        .map(|a| a.channel.name())
        .collect();
    (!beyond.is_empty() && !all().any(ChannelAnswer::is_open)).then(|| {
        format!(
            "no test is proposed, since what is left of the {} is made by something outside these channels, and no motion of the \
             rig tells more of it: look for what else acts on the rig, stop it or record it, and record again",
            beyond.join(" and of the ")
        )
    })
}

/// Designs the test that tells most about what `diagnosis` of `train` with `model` leaves open. `test` is the held-out
/// data: only its span is used. A channel about which no test can tell more is ignored.
///
/// # Errors
/// Records in which nothing moves; limits within which no phase fits; nothing that a test could tell ([`why_no_test`]).
pub fn next(
    model: &Model,
    diagnosis: &Diagnosis,
    train: &[Recording],
    test: &[Recording],
) -> Result<Next, Refusal> {
    if let Some(why) = why_no_test(diagnosis) {
        return Err(Refusal::new(why));
    }
    let all: Vec<&Recording> = train.iter().chain(test).collect();
    let limits = TestLimits::of(model, &all)?;
    let improved = &diagnosis.improved;
    let views: Vec<(ChannelDesign, &ChannelAnswer)> = diagnosis
        .channels
        .iter()
        .filter(|a| !a.is_beyond_tests())
        .filter_map(|a| {
            let causes = causes::causes(model, improved, a, train);
            let left = a.error_after.test_rms.max(a.noise_floor_rms);
            Some((
                ChannelDesign::new(a.channel, causes, model, train, left)?,
                a,
            ))
        })
        .collect();
    // If something is open, only that counts.
    let is_open = views.iter().any(|(v, a)| a.is_open() && v.causes.len() > 1);
    let counts = |v: &ChannelDesign| !is_open || v.causes.len() > 1;
    let record_h = train.first().map_or(1e-3, Recording::interval_s);
    let highest_hz = HIGHEST_HZ.min(0.05 / record_h);
    let interval_s = (1.0 / (A_CYCLE * highest_hz)).max(record_h);
    let stage = SimulatedRig {
        improved,
        views: &views,
        limits: &limits,
        n_per_mm: n_per_mm(train),
        interval_s,
    };
    let offers: Vec<PhaseCandidate> = phase::all(&limits, highest_hz, interval_s)
        .into_par_iter()
        .filter_map(|played| stage.offer(played))
        .collect();
    let recorded: f64 = train
        .iter()
        .map(|r| r.time_s.len() as f64 * r.interval_s())
        .sum();
    let most_s = recorded.clamp(SECONDS[0], SECONDS[1]);
    let chosen = choose(&views, counts, offers, most_s, interval_s);
    if chosen.is_empty() {
        return Err(Refusal::new(format!(
            "no test fits into {:.4} mm to either side, {:.4} mm/s and {} N with what the models predict: accepted are wider \
             limits, in the table [limits] of the model",
            limits.half_mm,
            limits.velocity_mm_per_s,
            limits.force_n.map_or("any".into(), |f| format!("{f:.4}")),
        )));
    }
    let (phases, command_mm) = joined(&limits, &chosen, interval_s);
    let channels = stage.expected(&command_mm);
    Ok(Next {
        seconds: command_mm.len() as f64 * interval_s,
        limits,
        phases,
        channels,
        interval_s,
        command_mm,
    })
}

/// Largest force over largest displacement, N/mm.
fn n_per_mm(records: &[Recording]) -> f64 {
    let largest = |x: Option<&Vec<f64>>| peak(x.into_iter().flatten());
    let ratio = |r: &Recording| {
        let way = largest(r.displacement_mm.as_ref());
        largest(r.force_n.as_ref()) / way.max(f64::MIN_POSITIVE)
    };
    records.iter().map(ratio).fold(0.0, f64::max)
}

/// Adds the most valuable phase, one at a time.
fn choose(
    views: &[(ChannelDesign, &ChannelAnswer)],
    counts: impl Fn(&ChannelDesign) -> bool,
    mut offers: Vec<PhaseCandidate>,
    most_s: f64,
    interval_s: f64,
) -> Vec<Played> {
    let samples = most_s / interval_s;
    let worth = |information: &[Information]| -> f64 {
        let each = views
            .iter()
            .zip(information)
            .filter(|((v, _), _)| counts(v));
        each.map(|((v, _), t)| v.worth(t, samples)).sum()
    };
    let mut chosen: Vec<Played> = Vec::new();
    let mut sum: Option<Vec<Information>> = None;
    let (mut reached, mut seconds) = (0.0, 0.0);
    while chosen.len() < PHASES {
        let together = |o: &PhaseCandidate| match &sum {
            None => o.information.clone(),
            Some(sum) => sum
                .iter()
                .zip(&o.information)
                .map(|(a, b)| a.and(b))
                .collect(),
        };
        let fits = |o: &PhaseCandidate| seconds + o.played.0.seconds + BETWEEN_S <= most_s;
        let best = offers
            .iter()
            .enumerate()
            .filter(|(_, o)| fits(o))
            .map(|(i, o)| (i, worth(&together(o))))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((i, value)) = best.filter(|b| b.1 > (1.0 + WORTH) * reached) else {
            break;
        };
        sum = Some(together(&offers[i]));
        reached = value;
        let offer = offers.swap_remove(i);
        seconds += offer.played.0.seconds + BETWEEN_S;
        chosen.push(offer.played);
    }
    chosen
}

/// Phases in sequence around the middle, starting and ending at zero if zero is within the limits, with rests.
fn joined(limits: &TestLimits, chosen: &[Played], h: f64) -> (Vec<Phase>, Vec<f64>) {
    let middle = limits.middle_mm;
    let from = if middle.abs() <= limits.half_mm {
        0.0
    } else {
        middle
    };
    let going = GOING * limits.velocity_mm_per_s;
    let mut phases = Vec::new();
    let mut command: Vec<f64> = Vec::new();
    let mut still = |seconds: f64, command: &mut Vec<f64>, at: f64| {
        let (phase, zeros) = phase::rest(seconds, h);
        phases.push(phase);
        command.extend(zeros.iter().map(|z| z + at));
    };
    still(REST_S, &mut command, from);
    if from != middle {
        command.extend(phase::passage(from, middle, going, h));
        still(REST_S, &mut command, middle);
    }
    let mut all = Vec::new();
    for (i, (phase, x)) in chosen.iter().enumerate() {
        if i > 0 {
            let (_, zeros) = phase::rest(BETWEEN_S, h);
            command.extend(zeros.iter().map(|z| z + middle));
        }
        all.push(*phase);
        command.extend(x.iter().map(|x| x + middle));
    }
    if from != middle {
        command.extend(phase::passage(middle, from, going, h));
    }
    let (rest, zeros) = phase::rest(REST_S, h);
    command.extend(zeros.iter().map(|z| z + from));
    phases.truncate(1);
    phases.extend(all);
    phases.push(rest);
    (phases, command)
}

/// The rig on which a command is played, as far as it is known.
struct SimulatedRig<'a> {
    improved: &'a Model,
    views: &'a [(ChannelDesign, &'a ChannelAnswer)],
    limits: &'a TestLimits,
    n_per_mm: f64,
    interval_s: f64,
}

impl SimulatedRig<'_> {
    /// The displacement and the force that a command causes, as far as there are models of them.
    fn played(&self, command: &[f64]) -> (Vec<f64>, Option<Vec<f64>>) {
        let x = predict::answer(
            self.improved,
            Channel::Actuator,
            &self.planned(command, None),
        );
        let x = x.unwrap_or_else(|| command.to_vec());
        let force = predict::answer(self.improved, Channel::Specimen, &self.planned(&x, None));
        (x, force)
    }

    fn planned<'p>(&self, input: &'p [f64], force: Option<&'p [f64]>) -> Planned<'p> {
        Planned {
            interval_s: self.interval_s,
            input,
            force,
            n_per_mm: self.n_per_mm,
        }
    }

    /// Information from a phase; `None` if a force would exceed the limits.
    fn offer(&self, played: Played) -> Option<PhaseCandidate> {
        let command: Vec<f64> = played.1.iter().map(|x| x + self.limits.middle_mm).collect();
        let (x, force) = self.played(&command);
        if !force.as_ref().is_none_or(|f| self.limits.holds(f)) {
            return None;
        }
        let information = |(design, _): &(ChannelDesign, &ChannelAnswer)| {
            let planned = match design.channel {
                Channel::Actuator => self.planned(&command, force.as_deref()),
                Channel::Specimen => self.planned(&x, None),
            };
            if design.channel == Channel::Specimen {
                let answers = design.answers(&planned)?;
                if !answers.iter().all(|a| self.limits.holds(a)) {
                    return None;
                }
            }
            design.information(&planned, 1)
        };
        let information = self.views.iter().map(information).collect::<Option<_>>()?;
        Some(PhaseCandidate {
            played,
            information,
        })
    }

    fn expected(&self, command: &[f64]) -> Vec<Outlook> {
        let (x, force) = self.played(command);
        let of = |(design, answer): &(ChannelDesign, &ChannelAnswer)| {
            let (input, planned) = match design.channel {
                Channel::Actuator => (command, self.planned(command, force.as_deref())),
                Channel::Specimen => (&x[..], self.planned(&x, None)),
            };
            let answers = design.answers(&planned)?;
            let information = design.information(&planned, 1)?;
            let separations = design.separations(&information);
            let nearest = |i: usize| {
                let own = separations.iter().filter(|s| s.0 == i || s.1 == i);
                own.map(|s| s.2).reduce(f64::min)
            };
            let first = answers[0].clone();
            let least = separations.iter().map(|s| s.2).reduce(f64::min);
            let variances = |s: f64| s * s * command.len() as f64 / design::COLOUR;
            let noisy = design.left_rms <= NOISE * answer.noise_floor_rms;
            let decided = |s: f64| 1.0 + s * s >= CERTAIN || noisy && variances(s) >= INSEPARABLE;
            let candidates = design.causes.iter().zip(answers).enumerate();
            let candidates = candidates.map(|(i, (cause, answer))| Prediction {
                name: cause.name,
                probability: cause.probability,
                peak: answer
                    .iter()
                    .fold(0.0, |m, y| if y.abs() > f64::abs(m) { *y } else { m }),
                loop_area: area(input, &answer),
                apart_rms: rms(&[difference(&answer, &first)]),
                separation: nearest(i),
                answer,
            });
            let (now, then) = (
                design.deviations(None),
                design.deviations(Some(&information)),
            );
            let numbers = design.numbers[0].iter().zip(now.iter().zip(&then));
            Some(Outlook {
                channel: design.channel,
                unit: answer.unit.clone(),
                left_rms: design.left_rms,
                noise_rms: answer.noise_floor_rms,
                candidates: candidates.collect(),
                squares_times: least.map(|s| 1.0 + s * s),
                variances: least.map(variances),
                decides: least.is_some_and(decided),
                tells: separations.iter().any(|s| decided(s.2)),
                parameters: numbers
                    .map(|(l, (now, then))| Narrowed {
                        name: l.name.clone(),
                        value: l.value,
                        half_now: NINETY * now * l.spread,
                        half_then: NINETY * then * l.spread,
                    })
                    .collect(),
            })
        };
        self.views.iter().filter_map(of).collect()
    }
}

/// Integral of the response over the travel.
fn area(x: &[f64], y: &[f64]) -> f64 {
    let steps = x.windows(2).zip(y.windows(2));
    steps
        .map(|(x, y)| 0.5 * (y[0] + y[1]) * (x[1] - x[0]))
        .sum()
}
