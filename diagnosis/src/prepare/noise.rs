//! The noise floor, from rests or from above the motion's band: a whitening filter and the noise level.

mod above;
pub mod hum;
pub mod neighbours;
mod quiet;

use self::above::Above;
use crate::numbers::linear::dot;
use crate::numbers::signals::{add_scaled, averaged, rms};
use crate::record::spectrum::line_hz;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Noise of a channel.
#[derive(Clone, Debug)]
pub struct Noise {
    /// Its rms, in the channel's unit.
    pub rms: f64,
    /// How it was determined.
    pub from: NoiseSource,
    /// Number of samples averaged into one before fitting: a rig moves far below half of that rate.
    pub every: usize,
    /// Autoregressive coefficients: `e_t = (r_t - sum a_i r_{t-i}) / innovation_rms` is white.
    coefficients: Vec<f64>,
    innovation_rms: f64,
    /// The rest segments from which it was learnt, averaged.
    at_rest: Vec<Vec<f64>>,
}

/// As many samples of noise like that of a motion's reading; none if it is too short for a spectrum.
pub fn like(reading: &[f64], interval_s: f64, samples: usize) -> Option<Vec<f64>> {
    let above = Above::of(reading, reading, interval_s, None)?;
    let most = neighbours::rms(reading, reading, interval_s);
    Some(at_most(above.sample(samples, interval_s), most))
}

/// How the noise was determined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseSource {
    /// From a segment in which nothing moves.
    Rest,
    /// From the difference between one period of the motion and the next.
    Repeats,
    /// From the spectrum above the band of the motion.
    AboveMotion,
    /// From the same, but it does not look like noise alone: a guess.
    Guess,
}

impl NoiseSource {
    /// The note for an answer.
    pub const fn note(self) -> Option<&'static str> {
        match self {
            Self::Rest => None,
            Self::Repeats => Some(
                "The noise is what one period of the motion differs by from the next: the record has no rest.",
            ),
            Self::AboveMotion => Some(
                "The noise is what the record has above the band of the motion: it has no rest and no repeats.",
            ),
            Self::Guess => Some(
                "The noise is not known without a rest: what the record has above the band of the motion is not alike \
                 enough for noise alone, so the stated floor is a guess. Record a second of rest before the motion.",
            ),
        }
    }
}

/// Largest order of the autoregressive model.
const ORDER: usize = 8;
/// Sampling rate after averaging, Hz: it still contains mains hum and its third harmonic.
const RATE_HZ: f64 = 500.0;
/// Fraction of the noise that is taken as white in any case: if the rest shows hardly any noise, a slightly wrong model
/// would otherwise dominate the fit.
const WHITE: f64 = 0.01;

impl Noise {
    /// From `segments` of residual at rest. Their means and mains lines are not noise; `least_rms` is what the
    /// converter's steps alone would make, so that a perfectly constant channel has a floor, too.
    pub fn at_rest(segments: &[Vec<f64>], interval_s: f64, least_rms: f64) -> Self {
        let every = (1.0 / (RATE_HZ * interval_s)).round().max(1.0) as usize;
        let clean: Vec<Vec<f64>> = segments
            .iter()
            .map(|s| without_lines(without_trend(s), interval_s))
            .collect();
        let whole = clean.iter().map(Vec::len).sum::<usize>();
        let square: f64 = clean.iter().map(|s| dot(s, s)).sum();
        let least = (least_rms * least_rms).max(f64::MIN_POSITIVE);
        let variance = (square / whole as f64).max(least);
        let clean: Vec<Vec<f64>> = clean.iter().map(|s| averaged(s, every)).collect();
        let (coefficients, innovation) = whitener(&clean, least / every as f64);
        Self {
            rms: variance.sqrt(),
            from: NoiseSource::Rest,
            every,
            coefficients,
            innovation_rms: innovation.sqrt(),
            at_rest: clean,
        }
    }

    /// From residuals above the band of the input motion, segment by segment; `None` if they are too short for a
    /// spectrum.
    pub fn without_rest(
        residuals: &[Vec<f64>],
        inputs: &[&[f64]],
        interval_s: f64,
        least_rms: f64,
    ) -> Option<Self> {
        let (sample, sure) = above(residuals, inputs, interval_s, None)?;
        let from = if sure {
            NoiseSource::AboveMotion
        } else {
            NoiseSource::Guess
        };
        Some(Self::at_rest(&[sample], interval_s, least_rms).with_source(from))
    }

    /// Variance of means of `of` samples of the record.
    pub fn variance_of_means(&self, of: usize) -> f64 {
        let whole = self.rms * self.rms;
        if of <= 1 {
            return whole;
        }
        let more = (of as f64 / self.every as f64).round().max(1.0) as usize;
        let means: Vec<Vec<f64>> = self.at_rest.iter().map(|s| averaged(s, more)).collect();
        let own = rms(&means).powi(2);
        // Between two rates the variance of means is a power of their number.
        let known = (self.every * more) as f64;
        let exponent = (own / whole).ln() / known.ln().max(f64::MIN_POSITIVE);
        let at = whole * (of as f64).powf(exponent.clamp(-1.0, 0.0));
        if own > 0.0 && known > 1.0 { at } else { whole }
    }

    /// What it is in means over all samples if only this share of them was measured and the others count as 0.
    pub fn of_share(mut self, share: f64) -> Self {
        let by = share.sqrt();
        self.rms *= by;
        self.innovation_rms *= by;
        let all = self.at_rest.iter_mut().flatten();
        all.for_each(|x| *x *= by);
        self
    }

    /// The same noise, attributed to another source.
    pub fn with_source(self, from: NoiseSource) -> Self {
        Self { from, ..self }
    }

    /// White with variance 1 if `r` is this noise, averaged over [`Self::every`] samples; the samples that the filter
    /// needs to start are omitted.
    pub fn whiten_into(&self, r: &[f64], out: &mut Vec<f64>) {
        let r = averaged(r, self.every);
        let p = self.coefficients.len().min(r.len());
        let scale = 1.0 / self.innovation_rms;
        let start = out.len();
        out.extend(r[p..].iter().map(|r| r * scale));
        // One coefficient at a time over the whole segment, which the processor can vectorise.
        for (i, a) in self.coefficients.iter().enumerate() {
            let before = &r[p - 1 - i..r.len() - 1 - i];
            add_scaled(&mut out[start..], before, -a * scale);
        }
    }
}

/// Noise rms in residuals at quiet times, from above the band of the input motion and above `free_hz`; `None` if they
/// are too short for a spectrum.
pub fn at_quiet_times(
    residuals: &[Vec<f64>],
    inputs: &[&[f64]],
    interval_s: f64,
    free_hz: f64,
) -> Option<f64> {
    let (sample, _) = above(residuals, inputs, interval_s, Some(free_hz))?;
    Some(rms(&[sample]))
}

/// A noise sample from the longest residual's spectrum above its motion, and whether it looks like noise alone.
fn above(
    residuals: &[Vec<f64>],
    inputs: &[&[f64]],
    interval_s: f64,
    quiet_hz: Option<f64>,
) -> Option<(Vec<f64>, bool)> {
    let longest = (0..residuals.len()).max_by_key(|i| residuals[*i].len())?;
    let (residual, input) = (&residuals[longest], inputs[longest]);
    let above = Above::of(residual, input, interval_s, quiet_hz)?;
    let sample = above.sample(residual.len(), interval_s);
    let most = neighbours::rms(residual, input, interval_s);
    Some((at_most(sample, most), above.sure))
}

/// A sample of noise scaled down to a known rms: the spectrum above a motion also contains its harmonics.
fn at_most(mut sample: Vec<f64>, most: Option<f64>) -> Vec<f64> {
    let seen = rms(std::slice::from_ref(&sample));
    if let Some(most) = most.filter(|m| *m < seen) {
        sample.iter_mut().for_each(|s| *s *= most / seen);
    }
    sample
}

/// Removes mean and slope: drift at rest is not noise either.
pub fn without_trend(x: &[f64]) -> Vec<f64> {
    let n = x.len() as f64;
    let mean = x.iter().sum::<f64>() / n;
    let centre = 0.5 * (n - 1.0);
    let (mut up, mut square) = (0.0, 0.0);
    for (i, x) in x.iter().enumerate() {
        let t = i as f64 - centre;
        up += t * x;
        square += t * t;
    }
    let slope = up / square.max(1.0);
    x.iter()
        .enumerate()
        .map(|(i, x)| x - mean - slope * (i as f64 - centre))
        .collect()
}

/// Power over the median at which a spectral line counts.
pub const PROMINENT: f64 = 60.0;

/// Removes the mains line and its third harmonic, if present.
fn without_lines(mut x: Vec<f64>, interval_s: f64) -> Vec<f64> {
    let Some((hz, prominence)) = line_hz(&x, interval_s, 44.0, 66.0) else {
        return x;
    };
    if prominence < PROMINENT {
        return x;
    }
    let best = between_bins(&x, interval_s, hz);
    for harmonic in [best, 3.0 * best] {
        if harmonic * interval_s < 0.45 {
            let (c, s) = quadratures(&x, interval_s, harmonic);
            for (i, x) in x.iter_mut().enumerate() {
                let phase = TAU * harmonic * i as f64 * interval_s;
                *x -= c * phase.cos() + s * phase.sin();
            }
        }
    }
    x
}

/// Refined frequency of a line, Hz, from that of its bin, which is too coarse over a second or two.
pub fn between_bins(x: &[f64], interval_s: f64, bin_hz: f64) -> f64 {
    let power = |hz: f64| {
        let (c, s) = quadratures(x, interval_s, hz);
        c * c + s * s
    };
    let width = 1.0 / (x.len() as f64 * interval_s);
    let near = (-20..=20).map(|i| bin_hz + width * f64::from(i) / 20.0);
    near.max_by(|a, b| power(*a).total_cmp(&power(*b)))
        .unwrap_or(bin_hz)
}

fn quadratures(x: &[f64], interval_s: f64, hz: f64) -> (f64, f64) {
    let (mut c, mut s) = (0.0, 0.0);
    for (i, x) in x.iter().enumerate() {
        let phase = TAU * hz * i as f64 * interval_s;
        c += x * phase.cos();
        s += x * phase.sin();
    }
    let scale = 2.0 / x.len() as f64;
    (c * scale, s * scale)
}

/// The autoregressive model of noise at rest and its residual mean square; `least`, what the converter adds to a
/// constant channel, is white.
fn whitener(at_rest: &[Vec<f64>], least: f64) -> (Vec<f64>, f64) {
    let samples = at_rest.iter().map(Vec::len).sum::<usize>().max(1);
    let mut cov = [0.0; ORDER + 1];
    for s in at_rest {
        for (lag, c) in cov.iter_mut().enumerate() {
            *c += dot(&s[lag.min(s.len())..], &s[..s.len() - lag.min(s.len())]);
        }
    }
    cov.iter_mut().for_each(|c| *c /= samples as f64);
    cov[0] = cov[0].max(least);
    autoregressive(&cov, samples)
}

/// Yule-Walker equations; order by Akaike's criterion.
fn autoregressive(cov: &[f64; ORDER + 1], samples: usize) -> (Vec<f64>, f64) {
    let mut best = (Vec::new(), cov[0], samples as f64 * cov[0].ln());
    for order in 1..=ORDER {
        let matrix = DMatrix::from_fn(order, order, |i, j| {
            cov[i.abs_diff(j)] + if i == j { WHITE * cov[0] } else { 0.0 }
        });
        let right = DVector::from_fn(order, |i, _| cov[i + 1]);
        let Some(factor) = matrix.cholesky() else {
            break;
        };
        let a = factor.solve(&right);
        // For the actual noise, filtered by the model of the noise with the white part added.
        let own = DMatrix::from_fn(order, order, |i, j| cov[i.abs_diff(j)]);
        let innovation = (cov[0] - 2.0 * a.dot(&right) + (&own * &a).dot(&a)).max(1e-6 * cov[0]);
        let criterion = samples as f64 * innovation.ln() + 2.0 * order as f64;
        if criterion < best.2 - 2.0 {
            best = (a.iter().copied().collect(), innovation, criterion);
        }
    }
    (best.0, best.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn coloured_noise_becomes_white_with_variance_one() {
        let mut rng =
            <rand_xoshiro::Xoshiro256PlusPlus as rand_core::SeedableRng>::seed_from_u64(1);
        let mut r = vec![0.0; 40_000];
        for t in 2..r.len() {
            let e: f64 = StandardNormal.sample(&mut rng);
            r[t] = 1.2 * r[t - 1] - 0.5 * r[t - 2] + 0.01 * e;
        }
        let hum = |t: usize| 0.2 * (TAU * 50.2 * t as f64 * 1e-3).sin();
        let rest: Vec<f64> = r[..4000]
            .iter()
            .enumerate()
            .map(|(t, r)| 5.0 + r + hum(t))
            .collect();
        let noise = Noise::at_rest(&[rest], 1e-3, 0.0);
        let mut e = Vec::new();
        noise.whiten_into(&r[4000..], &mut e);
        assert_eq!(noise.every, 2);
        let variance = dot(&e, &e) / e.len() as f64;
        let lag1 = dot(&e[1..], &e[..e.len() - 1]) / dot(&e, &e);
        assert!((variance - 1.0).abs() < 0.12, "{variance}");
        // The fraction taken as white leaves a trace.
        assert!(lag1.abs() < 0.1, "{lag1}");
    }

    /// A force of 16 s at 250 Hz without a rest: a slightly wrong spring, friction, a cubic spring, and noise.
    fn stated_over_true(seed: u64) -> f64 {
        let mut rng =
            <rand_xoshiro::Xoshiro256PlusPlus as rand_core::SeedableRng>::seed_from_u64(seed);
        let mut normal = move || -> f64 { StandardNormal.sample(&mut rng) };
        let unit = |n: f64| 0.5 + 0.5 * (n / 2.0).tanh();
        let (n, h) = (4000, 4e-3);
        let tones: Vec<[f64; 2]> = (0..5)
            .map(|_| [0.2 + 1.8 * unit(normal()), 6.0 * normal()])
            .collect();
        let x: Vec<f64> = (0..n)
            .map(|i| {
                tones
                    .iter()
                    .map(|[f, p]| (TAU * f * i as f64 * h + p).sin())
                    .sum()
            })
            .collect();
        // White to a corner at a tenth of the rate.
        let keep = 0.6 * unit(normal());
        let (off, dry, cubic) = (2.0 * normal(), 3.0 * unit(normal()), 0.3 * normal());
        let (mut low, mut square) = (0.0, 0.0);
        let mut slides = 0.0_f64;
        let residual: Vec<f64> = (0..n)
            .map(|i| {
                low = keep * low + normal();
                square += low * low;
                slides = (slides + (x[i] - x[i.saturating_sub(1)]) / 0.02).clamp(-1.0, 1.0);
                low + off * x[i] + dry * slides + cubic * x[i].powi(3)
            })
            .collect();
        let noise = Noise::without_rest(&[residual], &[x.as_slice()], h, 0.0).unwrap();
        noise.rms / (square / n as f64).sqrt()
    }

    /// Fraction of records whose stated noise is within a factor of 1.3 of the true one.
    fn within(records: std::ops::Range<u64>) -> f64 {
        let all: Vec<f64> = records.map(stated_over_true).collect();
        let near = all.iter().filter(|r| (1.0 / 1.3..1.3).contains(*r)).count();
        println!(
            "{near} of {} within 1.3; {:?}",
            all.len(),
            all.iter().take(10).collect::<Vec<_>>()
        );
        near as f64 / all.len() as f64
    }

    #[test]
    fn the_noise_without_a_rest_is_within_a_third_also_beside_what_the_model_lacks() {
        assert!(within(0..25) >= 0.95);
    }

    #[test]
    fn the_noise_of_five_hundred_records_without_a_rest_is_within_a_third() {
        assert!(within(1000..1500) >= 0.95);
    }
}
