//! Hysteresis: the force depends on the travel since the last reversals. With a free strength the spring may differ.

use crate::engine::row::{Row, Sizes, over};
use crate::laws::specimen::element::Law;
use plant::Effect;

pub fn rows(sizes: &Sizes) -> Vec<Row> {
    let m = &sizes.motion;
    let (x, v, c) = (m.x, m.v, m.middle);
    let mut all = vec![
        // Two rows, since a device may yield at two levels.
        Row::element(Law::Slider, 2.8, over([0.06, 0.1, 0.16], x)),
        Row::element(Law::Slider, 2.8, over([0.27, 0.42, 0.6, 0.75, 0.9], x)),
    ];
    let together = [0.06, 0.15, 0.3, 0.6, 0.9]
        .iter()
        .flat_map(|y| [0.0, 0.6].map(|begins| [y * x, begins, 0.0, 0.0]));
    all.push(Row::element(Law::Distributed, 2.8, together));
    let yields = [0.05, 0.1, 0.2, 0.35, 0.55, 0.8];
    let wen = yields
        .iter()
        .flat_map(|y| [1.0, 2.0].map(|n| (y, n)))
        .flat_map(|(y, n)| [-0.5, 0.0, 0.6].map(|unload| [y * x, n, 1.0, unload]));
    all.push(Row::element(Law::BoucWen, 2.6, wen));
    // With rates of their own: these stiffen on the way out, or hardly yield.
    let growing = [-0.8, -0.4, -0.15, 0.0, 0.3]
        .iter()
        .flat_map(|load| [0.4, 1.0, 2.0, 4.0].map(|unload| [x, 1.0, *load, unload]));
    all.push(Row::element(Law::BoucWen, 2.6, growing));
    let series = [0.02, 0.08, 0.25]
        .iter()
        .flat_map(|y| [0.05, 0.2, 0.5].map(|creep| (y, creep)))
        .flat_map(|(y, creep)| [3.0, 8.0].map(|n| [y * x, creep * v, n, 0.0]));
    all.push(Row::element(Law::InSeries, 3.5, series));
    let worn = [0.04, 0.12, 0.35]
        .iter()
        .flat_map(|y| [0.5, 1.5].map(|w| [y * x, w * m.travel, 0.0, 0.0]));
    all.push(Row::element(Law::Worn, 4.0, worn));
    let pinched = [0.04, 0.12, 0.35]
        .iter()
        .flat_map(|y| [0.15, 0.4].map(|w| [y * x, w * x, c, 0.0]));
    all.push(Row::element(Law::Pinched, 4.0, pinched));
    let flags = [0.05, 0.12, 0.25, 0.5]
        .iter()
        .flat_map(|slip| [0.3, 0.7].map(|back| [slip * x, back, 0.0, 0.0]));
    all.push(Row::element(Law::Recentring, 3.0, flags));
    let own: Vec<Row> = all.iter().map(|r| r.with_own(0)).collect();
    all.extend(own);
    // Fractions of the declared spring.
    all.extend(Row::effect(Effect::BilinearHysteresis, 2.6, sizes, &[10]));
    all.extend(Row::effect(Effect::BoucWenHysteresis, 2.6, sizes, &[6, 4]));
    all
}
