//! Springs that stiffen, soften, differ between the sides, or lose stiffness for good.

use crate::engine::row::{Row, Sizes, over};
use crate::laws::specimen::element::Law;
use plant::Effect;

pub fn rows(sizes: &Sizes) -> Vec<Row> {
    let m = &sizes.motion;
    let (x, c) = (m.x, m.middle);
    let mut all = vec![
        Row::element(Law::PowerOfPlace, 2.8, over([0.5, 1.0, 2.0, 3.0, 5.0], 1.0)),
        Row::element(Law::Lessened, 3.5, over([0.15, 0.4, 0.8, 1.4, 2.5], 1.0)),
        Row::element(Law::Fatigued, 4.0, over([0.2, 1.0], m.travel)),
        Row::element(
            Law::Away,
            3.5,
            [-0.5, -0.25, 0.0, 0.25, 0.5].map(|p| [c + p * x, 0.0, 0.0, 0.0]),
        ),
        Row::element(Law::Away, 3.5, [[0.0, 0.1 * x, 0.0, 0.0]]),
        Row::element(Law::Square, 4.0, [[0.0; 4]]),
    ];
    let own: Vec<Row> = all.iter().map(|r| r.with_own(0)).collect();
    all.extend(own);
    all.extend(Row::effect(Effect::Softening, 2.5, sizes, &[6, 3]));
    all.extend(Row::effect(Effect::Degradation, 2.8, sizes, &[6, 4]));
    all.extend(Row::effect(Effect::AsymmetricStiffness, 3.0, sizes, &[]));
    all
}
