//! Names, a set, or neither.

use super::fit::{ActuatorFit, DECLARED, PartSet};
use super::search::{PartSearch, ScoredFit};
use crate::answer::Certificate;
use crate::criteria::actuator::RIVALS;
use crate::criteria::{ALMOST_ALL, CERTAIN, LARGEST_SET, LEAST_PROBABLE, WEIGHT};
use plant::{Channel, Effect};
use rayon::prelude::*;

/// A name with its certificate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Name {
    pub effect: Effect,
    /// What speaks for it.
    pub certificate: Certificate,
}

/// What can be said.
#[derive(Clone, Debug)]
pub enum ActuatorOutcome {
    /// No part and no parameter is worth its penalty.
    Nothing,
    /// Names that can be vouched for, and the model that has no others.
    Named {
        fit: ActuatorFit,
        names: Vec<Name>,
        /// Something was left out that could not be vouched for.
        more: bool,
    },
    /// No name alone: one of these is it.
    Set {
        fit: ActuatorFit,
        /// Names and how probable they are, the most probable first.
        members: Vec<(Effect, f64)>,
    },
    /// Something is missing, and too many names would do.
    Unknown {
        nearest: Effect,
        /// Share of the squares that it explains.
        explained: f64,
    },
}

impl ActuatorOutcome {
    /// The same with its model fitted anew.
    pub fn with(self, full: impl Fn(&ActuatorFit) -> Option<ActuatorFit>) -> Option<Self> {
        Some(match self {
            Self::Named { fit, names, more } => Self::Named {
                fit: full(&fit)?,
                names,
                more,
            },
            Self::Set { fit, members } => Self::Set {
                fit: full(&fit)?,
                members,
            },
            other => other,
        })
    }
}

/// What a model claims: its parts; without any, the parameters that left their tolerances.
pub fn names(model: &PartSet) -> Vec<Effect> {
    let mut names: Vec<Effect> = if model.parts.is_empty() {
        let names = Channel::Actuator.mistakes().into_iter().zip(model.moved);
        names.filter(|n| n.1).map(|n| n.0).collect()
    } else {
        model.parts.iter().map(|p| p.kind.effect()).collect()
    };
    names.sort();
    names.dedup();
    names
}

/// From all that was searched.
pub fn conclude(search: &PartSearch, declared: &ScoredFit) -> ActuatorOutcome {
    let all = search.run(declared);
    let best = &all[0];
    let claimed = names(&best.fit.model);
    if claimed.is_empty() {
        return ActuatorOutcome::Nothing;
    }
    let judged: Vec<Name> = claimed
        .iter()
        .map(|&effect| {
            let mut rivals = rivals(search, best, effect, declared);
            rivals.extend(others(search, best, effect, &all));
            let least = rivals.iter().map(|r| r.1).fold(f64::INFINITY, f64::min);
            Name {
                effect,
                certificate: certificate(least),
            }
        })
        .collect();
    let explained = 1.0 - search.times(&best.squares, &declared.squares).exp();
    let sure: Vec<Name> = judged
        .iter()
        .copied()
        .filter(|n| n.certificate.rivals_leave >= CERTAIN)
        .collect();
    let unknown = |nearest| ActuatorOutcome::Unknown { nearest, explained };
    if !sure.is_empty() {
        let more = sure.len() < judged.len();
        let model = only(&best.fit.model, &sure);
        return match search.scored(&model, best.fit.declared) {
            Some(s) if s.score < 0.0 => ActuatorOutcome::Named {
                fit: s.fit,
                names: sure,
                more,
            },
            _ => unknown(sure[0].effect),
        };
    }
    let Some(first) = judged.iter().max_by(|a, b| {
        a.certificate
            .rivals_leave
            .total_cmp(&b.certificate.rivals_leave)
    }) else {
        return ActuatorOutcome::Nothing;
    };
    // The preferred member alone: what stands beside it cannot be vouched for either, and its rivals are those without it.
    let alone = search.scored(&only(&best.fit.model, &[*first]), best.fit.declared);
    let singles = single_names(search, declared);
    let alone = alone.filter(|s| s.score < 0.0);
    let with_others = alone.as_ref().and_then(|alone| {
        let mut rivals = rivals(search, alone, first.effect, declared);
        rivals.extend(others(search, alone, first.effect, &all));
        // One name has any other that explains the record alone for a rival.
        if names(&alone.fit.model).len() == 1 {
            rivals.extend(others(search, alone, first.effect, &singles));
        }
        set(alone, first.effect, named(rivals))
    });
    let with_parameters = || {
        let alone = alone.as_ref()?;
        let rivals = parameters_instead(search, alone, first.effect);
        set(alone, first.effect, rivals)
    };
    with_others
        .or_else(|| almost_all(search, declared, &singles))
        .or_else(with_parameters)
        .unwrap_or_else(|| unknown(first.effect))
}

/// The declared parameters that do together what the one part of a model does: each is a rival of its name.
fn parameters_instead(
    search: &PartSearch,
    alone: &ScoredFit,
    effect: Effect,
) -> Vec<(Effect, f64)> {
    let free = PartSet {
        parts: Vec::new(),
        moved: [true; DECLARED],
    };
    if names(&alone.fit.model) != [effect] || alone.fit.model.parts.is_empty() {
        return Vec::new();
    }
    let moved = search.scored(&free, alone.fit.declared);
    let Some(needed) = moved.map(|moved| search.held(moved)) else {
        return Vec::new();
    };
    let times = search.times(&needed.squares, &alone.squares);
    names(&needed.fit.model)
        .into_iter()
        .map(|name| (name, times))
        .collect()
}

/// Of a name whose best rival leaves this logarithm of the squares.
fn certificate(least: f64) -> Certificate {
    Certificate {
        rivals_leave: least.exp(),
        beside_the_rest: None,
    }
}

/// A set of a name and its rivals; `None` where there is no rival or too many.
fn set(own: &ScoredFit, effect: Effect, mut rivals: Vec<(Effect, f64)>) -> Option<ActuatorOutcome> {
    rivals.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut members: Vec<(Effect, f64)> = vec![(effect, 1.0)];
    for (rival, times) in rivals.into_iter().filter(|r| r.1 < CERTAIN.ln()) {
        let odds = (-WEIGHT * times).exp().min(1.0);
        match members.iter_mut().find(|m| m.0 == rival) {
            Some(m) => m.1 = m.1.max(odds),
            None => members.push((rival, odds)),
        }
    }
    let whole: f64 = members.iter().map(|m| m.1).sum();
    members.iter_mut().for_each(|m| m.1 /= whole);
    members.retain(|m| m.0 == effect || m.1 > LEAST_PROBABLE);
    if members.len() < 2 || members.len() > LARGEST_SET {
        return None;
    }
    // The preferred one is the one that the model has.
    members[1..].sort_by(|a, b| b.1.total_cmp(&a.1));
    Some(ActuatorOutcome::Set {
        fit: own.fit.clone(),
        members,
    })
}

/// Models of one name each, best first.
fn single_names(search: &PartSearch, declared: &ScoredFit) -> Vec<ScoredFit> {
    let mut singles: Vec<ScoredFit> = search.bare(declared);
    let held = [false; DECLARED];
    for screened_part in search.screened(declared, &[]).iter().take(RIVALS) {
        let model = PartSet {
            parts: vec![screened_part.part],
            moved: held,
        };
        singles.extend(search.scored(&model, declared.fit.declared));
    }
    singles.retain(|s| names(&s.fit.model).len() == 1);
    singles.sort_by(|a, b| a.score.total_cmp(&b.score));
    singles
}

/// Where one name alone leaves next to nothing of the squares: the set of those that do, whatever small part of the rest
/// could be had beside it.
fn almost_all(
    search: &PartSearch,
    declared: &ScoredFit,
    singles: &[ScoredFit],
) -> Option<ActuatorOutcome> {
    let best = singles.first()?.clone();
    if search.times(&best.squares, &declared.squares) > ALMOST_ALL.ln() {
        return None;
    }
    let effect = names(&best.fit.model)[0];
    let rivals = singles[1..]
        .iter()
        .filter(|s| names(&s.fit.model)[0] != effect);
    let rivals: Vec<(Effect, f64)> = rivals
        .map(|s| {
            let times = search.times(&s.squares, &best.squares);
            (names(&s.fit.model)[0], times)
        })
        .collect();
    let least = rivals.iter().map(|r| r.1).fold(f64::INFINITY, f64::min);
    if least >= CERTAIN.ln() {
        return Some(ActuatorOutcome::Named {
            fit: best.fit,
            names: vec![Name {
                effect,
                certificate: certificate(least),
            }],
            more: true,
        });
    }
    set(&best, effect, rivals)
}

/// A rival: its name, if it has one, and the logarithm of how many times the squares it leaves.
type RivalRatio = (Option<Effect>, f64);

/// Rivals that have a name.
fn named(rivals: Vec<RivalRatio>) -> Vec<(Effect, f64)> {
    rivals
        .into_iter()
        .filter_map(|(e, t)| Some((e?, t)))
        .collect()
}

/// A model with the parts of sure names only.
fn only(model: &PartSet, sure: &[Name]) -> PartSet {
    let mut kept = model.clone();
    kept.parts
        .retain(|p| sure.iter().any(|n| n.effect == p.kind.effect()));
    if model.parts.is_empty() {
        for (moved, effect) in kept.moved.iter_mut().zip(Channel::Actuator.mistakes()) {
            *moved &= sure.iter().any(|n| n.effect == effect);
        }
    }
    kept
}

/// Whether a name is another one or has it as a special case: friction that falls with speed fits whatever friction fits.
fn is_or_generalises(name: Effect, other: Effect) -> bool {
    name == other || (name, other) == (Effect::StribeckFriction, Effect::CoulombFriction)
}

/// What the best model leaves if a name is replaced: each rival's name, if it has one, and the logarithm of how many times the
/// squares it leaves.
fn rivals(
    search: &PartSearch,
    best: &ScoredFit,
    effect: Effect,
    declared: &ScoredFit,
) -> Vec<RivalRatio> {
    let mut without = best.fit.model.clone();
    without.parts.retain(|p| p.kind.effect() != effect);
    without.moved = [true; DECLARED];
    if best.fit.model.parts.is_empty() {
        for (moved, name) in without.moved.iter_mut().zip(Channel::Actuator.mistakes()) {
            *moved &= name != effect;
        }
    }
    let start = if best.fit.model.parts.is_empty() {
        declared.fit.declared
    } else {
        best.fit.declared
    };
    let Some(dropped) = search.scored(&without, start) else {
        return Vec::new();
    };
    let same: Vec<_> = super::part::PartKind::ALL
        .into_iter()
        .filter(|k| is_or_generalises(k.effect(), effect))
        .collect();
    let screened = search.screened(&dropped, &same);
    let replaced = screened.par_iter().take(RIVALS).filter_map(|g| {
        let mut model = without.clone();
        model.parts.push(g.part);
        let scored = search.scored(&model, dropped.fit.declared)?;
        // What is not worth its penalty beside the parameters that moved is not what explains.
        let pays = scored.score < dropped.score;
        Some((
            pays.then(|| g.part.kind.effect()),
            search.times(&scored.squares, &best.squares),
        ))
    });
    let mut all: Vec<RivalRatio> = replaced.collect();
    all.push((None, search.times(&dropped.squares, &best.squares)));
    all
}

/// Other models of the search that do without a name and are no larger.
fn others(
    search: &PartSearch,
    best: &ScoredFit,
    effect: Effect,
    all: &[ScoredFit],
) -> Vec<RivalRatio> {
    let size = |s: &ScoredFit| names(&s.fit.model).len();
    all.iter()
        .filter(|s| size(s) <= size(best))
        .filter_map(|s| {
            let claimed = names(&s.fit.model);
            let has = claimed.iter().any(|n| is_or_generalises(*n, effect));
            let new = claimed
                .iter()
                .find(|n| !names(&best.fit.model).contains(n))
                .copied();
            (!has && !claimed.is_empty()).then(|| (new, search.times(&s.squares, &best.squares)))
        })
        .collect()
}
