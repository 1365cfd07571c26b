//! A ground motion of the problem with everything that the trials under it need, computed once.

use super::channels::Noise;
use super::criteria::{Scale, percent};
use super::rules::Rules;
use super::shaking::Shaking;
use super::size::FLOORS;
use super::trial::Ground;
use super::yielding::Behaviour;

/// A ground motion with the responses of the whole structures.
pub struct GroundRecord {
    /// Its name.
    pub name: String,
    shaking: Shaking,
    references: [Vec<[f64; FLOORS]>; 4],
    scales: [Scale; 4],
    work_j: [f64; 4],
    behaviour: Behaviour,
}

impl GroundRecord {
    /// A record from points `interval_s` apart, m/s^2, scaled by the rules. A leading `RTHSBENCH_` of the name is removed.
    pub fn new(
        name: &str,
        acc_m_per_s2: &[f32],
        interval_s: f64,
        rules: &Rules,
        behaviour: Behaviour,
    ) -> Self {
        let shaking = Shaking::new(acc_m_per_s2, interval_s, rules.ground_scale());
        let (references, work_j) = shaking.references(behaviour);
        Self {
            name: name.strip_prefix("RTHSBENCH_").unwrap_or(name).to_owned(),
            scales: std::array::from_fn(|i| Scale::of(&references[i])),
            shaking,
            references,
            work_j,
            behaviour,
        }
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.shaking.samples()
    }

    /// The ground motion at the samples.
    pub fn shaking(&self) -> &Shaking {
        &self.shaking
    }

    /// The input of a trial in the case at `place` of [`CASES`](super::case::CASES).
    pub fn ground(&self, place: usize) -> Ground<'_> {
        Ground {
            shaking: &self.shaking,
            reference_m: &self.references[place],
            behaviour: self.behaviour,
        }
    }

    /// The size of the reference response in the case at `place`.
    pub fn scale(&self, place: usize) -> &Scale {
        &self.scales[place]
    }

    /// The difference of the energy that the specimen absorbed, `work_j`, from the reference's, per cent; `None` for a
    /// linear specimen, which returns almost all of it.
    pub fn energy_error(&self, place: usize, work_j: f64) -> Option<f64> {
        let exact_j = self.work_j[place];
        (self.behaviour != Behaviour::Linear).then(|| percent((work_j - exact_j).abs(), exact_j))
    }

    /// J1 to J9 of the noise alone in every case, for a controller without any error or delay.
    pub fn floors(&self, noise: &Noise, about_mean: bool) -> [[f64; 9]; 4] {
        let moved = Shaking::moved_by(noise, self.samples());
        std::array::from_fn(|place| {
            let errors: Vec<[f64; FLOORS]> = moved[place]
                .iter()
                .enumerate()
                .map(|(k, floors)| [noise.at(k)[0] + floors[0], floors[1], floors[2]])
                .collect();
            let (of, size) = (Scale::of(&errors), &self.scales[place]);
            let share = |i| 100.0 * of.size(i, about_mean) / size.size(i, about_mean);
            let peak = |i: usize| 100.0 * of.peak_m[i] / size.peak_m[i];
            // The target is the reference here.
            [
                0.0,
                share(0),
                peak(0),
                share(0),
                peak(0),
                share(1),
                share(2),
                peak(1),
                peak(2),
            ]
        })
    }
}
