//! A ground motion at the samples of the problem, and the response of the whole structures to it.

use super::case::{CASES, Structure};
use super::channels::Noise;
use super::criteria::Work;
use super::parameters::Specimen;
use super::size::{FLOORS, RATE_HZ};
use super::yielding::Behaviour;

/// A ground motion at the samples of the problem, scaled.
#[derive(Clone, Debug)]
pub struct Shaking {
    /// Acceleration, m/s^2; zero after its end.
    pub acc_m_per_s2: Vec<f64>,
    points_m_per_s2: Vec<f32>,
    interval_s: f64,
}

impl Shaking {
    /// A ground motion from points `interval_s` apart, m/s^2, times `scale`, by linear interpolation.
    pub fn new(points_m_per_s2: &[f32], interval_s: f64, scale: f64) -> Self {
        let end_s = points_m_per_s2.len().saturating_sub(1) as f64 * interval_s;
        let samples = (end_s * RATE_HZ).floor() as usize + 1;
        let at = |i: usize| points_m_per_s2.get(i).copied().map_or(0.0, f64::from);
        let acc_m_per_s2 = (0..samples)
            .map(|k| {
                let place = k as f64 / RATE_HZ / interval_s;
                let i = place.floor();
                let rise = at(i as usize + 1) - at(i as usize);
                scale * (at(i as usize) + (place - i) * rise)
            })
            .collect();
        Self {
            acc_m_per_s2,
            points_m_per_s2: points_m_per_s2
                .iter()
                .map(|a| (f64::from(*a) * scale) as f32)
                .collect(),
            interval_s,
        }
    }

    /// The original points, scaled, m/s^2, and their interval, s.
    pub fn points(&self) -> (&[f32], f64) {
        (&self.points_m_per_s2, self.interval_s)
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.acc_m_per_s2.len()
    }

    /// The accelerations at a sample and at the next.
    #[inline]
    pub fn pair(&self, sample: usize) -> [f64; 2] {
        let at = |i: usize| self.acc_m_per_s2.get(i).copied().unwrap_or(0.0);
        [at(sample), at(sample + 1)]
    }

    /// The references: displacements of the whole structures of all cases at each sample, m, and the total work of the
    /// specimens' forces, J.
    pub fn references(&self, behaviour: Behaviour) -> ([Vec<[f64; FLOORS]>; 4], [f64; 4]) {
        let mut specimens = CASES.map(|_| (behaviour.at_rest(), Work::default()));
        let floors = self.answers(|_, first_m| {
            let mut force_n = [0.0; 4];
            for (l, (specimen, work)) in specimens.iter_mut().enumerate() {
                let mut other_n = 0.0;
                if let Some(specimen) = specimen {
                    force_n[l] = specimen.go_to(first_m[l]);
                    other_n = specimen.other_n();
                }
                let elastic_n = Specimen::NOMINAL.stiffness_n_per_m * first_m[l];
                work.add(&[first_m[l]], &[elastic_n + other_n]);
            }
            force_n
        });
        (floors, specimens.map(|(_, work)| work.done_j[0]))
    }

    /// The motion of the whole structures caused by the noise of the force reading alone, m. No controller can have less.
    pub fn moved_by(noise: &Noise, samples: usize) -> [Vec<[f64; FLOORS]>; 4] {
        let still = Self {
            acc_m_per_s2: vec![0.0; samples],
            points_m_per_s2: Vec::new(),
            interval_s: 1.0,
        };
        still.answers(|k, _| [noise.at(k)[1]; 4])
    }

    /// The responses with a force on the first floor, N, which may depend on the sample and the first floors' displacements.
    fn answers(
        &self,
        mut force_n: impl FnMut(usize, [f64; 4]) -> [f64; 4],
    ) -> [Vec<[f64; FLOORS]>; 4] {
        let parts = CASES.map(|case| (case, case.reference()));
        let mut answers: [Vec<[f64; FLOORS]>; 4] =
            std::array::from_fn(|_| Vec::with_capacity(self.samples()));
        // The mass matrices of the problem are never singular.
        let Some(mut structures) = Structure::new(&parts) else {
            return answers;
        };
        for k in 0..self.samples() {
            let floors = structures.floors_m();
            for (l, answer) in answers.iter_mut().enumerate() {
                answer.push(floors.map(|lanes| lanes[l]));
            }
            structures.step(self.pair(k), force_n(k, floors[0]));
        }
        answers
    }
}
