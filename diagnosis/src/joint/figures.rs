//! The parameters of a name, each with its 90 % interval, on condition that the name is right.

use super::element::{Element, Law};
use super::fit::Fit;
use super::set::{DECLARED, Library, column};
use crate::interval;
use crate::linear::dot;
use nalgebra::{DMatrix, DVector};
use plant::{Channel, Effect};

/// A parameter: name, unit, value.
type Figure = (&'static str, &'static str, f64);

/// Blocks of the sandwich, from long to short: what is correlated over many samples shows in the long ones.
const SANDWICH: [usize; 3] = [12, 40, 120];
/// Step of a shape, relative, and of a strength.
const STEP: f64 = 1e-3;

/// The parameters of a name in a fit whose elements `own` belong to it; `declared` are the values before.
pub fn figures(name: Effect, own: &[usize], fit: &Fit, declared: &[f64; DECLARED]) -> Vec<Figure> {
    let part: Vec<(Element, f64)> = own.iter().map(|&i| fit.elements[i]).collect();
    let Some(&(first, strength)) = part.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
    else {
        return parameter(name, fit, declared);
    };
    let [p, q, r, s] = first.shape;
    let stiffness = fit.parameters[0];
    let share = |own: f64| ("hardening_ratio", "", stiffness / (stiffness + own));
    match name {
        Effect::CoulombFriction | Effect::StribeckFriction => friction(&part, fit),
        Effect::BilinearHysteresis => {
            let own = strength / p;
            vec![
                ("stiffness_n_per_mm", "N/mm", own),
                ("yield_mm", "mm", p),
                share(own),
            ]
        }
        Effect::BoucWenHysteresis if first.law == Law::BoucWen => {
            let own = strength / p;
            // dF/dx = stiffness (1 - load |F|^n) on the way out, (1 + unload |F|^n) on the way back.
            let per = strength.abs().powf(-q);
            vec![
                ("stiffness_n_per_mm", "N/mm", own),
                ("load_rate", "N^-n", r * per),
                ("unload_rate", "N^-n", s * per),
                ("exponent", "", q),
                share(own),
            ]
        }
        Effect::BoucWenHysteresis => vec![("force_n", "N", strength), ("yield_mm", "mm", p)],
        Effect::MaxwellDamper if first.law == Law::InSeries => vec![
            ("stiffness_n_per_mm", "N/mm", strength / p),
            ("force_at_speed_n", "N", strength),
            ("speed_mm_per_s", "mm/s", q),
            ("exponent", "", 1.0 / r),
        ],
        Effect::MaxwellDamper => vec![
            ("stiffness_n_per_mm", "N/mm", strength),
            ("relaxation_ms", "ms", 1e3 * p),
        ],
        Effect::ViscousDamping | Effect::QuadraticDamping if first.law == Law::PowerOfSpeed => {
            vec![
                ("force_at_top_speed_n", "N", strength),
                ("top_speed_mm_per_s", "mm/s", fit.sizes.v),
                ("exponent", "", p),
            ]
        }
        Effect::Hardening | Effect::Softening if first.law == Law::PowerOfPlace => vec![
            ("stiffness_at_reference_n_per_mm", "N/mm", strength),
            ("reference_mm", "mm", fit.sizes.x),
            ("exponent", "", p),
        ],
        Effect::Degradation => vec![
            ("stiffness_lost_at_reference_n_per_mm", "N/mm", strength),
            ("reference_mm", "mm", fit.sizes.x),
            ("exponent", "", p),
        ],
        Effect::Backlash => vec![
            ("width_mm", "mm", 2.0 * p),
            ("stiffness_n_per_mm", "N/mm", strength),
        ],
        Effect::Drift => vec![("force_n", "N", strength), ("time_constant_s", "s", p)],
        _ => vec![("strength", "N or N/mm", strength)],
    }
}

/// Friction: its force at speed, by how much it is larger at rest, how far it gives before it slides.
fn friction(part: &[(Element, f64)], fit: &Fit) -> Vec<Figure> {
    let steady = |(e, f): &(Element, f64)| match e.law {
        Law::Stribeck | Law::SliderAlong | Law::SliderAway => 0.0,
        Law::PowerOfSpeed => *f,
        Law::InSeries => f * (fit.sizes.v / e.shape[1]).powf(1.0 / e.shape[2]).min(1.0),
        _ => *f,
    };
    let force: f64 = part.iter().map(steady).sum();
    let falling: Vec<&(Element, f64)> = part
        .iter()
        .filter(|(e, _)| e.law == Law::Stribeck)
        .collect();
    let extra: f64 = falling.iter().map(|(_, f)| f).sum();
    let mut all = vec![("force_n", "N", if force > 0.0 { force } else { extra })];
    if let Some((e, _)) = falling.first() {
        if force > 0.0 {
            all.push(("rest_ratio", "", 1.0 + extra / force));
        }
        all.push(("stribeck_mm_per_s", "mm/s", e.shape[1]));
    }
    let gives = |law| {
        matches!(
            law,
            Law::Slider | Law::Stribeck | Law::InSeries | Law::Distributed
        )
    };
    if let Some((e, _)) = part.iter().find(|(e, _)| gives(e.law)) {
        all.push(("presliding_mm", "mm", e.shape[0]));
    }
    all
}

/// Below this share of a column's squares a direction is not told by the record.
const UNTOLD: f64 = 1e-6;

/// A declared parameter that has left its tolerance, as the change that it is.
fn parameter(name: Effect, fit: &Fit, declared: &[f64; DECLARED]) -> Vec<Figure> {
    let Some(i) = Channel::Specimen.parameter_of_error(name) else {
        return Vec::new();
    };
    let p = &Channel::Specimen.parameters()[i];
    let error = p.error(fit.parameters[i], declared[i]);
    vec![(p.error_parameter, p.error_unit(), error)]
}

/// An unknown of a fit.
#[derive(Clone, Copy)]
enum Unknown {
    Parameter(usize),
    Strength(usize),
    Shape(usize, usize),
}

impl Unknown {
    /// The fit with this unknown moved, and by how much.
    fn moved(self, fit: &Fit) -> (Fit, f64) {
        let mut other = fit.clone();
        let value = match self {
            Self::Parameter(i) => &mut other.parameters[i],
            Self::Strength(i) => &mut other.elements[i].1,
            Self::Shape(i, at) => &mut other.elements[i].0.shape[at],
        };
        let step = STEP * value.abs().max(1e-6);
        *value += step;
        (other, step)
    }
}

/// Intervals of the figures of all names, by a sandwich over blocks of the residual.
pub fn with_intervals(
    library: &Library,
    fit: &Fit,
    names: &[(Effect, Vec<usize>)],
) -> Vec<Vec<interval::Figure>> {
    let declared = &std::array::from_fn(|i| library.declared_value(i));
    let unknowns = unknowns(library, fit);
    let covariance = covariance(library, fit, &unknowns);
    names
        .iter()
        .map(|(name, own)| {
            let here = figures(*name, own, fit, declared);
            let mut gradient = DMatrix::zeros(here.len(), unknowns.len());
            for (j, unknown) in unknowns.iter().enumerate() {
                let (moved, step) = unknown.moved(fit);
                for (i, there) in figures(*name, own, &moved, declared).iter().enumerate() {
                    gradient[(i, j)] = (there.2 - here[i].2) / step;
                }
            }
            interval::around(here, &gradient, covariance.as_ref())
        })
        .collect()
}

/// Parameters inside their bounds, strengths, shapes that can be moved.
fn unknowns(library: &Library, fit: &Fit) -> Vec<Unknown> {
    let inside = |&i: &usize| {
        let bound = library.parameter(i, fit.moved[i]);
        let value = fit.parameters[i];
        // A parameter that has left its tolerance has no upper bound.
        let room = 1e-6 * (bound.high - bound.low).min(value.abs());
        value > bound.low + room && value < bound.high - room
    };
    let mut all: Vec<Unknown> = (0..DECLARED)
        .filter(inside)
        .map(Unknown::Parameter)
        .collect();
    for (i, (element, strength)) in fit.elements.iter().enumerate() {
        if *strength == 0.0 {
            continue;
        }
        all.push(Unknown::Strength(i));
        let shapes = element.movable().iter();
        all.extend(shapes.map(|(at, _)| Unknown::Shape(i, *at)));
    }
    all
}

fn covariance(library: &Library, fit: &Fit, unknowns: &[Unknown]) -> Option<DMatrix<f64>> {
    if unknowns.is_empty() {
        return None;
    }
    let answer = |fit: &Fit| {
        let mut y = vec![0.0; library.force.len()];
        for i in 0..DECLARED {
            crate::signals::add_scaled(&mut y, &library.columns[i], fit.parameters[i]);
        }
        for (element, strength) in &fit.elements {
            let force = column(library.tracks, library.every, |t| {
                element.force(t, &fit.sizes)
            });
            crate::signals::add_scaled(&mut y, &force, *strength);
        }
        y
    };
    let here = answer(fit);
    let residual: Vec<f64> = library
        .force
        .iter()
        .zip(&here)
        .map(|(f, y)| f - y)
        .collect();
    let columns: Vec<Vec<f64>> = unknowns
        .iter()
        .map(|unknown| {
            let (moved, step) = unknown.moved(fit);
            let there = answer(&moved);
            there
                .iter()
                .zip(&here)
                .map(|(t, h)| (t - h) / step)
                .collect()
        })
        .collect();
    let n = columns.len();
    let size: Vec<f64> = columns
        .iter()
        .map(|c| dot(c, c).sqrt().max(f64::MIN_POSITIVE).recip())
        .collect();
    let bread = DMatrix::from_fn(n, n, |i, j| {
        dot(&columns[i], &columns[j]) * size[i] * size[j]
    });
    // Directions that the record does not tell at all stay where they are.
    let eigen = bread.symmetric_eigen();
    let inverses = eigen
        .eigenvalues
        .map(|l| if l > UNTOLD { 1.0 / l } else { 0.0 });
    let q = &eigen.eigenvectors;
    let inverse = q * DMatrix::from_diagonal(&inverses) * q.transpose();
    let samples = residual.len();
    // The widest of several block lengths.
    let widest = SANDWICH
        .iter()
        .filter(|&&blocks| samples >= 4 * blocks)
        .map(|&blocks| {
            let mut meat: DMatrix<f64> = DMatrix::zeros(n, n);
            for b in 0..blocks {
                let (a, e) = (b * samples / blocks, (b + 1) * samples / blocks);
                let score =
                    DVector::from_fn(n, |i, _| dot(&columns[i][a..e], &residual[a..e]) * size[i]);
                meat += &score * score.transpose();
            }
            // What was fitted has taken its share of the scatter.
            let free = blocks as f64 / (blocks as f64 - n as f64).max(0.5 * blocks as f64);
            &inverse * meat * &inverse * free
        })
        .max_by(|a, b| a.trace().total_cmp(&b.trace()))?;
    Some(DMatrix::from_fn(n, n, |i, j| {
        widest[(i, j)] * size[i] * size[j]
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::track::Sizes;

    fn fit(elements: Vec<(Element, f64)>) -> Fit {
        Fit {
            parameters: [100.0, 0.0, 0.0, 0.0],
            moved: [false; DECLARED],
            elements,
            sizes: Sizes {
                x: 10.0,
                middle: 0.0,
                v: 50.0,
                seconds: 10.0,
                interval_s: 1e-3,
                travel: 300.0,
            },
            cutoff_hz: 50.0,
        }
    }

    #[test]
    fn friction_is_read_off_all_of_its_elements() {
        let both = fit(vec![
            (Element::new(Law::Slider, [0.02]), 20.0),
            (Element::new(Law::Stribeck, [0.02, 5.0]), 10.0),
        ]);
        let all = figures(Effect::StribeckFriction, &[0, 1], &both, &[0.0; DECLARED]);
        assert_eq!(all[0], ("force_n", "N", 20.0));
        assert_eq!(all[1], ("rest_ratio", "", 1.5));
        assert_eq!(all[3], ("presliding_mm", "mm", 0.02));
    }

    #[test]
    fn a_parallel_slider_is_a_bilinear_spring_of_another_first_stiffness() {
        let one = fit(vec![(Element::new(Law::Slider, [3.0]), 300.0)]);
        let all = figures(Effect::BilinearHysteresis, &[0], &one, &[0.0; DECLARED]);
        assert_eq!(all[0].2, 100.0);
        assert_eq!(all[2], ("hardening_ratio", "", 0.5));
    }
}
