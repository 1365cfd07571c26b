//! By how much a filter that knows the law of a specimen reduces the error caused by the noise of the force.
//!
//! ```text
//! cargo run --release -p benchmarks --example yielding_noise -- RECORD.csv...
//! ```
//!
//! The structure of Table 1 of the paper is tested on an ideal actuator. Its specimen yields at 30 mm with a hardening of .05,
//! and the force has the paper's noise of 2667 N rms. The law `R = a x + z` has three unknowns: the hardening stiffness `a`,
//! and for `z` a spring of stiffness `k` that slips at `z_y`. Between two reversals the law is linear in them, so they are
//! found by recursive least squares along the path of the *target*, which has no noise. Above the corner frequency the force
//! follows the law, below it the reading, so a wrong law cannot lead it astray for long.

#[allow(dead_code)] // Only its reading of a record is used.
#[path = "your_controller.rs"]
mod your_controller;

use plant::specimen::SpecimenKind;
use plant::{Rig, RigSpec};
use std::f64::consts::TAU;

const MASS_KG: f64 = 1000.0;
const STIFFNESS_N_PER_M: f64 = 158e3;
const DAMPING_RATIO: f64 = 0.02;
const YIELD_M: f64 = 0.030;
const HARDENING: f64 = 0.05;
const NOISE_N: f64 = 2667.0;
const RATE_HZ: f64 = 2000.0;
const DURATION_S: f64 = 40.0;
const SEEDS: u64 = 9;

/// The law, and what has been learnt of it.
struct Law {
    /// `a`, `k` and `z_y`.
    unknown: [f64; 3],
    covariance: [[f64; 3]; 3],
    /// How `z` depends on `k` and `z_y`.
    spring: [f64; 2],
    at_m: f64,
    /// Corner below which the reading counts, as a share per step; `None` for the law alone.
    share: Option<f64>,
    correction_n: f64,
}

impl Law {
    /// A law whose numbers are wrong by the factor `1 + off` and declared to be known to 20 %.
    fn new(off: f64, corner_hz: Option<f64>) -> Self {
        let k = (1.0 - HARDENING) * STIFFNESS_N_PER_M;
        let unknown = [HARDENING * STIFFNESS_N_PER_M, k, k * YIELD_M].map(|x| x * (1.0 + off));
        let mut covariance = [[0.0; 3]; 3];
        for i in 0..3 {
            covariance[i][i] = (0.2 * unknown[i]).powi(2);
        }
        Self {
            unknown,
            covariance,
            spring: [0.0; 2],
            at_m: 0.0,
            share: corner_hz.map(|hz| 1.0 - (-TAU * hz / RATE_HZ).exp()),
            correction_n: 0.0,
        }
    }

    /// The estimated force at the target, N, where `read_n` was read.
    fn force_n(&mut self, target_m: f64, read_n: f64) -> f64 {
        self.spring[0] += target_m - self.at_m;
        self.at_m = target_m;
        let [_, k, slips_n] = self.unknown;
        let z = self.spring[0] * k + self.spring[1] * slips_n;
        if z.abs() > slips_n {
            self.spring = [0.0, z.signum()];
        }
        let slopes = [target_m, self.spring[0], self.spring[1]];
        let law_n = |unknown: &[f64; 3]| (0..3).map(|i| slopes[i] * unknown[i]).sum::<f64>();
        let error_n = read_n - law_n(&self.unknown);
        let p = self.covariance;
        let seen: [f64; 3] = std::array::from_fn(|i| (0..3).map(|j| p[i][j] * slopes[j]).sum());
        let total = NOISE_N * NOISE_N + (0..3).map(|i| slopes[i] * seen[i]).sum::<f64>();
        for i in 0..3 {
            self.unknown[i] += seen[i] / total * error_n;
            for j in 0..3 {
                self.covariance[i][j] -= seen[i] * seen[j] / total;
            }
        }
        let law_n = law_n(&self.unknown);
        let Some(share) = self.share else {
            return law_n;
        };
        self.correction_n += share * (read_n - law_n - self.correction_n);
        law_n + self.correction_n
    }
}

/// Displacements of the structure, m. `force_n` turns target and reading into the force that is integrated.
fn response(
    ground: &[f64],
    kind: SpecimenKind,
    noise_n: f64,
    seed: u64,
    mut force_n: impl FnMut(f64, f64) -> f64,
) -> Vec<f64> {
    let mut spec = RigSpec::default();
    spec.specimen.kind = kind;
    spec.specimen.yield_mm = Some((YIELD_M * 1e3).into());
    spec.specimen.hardening_ratio = Some(HARDENING.into());
    spec.sensors.force_noise_n = noise_n;
    let mut rig = Rig::new(&spec, &[STIFFNESS_N_PER_M], RATE_HZ, seed).expect("a possible rig");
    let dt = 1.0 / RATE_HZ;
    let damping = 2.0 * DAMPING_RATIO * (STIFFNESS_N_PER_M * MASS_KG).sqrt();
    let (mut u, mut v, mut a) = (0.0, 0.0, 0.0);
    let mut path = Vec::with_capacity(ground.len());
    for g in ground {
        let half = v + 0.5 * dt * a;
        u += dt * half;
        let force = force_n(u, rig.step(&[u]).force_n[0]);
        a = (-MASS_KG * g - force - damping * half) / (MASS_KG + 0.5 * dt * damping);
        v = half + 0.5 * dt * a;
        path.push(u);
    }
    path
}

/// Eq. 18: root mean square of the difference over the largest displacement without noise.
fn eps_rms(path: &[f64], exact: &[f64]) -> f64 {
    let square = path
        .iter()
        .zip(exact)
        .map(|(u, e)| (u - e).powi(2))
        .sum::<f64>();
    let peak = exact.iter().fold(0.0, |peak: f64, u| peak.max(u.abs()));
    (square / exact.len() as f64).sqrt() / peak
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("eps_rms, per cent: median of {SEEDS} draws of the noise (largest)");
    for path in std::env::args().skip(1) {
        let (interval_s, points) = your_controller::points(&path)?;
        let ground: Vec<f64> = (0..(DURATION_S * RATE_HZ) as usize)
            .map(|i| {
                let at = i as f64 / RATE_HZ / interval_s;
                let (k, part) = (at as usize, at.fract());
                let value = |k: usize| points.get(k).copied().map_or(0.0, f64::from);
                value(k) + part * (value(k + 1) - value(k))
            })
            .collect();
        for (specimen, kind) in [
            ("bilinear, as the law has it", SpecimenKind::Bilinear),
            ("Bouc and Wen, rounder than the law", SpecimenKind::BoucWen),
        ] {
            println!("\n{path}, specimen {specimen}");
            let exact = response(&ground, kind, 0.0, 0, |_, read| read);
            let show = |name: &str, make: &dyn Fn() -> Box<dyn FnMut(f64, f64) -> f64>| {
                let mut eps: Vec<f64> = (1..=SEEDS)
                    .map(|seed| eps_rms(&response(&ground, kind, NOISE_N, seed, make()), &exact))
                    .collect();
                eps.sort_by(f64::total_cmp);
                let last = eps.len() - 1;
                println!(
                    "{name:44} {:6.2} ({:.2})",
                    100.0 * eps[last / 2],
                    100.0 * eps[last]
                );
            };
            show("the reading", &|| Box::new(|_, read| read));
            let law = |off: f64, corner_hz: Option<f64>| {
                move || -> Box<dyn FnMut(f64, f64) -> f64> {
                    let mut law = Law::new(off, corner_hz);
                    Box::new(move |target, read| law.force_n(target, read))
                }
            };
            show("the law, learnt", &law(0.0, None));
            show("the law, begun 10 % off", &law(0.1, None));
            show("the same, the reading below .1 Hz", &law(0.1, Some(0.1)));
            show("the same, the reading below .5 Hz", &law(0.1, Some(0.5)));
        }
    }
    Ok(())
}
