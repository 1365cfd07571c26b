//! The way from target to target, between integration steps: extrapolated while the next target is not known, then the
//! cubic that meets it.

use super::blocks::StateRow;
use outerloop_core::config::Timing;

/// The command on its way through one integration step.
#[derive(Clone, Debug)]
pub struct Interpolation {
    /// Command of each axis.
    pub command: Vec<StateRow>,
    /// Its velocity, a control step.
    pub velocity: Vec<StateRow>,
    /// Its acceleration, a control step squared.
    pub acceleration: Vec<StateRow>,
    from: (Vec<StateRow>, Vec<StateRow>),
    substeps: u16,
    solve_substeps: u16,
}

impl Interpolation {
    /// At a target `u` that was reached with `q` and `s` of the step before.
    pub fn from_target(u: &[StateRow], q: &[StateRow], s: &[StateRow], timing: &Timing) -> Self {
        Self::at_target(u, q, s, timing.substeps, timing.solve_substeps)
    }

    fn at_target(
        u: &[StateRow],
        q: &[StateRow],
        s: &[StateRow],
        substeps: u16,
        solve_substeps: u16,
    ) -> Self {
        let per = 1.0 / f64::from(substeps);
        let velocity: Vec<StateRow> = q.iter().zip(s).map(|(q, s)| (q + s) * per).collect();
        Self {
            command: u.to_vec(),
            acceleration: s.iter().map(|s| s * (per * per)).collect(),
            from: (u.to_vec(), velocity.clone()),
            velocity,
            substeps,
            solve_substeps,
        }
    }

    /// The command of control step `tick` towards the next target `u`, `q + s`.
    pub fn advance(&mut self, tick: u16, u: &[StateRow], q: &[StateRow], s: &[StateRow]) {
        if tick >= self.substeps {
            *self = Self::at_target(u, q, s, self.substeps, self.solve_substeps);
            return;
        }
        let extrapolated = tick <= self.solve_substeps;
        if tick == self.solve_substeps + 1 {
            self.from = (self.command.clone(), self.velocity.clone());
        }
        let span = f64::from(self.substeps - self.solve_substeps);
        let t = f64::from(tick);
        for j in 0..u.len() {
            let (from, speed) = (&self.from.0[j], &self.from.1[j]);
            if extrapolated {
                let a = &self.acceleration[j];
                self.velocity[j] = speed + a * t;
                self.command[j] = from + speed * t + a * (0.5 * t * t);
            } else {
                let t = (t - f64::from(self.solve_substeps)) / span;
                let rise = &u[j] - from;
                let start = speed * span;
                let end = (&q[j] + &s[j]) * (span / f64::from(self.substeps));
                let square = &rise * 3.0 - &start * 2.0 - &end;
                let cube = &start + &end - &rise * 2.0;
                self.command[j] = from + &start * t + &square * (t * t) + &cube * (t * t * t);
                self.velocity[j] = (&start + &square * (2.0 * t) + &cube * (3.0 * t * t)) / span;
                self.acceleration[j] = (&square * 2.0 + &cube * (6.0 * t)) / (span * span);
            }
        }
    }
}
