//! An actuator's channel for the engine: simulated parts of the path from command to displacement, and declared
//! parameters that leave their tolerances.

use super::asked::{Asked, Found, OfOneName};
use super::beam::{Beam, Scored, Width};
use super::posterior::{Candidate, OTHER_NAME};
use super::score::{BLOCKS, Evidence, KnownNoise, Score, raised};
use super::verdict::LACKS;
use crate::criteria::POSITION_LOOP;
use crate::engine::drivetrain;
use crate::engine::drivetrain::{ActuatorData, ActuatorFit, DECLARED, PartSet};
use crate::laws::drivetrain::part::{Part, PartKind, Shapes};
use crate::model::Model;
use crate::model::answer::ParameterEstimate;
use crate::model::base::Base;
use crate::numbers::linear::{Factor, dot, gram};
use crate::numbers::signals::rms;
use crate::record::recording::Recording;
use crate::record::rest;
use plant::{Channel, Effect};
use rayon::prelude::*;

/// Extent of the search: each model is simulated some dozen times.
const WIDTH: Width = Width {
    carried: [4, 4, 4],
    while_better: 3,
    swapped: 2,
};
/// Number of parts that are tried with each model that has any part or freed parameter.
const BESIDE: usize = 5;
/// Largest number of parts and parameters of a model.
const LARGEST: usize = 4;
/// Number of models judged on every sample, and their largest distance below the best, nats.
const JUDGED: usize = 12;
const FAR_BELOW: f64 = 14.0;
/// Number of single causes that are judged in any case.
const ALONE: usize = 3;
/// Half of a 90 % interval in standard deviations, Student's of 7: twelve segments less some five unknowns.
const NINETY: f64 = 1.895;
/// A second lag below this multiple of a delay that is found with it may be a part of what delays: of eight equal lags it is
/// .55 of it.
const ONE_OF_SEVERAL: f64 = 0.7;
/// A delay below this fraction of a second lag that is found with it may be a part of that lag.
const BESIDE_A_LAG: f64 = 0.3;
/// A drift below this fraction of an offset may be how that settles.
const SETTLES: f64 = 0.125;
/// Friction that builds up over a way of more than this fraction of the distance by which it holds back may be play.
const LOST: f64 = 0.4;
/// Price of a declared parameter that leaves its tolerance, nats: gain, delay, lag, offset.
const PARAMETERS: [f64; DECLARED] = [3.4, 3.0, 3.0, 3.2];

/// A fitted model, with the evidence for it.
#[derive(Clone, Debug)]
pub struct ActuatorModelFit {
    fit: ActuatorFit,
    squares: [f64; BLOCKS],
    evidence: Evidence,
    /// What the model claims: delay, lag, second lag and oil column as in any position loop are no finding.
    named: PartSet,
}

impl ActuatorModelFit {
    /// The names that it claims, in ascending order, each once.
    fn names(&self) -> Vec<Effect> {
        let model = &self.named;
        let along = |i: usize| model.parts.iter().any(|p| p.kind.takes_along() == Some(i));
        let mistakes = Channel::Actuator.mistakes().into_iter().zip(model.moved);
        let own = mistakes.enumerate().filter(|(i, n)| n.1 && !along(*i));
        let mut names: Vec<Effect> = own.map(|(_, n)| n.0).collect();
        names.extend(model.parts.iter().filter_map(Part::effect));
        names.sort_by_key(|n| *n as usize);
        names.dedup();
        names
    }

    /// Names with the other that the same response may have; of two names that are one cause, the lesser with the greater.
    fn other_names(&self, declared: [f64; DECLARED]) -> Vec<(Effect, Effect)> {
        let names = self.names();
        let has = |name: Effect| names.contains(&name);
        let fit = &self.fit;
        let [_, delay_s, _, offset_mm] = std::array::from_fn(|i| fit.declared[i] - declared[i]);
        let mut amplitudes = fit.amplitudes.iter();
        let mut all = Vec::new();
        for part in &fit.model.parts {
            let amplitude = part.kind.is_column().then(|| amplitudes.next()).flatten();
            let size = amplitude.map_or(0.0, |a| a.abs());
            let first = part.shapes[0];
            let other = match part.kind {
                PartKind::OilColumn if part.is_overdamped() => {
                    Some((Effect::OilColumn, Effect::SecondLag))
                }
                // Several small lags in series delay, and a lag in series with a small one is late by that.
                PartKind::SecondLag if !has(Effect::DelayError) => None,
                PartKind::SecondLag if delay_s * ONE_OF_SEVERAL > first => {
                    Some((Effect::SecondLag, Effect::DelayError))
                }
                PartKind::SecondLag if delay_s.abs() < BESIDE_A_LAG * first => {
                    Some((Effect::DelayError, Effect::SecondLag))
                }
                // A zero that settles by a little is no drift.
                PartKind::Drift if has(Effect::Offset) && size < SETTLES * offset_mm.abs() => {
                    Some((Effect::Drift, Effect::Offset))
                }
                // What holds a drive back over as long a way as it is held back by is lost motion.
                PartKind::Friction if first > LOST * size => {
                    Some((Effect::CoulombFriction, Effect::Backlash))
                }
                _ => None,
            };
            all.extend(other.filter(|(name, _)| has(*name)));
        }
        all
    }

    /// True if its supply sags, which has no name.
    fn sags(&self) -> bool {
        self.named.parts.iter().any(|p| p.kind == PartKind::Sag)
    }

    /// The names that it claims, and whether it claims a sagging supply.
    fn claims(&self) -> (Vec<Effect>, bool) {
        (self.names(), self.sags())
    }
}

/// Training data of an actuator.
#[derive(Debug)]
pub struct ActuatorChannel<'a> {
    base: &'a Base,
    /// All samples, and averages for the search.
    whole: ActuatorData<'a>,
    thin: ActuatorData<'a>,
    /// Number of samples averaged into one.
    pub every: usize,
    kinds: Vec<PartKind>,
}

impl<'a> ActuatorChannel<'a> {
    /// From records without the contribution of effects already in the model; `None` if a signal is missing.
    pub fn new(base: &'a Base, train: &[Recording]) -> Option<Self> {
        let whole = drivetrain::data(base, train, 1)?;
        let every = drivetrain::thinning(&whole, train);
        let mut kinds = PartKind::ALL.to_vec();
        if !whole.has_force() {
            kinds.retain(|k| *k != PartKind::Compliance);
        }
        // Without a declared lag, a second lag is the first, and it is not a position loop.
        if base.values[2] == 0.0 {
            kinds.retain(|k| !matches!(k, PartKind::SecondLag | PartKind::Load | PartKind::Sag));
        }
        // What depends on time alone must also predict the rest after the motion: without rests it is not considered.
        if !train.iter().all(|r| rest::spans(r).len() == 2) {
            kinds.retain(|k| !matches!(k, PartKind::Drift | PartKind::GainDrift));
        }
        Some(Self {
            base,
            thin: drivetrain::data(base, train, every)?,
            whole,
            every,
            kinds,
        })
    }
}

/// Searches and decides, given the noise of averages and of single samples.
pub fn actuator(
    channel: &ActuatorChannel,
    averages: KnownNoise,
    samples: KnownNoise,
) -> Option<Found<ActuatorModelFit>> {
    let mut search = Search::new(&channel.thin, &channel.kinds, averages.variance);
    let (empty, beam) = search.beam()?;
    let mut all: Vec<ActuatorModelFit> = beam.run(empty).into_iter().map(|s| s.fit).collect();
    drop(beam);
    if !averages.told {
        let quietest = all.iter().map(|f| f.evidence.quiet());
        let raised = raised(quietest.fold(f64::INFINITY, f64::min));
        search.score.noise *= raised;
        all.iter_mut().for_each(|f| search.score_anew(f));
    }
    sort(&mut all);
    let raised = search.score.noise / averages.variance.max(f64::MIN_POSITIVE);
    let judge = Search::new(&channel.whole, &channel.kinds, samples.variance * raised);
    let best = all.first()?.evidence.score();
    let near = |f: &&ActuatorModelFit| f.evidence.score() > best - FAR_BELOW;
    let mut chosen: Vec<PartSet> = Vec::new();
    let mut claimed: Vec<(Vec<Effect>, bool)> = Vec::new();
    for f in all.iter().filter(near) {
        if chosen.len() < JUDGED && !claimed.contains(&f.claims()) {
            claimed.push(f.claims());
            chosen.push(f.fit.model.clone());
        }
    }
    // The nearest single causes are reported even if nothing is probable, and a supply that sags is asked for in any case.
    let alone = all.iter().filter(|f| f.names().len() == 1).take(ALONE);
    for f in alone.chain(all.iter().find(|f| f.sags())) {
        if !claimed.contains(&f.claims()) {
            chosen.push(f.fit.model.clone());
        }
    }
    let start = all.first()?.fit.declared;
    let held = PartSet::held();
    let declared = judge.scored(&held, channel.thin.declared_values())?;
    let judged = chosen.into_par_iter().filter(|m| *m != held);
    let mut judged: Vec<ActuatorModelFit> =
        judged.filter_map(|m| judge.scored(&m, start)).collect();
    judged.push(declared.clone());
    judged.par_iter_mut().for_each(|f| judge.know_order(f));
    let values = channel.whole.declared_values();
    let candidates = judged.into_iter().flat_map(|f| candidates(f, values));
    let mut candidates: Vec<_> = candidates.collect();
    let enough = candidates.clone();
    candidates.retain(|c| !enough.iter().any(|e| does_as_well(e, c)));
    Some(Found::of(candidates, declared, averages.told))
}

/// True if a model's names are a proper subset of the other's and it is hardly worse.
fn does_as_well(model: &Candidate<ActuatorModelFit>, other: &Candidate<ActuatorModelFit>) -> bool {
    let (own, others) = (&model.names, &other.names);
    let part = !own.is_empty()
        && own.iter().all(|n| others.contains(n))
        && model.nameless <= other.nameless;
    part && own.len() < others.len() && model.evidence.score() > other.evidence.score() - LACKS
}

/// A model under each of the names that its parts may have.
fn candidates(
    model: ActuatorModelFit,
    declared: [f64; DECLARED],
) -> Vec<Candidate<ActuatorModelFit>> {
    let own = model.names();
    let mut names = vec![own.clone()];
    for (name, other) in model.other_names(declared) {
        let mut own: Vec<Effect> = own
            .iter()
            .map(|n| if *n == name { other } else { *n })
            .collect();
        own.sort_by_key(|n| *n as usize);
        own.dedup();
        names.push(own);
    }
    let of = |names: Vec<Effect>| {
        let mut evidence = model.evidence;
        if names != own {
            evidence.price += OTHER_NAME;
        }
        Candidate {
            names,
            nameless: model.sags(),
            only_family: false,
            evidence,
            model: model.clone(),
        }
    };
    names.into_iter().map(of).collect()
}

/// One model per name accepted by `wanted`, with one part or parameter besides the declared ones, and its rms residual
/// on the training data. Best first.
pub fn actuator_each(
    model: &Model,
    train: &[Recording],
    wanted: impl Fn(Effect) -> bool,
) -> Option<Vec<OfOneName>> {
    let base = Base::of(model, Channel::Actuator)?;
    let bare = drivetrain::without_known(&base, train)?;
    let channel = ActuatorChannel::new(&base, &bare)?;
    let search = Search::new(&channel.thin, &channel.kinds, f64::MIN_POSITIVE);
    let (empty, beam) = search.beam()?;
    let mut found: Vec<ActuatorModelFit> = beam.alone(&empty).into_iter().map(|s| s.fit).collect();
    found.sort_by(|a, b| a.fit.cost.total_cmp(&b.fit.cost));
    let mut all: Vec<OfOneName> = Vec::new();
    for fit in found {
        let name = fit.names().first().copied();
        let Some(name) = name.filter(|n| wanted(*n) && all.iter().all(|a| a.name != *n)) else {
            continue;
        };
        let left = rms(&channel.residuals(&channel.settled(&fit), &bare)?);
        let own = OfOneName::of(&channel, &fit, name, model, left);
        if left.is_finite() && own.model.check().is_ok() {
            all.push(own);
        }
    }
    Some(all)
}

/// A model of the search.
type OfAtoms = Scored<ActuatorModelFit>;

/// A model of these atoms.
fn atoms(atoms: Vec<usize>, fit: ActuatorModelFit) -> OfAtoms {
    Scored {
        atoms,
        evidence: fit.evidence,
        fit,
    }
}

fn sort(all: &mut [ActuatorModelFit]) {
    all.sort_by(|a, b| b.evidence.score().total_cmp(&a.evidence.score()));
}

/// Fits and scores models.
struct Search<'a, 'b> {
    data: &'a ActuatorData<'b>,
    kinds: &'a [PartKind],
    score: Score,
}

impl<'a, 'b> Search<'a, 'b> {
    fn new(data: &'a ActuatorData<'b>, kinds: &'a [PartKind], variance: f64) -> Self {
        let score = Score::new(variance.max(f64::MIN_POSITIVE), data.block_samples());
        Self { data, kinds, score }
    }

    /// The fitted model with its score.
    fn scored(&self, model: &PartSet, start: [f64; DECLARED]) -> Option<ActuatorModelFit> {
        let fit = self.data.fit(model, start)?;
        let squares = self.data.cross_validated(&fit)?;
        let parts: f64 = model.parts.iter().map(Part::price).sum();
        let moved = PARAMETERS.iter().zip(model.moved).filter(|p| p.1);
        let price = parts + moved.map(|p| p.0).sum::<f64>();
        let evidence = self.score.evidence(&squares, price);
        evidence.score().is_finite().then_some(ActuatorModelFit {
            fit,
            squares,
            evidence,
            named: model.clone(),
        })
    }

    /// Removes from a model's claims, one at a time, each higher-order feature without which it still leaves no more
    /// than noise and what any position loop leaves beyond its lag.
    fn know_order(&self, f: &mut ActuatorModelFit) {
        let target = &self.data.target;
        let mean = target.iter().sum::<f64>() / target.len() as f64;
        let moves = target.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
        let noise = self.score.noise * target.len() as f64;
        let most = noise + POSITION_LOOP.powi(2) * moves;
        let mut claimed = f.fit.model.clone();
        loop {
            let without = claimed
                .without_each_of_order()
                .into_iter()
                .filter_map(|model| {
                    let cost = self.data.fit(&model, f.fit.declared)?.cost;
                    (cost < most).then_some((model, cost))
                });
            match without.min_by(|a, b| a.1.total_cmp(&b.1)) {
                Some((fewer, _)) => claimed = fewer,
                None => break,
            }
        }
        // A delay or a lag alone is a wrong declared parameter.
        let is_order = f.fit.model.parts.iter().any(|p| p.kind.is_order());
        if claimed.size() > 0 || is_order {
            f.named = claimed;
        }
    }

    fn score_anew(&self, f: &mut ActuatorModelFit) {
        f.evidence = self.score.evidence(&f.squares, f.evidence.price);
    }

    /// The declared model and the search: an atom is a declared parameter or a kind of part.
    fn beam(&self) -> Option<(OfAtoms, Beam<'_, ActuatorModelFit, Option<Part>>)> {
        let declared = self.scored(&PartSet::held(), self.data.declared_values())?;
        let beam = Beam {
            laws: (0..DECLARED + self.kinds.len()).collect(),
            most: LARGEST,
            width: WIDTH,
            beside: Some(Box::new(|s| self.beside(&s.fit))),
            scored: Box::new(|set, from, part| {
                let model = self.model(&set, &from.fit.fit.model, part);
                Some(atoms(set, self.scored(&model, from.fit.fit.declared)?))
            }),
        };
        Some((atoms(Vec::new(), declared), beam))
    }

    /// The atom of a part.
    fn atom(&self, part: &Part) -> Option<usize> {
        let kind = self.kinds.iter().position(|k| *k == part.kind)?;
        Some(DECLARED + kind)
    }

    /// A set of atoms as a model: parts as in another model, plus one of its own.
    fn model(&self, set: &[usize], from: &PartSet, own: Option<Part>) -> PartSet {
        let parts = from.parts.iter().copied().chain(own);
        PartSet {
            parts: parts
                .filter(|p| self.atom(p).is_some_and(|a| set.contains(&a)))
                .collect(),
            moved: std::array::from_fn(|i| set.contains(&i)),
        }
    }

    /// Candidates to add to a model: a declared parameter, or a part; of parts that can replace each other only the
    /// best, unless added alone. To first order friction and play change the response alike.
    fn beside(&self, of: &ActuatorModelFit) -> Vec<(usize, Option<Part>)> {
        let alone = of.fit.model.size() == 0;
        let mut best: Vec<Part> = Vec::new();
        for part in self.screened(of) {
            let one_is = |kind| best.iter().any(|b| b.kind == kind) || part.kind == kind;
            let lost = [PartKind::Play, PartKind::Friction];
            let alike = |b: &&Part| b.kind.is_like(part.kind);
            let like = best.iter().filter(alike).count();
            let both = like == 1 && lost.contains(&part.kind) && lost.into_iter().all(one_is);
            if alone || like == 0 || both {
                best.push(part);
            }
        }
        best.truncate(if alone { usize::MAX } else { BESIDE });
        let parts = best.iter().filter_map(|p| Some((self.atom(p)?, Some(*p))));
        (0..DECLARED).map(|i| (i, None)).chain(parts).collect()
    }

    /// Parts that a fit lacks, each at the best point of its grid to first order, largest reduction first.
    fn screened(&self, from: &ActuatorModelFit) -> Vec<Part> {
        let fit = &from.fit;
        // A parameter at a limit of its tolerance cannot absorb any of a part's effect.
        let slopes = self.data.free_slopes(fit);
        let Some(factor) = Factor::of(gram(&slopes)) else {
            return Vec::new();
        };
        let has = |k: &PartKind| fit.model.parts.iter().any(|p| p.kind.is_like(*k));
        let kinds: Vec<PartKind> = self.kinds.iter().copied().filter(|k| !has(k)).collect();
        let best = |kind: PartKind| {
            let at = |shapes: Shapes| {
                let part = Part { kind, shapes };
                let mut column = self.data.change(fit, part);
                factor.add_regression(&slopes, &mut column, -1.0);
                let square = dot(&column, &column);
                let pull = dot(&column, &fit.residual);
                // A part without an amplitude is present fully or in part.
                let most = if kind.is_column() { f64::INFINITY } else { 1.0 };
                let least = if kind.is_column() && !kind.is_positive() {
                    f64::NEG_INFINITY
                } else {
                    0.0
                };
                let share = (pull / square.max(f64::MIN_POSITIVE)).clamp(least, most);
                (part, share * (2.0 * pull - share * square))
            };
            let grid = kind.grid(&self.data.sizes).into_iter().map(at);
            grid.max_by(|a, b| a.1.total_cmp(&b.1))
        };
        let mut found: Vec<(Part, f64)> = kinds.into_par_iter().filter_map(best).collect();
        found.retain(|f| f.1 > 0.0);
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        found.into_iter().map(|f| f.0).collect()
    }
}

impl Asked for ActuatorChannel<'_> {
    type Fit = ActuatorModelFit;

    fn residuals(&self, fit: &ActuatorModelFit, records: &[Recording]) -> Option<Vec<Vec<f64>>> {
        let data = drivetrain::data(self.base, records, 1)?;
        Some(data.by_record(&data.residual(&fit.fit)))
    }

    fn settled(&self, fit: &ActuatorModelFit) -> ActuatorModelFit {
        // A model file has no place for the parts that any sound ram has.
        let mut model = fit.fit.model.clone();
        model.parts.retain(|p| p.effect().is_some());
        let settled = self.whole.fit(&model, fit.fit.declared);
        ActuatorModelFit {
            fit: settled.unwrap_or_else(|| fit.fit.clone()),
            ..fit.clone()
        }
    }

    fn figures(&self, fit: &ActuatorModelFit) -> Vec<(Effect, Vec<ParameterEstimate>)> {
        let spread = self.whole.spread(&fit.fit);
        let of = |name| {
            let own = self.whole.figures(&fit.fit, name, &spread).into_iter();
            let estimate = |(name, unit, value, sigma): (_, _, f64, f64)| {
                let half = NINETY * sigma;
                (name, unit, value, [value - half, value + half])
            };
            (name, own.map(estimate).collect())
        };
        fit.names().into_iter().map(of).collect()
    }

    fn declared(&self, fit: &ActuatorModelFit) -> [f64; 4] {
        let [gain, delay_s, lag_s, offset] = fit.fit.declared;
        [gain, 1e3 * delay_s, 1e3 * lag_s, offset]
    }

    fn save(&self, fit: &ActuatorModelFit, model: &mut Model) {
        let spread = self.whole.spread(&fit.fit);
        self.whole.save(&fit.fit, &spread, model);
    }

    fn is_of_higher_order(&self, fit: &ActuatorModelFit) -> bool {
        fit.fit.model.size() > 0 && fit.names().is_empty()
    }
}
