//! Where parts touch, yield or end: friction, hysteresis, gaps, limits.

use super::{BIG, TINY, effect, needs, on, or};
use crate::effect::Channel::{Actuator, Specimen};
use crate::effect::{Effect, Entry, Family};

pub(super) const ENTRIES: &[Entry] = &[
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
];
