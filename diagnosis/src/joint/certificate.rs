//! What speaks for a name: rivals of every other family are given every chance in its place.

use super::dashpot;
use super::dictionary;
use super::element::Law;
use super::free_functions::{self, FreeFunctions};
use super::groups::{Group, groups};
use super::kind::ElementKind;
use super::polish::Polished;
use super::separable::inseparable;
use super::set::{DECLARED, ElementSet, Library};
use super::unnamed::share_beside_unnamed;
use crate::answer::Certificate;
use crate::criteria::{BESIDE_THE_REST, CERTAIN, PENALTY};
use plant::{Channel, Effect, Family};
use rayon::prelude::*;

/// A name and what speaks for it.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    /// The name.
    pub name: Effect,
    /// Places of its elements in the library; none for a declared parameter that has left its tolerance.
    pub elements: Vec<usize>,
    /// rms of its force, N.
    pub rms: f64,
    /// How many times the squares grow with the best rival of any other kind in its place.
    pub rho: f64,
    /// Logarithm of the squares with it over those without it, beside an unnamed rest of all other kinds.
    pub beside: f64,
    /// It has no part that is the same everywhere along the motion.
    pub varies: bool,
    /// It depends on time alone, and no rest tells that it is there without the motion.
    pub timed: bool,
    /// What free functions leave in its place.
    pub free: FreeFunctions,
    /// Names of other kinds that this motion cannot tell from it, whatever fits.
    pub inseparable: Vec<(Effect, ElementKind)>,
    /// The best of each other family and kind; best first.
    pub rivals: Vec<Rival>,
    /// It is named hysteresis and yields so early that it may be friction.
    pub may_be_friction: bool,
    /// Of one kind with it but of another family.
    pub kin: Option<Rival>,
    /// Of friction that falls with speed: friction that does not.
    pub sliding: Option<Rival>,
}

impl Hypothesis {
    /// Whether it is no better beside an unnamed rest of all other kinds, a product of place and speed, what the
    /// record's beginning in mid-motion leaves behind, or no better than a free function.
    pub fn is_void(&self) -> bool {
        let little = self.beside > (1.0 - BESIDE_THE_REST).ln();
        self.varies || self.timed || little || self.free.doubt.is_some()
    }

    /// What is said of it.
    pub fn certificate(&self) -> Certificate {
        Certificate {
            rivals_leave: self
                .kin
                .as_ref()
                .map_or(self.rho, |k| k.times.min(self.rho))
                .min(self.free.leave),
            beside_the_rest: Some(1.0 - self.beside.exp()),
        }
    }
}

/// What could be in the place of a name.
#[derive(Clone, Debug)]
pub struct Rival {
    /// Its model.
    pub set: ElementSet,
    /// Its name.
    pub name: Effect,
    /// Its kind.
    pub kind: ElementKind,
    /// How many times the squares it leaves.
    pub times: f64,
    /// The same with its shapes' penalty on top: of two that fit equally well the simpler one is likelier.
    pub penalised: f64,
    /// Its model has a force that does not change along the motion, as a name promises, and leaves little more than the best.
    pub steady: bool,
}

/// The names of a polished set, each with its certificate, the strongest first.
pub fn certify(library: &mut Library, best: &Polished) -> (ElementSet, Vec<Hypothesis>) {
    let polished = library.add_polished(best);
    let set = dashpot::simplest(library, polished);
    let tires = |e: &usize| library.elements[*e].law == Law::Fatigued;
    if set.elements.iter().any(tires) {
        library.add(&dictionary::warming(&library.sizes));
    }
    let mut candidates: Vec<Hypothesis> = Vec::new();
    for group in groups(library, &set) {
        // What a dashpot beside elements takes is small against what they take: it is measured by what the set leaves.
        let left = library.cross_validated(&set);
        let beside = group.kind == ElementKind::Parameter && !set.elements.is_empty();
        let before = left
            .filter(|_| beside)
            .map(|left| library.measure_by(&left));
        candidates.push(certificate(library, &set, group));
        if let Some(before) = before {
            library.measure(before);
        }
    }
    candidates.sort_by(|a, b| b.rms.total_cmp(&a.rms));
    (set, candidates)
}

fn certificate(library: &Library, set: &ElementSet, group: Group) -> Hypothesis {
    let own = set_log_ratio(library, set);
    let mut rest = set.clone();
    rest.elements.retain(|e| !group.elements.contains(e));
    if group.kind == ElementKind::Parameter
        && let Some(i) = Channel::Specimen.parameter_of_error(group.name)
    {
        rest.moved[i] = false;
    }
    let most = group.elements.len().max(1);
    let named = |e: usize| library.elements[e].name(&library.sizes, 1.0);
    let dashpot = group.kind == ElementKind::Parameter && !set.elements.is_empty();
    let other = |e: usize| {
        let element = &library.elements[e];
        if dashpot && element.is_dashpot(&library.sizes) {
            return false;
        }
        element.kind(&library.sizes) != group.kind && !element.is_nearly(group.kind, &library.sizes)
    };
    let family = group.name.entry().family;
    // Friction that does not fall with speed is the simpler cause of two.
    let simpler =
        |e: usize| group.name == Effect::StribeckFriction && named(e) == Effect::CoulombFriction;
    let relative = |e: usize| {
        library.elements[e].kind(&library.sizes) == group.kind
            && (named(e).entry().family != family || simpler(e))
    };
    let shapes = |s: &ElementSet| {
        let prices = s.elements.iter().map(|&e| library.elements[e].penalty());
        PENALTY * prices.sum::<f64>()
    };
    let own_price = shapes(set);
    let mut rivals: Vec<Rival> = Vec::new();
    let mut all = in_place_of(library, &rest, other, most, (group.name, group.kind));
    all.extend(in_place_of(
        library,
        &rest,
        relative,
        most,
        (group.name, group.kind),
    ));
    if dashpot {
        let late = dashpot::late(library, set, &rest);
        all.extend(late.map(|log_ratio| {
            (
                Effect::ChannelSkew,
                rest.clone(),
                ElementKind::Parameter,
                log_ratio,
            )
        }));
    }
    for (name, set, kind, log_ratio) in all {
        let same = |r: &&mut Rival| r.kind == kind && r.name.entry().family == name.entry().family;
        let times = (log_ratio - own).exp();
        let penalised = times * (shapes(&set) - own_price).exp();
        let steady = times < CERTAIN && !varies(library, &of_kind(library, &set, kind));
        match rivals.iter_mut().find(same) {
            Some(r) => {
                r.times = r.times.min(times);
                if (steady && !r.steady) || (steady == r.steady && penalised < r.penalised) {
                    (r.penalised, r.name, r.set, r.steady) = (penalised, name, set, steady);
                }
            }
            None => rivals.push(Rival {
                set,
                name,
                kind,
                times,
                penalised,
                steady,
            }),
        }
    }
    let (same_kind, mut rivals): (Vec<Rival>, Vec<Rival>) = rivals
        .into_iter()
        .partition(|r| r.kind == group.kind && group.kind != ElementKind::Parameter);
    let (sliding, kin): (Vec<Rival>, Vec<Rival>) = same_kind
        .into_iter()
        .partition(|r| r.name.entry().family == family);
    rivals.sort_by(|a, b| a.times.total_cmp(&b.times));
    let best = |all: Vec<Rival>| all.into_iter().min_by(|a, b| a.times.total_cmp(&b.times));
    let mut candidate = Hypothesis {
        name: group.name,
        free: FreeFunctions::NONE,
        beside: if group.elements.is_empty() {
            f64::NEG_INFINITY
        } else {
            share_beside_unnamed(library, group.kind, &group.elements)
        },
        varies: varies(library, &group.elements),
        timed: group.kind == ElementKind::Time && !library.rests,
        may_be_friction: family == Family::Hysteresis
            && group
                .elements
                .iter()
                .any(|&e| library.elements[e].may_be_friction(&library.sizes)),
        inseparable: if group.elements.is_empty() {
            Vec::new()
        } else {
            inseparable(library, set, group.kind, &group.elements)
        },
        elements: group.elements,
        rms: group.rms,
        rho: rivals.first().map_or(f64::INFINITY, |r| r.times),
        rivals,
        kin: best(kin),
        sliding: best(sliding),
    };
    if candidate.rho >= CERTAIN && !candidate.is_void() {
        let of = (group.kind, family);
        candidate.free = free_functions::tested(library, set, of, &candidate.elements);
    }
    candidate
}

fn set_log_ratio(library: &Library, set: &ElementSet) -> f64 {
    let costs = library.cross_validated(set);
    costs.map_or(0.0, |c| library.log_ratio(&c))
}

/// The set or the same with all declared parameters free, whichever is better: every chance. A parameter in whose place
/// it stands stays within its tolerances.
fn freest(library: &Library, set: ElementSet, of: Option<usize>) -> (ElementSet, f64) {
    let free = ElementSet {
        moved: std::array::from_fn(|i| Some(i) != of),
        ..set.clone()
    };
    let (held, loose) = (set_log_ratio(library, &set), set_log_ratio(library, &free));
    if loose < held {
        (free, loose)
    } else {
        (set, held)
    }
}

/// Rivals whose second element is tried.
const FOLLOWED: usize = 6;

/// A model with its name, its kind and its fall.
type Placed = (Effect, ElementSet, ElementKind, f64);

/// The models with other elements in place of some, as many at most.
fn in_place_of(
    library: &Library,
    rest: &ElementSet,
    allowed: impl Fn(usize) -> bool + Sync,
    most: usize,
    (of, not): (Effect, ElementKind),
) -> Vec<Placed> {
    let others: Vec<usize> = (0..library.elements.len())
        .filter(|&e| allowed(e) && !rest.elements.contains(&e))
        .collect();
    let parameter = Channel::Specimen.parameter_of_error(of);
    let parameter = parameter.filter(|_| not == ElementKind::Parameter);
    let with = |set: &ElementSet, e: usize| {
        let (set, log_ratio) = freest(library, set.with(e), parameter);
        let strengths = library.strengths(&set).unwrap_or_default();
        let at = set.elements.iter().position(|o| *o == e).unwrap_or(0);
        let strength = strengths.get(DECLARED + at).copied().unwrap_or(0.0);
        let element = &library.elements[e];
        let name = element.name(&library.sizes, strength);
        (name, set, element.kind(&library.sizes), log_ratio)
    };
    let mut found: Vec<Placed> = others.par_iter().map(|&e| with(rest, e)).collect();
    found.sort_by(|a, b| a.3.total_cmp(&b.3));
    if most > 1 {
        let leading = &found[..FOLLOWED.min(found.len())];
        let more: Vec<Placed> = leading
            .par_iter()
            .flat_map_iter(|(name, set, kind, _)| {
                let free = others.iter().filter(|e| !set.elements.contains(e));
                free.map(move |&e| {
                    let (_, set, _, log_ratio) = with(set, e);
                    (*name, set, *kind, log_ratio)
                })
            })
            .collect();
        found.extend(more);
    }
    // Nothing in its place, but a parameter that leaves its tolerance; in place of a parameter, another one.
    for (i, name) in Channel::Specimen.mistakes().into_iter().enumerate() {
        if name == of || (not == ElementKind::Parameter && rest.moved[i]) {
            continue;
        }
        let mut set = rest.clone();
        set.moved[i] = true;
        let log_ratio = set_log_ratio(library, &set);
        found.push((name, set, ElementKind::Parameter, log_ratio));
    }
    found
}

/// Whether elements are nothing but friction that varies along the motion: without a part that is the same everywhere it is no
/// friction that a name could be given to, but some product of place and speed.
fn varies(library: &Library, elements: &[usize]) -> bool {
    let along = |law| matches!(law, Law::SliderAway | Law::SliderAlong);
    let mut laws = elements.iter().map(|&e| library.elements[e].law);
    !elements.is_empty() && laws.all(along)
}

/// The elements of a kind in a set.
fn of_kind(library: &Library, set: &ElementSet, kind: ElementKind) -> Vec<usize> {
    let own = |e: &usize| library.elements[*e].kind(&library.sizes) == kind;
    set.elements.iter().copied().filter(own).collect()
}
