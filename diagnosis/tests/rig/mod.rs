//! Records of a simulated rig: rest, a multisine, rest.

use diagnosis::{ActuatorModel, Declared, Model, Recording, SpecimenModel};
use plant::{EffectSpec, Rig, RigSpec};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

pub const RATE_HZ: f64 = 1000.0;

/// Uniform between -1 and 1.
fn unit(rng: &mut Xoshiro256PlusPlus) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

fn command(seed: u64, seconds: f64) -> Vec<f64> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let lines: Vec<(f64, f64, f64)> = (0..24)
        .map(|i| {
            let hz = 0.2 * 1.17_f64.powi(i) * (1.0 + 0.03 * unit(&mut rng));
            (hz, 1.0 / (1.0 + hz / 1.5), 3.2 * unit(&mut rng))
        })
        .collect();
    let n = (seconds * RATE_HZ) as usize;
    let motion = |i: usize| -> f64 {
        let t = i as f64 / RATE_HZ - 2.0;
        let length = seconds - 4.0;
        if !(0.0..length).contains(&t) {
            return 0.0;
        }
        let fade = (t.min(length - t) / 1.0).min(1.0);
        let sum: f64 = lines
            .iter()
            .map(|(hz, a, p)| a * (std::f64::consts::TAU * hz * t + p).sin())
            .sum();
        fade * fade * (3.0 - 2.0 * fade) * sum
    };
    let raw: Vec<f64> = (0..n).map(motion).collect();
    let peak = raw.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    raw.iter().map(|x| 10.0 * x / peak).collect()
}

/// A record of the rig with `effects`.
pub fn record(effects: &[EffectSpec], true_values: [f64; 3], seed: u64) -> Recording {
    record_over(22.0, effects, true_values, seed)
}

/// The same over so many seconds.
pub fn record_over(
    seconds: f64,
    effects: &[EffectSpec],
    true_values: [f64; 3],
    seed: u64,
) -> Recording {
    let [stiffness, delay_ms, lag_ms] = true_values;
    let text = format!(
        "[actuator]\nkind = 'lag_delay'\ndelay_ms = {delay_ms:?}\nlag_ms = {lag_ms:?}\n[specimen]\nkind = 'linear'\n\
         [sensors]\ndisplacement_coloured_noise_mm = 0.01\nforce_coloured_noise_n = 10.0\ncoloured_noise_corner_hz = 150.0"
    );
    let mut spec: RigSpec = toml::from_str(&text).expect("a rig");
    spec.effects = effects.to_vec();
    let mut rig =
        Rig::new(&spec, &[stiffness * 1e3], RATE_HZ, seed).unwrap_or_else(|e| panic!("{e}"));
    let command = command(seed, seconds);
    let readings: Vec<_> = command
        .iter()
        .map(|u| {
            let r = rig.step(&[u * 1e-3]);
            (r.displacement_m[0] * 1e3, r.force_n[0])
        })
        .collect();
    Recording {
        name: format!("record {seed}"),
        time_s: (0..command.len()).map(|i| i as f64 / RATE_HZ).collect(),
        command_mm: Some(command),
        displacement_mm: Some(readings.iter().map(|r| r.0).collect()),
        force_n: Some(readings.iter().map(|r| r.1).collect()),
        ..Recording::default()
    }
}

/// What the laboratory declares: values inside their tolerances.
pub fn model() -> Model {
    let declared = |value, tolerance| Some(Declared { value, tolerance });
    Model {
        actuator: Some(ActuatorModel {
            gain: declared(1.0, 0.005),
            delay_ms: declared(5.0, 0.5),
            lag_ms: declared(22.0, 1.0),
            offset_mm: declared(0.0, 0.02),
            ..ActuatorModel::default()
        }),
        specimen: Some(SpecimenModel {
            stiffness_n_per_mm: declared(1000.0, 10.0),
            offset_n: declared(0.0, 10.0),
            ..SpecimenModel::default()
        }),
        ..Model::default()
    }
}

/// Two records of one rig whose true parameters are off inside their tolerances.
pub fn pair(effects: &[EffectSpec], seed: u64) -> [Recording; 2] {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0xabcd);
    let truth = [
        1000.0 + 8.0 * unit(&mut rng),
        5.0 + 0.4 * unit(&mut rng),
        22.0 + 0.8 * unit(&mut rng),
    ];
    [
        record(effects, truth, 2 * seed + 1),
        record(effects, truth, 2 * seed + 2),
    ]
}
