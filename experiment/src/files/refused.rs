//! Core's refusals of a test file, in terms of the keys that a person wrote.

use crate::numbers::three;
use crate::rig::declared::Expected;
use outerloop_core::{Config, Refusal};
use plant::RigSpec;

/// A refusal by core, with the key that is behind it.
pub fn sentence(e: &Refusal, config: &Config, plant: &RigSpec, expected: Expected) -> String {
    let timing = &config.timing;
    match (e.name, e.accepted) {
        (name, "as many values as masses") => format!(
            "{name} has {} and structure.mass_kg {}: accepted are {}",
            e.value,
            config.structure.mass_kg.len(),
            e.accepted
        ),
        (name, accepted) if accepted.ends_with("as storeys in the laboratory") => {
            let key = match name {
                "compensation.delay_ms" if expected == Expected::Truth => {
                    "plant.actuator.delay_ms or lag_ms"
                }
                name => name,
            };
            format!("{key} has {} values: accepted are {accepted}", e.value)
        }
        // The delay given to the loop was not in the file: it came from the simulated actuator.
        ("compensation.delay_ms", accepted) if expected == Expected::Truth => {
            let storeys = &config.structure.stiffness_n_per_m;
            match plant::Rig::new(plant, storeys, timing.rate_hz, 0) {
                Err(own) => own.to_string(),
                Ok(_) => format!(
                    "plant.actuator.delay_ms and lag_ms are {} together: accepted are {accepted} where nothing else says what \
                     delay the compensation works with (compensation.delay_ms, [declared.actuator])",
                    e.value
                ),
            }
        }
        // An integration step has three keys, any of which may be wrong.
        ("loop.rate_hz", accepted) if (10.0..=100_000.0).contains(&timing.rate_hz) => format!(
            "loop.substeps = {}, loop.rate_hz = {} and loop.time_scale = {} make an integration step of {} ms: accepted are \
             {accepted}, which is a step below {} ms here",
            timing.substeps,
            timing.rate_hz,
            timing.time_scale,
            three(1e3 * config.model_step_s()),
            three(1e3 * longest_step_s(config))
        ),
        _ => e.to_string(),
    }
}

/// The largest integration step, s, that core accepts: it assumes twice the stiffest storey over the lightest mass.
fn longest_step_s(config: &Config) -> f64 {
    let s = &config.structure;
    let stiffest = s.stiffness_n_per_m.iter().copied().fold(0.0, f64::max);
    let lightest = s.mass_kg.iter().copied().fold(f64::INFINITY, f64::min);
    (lightest / stiffest).sqrt()
}
