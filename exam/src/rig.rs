//! The true rig, without what is hidden.

use crate::fine::{delay, derivative, lag};

/// True values of the parameters that can be declared; units as in the names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Truth {
    pub(crate) gain: f64,
    pub(crate) delay_s: f64,
    pub(crate) lag_s: f64,
    pub(crate) offset_mm: f64,
    pub(crate) stiffness_n_per_mm: f64,
    pub(crate) damping_n_s_per_mm: f64,
    pub(crate) mass_kg: f64,
    pub(crate) offset_n: f64,
}

/// What effects in the actuator can see.
#[derive(Clone, Debug)]
pub(crate) struct Drive {
    /// Command after gain and transport delay, before the lag, mm.
    pub(crate) delayed: Vec<f64>,
    /// The true lag, s.
    pub(crate) lag_s: f64,
}

/// What effects in the specimen can see.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    /// mm
    pub(crate) x: Vec<f64>,
    /// mm/s
    pub(crate) v: Vec<f64>,
    /// mm/s2
    pub(crate) a: Vec<f64>,
    /// True stiffness, N/mm.
    pub(crate) k: f64,
}

/// The channel that an effect is in, as the effect sees it.
#[derive(Clone, Debug)]
pub(crate) enum Scene {
    Actuator(Drive),
    Specimen(Motion),
}

impl Truth {
    /// Command to displacement, and what effects need.
    pub(crate) fn displacement(&self, command: &[f64]) -> (Scene, Vec<f64>) {
        let scaled: Vec<f64> = command
            .iter()
            .map(|u| self.gain * u + self.offset_mm)
            .collect();
        let delayed = delay(&scaled, self.delay_s);
        let x = lag(&delayed, self.lag_s);
        let lag_s = self.lag_s;
        (Scene::Actuator(Drive { delayed, lag_s }), x)
    }

    /// Displacement to force, and what effects need.
    pub(crate) fn force(&self, x: &[f64]) -> (Scene, Vec<f64>) {
        let v = derivative(x);
        let a = derivative(&v);
        let k = self.stiffness_n_per_mm;
        let f = (0..x.len())
            .map(|i| {
                // kg mm/s2 is mN.
                k * x[i]
                    + self.damping_n_s_per_mm * v[i]
                    + 1e-3 * self.mass_kg * a[i]
                    + self.offset_n
            })
            .collect();
        let x = x.to_vec();
        (Scene::Specimen(Motion { x, v, a, k }), f)
    }
}
