//! If a model leaves nothing but noise, every sample counts: the rig is described by the table, and models that leave
//! more than noise allows are wrong.
//!
//! The score counts a record as few samples, since a residual is mostly the error of a law. That is not so if the best
//! model leaves noise: then a spring that stiffens by nothing is no rival of a gain, however alike their blocks are.

use super::score::LEAVES_NOISE;
use super::specimen::{SpecimenData, SpecimenModelFit};
use rayon::prelude::*;

/// If some model's structure is below this fraction of the noise, the rig is described by the table.
pub const ONE_OF_THE_TABLE: f64 = 0.5;
/// Number of samples that count as one: noise is not white, and no law is exact.
const COUNT_AS_ONE: f64 = 8.0;
/// Most evidence that samples can give against a model, nats.
const AT_MOST: f64 = 16.0;

impl SpecimenData<'_> {
    /// Counts all samples as evidence against models of one law that leave more than the best of them, if that leaves
    /// noise. They cannot tell one law from two: a second law absorbs the timing error of turns in a smoothed motion.
    pub fn weigh_samples(&self, fits: &mut [SpecimenModelFit]) {
        let one = |f: &&SpecimenModelFit| f.terms.len() == 1;
        let near = |f: &SpecimenModelFit| one(&f) && f.evidence.left_rms() < LEAVES_NOISE;
        let left = fits.iter().filter(one).map(|f| f.evidence.left_rms());
        if left.fold(f64::INFINITY, f64::min) > ONE_OF_THE_TABLE {
            return;
        }
        let costs: Vec<Option<(f64, usize)>> = fits
            .par_iter()
            .map(|f| near(f).then(|| self.settled_cost(f)))
            .collect();
        let samples = self.target().len() as f64;
        let least = costs.iter().flatten().map(|c| c.0);
        // The noise of this record, if a rest indicates another.
        let own = (least.fold(f64::INFINITY, f64::min) / samples).max(1.0);
        let counted = samples / COUNT_AS_ONE;
        let against = |(cost, unknowns): (f64, usize)| {
            0.5 * cost / own / COUNT_AS_ONE + 0.5 * unknowns as f64 * counted.ln()
        };
        let all: Vec<Option<f64>> = costs.into_iter().map(|c| c.map(against)).collect();
        let best = all.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        for (fit, against) in fits.iter_mut().zip(all).filter(|f| f.0.terms.len() == 1) {
            let against = against.map_or(AT_MOST, |a| a - best);
            fit.evidence.against = against.clamp(0.0, AT_MOST);
        }
    }
}
