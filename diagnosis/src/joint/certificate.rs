//! What speaks for a name: rivals of every other family are given every chance in its place.

use super::blocks::Blocks;
use super::dashpot;
use super::dictionary;
use super::element::{Element, ElementKind, Law};
use super::free::{self, FreeFunctions};
use super::polish::Polished;
use super::search::restrict;
use super::separable::inseparable;
use super::set::{DECLARED, ElementSet, Library, column};
use crate::answer::Certificate;
use crate::criteria::{BESIDE_THE_REST, BLOCKS, CERTAIN, PRICE};
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
    /// It has no part that is the same everywhere along the way.
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
    pub may_slide: bool,
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
    /// The same with its shapes' price on top: of two that fit equally well the simpler one is likelier.
    pub priced: f64,
    /// Its model has a force that does not change along the way, as a name promises, and leaves little more than the best.
    pub steady: bool,
}

/// The names of a polished set, each with its certificate, the strongest first.
pub fn certify(library: &mut Library, best: &Polished) -> (ElementSet, Vec<Hypothesis>) {
    let taken = taken(library, best);
    let set = dashpot::simplest(library, taken);
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

/// A polished set in the library.
pub fn taken(library: &mut Library, polished: &Polished) -> ElementSet {
    let first = library.add(&polished.elements);
    ElementSet {
        elements: (first..library.elements.len()).collect(),
        moved: polished.moved,
    }
}

/// Elements of one kind, with their name and the rms of their force.
#[derive(Clone, Debug)]
pub struct Group {
    /// The kind.
    pub kind: ElementKind,
    /// The name.
    pub name: Effect,
    /// Places in the library.
    pub elements: Vec<usize>,
    /// Of the strongest, N.
    pub rms: f64,
}

/// The kinds of a set.
pub fn groups(library: &Library, set: &ElementSet) -> Vec<Group> {
    let Some(strengths) = library.strengths(set) else {
        return Vec::new();
    };
    let sizes = &library.sizes;
    let mut groups: Vec<Group> = Vec::new();
    for (&place, strength) in set.elements.iter().zip(&strengths[DECLARED..]) {
        let element = &library.elements[place];
        let name = element.name(sizes, *strength);
        let by = library.blocks.scale[DECLARED + place];
        let rms = if by > 0.0 { strength.abs() / by } else { 0.0 };
        let kind = element.kind(sizes);
        match groups.iter_mut().find(|g| g.kind == kind) {
            Some(g) => {
                let falls = |n| n == Effect::StribeckFriction;
                let slides = |n| n == Effect::CoulombFriction;
                // Friction that drops with speed beside friction is friction that drops.
                if slides(g.name) && falls(name) || slides(name) && falls(g.name) {
                    g.name = Effect::StribeckFriction;
                } else if rms > g.rms {
                    g.name = name;
                }
                g.rms = g.rms.max(rms);
                g.elements.push(place);
            }
            None => groups.push(Group {
                kind,
                name,
                elements: vec![place],
                rms,
            }),
        }
    }
    for g in groups.iter_mut().filter(|g| g.kind == ElementKind::Place) {
        if g.elements.len() > 1 {
            g.name = spring(library, set, &strengths, &g.elements);
        }
    }
    // Beside elements a parameter takes up what they are wrong by; more damping than declared is a dashpot beside them,
    // where no element of theirs grows with speed.
    let alone = groups.is_empty();
    let has = |kind| groups.iter().any(|g| g.kind == kind);
    let dashpot = !has(ElementKind::Speed) && !has(ElementKind::Linear);
    let more = |i: usize| strengths[i] > library.parameter(i, false).high;
    let beside = |i: usize| i == dashpot::PARAMETER && dashpot && more(i);
    let named = |i: usize| set.moved[i] && (alone || beside(i));
    let moved: Vec<usize> = (0..DECLARED).filter(|&i| named(i)).collect();
    groups.extend(moved.into_iter().map(|i| Group {
        kind: ElementKind::Parameter,
        name: Channel::Specimen.mistakes()[i],
        elements: Vec::new(),
        rms: (strengths[i] - library.declared_value(i)).abs()
            / library.blocks.scale[i].max(f64::MIN_POSITIVE),
    }));
    groups
}

/// The name of several elements that depend on the place: together they are one spring, whose two sides may be alike. They
/// are compared where the motion has been on both: an excursion to one side shows nothing of the other.
fn spring(library: &Library, set: &ElementSet, strengths: &[f64], own: &[usize]) -> Effect {
    let sizes = &library.sizes;
    let [centre, reach] = sizes.both_sides();
    let places = [-1.0, -0.5, 0.0, 0.5, 1.0].map(|u| centre + u * reach);
    let mut force = [0.0; 5];
    for (&e, strength) in set.elements.iter().zip(&strengths[DECLARED..]) {
        if own.contains(&e) {
            let own = library.elements[e].over(&places, sizes);
            force
                .iter_mut()
                .zip(own)
                .for_each(|(f, o)| *f += strength * o);
        }
    }
    let [a, b, c, d, e] = force;
    let (odd, half) = (0.5 * (e - a), 0.5 * (d - b));
    // What bends alike on both sides, and what does not.
    let (bends, differs) = (odd - 2.0 * half, 0.5 * (e + a) - c);
    if differs.abs() > bends.abs() {
        Effect::AsymmetricStiffness
    } else if bends > 0.0 {
        Effect::Hardening
    } else {
        Effect::Softening
    }
}

fn certificate(library: &Library, set: &ElementSet, group: Group) -> Hypothesis {
    let own = set_fall(library, set);
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
        let prices = s.elements.iter().map(|&e| library.elements[e].price());
        PRICE * prices.sum::<f64>()
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
        all.extend(late.map(|fall| {
            (
                Effect::ChannelSkew,
                rest.clone(),
                ElementKind::Parameter,
                fall,
            )
        }));
    }
    for (name, set, kind, fall) in all {
        let same = |r: &&mut Rival| r.kind == kind && r.name.entry().family == name.entry().family;
        let times = (fall - own).exp();
        let priced = times * (shapes(&set) - own_price).exp();
        let steady = times < CERTAIN && !varies(library, &of_kind(library, &set, kind));
        match rivals.iter_mut().find(same) {
            Some(r) => {
                r.times = r.times.min(times);
                if (steady && !r.steady) || (steady == r.steady && priced < r.priced) {
                    (r.priced, r.name, r.set, r.steady) = (priced, name, set, steady);
                }
            }
            None => rivals.push(Rival {
                set,
                name,
                kind,
                times,
                priced,
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
            beside_the_rest(library, group.kind, &group.elements)
        },
        varies: varies(library, &group.elements),
        timed: group.kind == ElementKind::Time && !library.rests,
        may_slide: family == Family::Hysteresis
            && group
                .elements
                .iter()
                .any(|&e| library.elements[e].may_slide(&library.sizes)),
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
        candidate.free = free::tried(library, set, of, &candidate.elements);
    }
    candidate
}

fn set_fall(library: &Library, set: &ElementSet) -> f64 {
    let costs = library.cross_validated(set);
    costs.map_or(0.0, |c| library.fall(&c))
}

/// The set or the same with all declared parameters free, whichever is better: every chance. A parameter in whose place
/// it stands stays within its tolerances.
fn freest(library: &Library, set: ElementSet, of: Option<usize>) -> (ElementSet, f64) {
    let free = ElementSet {
        moved: std::array::from_fn(|i| Some(i) != of),
        ..set.clone()
    };
    let (held, loose) = (set_fall(library, &set), set_fall(library, &free));
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
        let (set, fall) = freest(library, set.with(e), parameter);
        let strengths = library.strengths(&set).unwrap_or_default();
        let at = set.elements.iter().position(|o| *o == e).unwrap_or(0);
        let strength = strengths.get(DECLARED + at).copied().unwrap_or(0.0);
        let element = &library.elements[e];
        let name = element.name(&library.sizes, strength);
        (name, set, element.kind(&library.sizes), fall)
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
                    let (_, set, _, fall) = with(set, e);
                    (*name, set, *kind, fall)
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
        let fall = set_fall(library, &set);
        found.push((name, set, ElementKind::Parameter, fall));
    }
    found
}

/// Hats over a range, memory, filters and time of the unnamed rest.
const HATS: usize = 9;
/// Ridge of the unnamed rest.
const RIDGE: f64 = 1e-4;

/// Columns of an unnamed rest, with the kind that each stands for.
fn rest_columns(library: &Library) -> Vec<(ElementKind, Vec<f64>)> {
    let s = library.sizes;
    let t = library.tracks;
    let mut all = Vec::new();
    for i in 0..HATS {
        let at = -1.0 + 2.0 * i as f64 / (HATS - 1) as f64;
        let width = 2.0 / (HATS - 1) as f64;
        let hat = |u: f64| (1.0 - (u - at).abs() / width).max(0.0);
        let in_x = |x: &f64| hat((x - s.middle) / s.x);
        let in_v = |v: &f64| hat((v / s.v).clamp(-1.0, 1.0));
        all.push((
            ElementKind::Place,
            column(t, library.every, |t| t.x.iter().map(in_x).collect()),
        ));
        all.push((
            ElementKind::Speed,
            column(t, library.every, |t| t.v.iter().map(in_v).collect()),
        ));
    }
    for i in 0..library.elements.len() {
        let e: &Element = &library.elements[i];
        let kind = match e.law {
            Law::Slider => ElementKind::Memory,
            Law::Relaxing => ElementKind::Linear,
            Law::Settling => ElementKind::Time,
            Law::Lessened => ElementKind::Damage,
            _ => continue,
        };
        all.push((kind, library.columns[DECLARED + i].clone()));
    }
    all
}

/// Whether elements are nothing but friction that varies along the way: without a part that is the same everywhere it is no
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

/// Logarithm of the squares with elements over those without, beside an unnamed rest of all other kinds.
fn beside_the_rest(library: &Library, kind: ElementKind, elements: &[usize]) -> f64 {
    // What a play takes off a spring is a slider that pulls; and sliders of many gives and either sign remember the largest
    // displacement (a Preisach model keeps the extremes that nothing later has wiped out), so they draw any damage.
    let sliders = matches!(kind, ElementKind::Play | ElementKind::Damage);
    let own = |k: ElementKind| k == kind || (sliders && k == ElementKind::Memory);
    let rest = rest_columns(library).into_iter().filter(|r| !own(r.0));
    let mut columns: Vec<Vec<f64>> = library.columns[..DECLARED].to_vec();
    columns.extend(rest.map(|r| r.1));
    let without = ridge_costs(&columns, &library.force);
    columns.extend(
        elements
            .iter()
            .map(|e| library.columns[DECLARED + e].clone()),
    );
    let with = ridge_costs(&columns, &library.force);
    match (without, with) {
        (Some(without), Some(with)) => library.fall(&with) - library.fall(&without),
        _ => f64::NEG_INFINITY,
    }
}

/// Cross-validated squares of many columns with a ridge.
fn ridge_costs(columns: &[Vec<f64>], force: &[f64]) -> Option<[f64; BLOCKS]> {
    let blocks = Blocks::new(columns, force);
    let costs = blocks.ridge_cross_validated(|_, own| RIDGE * own.max(1e-12))?;
    Some(std::array::from_fn(|b| costs[b].max(0.0)))
}

/// The set with these elements only, its parameters moved as far as that pays.
pub fn only(library: &Library, set: &ElementSet, elements: &[usize]) -> ElementSet {
    let kept = ElementSet {
        elements: elements.to_vec(),
        moved: set.moved,
    };
    let score = library.score(&kept).unwrap_or(f64::INFINITY);
    let settled = restrict(library, vec![(kept.clone(), score)]);
    let same = |s: &&(ElementSet, f64)| s.0.elements == kept.elements;
    settled.iter().find(same).map_or(kept, |s| s.0.clone())
}

#[cfg(test)]
mod tests {
    use super::super::track::UnfilteredSpan;
    use super::*;
    use crate::base::Base;
    use crate::model::{Model, SpecimenModel};
    use crate::recording::Recording;

    /// The name of two kinks in a spring, at -6 and 6 mm, of a specimen that has gone to `left_mm` once and to 28 mm.
    fn kinks(left_mm: f64, strengths: [f64; 2]) -> Effect {
        let at = |i: usize| {
            let t = 0.01 * i as f64;
            let pulse = |t0: f64| (-((t - t0) / 0.7).powi(2)).exp();
            left_mm * pulse(3.0) + 28.0 * pulse(5.0) + 9.0 * (1.7 * t).sin()
        };
        let x: Vec<f64> = (0..3000).map(at).collect();
        let places = [-6.0, 6.0];
        let spring = |x: &f64| {
            let kinks = places.iter().zip(strengths);
            50.0 * x + kinks.map(|(p, s)| s * (x - p).abs()).sum::<f64>()
        };
        let record = Recording {
            name: "a specimen".into(),
            time_s: (0..x.len()).map(|i| 0.01 * i as f64).collect(),
            force_n: Some(x.iter().map(spring).collect()),
            displacement_mm: Some(x),
            ..Recording::default()
        };
        let model = Model {
            specimen: Some(SpecimenModel::default()),
            ..Model::default()
        };
        let base = Base::of(&model, Channel::Specimen).unwrap();
        let tracks = [UnfilteredSpan::new(&record).unwrap().track(10.0)];
        let mut library = Library::new(&base, &tracks, 1).unwrap();
        let first = library.add(&places.map(|p| Element::new(Law::Away, [p])));
        let set = ElementSet {
            elements: vec![first, first + 1],
            moved: [true; DECLARED],
        };
        let groups = groups(&library, &set);
        let spring = groups.iter().find(|g| g.kind == ElementKind::Place);
        spring.unwrap().name
    }

    #[test]
    fn the_sides_of_a_spring_are_compared_where_the_motion_has_been_on_both() {
        for left_mm in [-28.0, -63.0] {
            assert_eq!(kinks(left_mm, [20.0, -20.0]), Effect::Softening);
            assert_eq!(kinks(left_mm, [-20.0, 20.0]), Effect::Hardening);
            assert_eq!(kinks(left_mm, [20.0, 0.5]), Effect::AsymmetricStiffness);
        }
    }
}
