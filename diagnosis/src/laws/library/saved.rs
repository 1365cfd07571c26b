//! Converts catalogue parameters, as in a model file, to amplitudes and shapes: the inverse of
//! [`super::Candidate::parameters`].

use super::candidate::MOST_AT_REST;
use crate::numbers::signals::Scales;
use plant::{Channel, Effect, EffectSpec};

/// A form's effect and parameter names, in the order of its shapes.
type Form = (Effect, &'static [&'static str]);

/// The forms of a channel's effects, in the order of `actuator::FORMS` or `specimen::FORMS`.
pub fn forms(channel: Channel) -> &'static [Form] {
    match channel {
        Channel::Actuator => &OF_AN_ACTUATOR,
        Channel::Specimen => &OF_A_SPECIMEN,
    }
}

const OF_A_SPECIMEN: [Form; 2] = [
    (Effect::Saturation, &["lower_n", "upper_n"]),
    (Effect::Saturation, &["limit_n", "sharpness"]),
];

const OF_AN_ACTUATOR: [Form; 13] = [
    (Effect::AsymmetricActuator, &["unequal_areas_per_mm"]),
    (Effect::AsymmetricActuator, &["flow_difference"]),
    (Effect::DeadBand, &["overlap_mm", "valve_lag_ms"]),
    (Effect::RateLimit, &["opening_mm", "valve_lag_ms"]),
    (Effect::RateLimit, &["valve_rate_mm_per_s"]),
    (
        Effect::OilColumn,
        &["frequency_hz", "damping_ratio", "damping_s_per_mm"],
    ),
    (Effect::Saturation, &["lower_mm", "upper_mm", "rounding_mm"]),
    (Effect::Saturation, &["lower_mm", "upper_mm"]),
    (Effect::DeadBand, &["width_mm", "middle_mm"]),
    (
        Effect::CoulombFriction,
        &["error_mm", "presliding_mm", "roundness"],
    ),
    (
        Effect::TemperatureGain,
        &["change", "time_constant_s", "own_heat_per_mm2"],
    ),
    (
        Effect::CoulombFriction,
        &["oil_bend_mm", "presliding_mm", "valve_lag_ms"],
    ),
    (
        Effect::StribeckFriction,
        &[
            "oil_bend_mm",
            "presliding_mm",
            "rest_ratio",
            "stribeck_mm_per_s",
            "valve_lag_ms",
        ],
    ),
];

/// The form that `effect` has; `None` if it is as in the catalogue.
pub fn form_of(channel: Channel, effect: &EffectSpec) -> Option<usize> {
    forms(channel).iter().position(|(name, names)| {
        let given = names
            .iter()
            .all(|name| effect.parameters.contains_key(*name));
        *name == effect.name && given
    })
}

/// The parameter names of the form that `effect` has; none if it is as in the catalogue.
pub fn form_names(channel: Channel, effect: &EffectSpec) -> &'static [&'static str] {
    form_of(channel, effect).map_or(&[], |i| forms(channel)[i].1)
}

/// True if `effect` is a spring that fatigues with travel.
pub fn tires(effect: &EffectSpec) -> bool {
    effect.name == Effect::Degradation && effect.parameter("travel_mm").is_some_and(|mm| mm > 0.0)
}

/// Amplitudes and shapes of a channel's `effect` for data of these sizes. A hum's phase belongs to its own record; its
/// sine starts at 0.
pub fn fit_of(channel: Channel, effect: &EffectSpec, k: &Scales) -> (Vec<f64>, Vec<f64>) {
    let own = form_names(channel, effect);
    if !own.is_empty() {
        // Of those that are columns the strength is among the shapes.
        return (vec![1.0], form_shapes(effect, own));
    }
    let get = |name: &'static str| effect.parameter(name).unwrap_or(0.0);
    let milli = |name: &'static str| 1e-3 * get(name);
    let in_force = channel == Channel::Specimen;
    let of_unit =
        |force: &'static str, motion: &'static str| get(if in_force { force } else { motion });
    // If an effect that replaces the whole response is a column, its amplitude is 1.
    let once = if in_force { vec![1.0] } else { Vec::new() };
    match effect.name {
        Effect::DelayError => (
            vec![],
            vec![milli("delay_ms") + k.interval_s + k.declared.delay_s],
        ),
        Effect::LagError => (vec![], vec![milli("lag_ms") + k.declared.lag_s]),
        Effect::SecondLag => (vec![], vec![milli("lag_ms")]),
        Effect::OilColumn => (vec![], vec![get("frequency_hz"), get("damping_ratio")]),
        Effect::ChannelSkew => (vec![], vec![milli("skew_ms")]),
        Effect::GainError => (vec![get("error")], vec![]),
        Effect::Offset => (vec![of_unit("offset_n", "offset_mm")], vec![]),
        Effect::RigCompliance => (vec![1.0 / get("stiffness_n_per_mm")], vec![]),
        Effect::Drift => (
            vec![of_unit("rate_n_per_s", "rate_mm_per_s")],
            vec![get("time_constant_s")],
        ),
        Effect::TemperatureGain => (vec![get("change")], vec![get("time_constant_s")]),
        Effect::CoulombFriction => (
            vec![of_unit("force_n", "error_mm")],
            vec![get("presliding_mm")],
        ),
        Effect::StribeckFriction => (
            at_rest_and_sliding(of_unit("force_n", "error_mm"), get("rest_ratio")),
            vec![get("presliding_mm"), get("stribeck_mm_per_s")],
        ),
        Effect::BilinearHysteresis => (vec![1.0 - get("hardening_ratio")], vec![get("yield_mm")]),
        Effect::BoucWenHysteresis => (
            vec![1.0 - get("hardening_ratio")],
            vec![get("yield_mm"), get("sharpness")],
        ),
        Effect::Backlash | Effect::DeadBand => (once, vec![get("width_mm")]),
        Effect::SlipGap => (once, vec![get("gap_mm"), get("slip_n") / k.stiffness]),
        Effect::Saturation => (once, vec![of_unit("limit_n", "limit_mm")]),
        Effect::RateLimit => (vec![], vec![get("rate_mm_per_s")]),
        Effect::ViscousDamping => (vec![get("damping_n_s_per_mm")], vec![]),
        Effect::QuadraticDamping => (vec![get("damping_n_s2_per_mm2")], vec![]),
        Effect::MaxwellDamper => (
            vec![get("stiffness_n_per_mm")],
            vec![milli("relaxation_ms")],
        ),
        Effect::Hardening => {
            let exponent = get("exponent");
            let at_largest = (get("reference_mm") / k.x).powf(-exponent);
            (vec![at_largest], vec![exponent])
        }
        Effect::Degradation if tires(effect) => (vec![get("lost_share")], vec![get("travel_mm")]),
        Effect::Softening | Effect::Degradation => {
            (once, vec![get("reference_mm"), get("exponent")])
        }
        Effect::AsymmetricActuator => match milli("retract_lag_ms") {
            lag_s if lag_s > 0.0 => (vec![get("difference"), 1.0], vec![lag_s]),
            _ => (vec![get("difference"), 0.0], vec![k.interval_s]),
        },
        Effect::AsymmetricStiffness => (vec![get("difference")], vec![]),
        Effect::InertiaForce => (vec![get("mass_kg")], vec![]),
        Effect::MainsHum => {
            let first = of_unit("amplitude_n", "amplitude_mm");
            let third = first * get("third_harmonic");
            (vec![first, 0.0, third, 0.0], vec![get("frequency_hz")])
        }
        // Read from the values themselves: no candidate has it.
        Effect::Quantisation | Effect::FrozenSensor | Effect::SensorNoise => (vec![], vec![]),
    }
}

/// Shapes of a form, in its order.
fn form_shapes(effect: &EffectSpec, names: &[&str]) -> Vec<f64> {
    let shape = |name: &&str| {
        let value = effect.parameters.get(*name).copied().unwrap_or(0.0);
        if name.ends_with("_ms") {
            1e-3 * value
        } else {
            value
        }
    };
    names.iter().map(shape).collect()
}

/// Amplitudes of friction at every speed and of that added at rest, for the column with the most at rest.
fn at_rest_and_sliding(sliding: f64, rest_ratio: f64) -> Vec<f64> {
    let falls = sliding * (rest_ratio - 1.0) / (MOST_AT_REST - 1.0);
    vec![sliding - falls, falls]
}
