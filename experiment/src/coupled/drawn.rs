//! Rigs drawn around one with two coupled actuators: each of its numbers varies by itself.

use super::table::SpreadTable;
use crate::stability::perturbed::Spread;
use plant::coupled::CoupledRigSpec;
use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// What of a rig is drawn by one factor.
pub(crate) struct DrawnNumbers<'a> {
    /// Its key in `[coupled.actuators]`; of the specimen the key in `[coupled]`.
    pub(crate) key: String,
    /// Standard deviation of the factor.
    pub(crate) deviation: f64,
    numbers: Vec<&'a mut f64>,
}

impl DrawnNumbers<'_> {
    /// True if a factor changes the rig.
    pub(crate) fn varies(&self) -> bool {
        self.deviation > 0.0 && self.numbers.iter().any(|x| **x != 0.0)
    }
}

/// All numbers of `rig`, in the order in which they are drawn: poles, zeros and delays with the spread of the delay, gains and the
/// specimen's stiffness and damping with their own.
pub(crate) fn numbers<'a>(rig: &'a mut CoupledRigSpec, spread: &Spread) -> Vec<DrawnNumbers<'a>> {
    fn pair<'a>(all: &mut Vec<DrawnNumbers<'a>>, name: &str, of: &'a mut [f64; 2], deviation: f64) {
        all.extend(of.iter_mut().enumerate().map(|(i, x)| DrawnNumbers {
            key: format!("{name}.{i}"),
            deviation,
            numbers: vec![x],
        }));
    }
    let (a, specimen) = (&mut rig.actuators, &mut rig.specimen);
    let mut all = Vec::new();
    pair(&mut all, "slow_pole_hz", &mut a.slow_pole_hz, spread.delay);
    pair(&mut all, "fast_pole_hz", &mut a.fast_pole_hz, spread.delay);
    for (name, rows) in [
        ("lead_ms", &mut a.lead_ms),
        ("path_lead_ms", &mut a.path_lead_ms),
    ] {
        for (i, row) in rows.iter_mut().enumerate() {
            pair(&mut all, &format!("{name}.{i}"), row, spread.delay);
        }
    }
    pair(&mut all, "delay_ms", &mut a.delay_ms, spread.delay);
    all.push(DrawnNumbers {
        key: "natural_hz".into(),
        deviation: spread.delay,
        numbers: vec![&mut a.natural_hz],
    });
    for (i, row) in a.gain.iter_mut().enumerate() {
        pair(&mut all, &format!("gain.{i}"), row, spread.gain);
    }
    // A specimen is stiffer as a whole.
    for (key, matrix, deviation) in [
        (
            "specimen.stiffness",
            &mut specimen.stiffness,
            spread.stiffness,
        ),
        ("specimen.damping", &mut specimen.damping, spread.damping),
    ] {
        all.push(DrawnNumbers {
            key: key.into(),
            deviation,
            numbers: matrix.as_flattened_mut().iter_mut().collect(),
        });
    }
    all
}

/// Rig `index` of those around `declared`, and the factor of each number that varies.
pub(crate) fn rig(
    declared: &CoupledRigSpec,
    spread: &Spread,
    index: u64,
) -> (CoupledRigSpec, Vec<f64>) {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(
        spread.seed ^ (index + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15),
    );
    let mut rig = declared.clone();
    let mut factors = Vec::new();
    for drawn in numbers(&mut rig, spread) {
        let normal: f64 = StandardNormal.sample(&mut random);
        // Beyond three deviations it would be another machine; a time stays above a twentieth of itself.
        let factor = (1.0 + drawn.deviation * normal.clamp(-3.0, 3.0)).max(0.05);
        if drawn.varies() {
            factors.push(factor);
        }
        drawn.numbers.into_iter().for_each(|x| *x *= factor);
    }
    (rig, factors)
}

/// `spread` with those of the actuators' times and gains that the test file declares.
pub(crate) fn of_declared(declared: &SpreadTable, spread: &Spread) -> Spread {
    let times = [
        declared.slow_pole_ratio,
        declared.fast_pole_ratio,
        declared.lead_ratio,
        declared.path_lead_ratio,
        declared.natural_ratio,
    ];
    let or = |declared: f64, asked| if declared > 0.0 { declared } else { asked };
    Spread {
        delay: or(times.into_iter().fold(0.0, f64::max), spread.delay),
        gain: or(declared.gain_ratio, spread.gain),
        ..*spread
    }
}
