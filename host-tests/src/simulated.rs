//! Force-driven simulation of a specimen with a named Bouc-Wen element, with the diagnosed parameters.
//!
//! The field's benchmark requires it: rms of the displacement error over a held-out record (Noel and Schoukens, Hysteretic
//! benchmark with a dynamic nonlinearity, 2016).

use diagnosis::{ChannelAnswer, Recording};
use plant::Effect;

/// Steps of the integration for each sample.
const STEPS: usize = 16;

/// A mass on spring, damper and Bouc-Wen element; N, mm, s.
#[derive(Clone, Copy, Debug)]
struct Oscillator {
    stiffness: f64,
    damping: f64,
    mass: f64,
    offset: f64,
    element: f64,
    load: f64,
    unload: f64,
    exponent: f64,
}

/// Displacement, velocity, force of the element.
type State = [f64; 3];

impl Oscillator {
    /// An oscillator from an answer that names the element.
    fn of(answer: &ChannelAnswer) -> Option<Self> {
        let refitted = |name: &str| {
            answer
                .refitted
                .iter()
                .find(|r| r.name == name)
                .map(|r| r.value)
        };
        let effect = answer
            .effects
            .iter()
            .find(|e| e.name == Effect::BoucWenHysteresis)?;
        let figure = |name: &str| {
            effect
                .parameters
                .iter()
                .find(|p| p.name == name)
                .map(|p| p.value)
        };
        Some(Self {
            stiffness: refitted("stiffness_n_per_mm")?,
            damping: refitted("damping_n_s_per_mm")?,
            mass: 1e-3 * refitted("mass_kg")?,
            offset: refitted("offset_n")?,
            element: figure("stiffness_n_per_mm")?,
            load: figure("load_rate")?,
            unload: figure("unload_rate")?,
            exponent: figure("exponent")?,
        })
    }

    fn slope(&self, [x, v, f]: State, force: f64) -> State {
        let size = f.abs().powf(self.exponent);
        let gives = if v * f > 0.0 {
            1.0 - self.load * size
        } else {
            1.0 + self.unload * size
        };
        let sum = force - self.offset - self.stiffness * x - self.damping * v - f;
        [v, sum / self.mass, self.element * gives * v]
    }

    /// One classical Runge-Kutta step; `force` at its start, middle and end.
    fn step(&self, s: State, force: [f64; 3], h: f64) -> State {
        let along = |s: State, k: State, by: f64| std::array::from_fn(|i| s[i] + by * k[i]);
        let a = self.slope(s, force[0]);
        let b = self.slope(along(s, a, 0.5 * h), force[1]);
        let c = self.slope(along(s, b, 0.5 * h), force[1]);
        let d = self.slope(along(s, c, h), force[2]);
        std::array::from_fn(|i| s[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]))
    }
}

/// A cubic through four neighbours, between the middle ones.
fn between(y: [f64; 4], u: f64) -> f64 {
    let [a, b, c, d] = y;
    b + 0.5 * u * (c - a + u * (2.0 * a - 5.0 * b + 4.0 * c - d + u * (3.0 * (b - c) + d - a)))
}

/// Rms of measured minus simulated displacement from `from_s`, m; the simulation starts with the record. `None` if the
/// answer has no such element or a signal is missing.
pub fn displacement_error_m(
    answer: &ChannelAnswer,
    record: &Recording,
    from_s: f64,
) -> Option<f64> {
    let rig = Oscillator::of(answer)?;
    let (x, force) = (record.displacement_mm.as_ref()?, record.force_n.as_ref()?);
    let h = record.interval_s();
    let n = x.len();
    let mut state = [x[0], (x[1] - x[0]) / h, 0.0];
    let (mut sum, mut count) = (0.0, 0.0);
    for i in 0..n {
        if record.time_s[i] >= from_s {
            sum += (x[i] - state[0]).powi(2);
            count += 1.0;
        }
        let near = [
            i.saturating_sub(1),
            i,
            (i + 1).min(n - 1),
            (i + 2).min(n - 1),
        ];
        let near = near.map(|j| force[j]);
        for k in 0..STEPS {
            let at = |u: f64| between(near, (k as f64 + u) / STEPS as f64);
            state = rig.step(state, [at(0.0), at(0.5), at(1.0)], h / STEPS as f64);
        }
    }
    Some(1e-3 * f64::sqrt(sum / f64::max(count, 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_its_element_it_is_an_oscillator_that_answers_as_its_equation_says() {
        let (k, m, h) = (50.0, 2e-3, 1e-3);
        let rig = Oscillator {
            stiffness: k,
            damping: 0.0,
            mass: m,
            offset: 0.0,
            element: 0.0,
            load: 0.0,
            unload: 0.0,
            exponent: 1.0,
        };
        let omega = f64::sqrt(k / m);
        let mut state = [1.0, 0.0, 0.0];
        for i in 1..500 {
            for _ in 0..STEPS {
                state = rig.step(state, [0.0; 3], h / STEPS as f64);
            }
            assert!(
                (state[0] - (omega * i as f64 * h).cos()).abs() < 1e-6,
                "{i}"
            );
        }
    }

    #[test]
    fn a_loop_closes_on_the_force_that_its_rates_lead_to() {
        let rig = Oscillator {
            stiffness: 0.0,
            damping: 0.0,
            mass: 1.0,
            offset: 0.0,
            element: 50.0,
            load: 0.1,
            unload: 0.1,
            exponent: 1.0,
        };
        let mut force = 0.0;
        for _ in 0..10_000 {
            force += 1e-3 * rig.slope([0.0, 1.0, force], 0.0)[2];
        }
        assert!((force - 10.0).abs() < 1e-6, "{force}");
    }
}
