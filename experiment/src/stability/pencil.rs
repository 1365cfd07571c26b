//! A free motion as a sum of `c e^(s t)`, by the matrix pencil (Hua and Sarkar, IEEE Trans. ASSP 38 (1990) 814).
//!
//! Rows of consecutive samples, each a sample later than the last, form a matrix with the exponentials' row space. A
//! shift by one sample multiplies each of them by its own factor: these are the eigenvalues of the shift.

use nalgebra::{Complex, DMatrix, DVector, Schur, SymmetricEigen};

/// A component of a free motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Component {
    /// s, 1/s: the real part is the growth rate, the imaginary part the angular frequency.
    pub rate: Complex<f64>,
    /// Its amplitude and phase at the last sample, in the unit of the samples.
    pub at_end: Complex<f64>,
}

/// Most samples in a row: twice as many components as a loop shows at once, plus some for the noise.
const MOST_IN_ROW: usize = 32;
/// Largest number of steps of the eigenvalue search: some thirty each are usual.
const SEARCHES: usize = 100_000;

/// The components of `samples`, `interval_s` apart, whose fraction of the motion exceeds `resolution`: below it are
/// rounding and what is not exponential. Empty if there is no motion, or too little.
pub fn components(samples: &[f64], interval_s: f64, resolution: f64) -> Vec<Component> {
    let peak = samples.iter().fold(0.0_f64, |p, x| p.max(x.abs()));
    let in_row = MOST_IN_ROW.min(samples.len() / 3);
    let finite = samples.iter().all(|x| x.is_finite());
    if in_row < 2 || !(peak > 0.0 && finite) {
        return Vec::new();
    }
    let samples = DVector::from_iterator(samples.len(), samples.iter().map(|x| x / peak));
    let Some(factors) = factors(&samples, in_row, resolution) else {
        return Vec::new();
    };
    let Some(at_end) = amplitudes(&samples, &factors) else {
        return Vec::new();
    };
    factors
        .into_iter()
        .zip(at_end.iter())
        .filter(|(_, c)| c.norm() > 0.0)
        .map(|(z, c)| Component {
            rate: z.ln() / interval_s,
            at_end: *c * peak,
        })
        .collect()
}

/// The factor of each component from one sample to the next.
fn factors(samples: &DVector<f64>, in_row: usize, resolution: f64) -> Option<Vec<Complex<f64>>> {
    let rows = samples.len() - in_row;
    // Squares of the singular values of the matrix of rows: f64 resolves them to 1e-8, finer than f32's own resolution.
    let products = DMatrix::from_fn(in_row + 1, in_row + 1, |i, j| {
        samples.rows(i, rows).dot(&samples.rows(j, rows))
    });
    let eigen = SymmetricEigen::try_new(products, f64::EPSILON, SEARCHES)?;
    let largest = eigen.eigenvalues.max();
    let kept: Vec<usize> = (0..=in_row)
        .filter(|&i| eigen.eigenvalues[i] > resolution * resolution * largest)
        .collect();
    let space = eigen.eigenvectors.select_columns(&kept);
    let (now, next) = (space.rows(0, in_row), space.rows(1, in_row));
    let inverse = now.into_owned().pseudo_inverse(1e-12).ok()?;
    let step = inverse * next;
    if step.iter().any(|x| !x.is_finite()) {
        return None;
    }
    let schur = Schur::try_new(step, f64::EPSILON, SEARCHES)?;
    let all = schur.complex_eigenvalues();
    Some(all.iter().copied().filter(|z| z.norm() > 0.0).collect())
}

/// Amplitudes at the last sample of the exponentials with `factors` that best fit `samples`.
fn amplitudes(samples: &DVector<f64>, factors: &[Complex<f64>]) -> Option<Vec<Complex<f64>>> {
    let last = samples.len() - 1;
    // Each column's largest value is 1, at its first or last sample.
    let columns = DMatrix::from_fn(samples.len(), factors.len(), |k, j| {
        let z: Complex<f64> = factors[j];
        let from = if z.norm() > 1.0 { last as i32 } else { 0 };
        z.powi(k as i32 - from)
    });
    let wanted = samples.map(|x| Complex::new(x, 0.0));
    let found = columns.svd(true, true).solve(&wanted, 1e-12).ok()?;
    let at_end = factors
        .iter()
        .zip(found.iter())
        .map(|(z, c)| match z.norm() > 1.0 {
            true => *c,
            false => *c * z.powi(last as i32),
        });
    Some(at_end.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_of_motions_is_taken_apart_to_what_f32_rounds() {
        let motions = [
            (Complex::new(-0.25, 12.6), Complex::new(1.0, 0.3)),
            (Complex::new(0.4, 35.0), Complex::new(0.01, -0.02)),
            (Complex::new(-3.0, 60.0), Complex::new(0.2, 0.0)),
        ];
        let interval_s = 0.0125;
        let samples: Vec<f64> = (0..160)
            .map(|k| {
                let t_s = f64::from(k) * interval_s;
                let of = |(s, c): &(Complex<f64>, Complex<f64>)| (c * (s * t_s).exp()).re;
                let sum: f64 = motions.iter().map(of).sum();
                f64::from(sum as f32)
            })
            .collect();
        let found = components(&samples, interval_s, 3e-6);
        let last_s = 159.0 * interval_s;
        for (s, c) in motions {
            let own = found.iter().find(|f| (f.rate - s).norm() < 1e-3 * s.norm());
            let own = own.unwrap_or_else(|| panic!("{s} is not among {found:?}"));
            // A real motion is a conjugate pair: each has half of it.
            let at_end = 0.5 * c * (s * last_s).exp();
            assert!((own.at_end - at_end).norm() < 1e-4, "{own:?} {at_end}");
        }
    }

    #[test]
    fn what_does_not_move_has_no_components() {
        assert!(components(&[0.0; 50], 0.01, 1e-6).is_empty());
        assert!(components(&[1.0, 2.0, 3.0], 0.01, 1e-6).is_empty());
        let not_finite = [1.0, f64::NAN, 3.0, 1.0, 2.0, 4.0, 1.0, 0.0];
        assert!(components(&not_finite, 0.01, 1e-6).is_empty());
    }
}
