//! Forces that depend on motion, and what comes in from outside.

use super::{BIG, TINY, effect, needs, on, or};
use crate::effect::Channel::{Actuator, Specimen};
use crate::effect::{Effect, Entry, Family};

pub(super) const ENTRIES: &[Entry] = &[
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
