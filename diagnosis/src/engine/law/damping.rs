//! Forces that depend on speed, and springs in series with dashpots.

use crate::engine::row::{Row, Sizes, over};
use crate::laws::specimen::element::Law;

pub fn rows(sizes: &Sizes) -> Vec<Row> {
    let m = &sizes.motion;
    let (short, long) = (3.0 * m.interval_s, 0.25 * m.seconds);
    let relaxes = (0..8).map(|i| {
        let tau = short * (long / short).powf(f64::from(i) / 7.0);
        [tau, 0.0, 0.0, 0.0]
    });
    let dashpots = [0.08, 0.2, 0.4]
        .iter()
        .flat_map(|y| [0.5, 1.0].map(|creep| [y * m.x, creep * m.v, 1.4, 0.0]));
    let mut all = vec![
        Row::element(
            Law::PowerOfSpeed,
            3.0,
            over([0.35, 0.5, 0.7, 0.85, 1.5, 2.0, 2.5, 3.0], 1.0),
        ),
        Row::element(Law::Saturating, 3.5, over([0.12, 0.25, 0.5, 1.0], m.v)),
        Row::element(Law::SizeOfSpeed, 5.0, [[0.0; 4]]),
        Row::element(Law::Relaxing, 3.5, relaxes),
        Row::element(Law::InSeries, 3.5, dashpots),
    ];
    let own: Vec<Row> = all.iter().map(|r| r.with_own(1)).collect();
    all.extend(own);
    all.push(Row::parameter(1, 3.0));
    all
}
