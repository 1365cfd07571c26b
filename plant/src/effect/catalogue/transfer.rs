//! Errors of time, of scale and of zero.

use super::{BIG, TINY, effect, needs, on, or};
use crate::effect::Channel::{Actuator, Specimen};
use crate::effect::{Effect, Entry, Family};

pub(super) const ENTRIES: &[Entry] = &[
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
];
