//! What a name also covers: other causes of the same force, and where and by how much that force changes.

use crate::laws::specimen::{GAINED, KNEE, PINCHED, STIFFNESS_BEYOND, WORN_TRAVEL};
use crate::model::answer::FoundEffect;
use crate::prepare::advice::four;
use plant::{Effect, Family};

/// Exponents of speed that count as proportional.
const PROPORTIONAL: std::ops::Range<f64> = 0.85..1.15;
/// From this damping ratio on nothing overshoots by more than a sixth, which nobody would call ringing.
const RINGS: f64 = 0.5;

/// Notes on a law of another power, an oil column that does not ring, a transducer that bends, and changes of a force.
pub fn interpretations(effects: &[FoundEffect]) -> Vec<String> {
    effects
        .iter()
        .flat_map(|e| cause(e).into_iter().chain(shape(e)))
        .collect()
}

/// Possible causes of an effect beyond its name.
fn cause(e: &FoundEffect) -> Option<String> {
    match e.name {
        Effect::ViscousDamping | Effect::CoulombFriction => {
            let exponent = e.value("exponent")?;
            (!PROPORTIONAL.contains(&exponent)).then(|| {
                    format!(
                        "The force of that {} grows with the power {exponent:.2} of the speed: the law of a fluid damper with \
                         orifices, or of a seal.",
                        e.name
                    )
                })
        }
        Effect::OilColumn => {
            let ratio = e.value("damping_ratio")?;
            (ratio > RINGS).then(|| {
                    format!(
                        "With a damping ratio of {ratio:.2} nothing rings: a valve or a controller of second order is as likely as \
                         the oil."
                    )
                })
        }
        // No transducer has a knee.
        Effect::Softening | Effect::Hardening if e.value(STIFFNESS_BEYOND).is_none() => {
            Some(format!(
                "A displacement transducer whose scale bends makes the same of a spring as {}: a second transducer would tell.",
                e.name
            ))
        }
        Effect::AsymmetricActuator => {
            let b = e.value("unequal_areas_per_mm")?;
            Some(format!(
                "Where the command is 1 mm ahead of the piston it moves {:.1} % faster towards {} than the other way: unequal \
                     areas of the piston, or unequal edges of the valve.",
                200.0 * b.abs(),
                if b > 0.0 { "plus" } else { "minus" }
            ))
        }
        _ => None,
    }
}

/// Where and by how much the force of an effect changes, in words.
fn shape(e: &FoundEffect) -> Vec<String> {
    let value = |name: &str| e.value(name);
    let n = |name: &str| value(name).map(four).unwrap_or_default();
    let mut all = Vec::new();
    if let Some(knee) = value(KNEE) {
        let part =
            value(GAINED).map_or(String::new(), |gained| format!("{} N of the", four(gained)));
        all.push(format!(
            "{} force of that {} grow{} with speed up to some {} mm/s and hardly beyond: {}.",
            if part.is_empty() { "The" } else { &part },
            e.name,
            if part.is_empty() { "s" } else { "" },
            four(knee),
            if e.family == Family::Friction {
                "friction in a film of grease, or a damper whose fluid yields"
            } else {
                "a damper with a relief valve, or one whose fluid yields"
            }
        ));
    }
    if let Some(travel) = value(WORN_TRAVEL) {
        all.push(format!(
            "Of the force of that {} {} N wear off along the way, to 37 % after {} mm of it, counted from the first sample of each \
             file: a lead core or a pad that heats, which comes back as it cools, or one that wears. A second test after a pause \
             tells which.",
            e.name,
            n("force_worn_off_n"),
            four(travel)
        ));
    }
    if let Some(less) = value(PINCHED) {
        all.push(format!(
            "Within some {} mm of {} mm that {} holds up to {} N less: it pinches, as a joint with slack or cracks that close.",
            n("pinch_width_mm"),
            n("pinch_middle_mm"),
            e.name,
            four(less)
        ));
    }
    if let Some(more) = value(STIFFNESS_BEYOND) {
        let place = match (value("knee_mm"), value("above_mm"), value("below_mm")) {
            (Some(knee), ..) => format!(
                "beyond {} mm to either side of {} mm",
                four(knee),
                n("middle_mm")
            ),
            (_, Some(above), _) => format!("above {} mm", four(above)),
            (.., below) => format!("below {} mm", below.map(four).unwrap_or_default()),
        };
        all.push(format!(
            "The spring has {} N/mm {} {place}.",
            four(more.abs()),
            if more > 0.0 { "more" } else { "less" }
        ));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::answer::FoundParameter;

    fn found(name: Effect, parameters: &[(&str, f64)]) -> FoundEffect {
        let parameter = |&(name, value): &(&str, f64)| FoundParameter {
            name: name.into(),
            value,
            unit: String::new(),
            ci90: [value; 2],
        };
        FoundEffect {
            name,
            family: name.entry().family,
            q: None,
            p: None,
            rivals: Vec::new(),
            parameters: parameters.iter().map(parameter).collect(),
        }
    }

    #[test]
    fn what_changes_a_force_is_said_in_words() {
        for (effect, words) in [
            (
                found(
                    Effect::BoucWenHysteresis,
                    &[
                        ("force_n", 150e3),
                        ("force_worn_off_n", 1e5),
                        (WORN_TRAVEL, 3700.0),
                    ],
                ),
                "100000 N wear off along the way, to 37 % after 3700 mm",
            ),
            (
                found(Effect::ViscousDamping, &[("force_n", 112.9), (KNEE, 14.91)]),
                "up to some 14.91 mm/s and hardly beyond: a damper with a relief valve",
            ),
            (
                found(
                    Effect::CoulombFriction,
                    &[("force_n", 48e3), (GAINED, 9500.0), (KNEE, 21.3)],
                ),
                "9500 N of the force of that coulomb_friction grow with speed up to some 21.30 mm/s",
            ),
            (
                found(
                    Effect::Softening,
                    &[
                        (STIFFNESS_BEYOND, -22877.0),
                        ("knee_mm", 5.93),
                        ("middle_mm", 0.0),
                    ],
                ),
                "22877 N/mm less beyond 5.930 mm to either side of 0 mm",
            ),
            (
                found(
                    Effect::AsymmetricStiffness,
                    &[(STIFFNESS_BEYOND, 12.5), ("below_mm", -3.0)],
                ),
                "12.50 N/mm more below -3.000 mm",
            ),
            (
                found(
                    Effect::AsymmetricActuator,
                    &[("unequal_areas_per_mm", -0.0222)],
                ),
                "4.4 % faster towards minus",
            ),
        ] {
            let said = interpretations(&[effect]).join(" ");
            assert!(said.contains(words), "{said}");
        }
    }
}
