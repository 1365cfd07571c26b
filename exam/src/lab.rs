//! A rig as it is and as it is declared.

use crate::declared::{Declared, DeclaredActuator, DeclaredSpecimen, Parameter};
use crate::draws::Draws;
use crate::rig::Truth;
use crate::size::Sensitivity;

/// A rig: its true values, and the declared model, which is wrong within its tolerances.
#[derive(Clone, Debug)]
pub(crate) struct Lab {
    pub(crate) truth: Truth,
    pub(crate) declared: Declared,
}

/// What a model does not declare, so that it is missing if the rig has it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Undeclared {
    pub(crate) offset_mm: bool,
    pub(crate) offset_n: bool,
    pub(crate) damping: bool,
    pub(crate) mass: bool,
}

impl Lab {
    /// Draws a rig. It has nothing that the model does not declare, apart from what will be hidden in it.
    pub(crate) fn draw(without: Undeclared, rng: &mut Draws) -> Self {
        let k = rng.log_between(80.0, 1200.0);
        let damped = rng.chance(0.5) && !without.damping;
        let massive = rng.chance(0.4) && !without.mass;
        let has = |is: bool, value: f64| if is { value } else { 0.0 };
        let truth = Truth {
            gain: 1.0 + rng.between(-0.02, 0.02),
            delay_s: 1e-3 * rng.between(2.0, 8.0),
            lag_s: 1e-3 * rng.between(8.0, 25.0),
            offset_mm: has(!without.offset_mm, rng.between(-0.1, 0.1)),
            stiffness_n_per_mm: k,
            damping_n_s_per_mm: has(damped, k * rng.log_between(1e-3, 8e-3)),
            mass_kg: has(massive, k * rng.log_between(0.01, 0.05)),
            offset_n: has(!without.offset_n, k * rng.between(-0.1, 0.1)),
        };
        let mut off = |value: f64, tolerance: f64| loop {
            let tolerances = rng.normal();
            if tolerances.abs() <= 2.0 {
                return Parameter::new(value - tolerances * tolerance, tolerance);
            }
        };
        let actuator = DeclaredActuator {
            gain: off(truth.gain, 0.01),
            delay_ms: off(1e3 * truth.delay_s, 0.25),
            lag_ms: off(1e3 * truth.lag_s, 0.7),
            offset_mm: (!without.offset_mm).then(|| off(truth.offset_mm, 0.03)),
        };
        let (c, m) = (truth.damping_n_s_per_mm, truth.mass_kg);
        let specimen = DeclaredSpecimen {
            stiffness_n_per_mm: off(k, 0.02 * k),
            damping_n_s_per_mm: damped.then(|| off(c, 0.1 * c)),
            mass_kg: massive.then(|| off(m, 0.1 * m)),
            offset_n: (!without.offset_n).then(|| off(truth.offset_n, 0.03 * k)),
        };
        let declared = Declared { actuator, specimen };
        Self { truth, declared }
    }

    /// How the actuator's declared parameters change its displacement.
    pub(crate) fn actuator_free(&self, command: &[f64]) -> Vec<Sensitivity> {
        let (t, d) = (&self.truth, &self.declared.actuator);
        let signal = |t: &Truth| t.displacement(command).1;
        let truth = signal(t);
        let mut free = vec![
            self.free(&truth, d.gain, t.gain, |t, p| t.gain += p, signal),
            self.free(
                &truth,
                d.delay_ms,
                1e3 * t.delay_s,
                |t, p| t.delay_s += 1e-3 * p,
                signal,
            ),
            self.free(
                &truth,
                d.lag_ms,
                1e3 * t.lag_s,
                |t, p| t.lag_s += 1e-3 * p,
                signal,
            ),
        ];
        if let Some(p) = d.offset_mm {
            free.push(self.free(&truth, p, t.offset_mm, |t, p| t.offset_mm += p, signal));
        }
        free
    }

    /// How the specimen's declared parameters change its force.
    pub(crate) fn specimen_free(&self, displacement: &[f64]) -> Vec<Sensitivity> {
        let (t, d) = (&self.truth, &self.declared.specimen);
        let signal = |t: &Truth| t.force(displacement).1;
        let truth = signal(t);
        let mut free = vec![self.free(
            &truth,
            d.stiffness_n_per_mm,
            t.stiffness_n_per_mm,
            |t, p| t.stiffness_n_per_mm += p,
            signal,
        )];
        if let Some(p) = d.damping_n_s_per_mm {
            let own = t.damping_n_s_per_mm;
            free.push(self.free(&truth, p, own, |t, p| t.damping_n_s_per_mm += p, signal));
        }
        if let Some(p) = d.mass_kg {
            free.push(self.free(&truth, p, t.mass_kg, |t, p| t.mass_kg += p, signal));
        }
        if let Some(p) = d.offset_n {
            free.push(self.free(&truth, p, t.offset_n, |t, p| t.offset_n += p, signal));
        }
        free
    }

    fn free(
        &self,
        truth: &[f64],
        declared: Parameter,
        own: f64,
        add: impl Fn(&mut Truth, f64),
        signal: impl Fn(&Truth) -> Vec<f64>,
    ) -> Sensitivity {
        let mut more = self.truth;
        add(&mut more, declared.tolerance);
        let off = (own - declared.value) / declared.tolerance;
        Sensitivity::new(truth, &signal(&more), off)
    }
}
