//! Ground motions: one generated here, always available, and third-party records if they are at hand (see the crate `test-data`).

use crate::Shaking;
use experiment::files::ground_motion::GroundMotionFile;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

/// A ground motion by its file name without extension; `None`, with a message, if the data are missing.
pub fn ground_motion(name: &str) -> Option<Shaking> {
    let path = test_data::file(&format!("ground-motion/{name}.csv"))?;
    let text = std::fs::read_to_string(&path).ok()?;
    let rows: Vec<(f64, f64)> = text
        .lines()
        .skip(1)
        .filter_map(|line| {
            let (t, a) = line.split_once(',')?;
            Some((t.trim().parse().ok()?, a.trim().parse().ok()?))
        })
        .collect();
    Some(Shaking {
        acc_m_per_s2: rows.iter().map(|r| (r.1 * 9.80665) as f32).collect(),
        interval_s: rows.get(1)?.0 - rows.first()?.0,
    })
}

/// Third-party records of different kinds of shaking, as far as they are at hand.
pub fn recorded() -> Vec<GroundMotionFile> {
    let names = [
        "ELCENTRO_NS_1940_NGAW2",
        "KJMA_NS_1995_NGAW2",
        "RTHSBENCH_Morgan",
        "TABAS_TR_1978_PEERold",
    ];
    let file = |name: &str| {
        let shaking = ground_motion(name)?;
        Some(GroundMotionFile {
            name: name.to_owned(),
            acc_m_per_s2: shaking.acc_m_per_s2,
            interval_s: shaking.interval_s,
        })
    };
    names.into_iter().filter_map(file).collect()
}

/// The two records of the paper: Kobe and Tabas.
pub fn kobe_and_tabas() -> Option<[(&'static str, Shaking); 2]> {
    Some([
        ("Kobe", ground_motion("KJMA_NS_1995_NGAW2")?),
        ("Tabas", ground_motion("TABAS_TR_1978_PEERold")?),
    ])
}

/// The generated motion, and Kobe and Tabas if they are at hand: for what must be true of any strong ground motion.
pub fn motions() -> Vec<(&'static str, Shaking)> {
    let mut all = vec![("drawn", drawn())];
    all.extend(kobe_and_tabas().into_iter().flatten());
    all
}

/// A strong motion on firm ground, so that a copy of this repository without third-party records can check a bound of every
/// figure: cosines with random phases and the spectrum of Kanai (1957) and Tajimi (1960), 1.5 Hz and 60 %, from 0.2 to 20 Hz,
/// which rise for 10 s, stay for 5 s and decay; peak 5 m/s^2; 150 s.
pub fn drawn() -> Shaking {
    const INTERVAL_S: f64 = 0.01;
    const GROUND_HZ: f64 = 1.5;
    const GROUND_DAMPING: f64 = 0.6;
    const PEAK_M_PER_S2: f64 = 5.0;
    let mut draw = Xoshiro256PlusPlus::seed_from_u64(1940);
    let waves: Vec<(f64, f64, f64)> = (0..400)
        .map(|i| {
            let hz = 0.2 + 19.8 * (f64::from(i) + 0.5) / 400.0;
            let (r, zeta) = (hz / GROUND_HZ, 2.0 * GROUND_DAMPING * hz / GROUND_HZ);
            let power = (1.0 + zeta * zeta) / ((1.0 - r * r).powi(2) + zeta * zeta);
            let phase = TAU * f64::from(draw.next_u32()) / f64::from(u32::MAX);
            (TAU * hz, power.sqrt(), phase)
        })
        .collect();
    let envelope = |t: f64| (t / 10.0).powi(3).min(1.0) * (-0.3 * (t - 15.0)).min(0.0).exp();
    let acc: Vec<f64> = (0..15_000)
        .map(|i| {
            let t = f64::from(i) * INTERVAL_S;
            let sum: f64 = waves.iter().map(|(w, a, p)| a * (w * t + p).cos()).sum();
            envelope(t) * sum
        })
        .collect();
    let peak = acc.iter().fold(0.0_f64, |p, a| p.max(a.abs()));
    Shaking {
        acc_m_per_s2: acc
            .iter()
            .map(|a| (a * PEAK_M_PER_S2 / peak) as f32)
            .collect(),
        interval_s: INTERVAL_S,
    }
}
