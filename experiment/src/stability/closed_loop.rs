//! The closed loop over one integration step, as a matrix.
//!
//! ```text
//!  target ─► signal generator ─► predictor ─► rig ─► sensors ─► filter ─► correction ─► explicit Newmark ─► next target
//! ```
//!
//! Variable damping is not linear. What stands for it here is what it comes to over a cycle: `C_cor` takes out the part of
//! the force error `K (u_m - u_c)` that is in phase with the velocity (Eq 14 with Eq 12), up to its clamp; so the force
//! correction is that share of `K (u_c - u_m)`.

use super::blocks::{Block, StateRow, nothing};
use super::filter::LinearFilter;
use super::interpolation::Interpolation;
use super::largest;
use super::predictor::{Ahead, Knowledge, LinearPredictor};
use super::rig::{LinearRig, Variation};
use super::spectrum;
use super::structure_matrices::StructureMatrices;
use crate::failure::Failure;
use nalgebra::{Complex, DMatrix, DVector};
use outerloop_core::Config;
use outerloop_core::linear::LinearForce;
use plant::RigSpec;

/// A test whose closed loop is asked for.
#[derive(Clone, Debug)]
pub struct Question<'a> {
    /// The loop.
    pub config: &'a Config,
    /// The rig.
    pub rig: &'a RigSpec,
    /// What an adaptive predictor knows.
    pub law: Knowledge,
}

impl Question<'_> {
    /// The transition matrix over `steps` integration steps of the loop on the rig with `vary`; what learns has learnt at
    /// `at` rad/s of model time.
    ///
    /// # Errors
    /// A structure or a rig that cannot be written down.
    pub fn transition(
        &self,
        frame: &StructureMatrices,
        vary: &Variation,
        at: f64,
        steps: usize,
    ) -> Result<DMatrix<f64>, Failure> {
        Ok(Loop::new(self, frame, vary, at)?.transition(steps))
    }

    /// Its eigenvalues over one integration step; of a loop with many states, the largest. What learns does so at the
    /// frequency of the first mode in the loop, which depends on what was learnt: it is sought by going there.
    ///
    /// # Errors
    /// A structure or a rig that cannot be written down.
    pub fn eigenvalues(
        &self,
        frame: &StructureMatrices,
        vary: &Variation,
    ) -> Result<Vec<Complex<f64>>, Failure> {
        let learns =
            self.law == Knowledge::Learnt && self.config.compensation.kind.predictor.learns();
        let mut at = frame.omega[0];
        let mut rounds = if learns { ROUNDS } else { 1 };
        loop {
            let z = self.eigenvalues_at(frame, vary, at)?;
            rounds -= 1;
            let first = spectrum::modes(&z, &[at], self.config.model_step_s());
            let found = first
                .first()
                .map_or(at, |m| m.frequency_hz * std::f64::consts::TAU);
            if rounds == 0 || (found / at - 1.0).abs() < 1e-3 {
                return Ok(z);
            }
            at = found;
        }
    }

    fn eigenvalues_at(
        &self,
        frame: &StructureMatrices,
        vary: &Variation,
        at: f64,
    ) -> Result<Vec<Complex<f64>>, Failure> {
        let step = self.transition(frame, vary, at, 1)?;
        if step.nrows() > MANY {
            // So long that what went into the longest delay has come out of it.
            let steps = 2 * step.nrows() / self.config.timing.substeps as usize;
            let far = self.transition(frame, vary, at, steps)?;
            if let Some(largest) = largest::largest(&step, &far, steps) {
                return Ok(largest);
            }
        }
        Ok(spectrum::eigenvalues(&step))
    }

    /// Delay of the measured behind the commanded displacement at the first natural frequency, s of the laboratory, and
    /// the gain there; of several actuators those of the latest.
    ///
    /// # Errors
    /// A rig that cannot be written down.
    pub fn lateness(
        &self,
        frame: &StructureMatrices,
        vary: &Variation,
    ) -> Result<(f64, f64), Failure> {
        let rig = LinearRig::new(self.rig, self.config, vary)?;
        let latest = self.latest(frame, &rig);
        let (late_s, g) = self.late(frame, &rig, latest);
        Ok((late_s, g.norm()))
    }

    /// Delay of the measured displacement behind the target at the first natural frequency, s of the laboratory: what
    /// the predictor leaves of [`Self::lateness`].
    ///
    /// # Errors
    /// A rig that cannot be written down.
    pub fn remaining_lateness(
        &self,
        frame: &StructureMatrices,
        vary: &Variation,
    ) -> Result<f64, Failure> {
        let rig = LinearRig::new(self.rig, self.config, vary)?;
        let latest = self.latest(frame, &rig);
        Ok(self.remaining_of_each(frame, &rig)[latest])
    }

    /// The same of each actuator on `rig`.
    fn remaining_of_each(&self, frame: &StructureMatrices, rig: &LinearRig) -> Vec<f64> {
        let omega = frame.omega[0] / self.config.timing.time_scale;
        let per_step = omega / self.config.timing.rate_hz;
        let predictor = self.predictor(frame, rig);
        let left = |axis| {
            let g = rig.response(axis, per_step);
            -(g * predictor.response(axis, per_step, g)).arg() / omega
        };
        (0..self.config.physical_storeys()).map(left).collect()
    }

    /// The actuator that is latest at the first natural frequency.
    fn latest(&self, frame: &StructureMatrices, rig: &LinearRig) -> usize {
        let late_s = |axis: usize| self.late(frame, rig, axis).0;
        let later = |a: usize, b: usize| if late_s(b) > late_s(a) { b } else { a };
        (0..self.config.physical_storeys()).fold(0, later)
    }

    /// Delay of an actuator there, s of the laboratory, and its response.
    fn late(&self, frame: &StructureMatrices, rig: &LinearRig, axis: usize) -> (f64, Complex<f64>) {
        let omega = frame.omega[0] / self.config.timing.time_scale;
        let g = rig.response(axis, omega / self.config.timing.rate_hz);
        (-g.arg() / omega, g)
    }

    /// True if a predictor would have to learn more than the bounds of its law allow.
    ///
    /// # Errors
    /// A rig that cannot be written down.
    pub fn at_bounds(&self, frame: &StructureMatrices) -> Result<bool, Failure> {
        let rig = LinearRig::new(self.rig, self.config, &Variation::NONE)?;
        Ok(self.predictor(frame, &rig).at_bounds)
    }

    fn predictor(&self, frame: &StructureMatrices, rig: &LinearRig) -> LinearPredictor {
        LinearPredictor::new(self.config, frame, rig, self.law, frame.omega[0])
    }
}

/// States from which on only the largest eigenvalues are sought.
const MANY: usize = 100;

/// Rounds of the search for the frequency at which a predictor learns.
const ROUNDS: usize = 6;

struct Loop<'a> {
    config: &'a Config,
    rig: LinearRig,
    filter: LinearFilter,
    predictor: LinearPredictor,
    /// What was sent last.
    sent: Vec<StateRow>,
    /// `dt^2 (M + dt/2 C)^-1`.
    flexibility: DMatrix<f64>,
    damping_per_increment: DMatrix<f64>,
    numerical: DMatrix<f64>,
    /// Force per displacement error.
    correction: DMatrix<f64>,
    /// `u_i`, `dt v_{i-1}` and `dt^2 a_{i-1}`, m.
    u: Vec<StateRow>,
    q: Vec<StateRow>,
    s: Vec<StateRow>,
}

impl<'a> Loop<'a> {
    fn new(
        question: &Question<'a>,
        frame: &StructureMatrices,
        vary: &Variation,
        at: f64,
    ) -> Result<Self, Failure> {
        let config = question.config;
        let dt = config.model_step_s();
        let n = config.degrees_of_freedom();
        let share = config.timing.time_scale.powi(-2);
        let mut mass = frame.mass.clone();
        for (j, p) in config.structure.physical_mass_kg.iter().enumerate() {
            mass[(j, j)] -= share * p;
        }
        let damping = &frame.damping * vary.damping;
        let flexibility = (mass + &damping * (0.5 * dt))
            .try_inverse()
            .ok_or_else(|| {
                Failure::input("structure.physical_mass_kg: accepted are less than the masses")
            })?
            * (dt * dt);
        let rig = LinearRig::new(question.rig, config, vary)?;
        let late_s = question.remaining_of_each(frame, &rig);
        Ok(Self {
            config,
            filter: LinearFilter::new(config, &rig.storeys()),
            predictor: LinearPredictor::new(config, frame, &rig, question.law, at),
            sent: vec![nothing(); config.physical_storeys()],
            rig,
            flexibility,
            damping_per_increment: damping / dt,
            numerical: frame.numerical.clone(),
            correction: correction(config, frame, vary, &late_s),
            u: vec![nothing(); n],
            q: vec![nothing(); n],
            s: vec![nothing(); n],
        })
    }

    /// Every state a row of its own, `steps` integration steps, and what the states are then.
    fn transition(mut self, steps: usize) -> DMatrix<f64> {
        let mut all = Vec::new();
        self.states(&mut all);
        let n = all.len();
        for (i, state) in all.into_iter().enumerate() {
            *state = DVector::zeros(n);
            state[i] = 1.0;
        }
        for _ in 0..steps {
            self.period();
        }
        let mut all = Vec::new();
        self.states(&mut all);
        let rows: Vec<_> = all.iter().map(|s| s.transpose()).collect();
        DMatrix::from_rows(&rows)
    }

    /// One integration step: its control steps, the first of which solves.
    fn period(&mut self) {
        let substeps = self.config.timing.substeps;
        let physical = self.config.physical_storeys();
        let mut way = Interpolation::from_target(&self.u, &self.q, &self.s, &self.config.timing);
        for tick in 0..substeps {
            let (displacement, force) = self.rig.step(&self.sent);
            let (displacement, force) = self.filter.step(&self.sent, displacement, force);
            if tick == 0 {
                self.solve(&displacement, &force);
            }
            let target = way.command[..physical].to_vec();
            way.advance(tick + 1, &self.u, &self.q, &self.s);
            let ahead = Ahead {
                displacement: &way.command,
                velocity: &way.velocity,
                acceleration: &way.acceleration,
            };
            self.sent = self.predictor.step(&target, &displacement, &ahead);
            self.sent.truncate(physical);
        }
    }

    fn solve(&mut self, displacement: &[StateRow], force: &[StateRow]) {
        let n = self.u.len();
        // u_i - u_{i-1}, as the integrator knows it.
        let increment: Vec<StateRow> = (0..n).map(|j| &self.q[j] + &self.s[j] * 0.5).collect();
        let mut unbalanced: Vec<StateRow> = Vec::with_capacity(n);
        for i in 0..n {
            let mut f = &self.u[i] * 0.0;
            for j in 0..n {
                f.axpy(-self.damping_per_increment[(i, j)], &increment[j], 1.0);
                f.axpy(-self.numerical[(i, j)], &self.u[j], 1.0);
            }
            if let Some(r) = force.get(i) {
                f -= r;
                for (j, x) in displacement.iter().enumerate() {
                    f.axpy(-self.correction[(i, j)], &(&self.u[j] - x), 1.0);
                }
            }
            unbalanced.push(f);
        }
        for i in 0..n {
            let mut s = &self.u[i] * 0.0;
            for (j, f) in unbalanced.iter().enumerate() {
                s.axpy(self.flexibility[(i, j)], f, 1.0);
            }
            self.q[i] += (&self.s[i] + &s) * 0.5;
            self.u[i] += &self.q[i] + &s * 0.5;
            self.s[i] = s;
        }
    }
}

impl Block for Loop<'_> {
    fn states<'a>(&'a mut self, all: &mut Vec<&'a mut StateRow>) {
        all.extend(self.u.iter_mut().chain(&mut self.q).chain(&mut self.s));
        all.extend(&mut self.sent);
        self.rig.states(all);
        self.filter.states(all);
        self.predictor.states(all);
    }
}

/// Force per displacement error that the compensation amounts to.
///
/// On one axis `K`; on several, the diagonal damping takes out what every axis has in phase with its velocity, so that
/// the energy of any motion is that of the whole matrix. The clamp leaves of each row what it allows in the first mode.
fn correction(
    config: &Config,
    frame: &StructureMatrices,
    vary: &Variation,
    late_s: &[f64],
) -> DMatrix<f64> {
    let c = &config.compensation;
    let physical = config.physical_storeys();
    let declared = &frame.stiffness - &frame.numerical;
    let mut specimen = &declared * vary.stiffness;
    let scale = config.timing.time_scale;
    // Phase of the error at the first natural frequency; what C_cor would have to be is K sin(phi) / omega.
    let omega = frame.omega[0];
    let forces = &specimen * &frame.shape;
    for (j, late_s) in late_s.iter().enumerate() {
        let phase = omega * late_s / scale;
        let share = match c.kind.force.linear(c, physical) {
            // The whole way that is left, with the stiffness that the specimen has.
            LinearForce::AtTarget | LinearForce::Damping { within: None } => 1.0,
            LinearForce::Damping {
                within: Some([below, above]),
            } => {
                let wanted = forces[j] / frame.shape[j] * phase.sin() / omega;
                let unit = declared[(j, j)] * 1e-3 * c.delay_ms.at(j) / scale;
                let allowed = wanted.clamp(unit * below, unit * above);
                if wanted == 0.0 { 1.0 } else { allowed / wanted }
            }
            LinearForce::Measured => 0.0,
        };
        specimen.row_mut(j).scale_mut(share);
    }
    specimen
}
