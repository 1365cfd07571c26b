//! The list of effects: one entry a name, in the order of [`Effect`].

use super::Channel::{Actuator, Specimen};
use super::{Channel, Effect, Entry, Family, Parameter};
use crate::error::Accept;

/// Every effect, in a fixed order.
pub fn catalogue() -> &'static [Entry] {
    CATALOGUE
}

const fn effect(
    effect: Effect,
    family: Family,
    channels: &'static [Channel],
    physics: &'static str,
    parameters: &'static [Parameter],
) -> Entry {
    Entry {
        effect,
        family,
        channels,
        parameters,
        physics,
    }
}

const fn needs(
    name: &'static str,
    min: f64,
    max: f64,
    unit: &'static str,
    meaning: &'static str,
) -> Parameter {
    Parameter {
        name,
        channel: None,
        default: None,
        accept: Accept::new(min, max, unit),
        meaning,
    }
}

const fn on(channel: Channel, parameter: Parameter) -> Parameter {
    Parameter {
        channel: Some(channel),
        ..parameter
    }
}

const fn or(default: f64, parameter: Parameter) -> Parameter {
    Parameter {
        default: Some(default),
        ..parameter
    }
}

/// The least size of what divides.
const TINY: f64 = 1e-6;
const BIG: f64 = 1e9;

const CATALOGUE: &[Entry] = &[
    effect(
        Effect::DelayError,
        Family::Timing,
        &[Actuator],
        "the transport delay is longer than declared",
        &[needs(
            "delay_ms",
            -1000.0,
            1000.0,
            "ms",
            "added transport delay; negative where the actuator has as much to give",
        )],
    ),
    effect(
        Effect::LagError,
        Family::Timing,
        &[Actuator],
        "the first-order lag is slower than declared",
        &[needs(
            "lag_ms",
            -1000.0,
            1000.0,
            "ms",
            "added to the time constant; negative where the actuator has as much to give",
        )],
    ),
    effect(
        Effect::SecondLag,
        Family::Timing,
        &[Actuator],
        "a further first-order lag in series, as of a servo valve or an amplifier",
        &[needs("lag_ms", TINY, 1000.0, "ms", "its time constant")],
    ),
    effect(
        Effect::OilColumn,
        Family::Timing,
        &[Actuator],
        "the moving mass rings on the compressible oil: a second-order resonance",
        &[
            needs("frequency_hz", 0.1, 1000.0, "Hz", "natural frequency"),
            or(0.1, needs("damping_ratio", 0.001, 5.0, "", "damping ratio")),
        ],
    ),
    effect(
        Effect::ChannelSkew,
        Family::Timing,
        &[Specimen],
        "displacement and force are not sampled at the same instant",
        &[needs(
            "skew_ms",
            -1000.0,
            1000.0,
            "ms",
            "the force is later by this; negative: the displacement is",
        )],
    ),
    effect(
        Effect::GainError,
        Family::Calibration,
        &[Actuator, Specimen],
        "a calibration factor is off",
        &[needs("error", -0.9, 9.0, "", "relative error of the gain")],
    ),
    effect(
        Effect::Offset,
        Family::Calibration,
        &[Actuator, Specimen],
        "zero is not where it is thought to be",
        &[
            on(
                Actuator,
                needs(
                    "offset_mm",
                    -1e4,
                    1e4,
                    "mm",
                    "displacement at the command zero",
                ),
            ),
            on(
                Specimen,
                needs("offset_n", -BIG, BIG, "N", "force read without force"),
            ),
        ],
    ),
    effect(
        Effect::RigCompliance,
        Family::Calibration,
        &[Specimen, Actuator],
        "the reaction frame gives way: the specimen gets less displacement than its actuator reads (specimen), or the \
         actuator yields to the force (actuator)",
        &[needs(
            "stiffness_n_per_mm",
            TINY,
            BIG,
            "N/mm",
            "stiffness of what gives way",
        )],
    ),
    effect(
        Effect::Drift,
        Family::Slow,
        &[Actuator, Specimen],
        "zero wanders with time",
        &[
            on(
                Actuator,
                needs("rate_mm_per_s", -1e3, 1e3, "mm/s", "initial rate"),
            ),
            on(
                Specimen,
                needs("rate_n_per_s", -BIG, BIG, "N/s", "initial rate"),
            ),
            or(
                0.0,
                needs(
                    "time_constant_s",
                    0.0,
                    1e6,
                    "s",
                    "levels out after; 0 does not",
                ),
            ),
        ],
    ),
    effect(
        Effect::TemperatureGain,
        Family::Slow,
        &[Specimen, Actuator],
        "the gain changes while something warms up",
        &[
            needs("change", -0.9, 9.0, "", "relative change in the end"),
            or(
                60.0,
                needs(
                    "time_constant_s",
                    1e-3,
                    1e6,
                    "s",
                    "time constant of warming up",
                ),
            ),
        ],
    ),
    effect(
        Effect::CoulombFriction,
        Family::Friction,
        &[Specimen, Actuator],
        "dry friction of a bearing or a guide beside the specimen; in a controlled actuator, motion that is held back",
        &[
            on(Specimen, needs("force_n", TINY, BIG, "N", "friction force")),
            on(
                Actuator,
                needs(
                    "error_mm",
                    TINY,
                    1e3,
                    "mm",
                    "by what the displacement is held back",
                ),
            ),
            or(
                0.05,
                needs(
                    "presliding_mm",
                    TINY,
                    1e3,
                    "mm",
                    "way over which it builds up",
                ),
            ),
        ],
    ),
    effect(
        Effect::StribeckFriction,
        Family::Friction,
        &[Specimen, Actuator],
        "dry friction that is greater at rest than in motion",
        &[
            on(
                Specimen,
                needs("force_n", TINY, BIG, "N", "friction force in motion"),
            ),
            on(
                Actuator,
                needs(
                    "error_mm",
                    TINY,
                    1e3,
                    "mm",
                    "by what the displacement is held back in motion",
                ),
            ),
            or(
                1.5,
                needs(
                    "rest_ratio",
                    1.0,
                    20.0,
                    "",
                    "friction at rest over that in motion",
                ),
            ),
            or(
                5.0,
                needs(
                    "stribeck_mm_per_s",
                    TINY,
                    1e6,
                    "mm/s",
                    "velocity at which the difference has dropped to 1/e",
                ),
            ),
            or(
                0.05,
                needs(
                    "presliding_mm",
                    TINY,
                    1e3,
                    "mm",
                    "way over which it builds up",
                ),
            ),
        ],
    ),
    effect(
        Effect::BilinearHysteresis,
        Family::Hysteresis,
        &[Specimen],
        "the storey yields: its stiffness drops to a share of itself, and unloading starts elastically",
        &[
            needs("yield_mm", TINY, 1e6, "mm", "yield drift"),
            or(
                0.05,
                needs(
                    "hardening_ratio",
                    0.0,
                    1.0,
                    "",
                    "stiffness after yield over initial stiffness",
                ),
            ),
        ],
    ),
    effect(
        Effect::BoucWenHysteresis,
        Family::Hysteresis,
        &[Specimen],
        "the storey yields with a smooth knee",
        &[
            needs("yield_mm", TINY, 1e6, "mm", "yield drift"),
            or(
                0.05,
                needs(
                    "hardening_ratio",
                    0.0,
                    1.0,
                    "",
                    "stiffness after yield over initial stiffness",
                ),
            ),
            or(
                2.0,
                needs("sharpness", 0.5, 50.0, "", "exponent of the knee"),
            ),
            or(
                0.5,
                needs("loop_shape", 0.5, 1.0, "", "beta over beta + gamma"),
            ),
        ],
    ),
    effect(
        Effect::Backlash,
        Family::Gap,
        &[Actuator, Specimen],
        "play in a joint: a reversal passes only after the play is crossed",
        &[needs("width_mm", TINY, 1e3, "mm", "play in all")],
    ),
    effect(
        Effect::DeadBand,
        Family::Gap,
        &[Actuator, Specimen],
        "nothing passes around zero",
        &[needs(
            "width_mm",
            TINY,
            1e3,
            "mm",
            "width of the band in all",
        )],
    ),
    effect(
        Effect::SlipGap,
        Family::Gap,
        &[Specimen],
        "a bolted joint holds by friction, slips through the clearance of its hole, then bears",
        &[
            needs("gap_mm", TINY, 1e3, "mm", "clearance in all"),
            needs("slip_n", 0.0, BIG, "N", "force at which it slips"),
        ],
    ),
    effect(
        Effect::Saturation,
        Family::Limit,
        &[Actuator, Specimen],
        "the stroke ends, or the force channel clips",
        &[
            on(
                Actuator,
                needs(
                    "limit_mm",
                    TINY,
                    1e6,
                    "mm",
                    "largest displacement either way",
                ),
            ),
            on(
                Specimen,
                needs(
                    "limit_n",
                    TINY,
                    BIG,
                    "N",
                    "largest force that is read either way",
                ),
            ),
        ],
    ),
    effect(
        Effect::RateLimit,
        Family::Limit,
        &[Actuator],
        "the valve's flow limits the velocity",
        &[needs(
            "rate_mm_per_s",
            TINY,
            1e6,
            "mm/s",
            "largest velocity",
        )],
    ),
    effect(
        Effect::ViscousDamping,
        Family::Damping,
        &[Specimen],
        "a force in proportion to velocity",
        &[needs(
            "damping_n_s_per_mm",
            0.0,
            1e6,
            "N s/mm",
            "its constant",
        )],
    ),
    effect(
        Effect::QuadraticDamping,
        Family::Damping,
        &[Specimen],
        "a force in proportion to velocity squared, as of oil through an orifice",
        &[needs(
            "damping_n_s2_per_mm2",
            0.0,
            1e6,
            "N s2/mm2",
            "its constant",
        )],
    ),
    effect(
        Effect::MaxwellDamper,
        Family::Damping,
        &[Specimen],
        "a spring and a dashpot in series: viscous when slow, elastic when fast",
        &[
            needs(
                "stiffness_n_per_mm",
                0.0,
                BIG,
                "N/mm",
                "stiffness of the spring",
            ),
            needs(
                "relaxation_ms",
                TINY,
                1e6,
                "ms",
                "damping constant over stiffness",
            ),
        ],
    ),
    effect(
        Effect::Hardening,
        Family::Stiffness,
        &[Specimen],
        "the storey stiffens with drift",
        &[
            needs(
                "reference_mm",
                TINY,
                1e6,
                "mm",
                "drift at which the secant stiffness has doubled",
            ),
            or(
                2.0,
                needs(
                    "exponent",
                    0.2,
                    10.0,
                    "",
                    "power of the drift that the stiffness grows with; 2: a cubic force",
                ),
            ),
        ],
    ),
    effect(
        Effect::Softening,
        Family::Stiffness,
        &[Specimen],
        "the storey softens with drift, without a loop",
        &[
            needs(
                "reference_mm",
                TINY,
                1e6,
                "mm",
                "drift at which the secant stiffness has halved",
            ),
            or(
                1.0,
                needs(
                    "exponent",
                    0.2,
                    10.0,
                    "",
                    "power of the drift; above 1 the force falls in the end",
                ),
            ),
        ],
    ),
    effect(
        Effect::AsymmetricActuator,
        Family::Asymmetry,
        &[Actuator],
        "a piston with unequal areas pushes and pulls differently",
        &[
            needs(
                "difference",
                -1.0,
                1.0,
                "",
                "gain pushing less gain pulling, over their mean",
            ),
            or(
                0.0,
                needs(
                    "retract_lag_ms",
                    0.0,
                    1000.0,
                    "ms",
                    "lag on the way back only",
                ),
            ),
        ],
    ),
    effect(
        Effect::AsymmetricStiffness,
        Family::Asymmetry,
        &[Specimen],
        "the storey is stiffer one way than the other",
        &[needs(
            "difference",
            -1.9,
            1.9,
            "",
            "stiffness at positive drift less that at negative, over their mean",
        )],
    ),
    effect(
        Effect::InertiaForce,
        Family::Inertia,
        &[Specimen],
        "mass between specimen and load cell: the load cell reads its acceleration as well",
        &[needs("mass_kg", 0.0, BIG, "kg", "that mass")],
    ),
    effect(
        Effect::MainsHum,
        Family::Interference,
        &[Specimen, Actuator],
        "the mains couple into a cable",
        &[
            on(Specimen, needs("amplitude_n", 0.0, BIG, "N", "amplitude")),
            on(Actuator, needs("amplitude_mm", 0.0, 1e3, "mm", "amplitude")),
            or(50.0, needs("frequency_hz", 0.01, 1e4, "Hz", "frequency")),
            or(
                0.0,
                needs(
                    "third_harmonic",
                    0.0,
                    10.0,
                    "",
                    "amplitude of the third harmonic over that of the first",
                ),
            ),
        ],
    ),
    effect(
        Effect::Quantisation,
        Family::Interference,
        &[Specimen, Actuator],
        "a channel resolves multiples of a step only",
        &[
            on(Specimen, needs("step_n", TINY, BIG, "N", "the step")),
            on(Actuator, needs("step_mm", TINY, 1e3, "mm", "the step")),
        ],
    ),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_has_its_entry_under_its_own_number() {
        assert_eq!(catalogue().len(), Effect::ALL.len());
        for effect in Effect::ALL {
            assert_eq!(effect.entry().effect, *effect);
        }
    }

    #[test]
    fn names_end_with_their_unit() {
        for parameter in catalogue().iter().flat_map(|e| e.parameters) {
            let unit = parameter.accept.unit.to_lowercase();
            let suffix = unit.replace('/', "_per_").replace(' ', "_");
            assert!(
                parameter.name.ends_with(&suffix),
                "{} in {unit}",
                parameter.name
            );
        }
    }
}
