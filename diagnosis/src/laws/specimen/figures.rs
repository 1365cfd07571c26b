//! The parameters of a name, each with its 90 % interval, conditional on the name being right.

use super::element::{Element, Law};
use super::fit::SpecimenFit;
use super::track::DECLARED;
use crate::laws::library::candidate::NamedValue;
use plant::{Channel, Effect};

/// The displacement over which friction builds up.
pub const PRESLIDING: &str = "presliding_mm";
/// The force of sliding friction.
pub const SLIDING: &str = "force_n";
/// Increase of friction with speed.
pub const GAINED: &str = "force_gained_n";
/// The speed above which a force hardly grows any further.
pub const KNEE: &str = "knee_mm_per_s";
/// The travel after which a force has worn off to 1/e.
pub const WORN_TRAVEL: &str = "worn_travel_mm";
/// First and last yield displacement of sliders that yield one after the other.
const YIELD_FROM: &str = "yield_from_mm";
const YIELD_TO: &str = "yield_to_mm";
/// Additional stiffness of a spring beyond a place.
pub const STIFFNESS_BEYOND: &str = "stiffness_beyond_n_per_mm";
/// Reduction of a force around one place.
pub const PINCHED: &str = "force_pinched_n";

/// The parameters of a name in a fit whose elements `own` belong to it; `declared` are the previous values.
pub fn figures(
    name: Effect,
    own: &[usize],
    fit: &SpecimenFit,
    declared: &[f64; DECLARED],
) -> Vec<NamedValue> {
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
        Effect::BilinearHysteresis if first.law == Law::Slider => {
            let own = strength / p;
            let mut all = vec![
                ("stiffness_n_per_mm", "N/mm", own),
                ("yield_mm", "mm", p),
                share(own),
            ];
            all.extend(beside(&part, &first, fit.sizes.v));
            all
        }
        Effect::BoucWenHysteresis if first.law == Law::BoucWen => {
            let own = strength / p;
            // dF/dx = stiffness (1 - load |F|^n) on the way out, (1 + unload |F|^n) on the way back.
            let per = strength.abs().powf(-q);
            let mut all = vec![
                ("stiffness_n_per_mm", "N/mm", own),
                ("load_rate", "N^-n", r * per),
                ("unload_rate", "N^-n", s * per),
                ("exponent", "", q),
                share(own),
            ];
            all.extend(beside(&part, &first, fit.sizes.v));
            all
        }
        Effect::BoucWenHysteresis if first.law == Law::Recentring => by_law(&first, strength, fit),
        Effect::BilinearHysteresis | Effect::BoucWenHysteresis => yields(&part, &first, fit),
        Effect::MaxwellDamper if first.law == Law::InSeries => vec![
            ("stiffness_n_per_mm", "N/mm", strength / p),
            ("force_at_speed_n", "N", strength),
            ("speed_mm_per_s", "mm/s", q),
            ("exponent", "", 1.0 / r),
        ],
        Effect::TemperatureGain => {
            let mut all = vec![
                ("change", "", strength / stiffness),
                ("time_constant_s", "s", p),
            ];
            if q > 0.0 {
                all.push(("change_by_motion", "", q * strength / stiffness));
            }
            all
        }
        _ => by_law(&first, strength, fit),
    }
}

/// The parameters of a single law; its strength first.
fn by_law(element: &Element, strength: f64, fit: &SpecimenFit) -> Vec<NamedValue> {
    let [p, q, _, _] = element.shape;
    match element.law {
        Law::PowerOfPlace
        | Law::Away
        | Law::Square
        | Law::Beyond
        | Law::Fatigued
        | Law::Lessened
        | Law::Lost => of_place(element, strength, fit),
        Law::Relaxing => vec![
            ("stiffness_n_per_mm", "N/mm", strength),
            ("relaxation_ms", "ms", 1e3 * p),
        ],
        Law::PowerOfSpeed => vec![
            ("force_at_top_speed_n", "N", strength),
            ("top_speed_mm_per_s", "mm/s", fit.sizes.v),
            ("exponent", "", p),
        ],
        Law::Saturating => vec![("force_n", "N", strength), (KNEE, "mm/s", p)],
        Law::SizeOfSpeed => vec![("damping_difference_n_s_per_mm", "N s/mm", 2.0 * strength)],
        Law::SlippingJoint => vec![
            ("stiffness_n_per_mm", "N/mm", strength),
            ("gap_mm", "mm", q),
            ("slip_n", "N", strength * p),
        ],
        Law::Recentring => vec![
            ("stiffness_n_per_mm", "N/mm", strength),
            ("yield_mm", "mm", p),
            ("back_at_mm", "mm", q * p),
        ],
        Law::Warming => vec![
            ("stiffness_change_n_per_mm", "N/mm", strength),
            ("time_constant_s", "s", p),
        ],
        Law::Slider
        | Law::Bristles
        | Law::BoucWen
        | Law::Distributed
        | Law::InSeries
        | Law::SliderAway
        | Law::SliderAlong
        | Law::Worn
        | Law::Pinched => yields(&[(*element, strength)], element, fit),
    }
}

/// The same for springs that differ elsewhere, or used to differ.
fn of_place(element: &Element, strength: f64, fit: &SpecimenFit) -> Vec<NamedValue> {
    let [p, q, r, s] = element.shape;
    let at = ("at_mm", "mm", fit.sizes.x);
    match element.law {
        Law::PowerOfPlace => {
            let mut all = vec![
                ("stiffness_added_n_per_mm", "N/mm", strength),
                at,
                ("exponent", "", p),
            ];
            let doubled = fit.parameters[0] / strength;
            if doubled > 0.0 {
                // As in the catalogue: where the secant stiffness has doubled.
                all.push(("reference_mm", "mm", fit.sizes.x * doubled.powf(1.0 / p)));
            }
            all
        }
        // From the secant stiffness on one side to that on the other.
        Law::Away => {
            let mut all = vec![
                ("stiffness_difference_n_per_mm", "N/mm", 2.0 * strength),
                ("middle_mm", "mm", p),
            ];
            if q > 0.0 {
                all.push(("width_mm", "mm", q));
            }
            all
        }
        Law::Square => vec![
            ("stiffness_difference_n_per_mm", "N/mm", 2.0 * strength),
            at,
        ],
        Law::Beyond if q == 0.0 => vec![
            (STIFFNESS_BEYOND, "N/mm", strength),
            ("knee_mm", "mm", p),
            ("middle_mm", "mm", r),
        ],
        Law::Beyond => {
            let place = if q > 0.0 { "above_mm" } else { "below_mm" };
            let mut all = vec![(STIFFNESS_BEYOND, "N/mm", strength), (place, "mm", p)];
            if s > 0.0 {
                all.push(("damping_beyond_n_s_per_mm", "N s/mm", strength * s));
            }
            all
        }
        Law::Fatigued => vec![
            ("travel_mm", "mm", p),
            ("stiffness_lost_in_the_end_n_per_mm", "N/mm", strength),
        ],
        Law::Lessened => vec![
            ("stiffness_lost_n_per_mm", "N/mm", strength),
            at,
            ("exponent", "", p),
        ],
        _ => vec![
            ("width_mm", "mm", 2.0 * p),
            ("stiffness_n_per_mm", "N/mm", strength),
        ],
    }
}

/// Sliding force of the elements beside the first, and the yield displacement of the strongest of these.
fn beside(part: &[(Element, f64)], first: &Element, v: f64) -> Vec<NamedValue> {
    let level = |(e, strength): &(Element, f64)| strength * e.level(v);
    let others = || part.iter().filter(|(e, _)| e != first);
    let force: f64 = others().map(level).sum();
    let strongest = others().max_by(|a, b| level(a).total_cmp(&level(b)));
    let both = strongest.filter(|_| force != 0.0).map(|(e, _)| {
        let yields = ("yield_beside_mm", "mm", e.yields_at());
        [("force_beside_n", "N", force), yields]
    });
    both.into_iter().flatten().collect()
}

/// Yielding elements: their total force, the yield displacement of the first, and what changes their force.
fn yields(part: &[(Element, f64)], first: &Element, fit: &SpecimenFit) -> Vec<NamedValue> {
    let force: f64 = part.iter().map(|(e, f)| f * e.level(fit.sizes.v)).sum();
    let mut all = Vec::new();
    if force != 0.0 {
        all.push(("force_n", "N", force));
    }
    all.extend(changes(part, fit));
    all.insert(all.len().min(1), ("yield_mm", "mm", first.yields_at()));
    if first.law == Law::Distributed {
        let [to, begins, ..] = first.shape;
        all.push((YIELD_FROM, "mm", to * (0.2 + 0.8 * begins)));
        all.push((YIELD_TO, "mm", to));
    }
    all
}

/// What changes the force of sliding elements: travel, place, speed; of the strongest of each law.
fn changes(part: &[(Element, f64)], fit: &SpecimenFit) -> Vec<NamedValue> {
    let mut all: Vec<NamedValue> = Vec::new();
    for law in [Law::Worn, Law::Pinched, Law::SliderAway, Law::SliderAlong] {
        let own = part.iter().filter(|(e, _)| e.law == law);
        let Some((element, strength)) = own.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())) else {
            continue;
        };
        let [_, q, r, _] = element.shape;
        match law {
            Law::Worn => all.extend([("force_worn_off_n", "N", *strength), (WORN_TRAVEL, "mm", q)]),
            Law::Pinched => all.extend([
                (PINCHED, "N", *strength),
                ("pinch_width_mm", "mm", q),
                ("pinch_middle_mm", "mm", r),
            ]),
            Law::SliderAway => all.extend([
                ("force_away_n_per_mm", "N/mm", strength / fit.sizes.x),
                ("away_from_mm", "mm", q),
            ]),
            _ => all.extend([
                ("force_along_n_per_mm", "N/mm", strength / fit.sizes.x),
                ("along_from_mm", "mm", q),
            ]),
        }
    }
    all
}

/// Friction: its force at speed, and its give before it slides.
fn friction(part: &[(Element, f64)], fit: &SpecimenFit) -> Vec<NamedValue> {
    let force: f64 = part.iter().map(|(e, f)| f * e.level(fit.sizes.v)).sum();
    let mut all = Vec::new();
    if force > 0.0 {
        all.push((SLIDING, "N", force));
    }
    all.extend(changes(part, fit));
    let gives = |e: &Element| e.law.slides() && e.yields_at().is_finite();
    if let Some((e, _)) = part.iter().find(|(e, _)| gives(e)) {
        all.push((PRESLIDING, "mm", e.yields_at()));
    }
    // A force that hardly grows with speed has no give: its smooth reversals are a power of the speed.
    if let Some((e, _)) = part.iter().find(|(e, _)| e.law == Law::PowerOfSpeed) {
        all.push(("exponent", "", e.shape[0]));
    }
    if let Some((e, _)) = part.iter().find(|(e, _)| e.law == Law::InSeries) {
        all.extend([
            ("speed_mm_per_s", "mm/s", fit.sizes.v.min(e.shape[1])),
            ("exponent", "", 1.0 / e.shape[2]),
        ]);
    }
    if let Some((e, gained)) = part.iter().find(|(e, _)| e.law == Law::Saturating) {
        if part.len() > 1 {
            all.push((GAINED, "N", *gained));
        }
        all.push((KNEE, "mm/s", e.shape[0]));
    }
    all
}

/// A declared parameter that has left its tolerance, as a change.
fn parameter(name: Effect, fit: &SpecimenFit, declared: &[f64; DECLARED]) -> Vec<NamedValue> {
    if name == Effect::RigCompliance {
        let frame = 1.0 / (1.0 / fit.parameters[0] - 1.0 / declared[0]);
        return vec![("stiffness_n_per_mm", "N/mm", frame)];
    }
    let Some(i) = Channel::Specimen.parameter_of_error(name) else {
        return Vec::new();
    };
    let p = &Channel::Specimen.parameters()[i];
    let error = p.error(fit.parameters[i], declared[i]);
    vec![(p.error_parameter, p.error_unit(), error)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::specimen::track::MotionScales;
    use crate::model::saved_element::SavedElement;

    fn fit(elements: Vec<(Element, f64)>) -> SpecimenFit {
        SpecimenFit {
            parameters: [100.0, 0.0, 0.0, 0.0],
            moved: [false; DECLARED],
            elements,
            sizes: MotionScales {
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
            (Element::new(Law::Saturating, [5.0]), 10.0),
        ]);
        let all = figures(Effect::CoulombFriction, &[0, 1], &both, &[0.0; DECLARED]);
        let wanted = [
            ("force_n", "N", 30.0),
            ("presliding_mm", "mm", 0.02),
            ("force_gained_n", "N", 10.0),
            ("knee_mm_per_s", "mm/s", 5.0),
        ];
        assert_eq!(all, wanted);
    }

    /// What the figure says is what the loop takes out of the force.
    #[test]
    fn the_force_of_friction_is_the_same_in_the_figure_and_for_the_loop() {
        for element in [
            Element::new(Law::Slider, [0.02]),
            Element::new(Law::Bristles, [0.02]),
            Element::new(Law::Distributed, [0.02]),
            Element::new(Law::BoucWen, [0.02, 1.0, 4.0, 4.0]),
            // Creep below and above the top speed of the motion.
            Element::new(Law::InSeries, [0.02, 5.0, 8.0]),
            Element::new(Law::InSeries, [0.02, 80.0, 8.0]),
        ] {
            let one = fit(vec![(element, 100.0)]);
            let all = figures(Effect::CoulombFriction, &[0], &one, &[0.0; DECLARED]);
            let saved = SavedElement {
                name: Effect::CoulombFriction,
                law: element.law,
                strength: 100.0,
                shape: element.shape,
                reference_mm: one.sizes.x,
                reference_mm_per_s: one.sizes.v,
                cutoff_hz: None,
                enabled: true,
            };
            let taken_out = saved.sliding().expect("it slides");
            assert_eq!((all[0].0, all[0].2), (SLIDING, taken_out[0]), "{element:?}");
        }
    }

    #[test]
    fn a_parallel_slider_is_a_bilinear_spring_of_another_first_stiffness() {
        let one = fit(vec![(Element::new(Law::Slider, [3.0]), 300.0)]);
        let all = figures(Effect::BilinearHysteresis, &[0], &one, &[0.0; DECLARED]);
        assert_eq!(all[0].2, 100.0);
        assert_eq!(all[2], ("hardening_ratio", "", 0.5));
    }

    #[test]
    fn a_bearing_that_heats_is_told_by_its_whole_force_and_by_what_wears_off() {
        let both = fit(vec![
            (Element::new(Law::Worn, [8.0, 3700.0]), 100.0),
            (Element::new(Law::Distributed, [10.0]), 50.0),
        ]);
        let all = figures(Effect::BoucWenHysteresis, &[0, 1], &both, &[0.0; DECLARED]);
        let wanted = [
            ("force_n", "N", 150.0),
            ("yield_mm", "mm", 8.0),
            ("force_worn_off_n", "N", 100.0),
            (WORN_TRAVEL, "mm", 3700.0),
        ];
        assert_eq!(all, wanted);
    }

    #[test]
    fn every_law_is_told_by_its_shapes_and_none_by_a_number_alone() {
        for (element, name, shape) in [
            (
                Element::new(Law::Saturating, [15.0]),
                Effect::ViscousDamping,
                (KNEE, "mm/s", 15.0),
            ),
            (
                Element::new(Law::Beyond, [5.0, 0.0, 1.0]),
                Effect::Softening,
                ("knee_mm", "mm", 5.0),
            ),
            (
                Element::new(Law::Beyond, [5.0, -1.0]),
                Effect::AsymmetricStiffness,
                ("below_mm", "mm", 5.0),
            ),
            (
                Element::new(Law::Beyond, [5.0, 1.0, 0.0, 0.02]),
                Effect::AsymmetricStiffness,
                ("damping_beyond_n_s_per_mm", "N s/mm", -0.8),
            ),
            (
                Element::new(Law::Distributed, [3.0, 0.7]),
                Effect::BilinearHysteresis,
                (YIELD_FROM, "mm", 3.0 * (0.2 + 0.8 * 0.7)),
            ),
            (
                Element::new(Law::Recentring, [3.0, 0.5]),
                Effect::BoucWenHysteresis,
                ("back_at_mm", "mm", 1.5),
            ),
            (
                Element::new(Law::Pinched, [1.0, 4.0, 2.0]),
                Effect::BoucWenHysteresis,
                ("pinch_width_mm", "mm", 4.0),
            ),
            (
                Element::new(Law::SlippingJoint, [0.5, 3.0]),
                Effect::SlipGap,
                ("gap_mm", "mm", 3.0),
            ),
            (
                Element::new(Law::SliderAlong, [0.1, 7.0]),
                Effect::CoulombFriction,
                ("along_from_mm", "mm", 7.0),
            ),
            (
                Element::new(Law::BoucWen, [0.2, 2.0, 1.0, 0.5]),
                Effect::CoulombFriction,
                (PRESLIDING, "mm", 0.2),
            ),
        ] {
            let one = fit(vec![(element, -40.0)]);
            let all = figures(name, &[0], &one, &[0.0; DECLARED]);
            assert!(all.contains(&shape), "{name}: {all:?}");
            // Its strength comes first: that shows whether it is present at all.
            assert!(all[0].2.abs() > 0.0, "{name}: {all:?}");
        }
    }
}
