//! Simulation of the transfer system (servo valve, actuator and specimen), several side by side.

use super::parameters::{OUTPUT_GAIN, Parameters};
use super::size::RATE_HZ;
use crate::linear::Lanes;
use nalgebra::SMatrix;
use plant::linear::Linear;

/// Angular frequency that derivatives are scaled by, so that the states are of similar size.
const SCALE_RAD_PER_S: f64 = 300.0;

/// `L` transfer systems; commands are held over a period.
///
/// The states are displacement x, velocity v, the actuator's force p, the valve's flow q (as the rate of that force) and its
/// rate: `m v' = p - c v - k x - d`, `p' = q - a3 p - a2 v`, `q'' = a1b0 (gain u - x) - b1 q' - b2 q`, where d is the difference
/// of the specimen's force from the linear one.
#[derive(Clone, Debug)]
pub struct TransferSystem<const L: usize> {
    system: Lanes<5, 2, L>,
    /// Masses, dampings and stiffnesses of the specimens.
    specimen: [[f64; L]; 3],
    /// Scale of the force states, N/m.
    size_n_per_m: [f64; L],
    other_n: [f64; L],
}

impl<const L: usize> TransferSystem<L> {
    /// Systems at rest.
    pub fn new(plants: &[Parameters; L]) -> Self {
        use std::array::from_fn;
        Self {
            system: Lanes::new(&from_fn(|l| sampled(&plants[l]))),
            specimen: from_fn(|i| {
                from_fn(|l| {
                    let s = &plants[l].specimen;
                    [s.mass_kg, s.damping_n_s_per_m, s.stiffness_n_per_m][i]
                })
            }),
            size_n_per_m: from_fn(|l| plants[l].specimen.stiffness_n_per_m),
            other_n: [0.0; L],
        }
    }

    /// Advances by one period under `command_m`, m. `other_n` is the specimens' force beyond `c v + k x` in its middle, N.
    #[inline(always)]
    pub fn step(&mut self, command_m: [f64; L], other_n: [f64; L]) {
        self.other_n = other_n;
        self.system.step(&[command_m, other_n]);
    }

    /// Displacement, m, velocity, m/s, and acceleration, m/s^2, of the specimens.
    #[inline(always)]
    pub fn motion(&self) -> [[f64; L]; 3] {
        let [x, v, p, ..] = &self.system.state;
        let [m, c, k] = &self.specimen;
        let (mut speed, mut acceleration) = ([0.0; L], [0.0; L]);
        for l in 0..L {
            speed[l] = v[l] * SCALE_RAD_PER_S;
            let force_n = p[l] * self.size_n_per_m[l];
            acceleration[l] = (force_n - c[l] * speed[l] - k[l] * x[l] - self.other_n[l]) / m[l];
        }
        [*x, speed, acceleration]
    }

    /// Displacements of the specimens, m.
    #[inline(always)]
    pub fn displacement_m(&self) -> &[f64; L] {
        &self.system.state[0]
    }

    /// Forces on the load cells, N: the actuators' forces, including inertia and damping of the specimens.
    #[inline(always)]
    pub fn force_n(&self) -> [f64; L] {
        let p = &self.system.state[2];
        std::array::from_fn(|l| p[l] * self.size_n_per_m[l])
    }
}

/// Transition and inputs (command, m; other force, N) over a period, for states of similar size.
fn sampled(plant: &Parameters) -> (SMatrix<f64, 5, 5>, SMatrix<f64, 5, 2>) {
    let s = &plant.specimen;
    let (m, c, k) = (s.mass_kg, s.damping_n_s_per_m, s.stiffness_n_per_m);
    let w = SCALE_RAD_PER_S;
    // States x, v / w, p / k, q / (k w), q' / (k w^2).
    let a = SMatrix::<f64, 5, 5>::from_row_slice(&[
        0.0,
        w,
        0.0,
        0.0,
        0.0, //
        -k / (m * w),
        -c / m,
        k / (m * w),
        0.0,
        0.0, //
        0.0,
        -plant.a2 * w / k,
        -plant.a3,
        w,
        0.0, //
        0.0,
        0.0,
        0.0,
        0.0,
        w, //
        -plant.a1_b0 / (k * w * w),
        0.0,
        0.0,
        -plant.b2 / w,
        -plant.b1,
    ]);
    let mut b = SMatrix::<f64, 5, 2>::zeros();
    b[(4, 0)] = OUTPUT_GAIN * plant.a1_b0 / (k * w * w);
    b[(1, 1)] = -1.0 / (m * w);
    let linear = Linear::new(&a, &b, 1.0 / RATE_HZ);
    (*linear.transition(), *linear.held())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Complex;
    use std::f64::consts::TAU;

    #[test]
    fn the_sampled_system_has_that_response_and_moves_consistently() {
        let w = TAU * 5.0;
        let mut plant = TransferSystem::new(&[Parameters::NOMINAL]);
        let n = RATE_HZ as usize;
        let (mut sum, mut worst) = (Complex::new(0.0, 0.0), 0.0_f64);
        let mut last = plant.motion().map(|lanes| lanes[0]);
        for i in 0..4 * n {
            // The middle of a held command is half a period late.
            plant.step([(w * (i as f64 + 0.5) / RATE_HZ).sin()], [0.0]);
            let now = plant.motion().map(|lanes| lanes[0]);
            let t = (i + 1) as f64 / RATE_HZ;
            if i >= 3 * n {
                sum += Complex::from_polar(2.0 / RATE_HZ, -w * t) * now[0];
                let mean = 0.5 * (now[1] + last[1]);
                worst = worst.max(((now[0] - last[0]) * RATE_HZ - mean).abs());
            }
            last = now;
        }
        // sin = Im e^{iwt}: the sum is G / i.
        let g = sum * Complex::new(0.0, 1.0);
        assert!((g - Parameters::NOMINAL.response(w)).norm() < 2e-5);
        assert!(worst < 1e-3 * w, "velocity is not the derivative: {worst}");
    }

    #[test]
    fn a_lane_is_to_the_bit_what_it_is_alone() {
        let plants: [Parameters; 4] = std::array::from_fn(|l| Parameters::perturbed(l as u64));
        let mut together = TransferSystem::new(&plants);
        let mut alone = plants.map(|p| TransferSystem::new(&[p]));
        for i in 0..5000 {
            let command: [f64; 4] =
                std::array::from_fn(|l| (0.01 * f64::from(i)).sin() * (l as f64 - 1.5));
            together.step(command, [0.0; 4]);
            for (l, one) in alone.iter_mut().enumerate() {
                one.step([command[l]], [0.0]);
                assert_eq!(
                    together.displacement_m()[l].to_bits(),
                    one.displacement_m()[0].to_bits()
                );
                assert_eq!(together.force_n()[l].to_bits(), one.force_n()[0].to_bits());
            }
        }
    }
}
