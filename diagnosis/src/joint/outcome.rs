//! Names, a set, or neither: what the certificates allow to be said.

use super::certificate::{Hypothesis, Rival};
use super::covariance::settled;
use super::figures::{PRESLIDING, with_intervals};
use super::fit::SpecimenFit;
use super::groups::groups;
use super::kind::ElementKind;
use super::polish::polish;
use super::search::{only, restrict};
use super::set::{ElementSet, Library};
use super::sliding;
use crate::answer::{Certificate, ParameterEstimate};
use crate::criteria::{
    CERTAIN, FALSE_NAMES, LARGEST_SET, LEAST_PROBABLE, LEAST_SURE, LEAST_TIMES, WEIGHT,
};
use plant::{Effect, Family};

/// A model with its names.
#[derive(Clone, Debug)]
pub struct Explained {
    /// The model.
    pub fit: SpecimenFit,
    /// Whose each of its elements is.
    pub owners: Vec<Effect>,
    /// Each name, its certificate where it has one, and its parameters.
    pub names: Vec<(Effect, Option<Certificate>, Vec<ParameterEstimate>)>,
    /// What more damping than declared, which is in the model, may be: no name, since others do nearly as well.
    pub damping: Vec<Effect>,
}

/// A name, its elements in the library, and what speaks for it.
type NamedElements = (Effect, Vec<usize>, Option<Certificate>);

/// What the search came to.
#[derive(Clone, Debug)]
pub enum SpecimenOutcome {
    /// No element and no parameter is worth its penalty.
    Nothing,
    /// Names that can be vouched for; whether something was left out that could not be.
    Named(Explained, bool),
    /// No name alone: one of these is it, with their probabilities, the model's own first.
    Set(Explained, Vec<(Effect, f64)>),
    /// Nothing that can be said: the nearest, and the share of the squares that it explains with what stands beside it, on
    /// data left out.
    Unknown(Effect, f64),
}

/// Expected share of false names among all that are given with this certificate or a better one.
pub fn q(rivals_leave: f64) -> f64 {
    let row = FALSE_NAMES.iter().find(|row| rivals_leave >= row.0);
    row.map_or(LEAST_SURE, |row| row.1)
}

/// How often a cause is met among those that fit a specimen's record equally well, relative to friction: every machine
/// has that; a filter or a change with time fits many records and is the cause of few.
pub fn commonness(name: Effect) -> f64 {
    match name.entry().family {
        Family::Friction => 1.0,
        Family::Hysteresis | Family::Calibration => 0.7,
        Family::Damping if name == Effect::MaxwellDamper => 0.25,
        Family::Damping => 1.0,
        Family::Slow => 0.1,
        _ => 0.5,
    }
}

/// From the best set and the certificates of its names, the strongest first.
pub fn conclude(
    library: &mut Library,
    set: &ElementSet,
    names: &[Hypothesis],
    cutoff_hz: f64,
) -> Option<SpecimenOutcome> {
    let Some(strongest) = names.first() else {
        return Some(SpecimenOutcome::Nothing);
    };
    // Friction or hysteresis: of one kind, and where it yields does not tell.
    let undecided = |n: &Hypothesis| {
        let kin = n.kin.as_ref().is_some_and(|k| k.times < CERTAIN);
        kin || n.may_be_friction || !n.inseparable.is_empty()
    };
    let sure = names.iter().filter(|n| n.rho >= CERTAIN && !n.is_void());
    let (open, sure): (Vec<Hypothesis>, Vec<Hypothesis>) = sure.cloned().partition(undecided);
    // What goes with names that are dropped, parameters may take: by the measure of what the whole set leaves.
    if let Some(left) = library.cross_validated(set) {
        library.measure_by(&left);
    }
    // Friction that falls with speed, where friction that does not would do.
    let slides = |n: &Hypothesis| n.sliding.as_ref().map(|r| r.times).filter(|t| *t < CERTAIN);
    if let [one] = &sure[..]
        && let Some(times) = slides(one)
    {
        let odds = times.max(1.0).powf(-WEIGHT);
        let own = [(one.name, one.elements.clone(), None)];
        let both = [(one.name, 1.0), (Effect::CoulombFriction, odds)];
        let members = both.map(|(name, weight)| (name, weight / (1.0 + odds)));
        let model = explained(library, set, &own, cutoff_hz, false)?;
        return Some(SpecimenOutcome::Set(model, members.to_vec()));
    }
    if !sure.is_empty() {
        let named = |n: &Hypothesis| slides(n).map_or(n.name, |_| Effect::CoulombFriction);
        let groups: Vec<NamedElements> = sure
            .iter()
            .map(|n| (named(n), n.elements.clone(), Some(n.certificate())))
            .collect();
        let mut model = explained(library, set, &groups, cutoff_hz, true)?;
        let dashpot =
            |n: &&Hypothesis| n.elements.is_empty() && groups.iter().all(|g| g.0 != n.name);
        if let Some(dashpot) = names.iter().find(dashpot) {
            let rivals = dashpot.rivals.iter().filter(|r| r.times < CERTAIN);
            model.damping = std::iter::once(dashpot.name)
                .chain(rivals.map(|r| r.name))
                .take(LARGEST_SET)
                .collect();
        }
        return Some(SpecimenOutcome::Named(model, sure.len() < names.len()));
    }
    let first = open.first().unwrap_or(strongest);
    let members = members(first);
    if members.len() < 2 {
        let left = library.cross_validated(set);
        let explained = left.map_or(0.0, |left| 1.0 - library.log_ratio(&left).exp());
        return Some(SpecimenOutcome::Unknown(first.name, explained.max(0.0)));
    }
    // The model is that of the likeliest that can be fitted.
    let model = members.iter().find_map(|&(name, _)| {
        if name == first.name {
            let own = [(first.name, first.elements.clone(), None)];
            return explained(library, set, &own, cutoff_hz, false);
        }
        let rival = first.rivals.iter().chain(&first.kin);
        let rival = rival.clone().find(|r| r.name == name)?;
        instead(library, rival, cutoff_hz)
    })?;
    let members = led_by(model.names[0].0, members);
    Some(SpecimenOutcome::Set(model, members))
}

/// A set with the name that the model has at its head; the others stay in their order.
fn led_by(name: Effect, mut members: Vec<(Effect, f64)>) -> Vec<(Effect, f64)> {
    if let Some(own) = members.iter().position(|m| m.0 == name) {
        members[..=own].rotate_right(1);
    }
    members
}

/// The names that could be it, with their probabilities.
fn members(first: &Hypothesis) -> Vec<(Effect, f64)> {
    let mut members = vec![(first.name, commonness(first.name))];
    for rival in first.rivals.iter().chain(&first.kin) {
        if rival.times < CERTAIN && members.iter().all(|m| m.0 != rival.name) {
            let odds = rival.penalised.max(LEAST_TIMES).powf(-WEIGHT);
            members.push((rival.name, commonness(rival.name) * odds));
        }
    }
    // As probable as the hysteresis that the model has, whatever the exact shape of its knee.
    if first.may_be_friction && members.iter().all(|m| m.0 != Effect::CoulombFriction) {
        members.push((Effect::CoulombFriction, commonness(first.name)));
    }
    // What the motion cannot tell apart is equally probable, but for how common it is.
    for &(name, _) in &first.inseparable {
        if members.iter().all(|m| m.0 != name) {
            members.push((name, commonness(name)));
        }
    }
    members.sort_by(|a, b| b.1.total_cmp(&a.1));
    members.truncate(LARGEST_SET);
    let whole: f64 = members.iter().map(|m| m.1).sum();
    members.iter_mut().for_each(|m| m.1 /= whole);
    members.retain(|m| m.1 > LEAST_PROBABLE);
    members
}

/// The model with some names, which may be vouched for, and no other elements.
fn explained(
    library: &Library,
    set: &ElementSet,
    groups: &[NamedElements],
    cutoff_hz: f64,
    vouched: bool,
) -> Option<Explained> {
    let kept: Vec<usize> = groups.iter().flat_map(|g| g.1.clone()).collect();
    let own = if kept.len() == set.elements.len() {
        set.clone()
    } else {
        only(library, set, &kept)
    };
    let fit = settled(library, &SpecimenFit::new(library, &own, cutoff_hz)?);
    let place = |e: &usize| own.elements.iter().position(|o| o == e);
    let named: Vec<(Effect, Vec<usize>)> = groups
        .iter()
        .map(|g| (g.0, g.1.iter().filter_map(place).collect()))
        .collect();
    // A set says which laws may act, not how strong one is: its model is the one that answers best.
    let sliding = vouched
        .then(|| sliding::read(library, &own, &fit, &named))
        .flatten();
    let sure = sliding.as_ref().map(|s| &s.sure[..]);
    let fit = sliding.as_ref().map_or(fit, |s| s.fit.clone());
    let mut figures = with_intervals(library, &fit, &named, sure);
    if let Some((_, interval)) = sliding.and_then(|s| s.presliding_mm) {
        let way = figures.iter_mut().flatten();
        way.filter(|f| f.0 == PRESLIDING)
            .for_each(|f| f.3 = interval);
    }
    let owner = |element: usize| {
        let own = named.iter().find(|n| n.1.contains(&element));
        own.unwrap_or(&named[0]).0
    };
    let owners = (0..fit.elements.len()).map(owner).collect();
    let names = groups.iter().zip(figures);
    Some(Explained {
        owners,
        names: names.map(|(g, f)| (g.0, g.2, f)).collect(),
        damping: Vec::new(),
        fit,
    })
}

/// The model of a rival that is likelier than what fits best; there is none of a force that is read late.
fn instead(library: &mut Library, rival: &Rival, cutoff_hz: f64) -> Option<Explained> {
    if rival.name == Effect::ChannelSkew {
        return None;
    }
    let score = library.score(&rival.set)?;
    let mut settled = restrict(library, vec![(rival.set.clone(), score)]);
    let (set, score) = settled.pop()?;
    let polished = polish(library, &set, score);
    let set = library.add_polished(&polished);
    let own = if rival.kind == ElementKind::Parameter {
        Vec::new()
    } else {
        let group = groups(library, &set)
            .into_iter()
            .find(|g| g.kind == rival.kind);
        group?.elements
    };
    explained(library, &set, &[(rival.name, own, None)], cutoff_hz, false)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rival(name: Effect, kind: ElementKind, times: f64) -> Rival {
        Rival {
            set: ElementSet::default(),
            name,
            kind,
            times,
            penalised: times,
            steady: true,
        }
    }

    fn candidate(name: Effect, rivals: Vec<Rival>) -> Hypothesis {
        Hypothesis {
            name,
            elements: vec![0],
            rms: 1.0,
            rho: rivals.first().map_or(f64::INFINITY, |r| r.times),
            beside: -1.0,
            free: super::super::free_functions::FreeFunctions::NONE,
            varies: false,
            timed: false,
            may_be_friction: false,
            inseparable: Vec::new(),
            rivals,
            kin: None,
            sliding: None,
        }
    }

    #[test]
    fn a_relaxation_that_fits_a_little_better_than_friction_is_less_probable() {
        let friction = |times| rival(Effect::CoulombFriction, ElementKind::Memory, times);
        let near = members(&candidate(Effect::MaxwellDamper, vec![friction(1.2)]));
        assert_eq!(near[0].0, Effect::CoulombFriction);
        let far = members(&candidate(Effect::MaxwellDamper, vec![friction(1.9)]));
        assert_eq!(far[0].0, Effect::MaxwellDamper);
        let whole: f64 = far.iter().map(|m| m.1).sum();
        assert!((whole - 1.0).abs() < 1e-9);
    }

    #[test]
    fn the_name_that_the_model_has_leads_its_set_and_no_other_is_lost() {
        use Effect::{BoucWenHysteresis, CoulombFriction, ViscousDamping};
        let set = vec![
            (CoulombFriction, 0.4),
            (BoucWenHysteresis, 0.35),
            (ViscousDamping, 0.25),
        ];
        let led = led_by(ViscousDamping, set.clone());
        assert_eq!(led, [set[2], set[0], set[1]]);
        assert_eq!(led_by(CoulombFriction, set.clone()), set);
    }

    #[test]
    fn rivals_that_fit_far_worse_are_no_members_and_a_set_has_at_most_five() {
        let worse = rival(Effect::Hardening, ElementKind::Displacement, 1.01 * CERTAIN);
        let alone = members(&candidate(Effect::CoulombFriction, vec![worse]));
        assert_eq!(alone.len(), 1);
        let all = [
            (Effect::Hardening, ElementKind::Displacement),
            (Effect::ViscousDamping, ElementKind::Velocity),
            (Effect::Offset, ElementKind::Parameter),
            (Effect::Backlash, ElementKind::Play),
            (Effect::MaxwellDamper, ElementKind::Linear),
            (Effect::Drift, ElementKind::Time),
        ];
        let rivals = all.iter().map(|(name, kind)| rival(*name, *kind, 1.0));
        let many = members(&candidate(Effect::CoulombFriction, rivals.collect()));
        assert_eq!(many.len(), LARGEST_SET);
        assert!(many.iter().all(|m| m.0 != Effect::Drift));
    }

    #[test]
    fn what_the_motion_cannot_tell_apart_joins_whatever_fits() {
        let mut friction = candidate(Effect::CoulombFriction, Vec::new());
        friction.inseparable = vec![(Effect::ViscousDamping, ElementKind::Velocity)];
        let both = members(&friction);
        assert_eq!(both.len(), 2);
        assert!((both[0].1 - both[1].1).abs() < 1e-9);
    }

    #[test]
    fn hysteresis_that_yields_early_may_be_friction_and_keeps_its_own_model() {
        let mut early = candidate(Effect::BoucWenHysteresis, Vec::new());
        early.may_be_friction = true;
        let both = members(&early);
        assert_eq!(both[0].0, Effect::BoucWenHysteresis);
        assert_eq!(both[1].0, Effect::CoulombFriction);
    }

    #[test]
    fn the_stated_share_of_false_names_falls_with_the_certificate() {
        let all: Vec<f64> = [1.0, 1.3, 1.7, 2.5, 5.0].map(q).to_vec();
        assert!(all.windows(2).all(|w| w[1] < w[0]), "{all:?}");
        assert!(q(CERTAIN) <= 0.1);
    }
}
