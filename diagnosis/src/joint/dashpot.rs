//! More damping than declared beside friction or hysteresis: the most ordinary pair that a laboratory has.

use super::set::{ElementSet, Library};
use crate::criteria::ALIKE;
use plant::Effect;

/// Place of the damping among the declared parameters.
pub const PARAMETER: usize = 1;

/// The set with more damping than declared in the place of a force that grows with speed nearly in proportion: of two that
/// fit alike a dashpot is the simpler one, and rivals of an element get the declared parameters to help them.
pub fn simplest(library: &Library, set: ElementSet) -> ElementSet {
    let named = |e: usize| library.elements[e].name(&library.sizes, 1.0);
    let own = |e: &usize| named(*e) == Effect::ViscousDamping;
    let Some(place) = set.elements.iter().position(own) else {
        return set;
    };
    let mut simple = set.without(place);
    simple.moved[PARAMETER] = true;
    if simple.elements.is_empty() || simple.elements.iter().any(own) {
        return set;
    }
    let log_ratio = |s: &ElementSet| library.cross_validated(s).map(|c| library.log_ratio(&c));
    match (log_ratio(&simple), log_ratio(&set)) {
        (Some(simpler), Some(own)) if simpler < own + ALIKE => simple,
        _ => set,
    }
}

/// The fall of a force that is read late by as much as the dashpot makes of it: on a spring alone the two are one force, beside friction
/// they are not, whose reversals a dashpot does not move.
pub fn late(library: &Library, set: &ElementSet, rest: &ElementSet) -> Option<f64> {
    let strengths = library.strengths(set)?;
    let (stiffness, more) = (
        strengths[0],
        strengths[PARAMETER] - library.declared_value(PARAMETER),
    );
    // A force that leads is read early.
    let shift_s = -more / stiffness;
    let falls = LATE.iter().filter_map(|share| {
        let costs = library.cross_validated_late(rest, share * shift_s)?;
        Some(library.log_ratio(&costs))
    });
    let log_ratio = falls.fold(f64::INFINITY, f64::min);
    (stiffness > 0.0 && log_ratio.is_finite()).then_some(log_ratio)
}

/// Shares of a dashpot's delay that are tried.
const LATE: [f64; 5] = [0.6, 0.8, 1.0, 1.2, 1.4];
