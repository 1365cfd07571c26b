//! The integration against a twin in f64 and against exact solutions.
#![allow(missing_docs)]

mod common;

use outerloop_core::{Coefficients, Newmark, Structure};

/// Explicit Newmark in f64, written from the equations and not from the code: displacement, velocity, acceleration.
struct Twin<const N: usize> {
    u: [f64; N],
    v: [f64; N],
    a: [f64; N],
    dt: f64,
    mass: [f64; N],
    damping: [[f64; N]; N],
    started: bool,
}

impl<const N: usize> Twin<N> {
    fn new(s: &Structure<N>, dt: f64) -> Self {
        let mass = core::array::from_fn(|j| s.mass[j][j]);
        Self {
            u: [0.0; N],
            v: [0.0; N],
            a: [0.0; N],
            dt,
            mass,
            damping: s.damping,
            started: false,
        }
    }

    /// Solves at `u` by Gauss elimination and moves on.
    fn advance(&mut self, force: &[f64; N]) {
        let half = self.dt / 2.0;
        let mut m = [[0.0; N]; N];
        let mut rhs = [0.0; N];
        for i in 0..N {
            rhs[i] = force[i];
            for j in 0..N {
                m[i][j] = half * self.damping[i][j];
                let predictor = self.v[j] + if self.started { half * self.a[j] } else { 0.0 };
                rhs[i] -= self.damping[i][j] * predictor;
            }
            m[i][i] += self.mass[i];
        }
        for p in 0..N {
            for i in p + 1..N {
                let f = m[i][p] / m[p][p];
                for j in p..N {
                    m[i][j] -= f * m[p][j];
                }
                rhs[i] -= f * rhs[p];
            }
        }
        let mut a = [0.0; N];
        for i in (0..N).rev() {
            a[i] = (rhs[i] - (i + 1..N).map(|j| m[i][j] * a[j]).sum::<f64>()) / m[i][i];
        }
        for j in 0..N {
            if self.started {
                self.v[j] += half * (self.a[j] + a[j]);
            }
            self.u[j] += self.dt * self.v[j] + self.dt * half * a[j];
        }
        self.started = true;
        self.a = a;
    }
}

/// Largest difference of core and twin over `seconds`, relative to the peak. The loads of both are the same single
/// precision numbers; so is the restoring force, formed in f64 from each one's own displacement.
fn worst<const N: usize>(damping_ratio: f64, rate_hz: f64, seconds: f64) -> f64 {
    let mass: [f64; N] = core::array::from_fn(|j| 1000.0 + 37.0 * j as f64);
    let k: [f64; N] = core::array::from_fn(|j| 158e3 * (N * N) as f64 - 1000.0 * j as f64);
    let s = Structure::shear_frame(&mass, &k, &[damping_ratio; N], N, &[0.0; N]).unwrap();
    let dt = 1.0 / rate_hz;
    let coefficients = Coefficients::new(&s, dt, 0.0).unwrap();
    let (mut core, mut twin) = (Newmark::<N>::at_rest(), Twin::new(&s, dt));
    let (mut difference, mut peak) = (0.0_f64, 0.0_f64);
    for i in 0..(seconds * rate_hz) as u64 {
        let t = i as f64 * dt;
        // A load that ends after 20 s: 80 s of nearly free vibration show the phase.
        let ground = if t < 20.0 {
            (3.0 * (11.0 * t).sin() + 2.0 * (4.3 * t).cos()) as f32
        } else {
            0.0
        };
        let load = coefficients.load_n(ground);
        let u = core.displacement_m();
        let restoring = |u: &[f64; N]| -> [f64; N] {
            core::array::from_fn(|r| (0..N).map(|c| s.stiffness[r][c] * u[c]).sum())
        };
        let measured = restoring(&u.map(f64::from)).map(|f| f as f32);
        let exact = restoring(&twin.u);
        core.advance(&coefficients, &load, &measured, &[0.0; N]);
        let force: [f64; N] = core::array::from_fn(|j| f64::from(load[j]) - exact[j]);
        twin.advance(&force);
        for j in 0..N {
            peak = peak.max(twin.u[j].abs());
            difference = difference.max((f64::from(core.displacement_m()[j]) - twin.u[j]).abs());
        }
    }
    difference / peak
}

#[test]
fn f32_stays_within_a_millionth_of_f64_over_100_s() {
    for rate_hz in [2_000.0, 20_000.0] {
        let e = worst::<1>(0.02, rate_hz, 100.0);
        println!("1 DOF, 2 % damping, {rate_hz} Hz: {e:.1e} of the peak");
        assert!(e < 1e-6, "{rate_hz} Hz: {e:e}");
    }
}

#[test]
fn f32_stays_within_ten_millionths_without_damping() {
    for rate_hz in [2_000.0, 20_000.0] {
        let e = worst::<1>(0.0, rate_hz, 100.0);
        println!("1 DOF, no damping, {rate_hz} Hz: {e:.1e} of the peak");
        assert!(e < 1e-5, "{rate_hz} Hz: {e:e}");
    }
}

#[test]
fn more_degrees_of_freedom_are_as_good() {
    for (n, e) in [
        (2, worst::<2>(0.02, 2_000.0, 100.0)),
        (3, worst::<3>(0.02, 2_000.0, 100.0)),
        (8, worst::<8>(0.02, 2_000.0, 100.0)),
    ] {
        println!("{n} DOF, 2 % damping, 2000 Hz: {e:.1e} of the peak");
        assert!(e < 1e-6, "{n} DOF: {e:e}");
    }
}

/// Natural angular frequency of explicit Newmark: `sin(w dt / 2) = omega dt / 2`, exactly, without damping.
#[test]
fn free_vibration_has_its_exact_discrete_solution() {
    let (m, k, dt) = (1000.0, 158e3, 5e-4);
    let s = Structure::<1>::shear_frame(&[m], &[k], &[0.0], 1, &[0.0]).unwrap();
    let c = Coefficients::new(&s, dt, 0.0).unwrap();
    let omega = libm::sqrt(k / m);
    let discrete = 2.0 / dt * (omega * dt / 2.0).asin();
    let mut motion = Newmark::starting([0.05], [0.0]);
    let mut worst = 0.0_f64;
    for i in 0..20_000 {
        let u = f64::from(motion.displacement_m()[0]);
        worst = worst.max((u - 0.05 * (discrete * f64::from(i) * dt).cos()).abs());
        motion.advance(&c, &[0.0], &[(k * u) as f32], &[0.0]);
    }
    assert!(worst < 0.05 * 2e-6, "{worst} m in 10 s");
}

/// Steady state under a harmonic load against the textbook amplification and phase.
#[test]
fn harmonic_vibration_reaches_its_exact_steady_state() {
    let (m, k, zeta, dt) = (1000.0, 158e3, 0.05, 5e-4);
    let s = Structure::<1>::shear_frame(&[m], &[k], &[zeta], 1, &[0.0]).unwrap();
    let c = Coefficients::new(&s, dt, 0.0).unwrap();
    let omega = libm::sqrt(k / m);
    for ratio in [0.5_f64, 1.0, 2.0] {
        let w = ratio * omega;
        let mut motion = Newmark::<1>::at_rest();
        let (mut sine, mut cosine, mut n) = (0.0, 0.0, 0.0);
        for i in 0..80_000 {
            let t = f64::from(i) * dt;
            let u = f64::from(motion.displacement_m()[0]);
            if t > 20.0 {
                sine += 2.0 * u * (w * t).sin();
                cosine += 2.0 * u * (w * t).cos();
                n += 1.0;
            }
            motion.advance(
                &c,
                &[(1e3 * (w * t).sin()) as f32],
                &[(k * u) as f32],
                &[0.0],
            );
        }
        let dynamic = (1.0 - ratio * ratio, 2.0 * zeta * ratio);
        let square = dynamic.0 * dynamic.0 + dynamic.1 * dynamic.1;
        let exact = (1e3 / k * dynamic.0 / square, -1e3 / k * dynamic.1 / square);
        let scale = 1e3 / k / square.sqrt();
        assert!(
            (sine / n - exact.0).abs() < 2e-3 * scale,
            "in phase at {ratio}"
        );
        assert!(
            (cosine / n - exact.1).abs() < 2e-3 * scale,
            "out of phase at {ratio}"
        );
    }
}

/// Kinetic and strain energy of the undamped motion: explicit Newmark conserves
/// `m v^2 / 2 + k u^2 / 2 - k dt^2 v^2 ... ` only up to O(dt^2); the envelope must not grow or shrink.
#[test]
fn undamped_vibration_neither_gains_nor_loses_energy() {
    let (m, k, dt) = (1000.0, 158e3, 5e-4);
    let s = Structure::<1>::shear_frame(&[m], &[k], &[0.0], 1, &[0.0]).unwrap();
    let c = Coefficients::new(&s, dt, 0.0).unwrap();
    let mut motion = Newmark::starting([0.05], [0.0]);
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for _ in 0..200_000 {
        let u = f64::from(motion.displacement_m()[0]);
        motion.advance(&c, &[0.0], &[(k * u) as f32], &[0.0]);
        let v = f64::from(motion.velocity_dt_m()[0]) / dt;
        let energy = 0.5 * m * v * v + 0.5 * k * u * u;
        (least, most) = (least.min(energy), most.max(energy));
    }
    let start = 0.5 * k * 0.05 * 0.05;
    let ripple = k / m * dt * dt / 4.0;
    assert!(
        (most / start - 1.0).abs() < 2.0 * ripple && (least / start - 1.0).abs() < 2.0 * ripple,
        "{least} {most} {start}"
    );
}
