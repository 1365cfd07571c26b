//! Effects of the readings: a calibration, a zero, a clock, a spectral line, a limit; and the mass on the load cell.

use crate::engine::row::{Row, Sizes};
use crate::laws::library::{OFF_CENTRE_LIMIT, ROUNDED_LIMIT};
use crate::laws::specimen::element::Law;
use plant::Effect;

pub fn rows(sizes: &Sizes, rests: bool) -> Vec<Row> {
    let mut all = vec![
        Row::parameter(0, 3.6),
        Row::parameter(2, 4.2),
        Row::parameter(3, 3.2),
    ];
    let effects = [
        (Effect::GainError, 3.4, &[][..]),
        (Effect::RigCompliance, 3.4, &[][..]),
        (Effect::ChannelSkew, 2.8, &[12][..]),
        (Effect::Saturation, 3.2, &[12][..]),
        (Effect::MainsHum, 3.0, &[3][..]),
    ];
    all.push(Row::of(ROUNDED_LIMIT, 3.2, sizes, &[6, 3]));
    all.push(Row::of(OFF_CENTRE_LIMIT, 3.2, sizes, &[6, 4]));
    let slow = [
        (Effect::Drift, 3.3, &[5][..]),
        (Effect::TemperatureGain, 4.3, &[5][..]),
    ];
    let asked = slow.iter().filter(|_| rests);
    for (name, price, counts) in effects.iter().chain(asked) {
        all.extend(Row::effect(*name, *price, sizes, counts));
    }
    if rests {
        let seconds = sizes.motion.seconds;
        let grid = [0.15, 0.5].map(|t| [3.0, 30.0].map(|own| [t * seconds, own, 0.0, 0.0]));
        all.push(Row::element(Law::Warming, 4.3, grid.concat()));
    }
    all
}
