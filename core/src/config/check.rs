//! Validation: the whole configuration, once. Nothing is clamped; what cannot be accepted is refused by name.

use super::{Config, Filter, MAX_DOF, PerFloor};
use crate::force::Law;
use crate::predict::Predictor;
use crate::predict::adaptation::Learning;
use crate::refusal::{Refusal, accept, between};

impl Config {
    /// Number of degrees of freedom.
    pub fn degrees_of_freedom(&self) -> usize {
        self.structure.mass_kg.len()
    }

    /// Number of storeys, from the ground up, that stand in the laboratory.
    pub fn physical_storeys(&self) -> usize {
        let n = self.degrees_of_freedom();
        self.structure.physical_storeys.map_or(n, usize::from)
    }

    /// Checks every parameter.
    ///
    /// # Errors
    /// The first parameter that cannot be accepted, with its value and what would be.
    pub fn check(&self) -> Result<(), Refusal> {
        self.check_structure()?;
        self.check_timing()?;
        self.check_compensation()?;
        self.check_estimation()?;
        self.check_limits()?;
        self.rig.check(self.physical_storeys(), self.timing.rate_hz)
    }

    fn check_structure(&self) -> Result<(), Refusal> {
        let s = &self.structure;
        let n = s.mass_kg.len();
        let count = |name, list: &PerFloor| {
            accept(
                name,
                list.len() as f64,
                list.len() == n,
                "as many values as masses",
            )
        };
        accept(
            "structure.mass_kg",
            n as f64,
            (1..=MAX_DOF).contains(&n),
            "1 to 8 masses",
        )?;
        count("structure.stiffness_n_per_m", &s.stiffness_n_per_m)?;
        count("structure.damping_ratio", &s.damping_ratio)?;
        if !s.physical_mass_kg.is_empty() {
            count("structure.physical_mass_kg", &s.physical_mass_kg)?;
        }
        for &m in &s.mass_kg {
            between(
                "structure.mass_kg",
                m,
                0.0,
                1e9,
                "masses above 0 and below 1e9 kg",
            )?;
        }
        for &k in &s.stiffness_n_per_m {
            between(
                "structure.stiffness_n_per_m",
                k,
                0.0,
                1e13,
                "stiffnesses above 0 and below 1e13 N/m",
            )?;
        }
        for &z in &s.damping_ratio {
            accept(
                "structure.damping_ratio",
                z,
                (0.0..1.0).contains(&z),
                "ratios from 0 to below 1",
            )?;
        }
        let share = 1.0 / (self.timing.time_scale * self.timing.time_scale);
        for (&p, &m) in s.physical_mass_kg.iter().zip(&s.mass_kg) {
            accept(
                "structure.physical_mass_kg",
                p,
                p >= 0.0 && p * share < 0.9 * m,
                "masses of at least 0 whose share 1 / time_scale^2 stays below 0.9 of the floor's mass",
            )?;
        }
        let physical = self.physical_storeys();
        accept(
            "structure.physical_storeys",
            physical as f64,
            (1..=n).contains(&physical),
            "1 to the number of floors",
        )
    }

    fn check_timing(&self) -> Result<(), Refusal> {
        let t = &self.timing;
        accept(
            "loop.rate_hz",
            t.rate_hz,
            (10.0..=100_000.0).contains(&t.rate_hz),
            "10 to 100000 Hz",
        )?;
        accept(
            "loop.time_scale",
            t.time_scale,
            (0.01..=1e4).contains(&t.time_scale),
            "0.01 to 10000",
        )?;
        accept(
            "loop.substeps",
            f64::from(t.substeps),
            (1..=1000).contains(&t.substeps),
            "1 to 1000",
        )?;
        accept(
            "loop.solve_substeps",
            f64::from(t.solve_substeps),
            t.solve_substeps < t.substeps,
            "0 to one less than loop.substeps",
        )?;
        accept(
            "loop.slow_down_steps",
            f64::from(t.slow_down_steps),
            t.slow_down_steps >= 1,
            "at least 1",
        )?;
        accept(
            "loop.late_limit_steps",
            f64::from(t.late_limit_steps),
            t.late_limit_steps >= 1,
            "at least 1",
        )?;
        between(
            "loop.approach_m_per_s",
            t.approach_m_per_s,
            0.0,
            10.0,
            "above 0 and below 10 m/s",
        )?;
        between(
            "loop.hold_deceleration_m_per_s2",
            t.hold_deceleration_m_per_s2,
            0.0,
            1e6,
            "above 0 and below 1e6 m/s^2",
        )?;
        // The explicit integration is stable for omega dt < 2; below 20 steps a radian its own error shows.
        let s = &self.structure;
        let stiffest = s.stiffness_n_per_m.iter().copied().fold(0.0, f64::max);
        let lightest = s.mass_kg.iter().copied().fold(f64::INFINITY, f64::min);
        let omega_dt = 2.0 * libm::sqrt(stiffest / lightest) * self.model_step_s();
        accept(
            "loop.rate_hz",
            t.rate_hz,
            omega_dt < 2.0,
            "rates at which the highest natural frequency times the integration step stays below 2",
        )
    }

    /// What several methods share; each method checks its own.
    fn check_compensation(&self) -> Result<(), Refusal> {
        let c = &self.compensation;
        accept(
            "compensation.window_steps",
            f64::from(c.window_steps),
            (1..=crate::energy::MAX_WINDOW as u16).contains(&c.window_steps),
            "1 to 64",
        )?;
        c.delay_ms.check(
            "compensation.delay_ms",
            self.physical_storeys(),
            |ms| ms > 0.0 && ms < 1e4,
            "above 0 and below 10000 ms",
        )?;
        accept(
            "compensation.hold_share",
            c.hold_share,
            (0.0..1.0).contains(&c.hold_share),
            "0 to below 1",
        )?;
        accept(
            "compensation.lead_steps",
            c.lead_steps,
            (0.0..=8.0).contains(&c.lead_steps),
            "0 to 8",
        )?;
        for &number in &c.own {
            let accepted = "finite numbers";
            accept("compensation.own", number, number.is_finite(), accepted)?;
        }
        Learning::check(&c.adaptation)?;
        Law::<1>::check(c)?;
        Predictor::<1>::check(c, &self.timing)
    }

    fn check_estimation(&self) -> Result<(), Refusal> {
        let e = &self.estimation;
        let nyquist = self.timing.rate_hz / 2.0;
        if e.kind == Filter::LowPass {
            between(
                "estimation.cutoff_hz",
                e.cutoff_hz,
                0.0,
                nyquist,
                "above 0 and below half of loop.rate_hz",
            )?;
        }
        let longest = crate::delay_line::MAX_DELAY_STEPS as f64 / self.timing.rate_hz * 1e3;
        e.delay_ms.check(
            "estimation.delay_ms",
            self.physical_storeys(),
            |ms| (0.0..=longest).contains(&ms),
            "0 to 128 control steps",
        )?;
        e.lag_ms.check(
            "estimation.lag_ms",
            self.physical_storeys(),
            |ms| (0.05..=1e4).contains(&ms),
            "0.05 to 10000 ms",
        )?;
        accept(
            "estimation.lag_damping_ratio",
            e.lag_damping_ratio,
            (0.1..=10.0).contains(&e.lag_damping_ratio),
            "0.1 to 10",
        )?;
        between(
            "estimation.displacement_noise_m",
            e.displacement_noise_m,
            0.0,
            1.0,
            "above 0 and below 1 m",
        )?;
        between(
            "estimation.force_noise_n",
            e.force_noise_n,
            0.0,
            1e9,
            "above 0 and below 1e9 N",
        )?;
        between(
            "estimation.process_m_per_s2",
            e.process_m_per_s2,
            0.0,
            1e6,
            "above 0 and below 1e6 m/s^2",
        )?;
        between(
            "estimation.stiffness_tolerance",
            e.stiffness_tolerance,
            0.0,
            1.0,
            "above 0 and below 1",
        )?;
        accept(
            "estimation.stiffness_walk_per_s",
            e.stiffness_walk_per_s,
            (0.0..=10.0).contains(&e.stiffness_walk_per_s),
            "0 to 10",
        )
    }

    fn check_limits(&self) -> Result<(), Refusal> {
        let l = &self.limits;
        let positive = |name, value: Option<f64>| match value {
            Some(v) => between(name, v, 0.0, 1e12, "above 0 and below 1e12"),
            None => Ok(()),
        };
        positive("limits.displacement_m", l.displacement_m)?;
        positive("limits.increment_m", l.increment_m)?;
        positive("limits.velocity_m_per_s", l.velocity_m_per_s)?;
        positive("limits.force_n", l.force_n)?;
        positive("limits.tracking_m", l.tracking_m)?;
        positive("limits.energy_warning", l.energy_warning)?;
        positive("limits.energy_trip", l.energy_trip)?;
        positive("limits.energy_floor_j", l.energy_floor_j)?;
        positive("limits.locked_damping_ratio", l.locked_damping_ratio)?;
        positive("limits.frozen_m", l.frozen_m)?;
        positive("limits.disagree_m", l.disagree_m)?;
        positive("limits.force_stands_m", l.force_stands_m)?;
        positive("limits.stale_steps", l.stale_steps.map(f64::from))
    }

    /// Integration step, s of model time.
    pub fn model_step_s(&self) -> f64 {
        f64::from(self.timing.substeps) / (self.timing.rate_hz * self.timing.time_scale)
    }
}
