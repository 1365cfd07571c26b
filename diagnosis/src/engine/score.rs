//! The one score of the one engine: how well a model predicts blocks of the training data that it was not fitted to.
//!
//! ```text
//! score = - nu / 2 * mean over 12 blocks of ln(eps^2 + s_b^2) - price
//! s_b^2 = (mean square that is left of block b, fitted to the other eleven, - noise variance) / noise variance, not below 0
//! ```
//!
//! What is left of a record is mostly the error of the law and not noise, and such an error has no sample size: the whole record,
//! however long, counts as `nu` samples, and structure below `eps` of the noise counts as nothing (a coarsened likelihood:
//! Miller and Dunson, J. Am. Stat. Assoc. 114, 2019). Held-out records take no part: they judge what was chosen.

/// Blocks of the training data, of equal shares of the input's way.
pub const BLOCKS: usize = 12;
/// So many samples a record counts as. Twice the squares on every block are then 5.5 nats.
pub const NU: f64 = 16.0;
/// Structure below this share of the noise counts as nothing.
pub const EPS: f64 = 0.28;

/// A model that leaves less than this share of the noise leaves noise: each sample counts.
pub const LEAVES_NOISE: f64 = 1.0;

/// So many times a noise without a rest may be what the best model leaves in its quietest blocks.
const AT_MOST: f64 = 2.5;

/// The noise that a search is to know: its variance in the samples that are searched, and whether a rest tells it.
#[derive(Clone, Copy, Debug)]
pub struct KnownNoise {
    /// Variance of averaged samples.
    pub variance: f64,
    /// A rest tells it.
    pub told: bool,
}

/// So many times its variance a noise is that no rest tells, where the best model leaves so much of it in its quietest blocks.
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
    /// Variance of the noise in samples as they are searched.
    pub noise: f64,
    /// Samples of each block.
    pub samples: [f64; BLOCKS],
}

/// What speaks for a model.
#[derive(Clone, Copy, Debug)]
pub struct Evidence {
    /// Structure that is left of each block, as a share of the noise's variance.
    pub left: [f64; BLOCKS],
    /// `- nu / 2 * mean ln(eps^2 + left)`.
    pub log_density: f64,
    /// What its terms cost, nats.
    pub price: f64,
    /// What every sample by itself says against it, where another model leaves nothing but noise, nats.
    pub against: f64,
}

impl Evidence {
    /// Of a model that leaves nothing but noise, and against which every sample by itself says so much, nats.
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

    /// Structure in its third quietest block, as a share of the noise's variance.
    pub fn quiet(&self) -> f64 {
        let mut left = self.left;
        left.sort_by(f64::total_cmp);
        left[2]
    }

    /// The structure that is left, typical of the blocks, over the noise's rms.
    pub fn left_rms(&self) -> f64 {
        let mean = -2.0 * self.log_density / NU;
        (mean.exp() - EPS * EPS).max(0.0).sqrt()
    }
}

impl Score {
    /// Structure beyond the noise on each block, over the noise's variance.
    fn structure(&self, squares: &[f64; BLOCKS]) -> [f64; BLOCKS] {
        std::array::from_fn(|b| {
            let mean = squares[b] / self.samples[b].max(1.0);
            ((mean - self.noise) / self.noise).max(0.0)
        })
    }

    /// What squares on blocks left out say for a model of this price.
    pub fn evidence(&self, left_out: &[f64; BLOCKS], price: f64) -> Evidence {
        let left = self.structure(left_out);
        let logs = left.iter().map(|s| (EPS * EPS + s).ln());
        Evidence {
            left,
            log_density: -0.5 * NU * logs.sum::<f64>() / BLOCKS as f64,
            price,
            against: 0.0,
        }
    }

    /// What a declared parameter's distance from its declared value weighs beside the blocks' squares: half a nat at one tolerance.
    /// Without it a parameter that the motion hardly feels goes to an end of its tolerances.
    pub fn tie(&self, tolerance: f64) -> f64 {
        BLOCKS as f64 * self.noise / (NU * tolerance * tolerance)
    }

    /// Weights of the blocks' squares in a fit: the slope of the score.
    pub fn weights(&self, left: &[f64; BLOCKS]) -> [f64; BLOCKS] {
        let structure = self.structure(left);
        std::array::from_fn(|b| 1.0 / (self.samples[b].max(1.0) * (EPS * EPS + structure[b])))
    }
}

/// First samples of blocks of equal shares of the way, none shorter than a quarter of an even share of the samples.
pub fn edges(speeds: &[f64]) -> Vec<usize> {
    let n = speeds.len();
    let mean = speeds.iter().map(|v| v.abs()).sum::<f64>() / n.max(1) as f64;
    // A third of the share is the time's, so that slow parts are blocks, too.
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
    fn twice_the_squares_are_five_and_a_half_nats_and_less_than_the_noise_hides_is_nothing() {
        let score = Score {
            noise: 1.0,
            samples: [100.0; BLOCKS],
        };
        let of = |s: f64| score.evidence(&[100.0 * (1.0 + s); BLOCKS], 0.0);
        let fall = of(100.0).log_density - of(200.0).log_density;
        assert!((fall - 5.545).abs() < 0.01, "{fall}");
        assert!((of(0.0).log_density - of(0.005).log_density) < 0.5);
        assert!((of(9.0).left_rms() - 3.0).abs() < 1e-9);
    }
}
