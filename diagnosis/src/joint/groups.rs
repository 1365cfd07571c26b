//! The names of a set: its elements by kind, and the declared parameters that have left their tolerances.

use super::dashpot;
use super::kind::ElementKind;
use super::set::{DECLARED, ElementSet, Library};
use plant::{Channel, Effect};

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
    for g in groups
        .iter_mut()
        .filter(|g| g.kind == ElementKind::Displacement)
    {
        if g.elements.len() > 1 {
            g.name = spring(library, set, &strengths, &g.elements);
        }
    }
    // Beside elements a parameter takes up what they are wrong by; more damping than declared is a dashpot beside them,
    // where no element of theirs grows with speed.
    let alone = groups.is_empty();
    let has = |kind| groups.iter().any(|g| g.kind == kind);
    let dashpot = !has(ElementKind::Velocity) && !has(ElementKind::Linear);
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

#[cfg(test)]
mod tests {
    use super::super::element::{Element, Law};
    use super::super::set::example::with_library;
    use super::*;

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
        let force = x.iter().map(spring).collect();
        with_library(x, force, (0.01, 10.0), |library| {
            let first = library.add(&places.map(|p| Element::new(Law::Away, [p])));
            let set = ElementSet {
                elements: vec![first, first + 1],
                moved: [true; DECLARED],
            };
            let groups = groups(library, &set);
            let spring = groups.iter().find(|g| g.kind == ElementKind::Displacement);
            spring.unwrap().name
        })
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
