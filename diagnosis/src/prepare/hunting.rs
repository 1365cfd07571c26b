//! A hunting loop: the command is constant or nearly so, but the rig moves.

use crate::criteria::{LITTLE, SWINGS};
use crate::numbers::coherence::linear_share;
use crate::numbers::signals::{deviation, rms};
use crate::prepare::noise::hum::without_hum;
use crate::record::recording::{Recording, correlation};

/// True if the specimen moves during a rest: a hunting loop swings displacement and force together, each well above its
/// sample noise. Such a force is not noise.
pub fn hunts(recording: &Recording, (first, end): (usize, usize)) -> bool {
    let (Some(x), Some(force)) = (&recording.displacement_mm, &recording.force_n) else {
        return false;
    };
    let clean = [x, force].map(|x| without_hum(x, recording)[first..end].to_vec());
    let swings = |x: &Vec<f64>| deviation(x) > SWINGS * sample_noise(x);
    let [x, force] = &clean;
    let together = || {
        let at_once = correlation(x, force).powi(2);
        linear_share(x, force).unwrap_or(0.0).max(at_once) > LITTLE
    };
    clean.iter().all(swings) && together()
}

/// Deviation of samples from a smooth curve through their neighbours, rms; for white noise its own rms.
fn sample_noise(x: &[f64]) -> f64 {
    let fourth = |w: &[f64]| w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4];
    // The squares of the weights sum to 70.
    rms(&[x.windows(5).map(fourth).collect()]) / 70.0_f64.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loop_that_hunts_is_not_at_rest_and_noise_of_the_displacement_is_no_motion() {
        let h = 1e-3;
        let noise = |i: usize, by: usize| ((i * by) % 1009) as f64 / 504.5 - 1.0;
        let record = |moves: &dyn Fn(f64) -> f64| {
            let time_s: Vec<f64> = (0..2000).map(|i| i as f64 * h).collect();
            let x: Vec<f64> = time_s.iter().map(|t| moves(*t)).collect();
            let read = |(i, x): (usize, &f64)| x + 0.01 * noise(i, 7919);
            let force = |(i, x): (usize, &f64)| 300.0 * (x / 0.05).tanh() + 15.0 * noise(i, 6007);
            Recording {
                displacement_mm: Some(x.iter().enumerate().map(read).collect()),
                force_n: Some(x.iter().enumerate().map(force).collect()),
                time_s,
                ..Recording::default()
            }
        };
        let hunting = record(&|t| 0.13 * (45.0 * t).sin());
        assert!(hunts(&hunting, (0, 1900)));
        assert!(!hunts(&record(&|_| 0.0), (0, 1900)));
        // Hum in the displacement only.
        let mut hums = record(&|_| 0.0);
        let read = hums.displacement_mm.iter_mut().flatten().enumerate();
        read.for_each(|(i, x)| *x += 0.2 * (std::f64::consts::TAU * 50.0 * i as f64 * h).sin());
        assert!(!hunts(&hums, (0, 1900)));
    }
}
