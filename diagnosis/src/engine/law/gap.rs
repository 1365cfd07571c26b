//! Lost motion and contacts.

use crate::engine::row::{Row, Sizes, over};
use crate::laws::library::ROUNDED_GAP;
use crate::laws::specimen::element::Law;
use plant::Effect;

pub fn rows(sizes: &Sizes) -> Vec<Row> {
    let (x, c) = (sizes.motion.x, sizes.motion.middle);
    // Clearances are around zero if the motion passes through it.
    let [centre, reach] = sizes.motion.both_sides();
    let mut all = vec![
        Row::element(
            Law::Lost,
            3.2,
            over([0.015, 0.04, 0.1, 0.2, 0.35, 0.6, 0.85], x),
        ),
        Row::element(
            Law::Beyond,
            3.2,
            [0.1, 0.25, 0.45, 0.65, 0.85].map(|gap| [gap * reach, 0.0, centre, 0.0]),
        ),
    ];
    let sides = [-0.75, -0.4, 0.0, 0.4, 0.75]
        .iter()
        .flat_map(|place| [-1.0, 1.0].map(|side| [c + place * x, side, 0.0, 0.0]));
    // A bumper also has damping: it pushes and never pulls.
    let damped = sides
        .clone()
        .map(|[p, side, ..]| [p, side, 0.0, 0.3 * x / sizes.motion.v]);
    all.push(Row::element(Law::Beyond, 3.5, damped));
    all.push(Row::element(Law::Beyond, 3.0, sides));
    // A joint in a part of the structure: the rest of the spring is unchanged.
    let joints = [0.05, 0.12, 0.3]
        .iter()
        .flat_map(|slip| [0.15, 0.3, 0.55, 0.85].map(|gap| [slip * x, gap * x, 0.0, 0.0]));
    all.push(Row::element(Law::SlippingJoint, 3.2, joints));
    let own: Vec<Row> = all.iter().map(|r| r.with_own(0)).collect();
    all.extend(own);
    all.extend(Row::effect(Effect::Backlash, 2.8, sizes, &[10]));
    all.extend(Row::effect(Effect::DeadBand, 2.8, sizes, &[10]));
    all.push(Row::of(ROUNDED_GAP, 2.8, sizes, &[6, 2]));
    all.extend(Row::effect(Effect::SlipGap, 3.2, sizes, &[6, 5]));
    all
}
