//! Friction: independent of speed, higher at rest, varying with position, varying with travel.

use crate::engine::row::{Row, Sizes, over};
use crate::laws::specimen::element::Law;
use plant::Effect;

pub fn rows(sizes: &Sizes) -> Vec<Row> {
    let (x, v, c) = (sizes.motion.x, sizes.motion.v, sizes.motion.middle);
    let mut all = vec![
        Row::element(
            Law::Slider,
            2.0,
            over([7e-4, 1.5e-3, 3e-3, 6e-3, 0.012, 0.025, 0.038], x),
        ),
        Row::element(
            Law::Bristles,
            2.4,
            over([7e-4, 2e-3, 6e-3, 0.018, 0.036], x),
        ),
        Row::element(Law::Saturating, 2.7, over([0.01, 0.03, 0.06], v)),
        Row::element(Law::PowerOfSpeed, 3.2, over([0.12, 0.2], 1.0)),
        Row::element(
            Law::SliderAway,
            4.5,
            [3e-3, 0.015, 0.06, 0.2].map(|y| [y * x, c, 0.0, 0.0]),
        ),
        Row::element(
            Law::SliderAlong,
            4.5,
            [3e-3, 0.015, 0.06, 0.2].map(|y| [y * x, c, 0.0, 0.0]),
        ),
    ];
    all.extend(Row::effect(Effect::StribeckFriction, 2.5, sizes, &[4, 5]));
    all
}
