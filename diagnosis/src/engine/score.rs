//! The engine's only score: how well a model predicts blocks of the training data that it was not fitted to.
//!
//! ```text
//! score = - nu / 2 * mean over 12 blocks of ln(eps^2 + s_b^2) - price
//! s_b^2 = (mean square of block b's residual, fitted to the other eleven, - noise variance) / noise variance, >= 0
//! ```
//!
//! A residual is mostly the error of the law and not noise, and such an error has no sample size. So the whole record,
//! however long, counts as `nu` samples, and structure below `eps` of the noise counts as nothing (a coarsened
//! likelihood: Miller and Dunson, J. Am. Stat. Assoc. 114, 2019). Held-out records are not used: they judge the choice.

/// Number of blocks of the training data, each with an equal share of the distance that the input travels.
pub const BLOCKS: usize = 12;
/// Number of samples that a record counts as. Twice the squares on every block are then 5.5 nats.
pub const NU: f64 = 16.0;
/// Structure below this fraction of the noise counts as nothing.
pub const EPS: f64 = 0.28;

/// A model whose structure is below this fraction of the noise leaves noise: each sample counts.
pub const LEAVES_NOISE: f64 = 1.0;

/// Factor on the prices of terms where structure of more than the usual size counts as nothing.
const COARSE: f64 = 0.3;
/// Structure of the worst block over the typical one beyond which few blocks have nearly all of it.
const FEW: f64 = 50.0;

/// Largest factor by which a noise without a rest is raised to the best model's residual in its quietest blocks, rms.
const AT_MOST: f64 = 2.5;

/// The noise given to a search: its variance in the samples searched, and whether a rest determines it.
#[derive(Clone, Copy, Debug)]
pub struct KnownNoise {
    /// Variance of the averaged samples.
    pub variance: f64,
    /// True if a rest determines it.
    pub told: bool,
}

/// Factor on the variance of a noise that no rest determines, from the best model's structure in its quiet blocks.
pub fn raised(quietest: f64) -> f64 {
    let raised = (1.0 + quietest).min(AT_MOST * AT_MOST);
    if raised > 1.2 && raised.is_finite() {
        raised
    } else {
        1.0
    }
}

/// The score's measure for one channel.
#[derive(Clone, Debug)]
pub struct Score {
    /// Noise variance of the samples as searched.
    pub noise: f64,
    /// Number of samples of each block.
    pub samples: [f64; BLOCKS],
    /// Structure below this fraction of the noise variance counts as nothing.
    hidden: f64,
}

/// The evidence for a model.
#[derive(Clone, Copy, Debug)]
pub struct Evidence {
    /// Residual structure of each block, as a fraction of the noise variance.
    pub left: [f64; BLOCKS],
    /// `- nu / 2 * mean ln(eps^2 + left)`.
    pub log_density: f64,
    /// Price of its terms, nats.
    pub price: f64,
    /// Evidence of all samples against it, used when another model leaves nothing but noise, nats.
    pub against: f64,
}

impl Evidence {
    /// Evidence for a model that leaves nothing but noise, with `against` nats of evidence from all samples.
    pub fn of_samples(against: f64, price: f64) -> Self {
        Self {
            left: [0.0; BLOCKS],
            log_density: -0.5 * NU * (EPS * EPS).ln(),
            price,
            against,
        }
    }

    /// The score, nats.
    pub fn score(&self) -> f64 {
        self.log_density - self.price - self.against
    }

    /// Structure in its worst block, as a fraction of the noise variance.
    pub fn worst(&self) -> f64 {
        self.left.into_iter().fold(0.0, f64::max)
    }

    /// True if a few blocks have nearly all of its structure: a fit may be caught there.
    pub fn is_in_few_blocks(&self) -> bool {
        let typical = (-2.0 * self.log_density / NU).exp();
        self.worst() > FEW * typical
    }

    /// Structure in its third quietest block, as a fraction of the noise variance.
    pub fn quiet(&self) -> f64 {
        let mut left = self.left;
        left.sort_by(f64::total_cmp);
        left[2]
    }

    /// Typical residual structure of a block, relative to the noise rms.
    pub fn left_rms(&self) -> f64 {
        let mean = -2.0 * self.log_density / NU;
        (mean.exp() - EPS * EPS).max(0.0).sqrt()
    }
}

impl Score {
    /// For a noise of this variance in blocks of these numbers of samples.
    pub const fn new(noise: f64, samples: [f64; BLOCKS]) -> Self {
        let hidden = EPS * EPS;
        Self {
            noise,
            samples,
            hidden,
        }
    }

    /// The same, in which structure below this fraction of the noise variance counts as nothing: plain least squares for
    /// smaller ones.
    pub const fn coarser(&self, hidden: f64) -> Self {
        Self { hidden, ..*self }
    }

    /// Structure beyond the noise on each block, relative to the noise variance.
    fn structure(&self, squares: &[f64; BLOCKS]) -> [f64; BLOCKS] {
        std::array::from_fn(|b| {
            let mean = squares[b] / self.samples[b].max(1.0);
            ((mean - self.noise) / self.noise).max(0.0)
        })
    }

    /// The evidence for a model of this price, from its squares on left-out blocks.
    pub fn evidence(&self, left_out: &[f64; BLOCKS], price: f64) -> Evidence {
        let left = self.structure(left_out);
        let logs = left.iter().map(|s| (self.hidden + s).ln());
        Evidence {
            left,
            log_density: -0.5 * NU * logs.sum::<f64>() / BLOCKS as f64,
            price,
            against: 0.0,
        }
    }

    /// Factor on the prices of terms: coarsely, what a term is worth shows only in part.
    pub const fn of_prices(&self) -> f64 {
        if self.hidden > EPS * EPS { COARSE } else { 1.0 }
    }

    /// Weight of a declared parameter's deviation from its declared value, relative to the blocks' squares: half a nat
    /// at one tolerance. Without it a parameter that hardly affects the fit would drift to a limit of its tolerances.
    pub fn tie(&self, tolerance: f64) -> f64 {
        BLOCKS as f64 * self.noise / (NU * tolerance * tolerance)
    }

    /// Weights of the blocks' squares in a fit: the gradient of the score.
    pub fn weights(&self, left: &[f64; BLOCKS]) -> [f64; BLOCKS] {
        let structure = self.structure(left);
        std::array::from_fn(|b| 1.0 / (self.samples[b].max(1.0) * (self.hidden + structure[b])))
    }
}

/// First samples of blocks of equal travel, none shorter than a quarter of an even share of the samples.
pub fn edges(speeds: &[f64]) -> Vec<usize> {
    let n = speeds.len();
    let mean = speeds.iter().map(|v| v.abs()).sum::<f64>() / n.max(1) as f64;
    // A third of a block's share is time, so that slow parts get blocks, too.
    let mut way = 0.0;
    let whole = 1.5 * mean * n as f64;
    let mut all = vec![0];
    for (i, v) in speeds.iter().enumerate() {
        way += v.abs() + 0.5 * mean;
        if all.len() < BLOCKS && way >= whole * all.len() as f64 / BLOCKS as f64 {
            all.push(i + 1);
        }
    }
    while all.len() < BLOCKS {
        all.push(n);
    }
    all.push(n);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coarser_score_weighs_blocks_alike_and_prices_less() {
        let score = Score::new(1.0, [100.0; BLOCKS]);
        let coarse = score.coarser(400.0);
        let mut left = [100.0; BLOCKS];
        left[0] = 100.0 * 401.0;
        let ratio = |s: &Score| s.weights(&left)[1] / s.weights(&left)[0];
        assert!(ratio(&score) > 5000.0 && (ratio(&coarse) - 2.0).abs() < 1e-9);
        assert!(coarse.of_prices() < score.of_prices());
        assert!(score.evidence(&left, 0.0).is_in_few_blocks());
        assert!(!score.evidence(&[40_100.0; BLOCKS], 0.0).is_in_few_blocks());
    }

    #[test]
    fn twice_the_squares_are_five_and_a_half_nats_and_less_than_the_noise_hides_is_nothing() {
        let score = Score::new(1.0, [100.0; BLOCKS]);
        let of = |s: f64| score.evidence(&[100.0 * (1.0 + s); BLOCKS], 0.0);
        let fall = of(100.0).log_density - of(200.0).log_density;
        assert!((fall - 5.545).abs() < 0.01, "{fall}");
        assert!((of(0.0).log_density - of(0.005).log_density) < 0.5);
        assert!((of(9.0).left_rms() - 3.0).abs() < 1e-9);
    }
}
