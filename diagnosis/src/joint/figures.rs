//! The parameters of a name, each with its 90 % interval, on condition that the name is right.

use super::covariance::{covariance, unknowns};
use super::element::{Element, Law};
use super::fit::Fit;
use super::set::{DECLARED, Library};
use crate::interval;
use nalgebra::DMatrix;
use plant::{Channel, Effect};

/// The way in which friction builds up.
pub const PRESLIDING: &str = "presliding_mm";

/// A parameter: name, unit, value.
type Figure = (&'static str, &'static str, f64);

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
        Effect::Degradation if first.law == Law::Fatigued => vec![
            ("travel_mm", "mm", p),
            ("stiffness_lost_in_the_end_n_per_mm", "N/mm", strength),
        ],
        Effect::TemperatureGain => vec![
            ("change", "", strength / stiffness),
            ("time_constant_s", "s", p),
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
        _ => vec![("strength", unit(first.law), strength)],
    }
}

/// Unit of a law's strength.
const fn unit(law: Law) -> &'static str {
    match law {
        Law::PowerOfPlace
        | Law::Lessened
        | Law::Fatigued
        | Law::Warming
        | Law::Away
        | Law::Square
        | Law::Beyond
        | Law::Lost
        | Law::Relaxing => "N/mm",
        Law::SizeOfSpeed => "N s/mm",
        _ => "N",
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
    // The first shape of Bouc-Wen's law is the unit of its force.
    let gives = |law: Law| law.slides() && law != Law::BoucWen;
    if let Some((e, _)) = part.iter().find(|(e, _)| gives(e.law)) {
        all.push((PRESLIDING, "mm", e.shape[0]));
    }
    // A force that hardly grows with speed has no give: its smooth reversals are a power of the speed.
    if let Some((e, _)) = part.iter().find(|(e, _)| e.law == Law::PowerOfSpeed) {
        all.push(("exponent", "", e.shape[0]));
    }
    all
}

/// A declared parameter that has left its tolerance, as the change that it is.
fn parameter(name: Effect, fit: &Fit, declared: &[f64; DECLARED]) -> Vec<Figure> {
    let Some(i) = Channel::Specimen.parameter_of_error(name) else {
        return Vec::new();
    };
    let p = &Channel::Specimen.parameters()[i];
    let error = p.error(fit.parameters[i], declared[i]);
    vec![(p.error_parameter, p.error_unit(), error)]
}

/// Intervals of the figures of all names, by a sandwich over blocks of the residual; of the samples in `sure` where the fit
/// comes from these.
pub fn with_intervals(
    library: &Library,
    fit: &Fit,
    names: &[(Effect, Vec<usize>)],
    sure: Option<&[bool]>,
) -> Vec<Vec<interval::Figure>> {
    let declared = &std::array::from_fn(|i| library.declared_value(i));
    let unknowns = unknowns(library, fit);
    let whole = covariance(library, fit, &unknowns, None);
    // Where friction slides nothing tells the way in which it builds up.
    let sliding = sure.and_then(|sure| covariance(library, fit, &unknowns, Some(sure)));
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
            let all = interval::around(here.clone(), &gradient, whole.as_ref());
            let Some(sliding) = &sliding else {
                return all;
            };
            let sliding = interval::around(here, &gradient, Some(sliding));
            let which = |(s, a): (interval::Figure, _)| if s.0 == PRESLIDING { a } else { s };
            sliding.into_iter().zip(all).map(which).collect()
        })
        .collect()
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
