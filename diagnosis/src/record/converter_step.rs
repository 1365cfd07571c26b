//! The steps of a converter, read from the values themselves.

/// Fewest samples per distinct value of a coarse converter.
const FEW: usize = 100;

/// The step of which the differences of `x` are multiples, if there is one that matters.
pub fn step(x: &[f64]) -> Option<f64> {
    let mut sorted = x.to_vec();
    sorted.sort_by(f64::total_cmp);
    let whole = sorted[sorted.len() - 1] - sorted[0];
    let room = 1e-9 * whole;
    let mut gaps: Vec<f64> = sorted
        .windows(2)
        .map(|w| w[1] - w[0])
        .filter(|g| *g > room)
        .collect();
    if gaps.len() < 3 {
        return None;
    }
    let few = gaps.len() * FEW < x.len();
    gaps.sort_by(f64::total_cmp);
    if few && gaps[gaps.len() / 4] > 0.5 * gaps[gaps.len() / 2] {
        // So few values for so many samples are steps, even if they are not all equal.
        return Some(whole / gaps.len() as f64).filter(|step| {
            let mean = gaps.iter().sum::<f64>() / gaps.len() as f64;
            gaps[gaps.len() / 2] > 0.5 * mean && *step > 0.0
        });
    }
    // The smallest gap may be rounding of the file's digits: the tenth percentile is a whole step of a lattice.
    let guess = gaps[gaps.len() / 10];
    let fits = |q: f64| {
        let near = |g: &&f64| ((**g / q) - (**g / q).round()).abs() < 0.12;
        gaps.iter().take(2000).filter(near).count() as f64 / gaps.len().min(2000) as f64
    };
    // On a fine lattice neighbouring values of a random signal are one step apart; otherwise they lie anywhere.
    (fits(guess) > 0.95 && gaps[gaps.len() / 2] < 40.0 * guess).then_some(guess)
}

/// Possible error of the step of `x`: the deviation of its values from a lattice of this step, divided by the number of
/// steps between the outermost.
pub fn unevenness(x: &[f64], step: f64) -> f64 {
    let off = |v: &f64| (v - x[0]) - ((v - x[0]) / step).round() * step;
    let farthest = x.iter().map(|v| off(v).abs()).fold(0.0, f64::max);
    let steps = (crate::record::recording::range(x) / step).round().max(1.0);
    2.0 * farthest / steps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lattice_is_seen_and_a_smooth_signal_has_none() {
        let x: Vec<f64> = (0..5000).map(|i| 3.0 * (i as f64 * 0.01).sin()).collect();
        assert_eq!(step(&x), None);
        let q = 0.05;
        let rounded: Vec<f64> = x.iter().map(|x| (x / q).round() * q).collect();
        assert!((step(&rounded).unwrap() / q - 1.0).abs() < 1e-6);
        // Unequal steps.
        let uneven: Vec<f64> = (0..20_000)
            .map(|i| (3.0 * (f64::from(i) * 0.01).sin() / q).floor())
            .map(|n| q * (n + 0.1 * (1.7 * n).sin()))
            .collect();
        assert!((step(&uneven).unwrap() / q - 1.0).abs() < 0.02);
    }
}
