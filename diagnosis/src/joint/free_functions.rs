//! Free functions in the place of a name: what has no equation is given every chance, too.
//!
//! A law that remembers is named only where any function of the present displacement and speed does clearly worse; every
//! law only where a spring and a damper that change with travel do; and a law of one variable only where it is nearly all of what
//! any function of that variable takes. A free function has more freedom than the law in whose place it stands, beside all that is not in
//! doubt, and is judged on pieces of the record that are left out. The pieces are short and dealt in turn: a free function knows
//! nothing of a place where it has not been.

use super::blocks::{Blocks, Products};
use super::element::Law;
use super::kind::ElementKind;
use super::set::{DECLARED, ElementSet, Library, column};
use super::track::Track;
use crate::criteria::{ACCOUNTS, BLOCKS, CERTAIN};
use crate::library::operators::travel;
use plant::Family;

/// Pieces of the record; each sixth of them is left out once.
const PIECES: usize = 36;
/// Ridge of the free functions, relative to each column's squares: a hat that the motion hardly touches would be anything.
const RIDGE: f64 = 1e-5;
/// The same of declared parameters and elements, against columns that are one.
const HELD: f64 = 1e-9;
/// Squares that are left are not told below this share of all.
const LEAST: f64 = 1e-12;
/// Hats over the displacement, over the speed, and over each of the two in their product.
const PLACES: usize = 25;
const SPEEDS: usize = 17;
const BOTH: usize = 7;
/// Hats over the displacement where it is the law's own variable: a force that comes again every fifteenth of the range shows.
const OWN_PLACES: usize = 41;
/// Hats over the travel.
const STAGES: usize = 6;

/// Why a name is not given although no other name comes near it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doubt {
    /// A function of displacement and speed does nearly as well: nothing shows that it remembers.
    Forgets,
    /// A spring and a damper that change with travel do nearly as well.
    Changes,
    /// Another function of the same variable takes much more.
    OtherFunction,
}

/// What free functions leave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeFunctions {
    /// In its place, the best of them, in times the squares that the whole set leaves.
    pub leave: f64,
    /// What that makes of the name.
    pub doubt: Option<Doubt>,
}

impl FreeFunctions {
    /// Nothing tried.
    pub const NONE: Self = Self {
        leave: f64::INFINITY,
        doubt: None,
    };
}

/// Tries free functions for the elements `own`, of one kind and family, of a set.
pub fn tested(
    library: &Library,
    set: &ElementSet,
    (kind, family): (ElementKind, Family),
    own: &[usize],
) -> FreeFunctions {
    if own.is_empty() || kind == ElementKind::Time {
        return FreeFunctions::NONE;
    }
    let interleaved = Interleaved::new(library);
    let with = interleaved.columns(set, &[]);
    let rest = interleaved.columns(set, own);
    let here = interleaved.left(&with, &[]);
    let times = |base: &[Vec<f64>], free: &[Vec<f64>]| (interleaved.left(base, free) - here).exp();
    let tires = own
        .iter()
        .any(|&e| library.elements[e].law == Law::Fatigued);
    let own_variable = match kind {
        ElementKind::Displacement => interleaved.places(OWN_PLACES),
        ElementKind::Velocity => interleaved.speeds(SPEEDS),
        ElementKind::Damage if tires => interleaved.changing(&[|t| &t.x]),
        _ => Vec::new(),
    };
    if !own_variable.is_empty() {
        // Both in times what the set leaves: what it takes, and what any function beside it takes.
        let without = times(&rest, &[]);
        let takes = (without - 1.0) / (without - times(&with, &own_variable).min(1.0));
        if takes < 1.0 - ACCOUNTS * ACCOUNTS {
            return FreeFunctions {
                leave: 1.0,
                doubt: Some(Doubt::OtherFunction),
            };
        }
    }
    let mut free = FreeFunctions::NONE;
    let mut chance = |columns: &[Vec<f64>], most: f64, doubt: Doubt| {
        let leaves = times(&rest, columns);
        if leaves < free.leave {
            free.leave = leaves;
            free.doubt = (leaves < most).then_some(doubt).or(free.doubt);
        }
    };
    let remembers = tires
        || family == Family::Hysteresis
        || matches!(kind, ElementKind::Play | ElementKind::Linear);
    if remembers {
        chance(&interleaved.states(), CERTAIN, Doubt::Forgets);
    }
    // What cycles that grow take from a spring for good is a change with travel as well: there the law must only not be beaten.
    // What the way itself takes is that change.
    if !tires {
        let most = if kind == ElementKind::Damage {
            1.0
        } else {
            CERTAIN
        };
        chance(
            &interleaved.changing(&[|t| &t.x, |t| &t.v]),
            most,
            Doubt::Changes,
        );
    }
    free
}

/// A signal of a track.
type Signal = fn(&Track) -> &Vec<f64>;

/// The data of a library in another order: the pieces that are left out together stand together.
struct Interleaved<'a> {
    library: &'a Library<'a>,
    order: Vec<usize>,
    force: Vec<f64>,
}

impl<'a> Interleaved<'a> {
    fn new(library: &'a Library<'a>) -> Self {
        let n = library.force.len();
        let edge = |piece: usize| piece * n / PIECES;
        let order: Vec<usize> = (0..BLOCKS)
            .flat_map(|fold| (fold..PIECES).step_by(BLOCKS))
            .flat_map(|piece| edge(piece)..edge(piece + 1))
            .collect();
        let force = order.iter().map(|&i| library.force[i]).collect();
        Self {
            library,
            order,
            force,
        }
    }

    fn interleaved(&self, column: &[f64]) -> Vec<f64> {
        self.order.iter().map(|&i| column[i]).collect()
    }

    fn of(&self, signal: impl Fn(&Track) -> Vec<f64>) -> Vec<f64> {
        self.interleaved(&column(self.library.tracks, self.library.every, signal))
    }

    /// Columns of the declared parameters and of a set's elements but for some.
    fn columns(&self, set: &ElementSet, without: &[usize]) -> Vec<Vec<f64>> {
        let kept = set.elements.iter().filter(|e| !without.contains(e));
        (0..DECLARED)
            .chain(kept.map(|e| DECLARED + e))
            .map(|i| self.interleaved(&self.library.columns[i]))
            .collect()
    }

    /// Hats over the displacement.
    fn places(&self, n: usize) -> Vec<Vec<f64>> {
        let s = self.library.sizes;
        let at = move |x: &f64| (x - s.middle) / s.x;
        let one = |i| self.of(|t| t.x.iter().map(|x| hat(at(x), i, n)).collect());
        (0..n).map(one).collect()
    }

    /// Hats over the root of the speed: narrow where friction turns.
    fn speeds(&self, n: usize) -> Vec<Vec<f64>> {
        let top = self.library.sizes.v;
        let at = move |v: &f64| (v / top).abs().sqrt().copysign(*v);
        let one = |i| self.of(|t| t.v.iter().map(|v| hat(at(v), i, n)).collect());
        (0..n).map(one).collect()
    }

    /// Any function of displacement and speed.
    fn states(&self) -> Vec<Vec<f64>> {
        let (places, speeds) = (self.places(BOTH), self.speeds(BOTH));
        let product =
            |(x, v): (&Vec<f64>, &Vec<f64>)| x.iter().zip(v).map(|(x, v)| x * v).collect();
        let pairs = places
            .iter()
            .flat_map(|x| speeds.iter().map(move |v| (x, v)));
        let mut all: Vec<Vec<f64>> = pairs.map(product).collect();
        all.extend(self.places(PLACES));
        all.extend(self.speeds(SPEEDS));
        all
    }

    /// A spring, a damper or both that change with travel in any manner.
    fn changing(&self, of: &[Signal]) -> Vec<Vec<f64>> {
        let stage = |t: &Track, i: usize| -> Vec<f64> {
            let travels: Vec<f64> = travel(&t.v, t.interval_s, 0.0).collect();
            let (first, last) = (travels[t.first], travels[travels.len() - 1]);
            let at = |w: &f64| 2.0 * (w - first) / (last - first).max(f64::MIN_POSITIVE) - 1.0;
            travels.iter().map(|w| hat(at(w), i, STAGES)).collect()
        };
        let times = |a: Vec<f64>, b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).collect();
        (0..STAGES)
            .flat_map(|i| of.iter().map(move |signal| (i, signal)))
            .map(|(i, signal)| self.of(|t| times(stage(t, i), signal(t))))
            .collect()
    }

    /// Mean logarithm of the squares on what is left out.
    fn left(&self, held: &[Vec<f64>], free: &[Vec<f64>]) -> f64 {
        let columns: Vec<Vec<f64>> = held.iter().chain(free).cloned().collect();
        let blocks = Blocks::new(&columns, &self.force);
        let share = |i: usize| if i < held.len() { HELD } else { RIDGE };
        let ridge = |i: usize, own: f64| share(i) * own.max(f64::MIN_POSITIVE);
        let Some(costs) = blocks.ridge_cross_validated(ridge) else {
            return f64::INFINITY;
        };
        let ln =
            |(cost, p): (&f64, &Products)| cost.max(LEAST * p.square).max(f64::MIN_POSITIVE).ln();
        costs.iter().zip(&blocks.each).map(ln).sum::<f64>() / BLOCKS as f64
    }
}

/// The `i`th of `n` hats over -1 to 1; what is outside counts as the end.
fn hat(u: f64, i: usize, n: usize) -> f64 {
    let at = 0.5 * (u.clamp(-1.0, 1.0) + 1.0) * (n - 1) as f64;
    (1.0 - (at - i as f64).abs()).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::super::element::Element;
    use super::super::set::example::with_library;
    use super::*;
    use crate::library::operators::slider;

    const H: f64 = 5e-3;
    const STIFFNESS: f64 = 100.0;

    /// Cycles from 0.3 to 1 Hz that grow from 2 to 10 mm.
    fn growing() -> Vec<f64> {
        let at = |i: usize| {
            let t = i as f64 * H;
            (2.0 + 8.0 * t / 20.0) * (std::f64::consts::TAU * (0.3 * t + 0.0175 * t * t)).sin()
        };
        (0..4000).map(at).collect()
    }

    /// What free functions make of an element's name, where the specimen has a force beside its spring.
    fn of(element: Element, force: &dyn Fn(&[f64]) -> Vec<f64>) -> FreeFunctions {
        let x = growing();
        let more = force(&x);
        // Coarse, so that nothing is exact.
        let read = |(x, f): (&f64, &f64)| (STIFFNESS * x + f).round();
        let force = x.iter().zip(&more).map(read).collect();
        with_library(x, force, (H, 20.0), |library| {
            let place = library.add(&[element]);
            let set = ElementSet {
                elements: vec![place],
                moved: [true; DECLARED],
            };
            let family = element.name(&library.sizes, 1.0).entry().family;
            let kind = element.kind(&library.sizes);
            tested(library, &set, (kind, family), &[place])
        })
    }

    fn slides(x: &[f64]) -> Vec<f64> {
        slider(x, 1.5).iter().map(|z| 300.0 * z).collect()
    }

    #[test]
    fn a_spring_without_memory_is_no_hysteresis_and_a_slider_is_one() {
        let cubic = |x: &[f64]| x.iter().map(|x| 0.5 * x.powi(3)).collect();
        let stiffens = Element::new(Law::BoucWen, [10.0, 2.0, -0.4, 0.4]);
        assert_eq!(of(stiffens, &cubic).doubt, Some(Doubt::Forgets));
        let slider = of(Element::new(Law::Slider, [1.5]), &slides);
        assert_eq!(slider.doubt, None);
        assert!(slider.leave > CERTAIN, "{slider:?}");
    }

    #[test]
    fn a_force_that_comes_again_along_the_range_is_no_spring_that_softens() {
        let cogs = |x: &[f64]| x.iter().map(|x| 80.0 * (2.5 * x).sin()).collect();
        let softens = Element::new(Law::PowerOfPlace, [0.5]);
        assert_eq!(of(softens, &cogs).doubt, Some(Doubt::OtherFunction));
        let cubic = |x: &[f64]| x.iter().map(|x| -0.3 * x.powi(3)).collect();
        assert_eq!(
            of(Element::new(Law::PowerOfPlace, [2.0]), &cubic).doubt,
            None
        );
    }

    #[test]
    fn a_spring_that_weakens_along_the_way_is_no_damage_by_the_largest_displacement() {
        let weakens = |x: &[f64]| {
            let (mut travel, mut last) = (0.0, x[0]);
            let step = |x: &f64| {
                travel += (x - last).abs();
                last = *x;
                -50.0 * x * travel / (travel + 100.0)
            };
            x.iter().map(step).collect()
        };
        let lessened = |p: f64| Element::new(Law::Lessened, [p]);
        assert_eq!(of(lessened(0.4), &weakens).doubt, Some(Doubt::Changes));
        let peaks = |x: &[f64]| {
            let mut largest = 0.0_f64;
            let step = |x: &f64| {
                largest = largest.max(x.abs());
                -5.0 * x * largest
            };
            x.iter().map(step).collect()
        };
        assert_eq!(of(lessened(1.0), &peaks).doubt, None);
    }
}
