//! Explicit Newmark integration (beta 0, gamma 1/2) in scaled, compensated state.
//!
//! The state is `u`, `q = dt v` and `s = dt^2 a`, all in metres. Increments come from `q` and `s`, never
//! from subtracting two displacements: that is what keeps f32 within 1e-6 of f64 over 100 s.
//!
//! `u_{i+1} = u_i + q_i + s_i/2`, `q_{i+1} = q_i + (s_i + s_{i+1})/2`, and the predictor velocity of Eq 16 is
//! `q_i + s_i`, so that `v_i + v^_{i+1} = 2 (u_{i+1} - u_i) / dt` exactly.

use crate::matrix;
use crate::refusal::Refusal;
use crate::structure::{Structure, actuated};
use crate::sum::{CompensatedSum, Split};
use core::array::from_fn;

/// Constants of the integration, computed once.
#[derive(Clone, Debug)]
pub struct Coefficients<const N: usize> {
    /// `dt^2 (M + dt/2 C)^-1`, m/N.
    flexibility: [[Split; N]; N],
    /// `C / dt`, N/m: damping force per increment of displacement.
    damping_per_increment: [[f32; N]; N],
    /// `-M g`, kg: load per ground acceleration.
    load_kg: [f32; N],
    /// Numerical stiffness, N/m, if there is one.
    numerical_stiffness: Option<[[f32; N]; N]>,
    /// Number of axes on which damping may be added: those with an actuator.
    physical: usize,
    /// `1 / dt`, 1/s of model time.
    pub rate_hz: f32,
    /// `1 / dt^2`.
    pub rate_squared: f32,
}

impl<const N: usize> Coefficients<N> {
    /// Computes the constants for a step of `dt_s` of model time; `inertia_share` is the fraction of a load
    /// cell's mass that it reads as force, 1 / time scale squared.
    ///
    /// # Errors
    /// An effective mass that is not positive definite.
    pub fn new(structure: &Structure<N>, dt_s: f64, inertia_share: f64) -> Result<Self, Refusal> {
        // The load cell already measures the inertia of its own mass: only the rest is integrated numerically.
        let mut numerical_mass = structure.mass;
        for j in 0..N {
            numerical_mass[j][j] -= inertia_share * structure.physical_mass_kg[j];
        }
        let effective = matrix::sum(&numerical_mass, dt_s / 2.0, &structure.damping);
        let inverse =
            matrix::inverse(&effective).ok_or(Refusal::matrix("structure.physical_mass_kg"))?;
        let single =
            |m: &matrix::Matrix<N>, factor: f64| m.map(|row| row.map(|x| (x * factor) as f32));
        let numerical = structure.numerical_stiffness != matrix::zeros();
        let mut load_kg = [0.0; N];
        for i in 0..N {
            load_kg[i] = -(0..N)
                .map(|j| structure.mass[i][j] * structure.influence[j])
                .sum::<f64>() as f32;
        }
        Ok(Self {
            flexibility: inverse.map(|row| row.map(|x| Split::new(x * dt_s * dt_s))),
            damping_per_increment: single(&structure.damping, 1.0 / dt_s),
            load_kg,
            numerical_stiffness: numerical.then(|| single(&structure.numerical_stiffness, 1.0)),
            physical: structure.physical.min(N),
            rate_hz: (1.0 / dt_s) as f32,
            rate_squared: (1.0 / (dt_s * dt_s)) as f32,
        })
    }

    /// The load `-M g a_g`, N.
    #[inline]
    pub fn load_n(&self, ground_m_per_s2: f32) -> [f32; N] {
        self.load_kg.map(|m| m * ground_m_per_s2)
    }
}

/// The integrated motion of the structure: target `u_i` and the state that leads to the next.
#[derive(Clone, Debug)]
pub struct Newmark<const N: usize> {
    u: [CompensatedSum; N],
    q: [CompensatedSum; N],
    s: [f32; N],
    increment: [f32; N],
    started: bool,
}

impl<const N: usize> Newmark<N> {
    /// At rest at displacement 0.
    pub fn at_rest() -> Self {
        Self::starting([0.0; N], [0.0; N])
    }

    /// Starts from a displacement (m) and a displacement per step, `q = dt v` (m), for free vibration.
    pub fn starting(displacement_m: [f32; N], velocity_dt_m: [f32; N]) -> Self {
        Self {
            u: displacement_m.map(CompensatedSum::new),
            q: velocity_dt_m.map(CompensatedSum::new),
            s: [0.0; N],
            // The first damping force belongs to v_0 itself.
            increment: velocity_dt_m,
            started: false,
        }
    }

    /// Target displacement `u_i`, m.
    #[inline]
    pub fn displacement_m(&self) -> [f32; N] {
        self.u.map(CompensatedSum::value)
    }

    /// `u_i - u_{i-1}`, m.
    #[inline]
    pub fn increment_m(&self) -> &[f32; N] {
        &self.increment
    }

    /// Velocity per step `q = dt v` of the last solved step, m.
    #[inline]
    pub fn velocity_dt_m(&self) -> [f32; N] {
        self.q.map(CompensatedSum::value)
    }

    /// Acceleration per step squared `s = dt^2 a` of the last solved step, m.
    #[inline]
    pub fn acceleration_dt2_m(&self) -> &[f32; N] {
        &self.s
    }

    /// Predictor velocity per step, Eq 16: `q_{i-1} + s_{i-1}`, m.
    #[inline]
    pub fn predictor_velocity_dt_m(&self) -> [f32; N] {
        from_fn(|j| self.q[j].plus(self.s[j]))
    }

    /// Moves on to an externally solved target. Velocity and acceleration are central differences, the same as those
    /// of the explicit integration: `q_i = (u_{i+1} - u_{i-1})/2`, `s_i = u_{i+1} - 2 u_i + u_{i-1}`.
    pub fn follow(&mut self, next_m: [f32; N]) {
        for j in 0..N {
            let (before, now) = (self.increment[j], next_m[j] - self.u[j].value());
            self.q[j] = CompensatedSum::new(0.5 * (before + now));
            self.s[j] = now - before;
            self.increment[j] = now;
            self.u[j] = CompensatedSum::new(next_m[j]);
        }
    }

    /// Solves the equation of motion at `u_i` for `a_i` and moves on to `u_{i+1}`.
    ///
    /// `load_n` is the external load, `restoring_force_n` the specimen's, `added_damping` the diagonal of
    /// C_cor in N s/m. The damping acts in the same step: `M + dt/2 (C + C_cor)` is the effective mass. Returns the
    /// force of the added damping over the increment that led to `u_i`, N.
    #[inline]
    pub fn advance(
        &mut self,
        k: &Coefficients<N>,
        load_n: &[f32; N],
        restoring_force_n: &[f32; N],
        added_damping: &[f32; N],
    ) -> [f32; N] {
        // v_{i-1} + dt/2 a_{i-1} is increment/dt, exactly; so C v takes the increment.
        let (mut unbalanced, mut added_n) = ([0.0; N], [0.0; N]);
        for i in 0..N {
            let mut f = load_n[i] - restoring_force_n[i];
            for j in 0..N {
                f -= k.damping_per_increment[i][j] * self.increment[j];
            }
            added_n[i] = added_damping[i] * k.rate_hz * self.increment[i];
            unbalanced[i] = f - added_n[i];
        }
        if let Some(stiffness) = &k.numerical_stiffness {
            let u = self.displacement_m();
            for i in 0..N {
                for j in 0..N {
                    unbalanced[i] -= stiffness[i][j] * u[j];
                }
            }
        }
        let mut s = [-0.0; N];
        for i in 0..N {
            for j in 0..N {
                s[i] += k.flexibility[i][j].times(unbalanced[j]);
            }
        }
        if (0..actuated::<N>(k.physical)).any(|j| added_damping[j] != 0.0) {
            solve_with_added_damping(k, added_damping, &mut s);
        }
        for j in 0..N {
            if self.started {
                self.q[j].add(0.5 * (self.s[j] + s[j]));
            }
            self.increment[j] = self.q[j].plus(0.5 * s[j]);
            self.u[j].add(self.increment[j]);
        }
        self.started = true;
        self.s = s;
        added_n
    }
}

/// Solves `(I + A C_cor / (2 dt)) s = b` in place, with `A` the flexibility and `b` the first guess.
///
/// Gauss without pivoting: for C_cor >= 0 every leading minor is at least 1, since those of `A` (symmetric
/// positive definite) and of a non-negative diagonal are non-negative. Otherwise the guard keeps the pivot away
/// from 0. Axes without an actuator have no damping: their columns are those of the identity.
#[inline]
fn solve_with_added_damping<const N: usize>(
    k: &Coefficients<N>,
    added_damping: &[f32; N],
    s: &mut [f32; N],
) {
    let physical = actuated::<N>(k.physical);
    if physical == 1 {
        // One actuator: one column to eliminate, and no matrix to clear.
        let entry = |i: usize| k.flexibility[i][0].value() * added_damping[0] * (0.5 * k.rate_hz);
        let pivot = entry(0) + 1.0;
        let inverse = 1.0 / pivot;
        for i in 1..N {
            s[i] -= entry(i) * inverse * s[0];
        }
        s[0] /= pivot;
        return;
    }
    let entry =
        |i: usize, j: usize| k.flexibility[i][j].value() * added_damping[j] * (0.5 * k.rate_hz);
    let mut m: [[f32; N]; N] = from_fn(|i| from_fn(|j| entry(i, j)));
    for i in 0..N {
        m[i][i] += 1.0;
    }
    for p in 0..physical {
        let inverse = 1.0 / m[p][p];
        for i in p + 1..N {
            let factor = m[i][p] * inverse;
            for j in p + 1..physical {
                m[i][j] -= factor * m[p][j];
            }
            s[i] -= factor * s[p];
        }
    }
    for p in (0..physical).rev() {
        for j in p + 1..physical {
            s[p] -= m[p][j] * s[j];
        }
        s[p] /= m[p][p];
    }
}
