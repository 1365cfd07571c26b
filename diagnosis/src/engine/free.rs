//! The unnamed rival: free functions of displacement and speed, memory of any yield, relaxation and slow change, added
//! to any model. If it predicts left-out blocks as well as a law, less its price, other laws are possible.

use super::gram::judged;
use super::motion::Motion;
use super::score::{BLOCKS, Evidence};
use super::specimen::{SpecimenData, SpecimenModelFit};
use crate::laws::specimen::track::Track;
use crate::numbers::bounded::Equations;
use crate::numbers::linear::Bound;
use crate::numbers::operators::{relaxed, slider, travel};

/// Its price, nats: it beats a name of the usual price 3 if it leaves under half (0.44) of that name's squares.
const PRICE: f64 = 9.5;
/// Knots over the displacement, in half ranges.
const PLACES: [f64; 9] = [-1.0, -0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75, 1.0];
/// Knots over the speed, in top speeds. Steeper ones would be friction, and indistinguishable from a name.
const SPEEDS: [f64; 7] = [-1.0, -0.6, -0.2, 0.0, 0.2, 0.6, 1.0];
/// Yields of sliders, in half ranges; each also with a force proportional to the distance from the middle.
const YIELDS: [f64; 4] = [0.05, 0.15, 0.4, 0.8];
/// Time constants, in half ranges over the top speed.
const RELAXES: [f64; 3] = [0.3, 1.5, 6.0];

/// The hat function of a knot at `u`; beyond the ends it counts as at the end.
fn hat(u: f64, knots: &[f64], i: usize) -> f64 {
    let u = u.clamp(knots[0], knots[knots.len() - 1]);
    let side = if u < knots[i] {
        i.checked_sub(1)
    } else {
        Some(i + 1)
    };
    side.and_then(|j| knots.get(j)).map_or_else(
        || f64::from(u8::from(u == knots[i])),
        |far| (1.0 - (u - knots[i]) / (far - knots[i])).max(0.0),
    )
}

impl SpecimenData<'_> {
    /// The rival's columns.
    pub fn free(&self) -> Vec<Vec<f64>> {
        self.stacked(|m: &Motion| self.free_over(&m.track))
    }

    fn free_over(&self, t: &Track) -> Vec<Vec<f64>> {
        let s = &self.sizes.motion;
        let place = |x: &f64| (x - s.middle) / s.x;
        let of = |signal: &[f64], f: &dyn Fn(&f64) -> f64| signal.iter().map(f).collect();
        let mut all: Vec<Vec<f64>> = Vec::new();
        all.extend((0..PLACES.len()).map(|i| of(&t.x, &|x| hat(place(x), &PLACES, i))));
        all.extend((0..SPEEDS.len()).map(|i| of(&t.v, &|v| hat(v / s.v, &SPEEDS, i))));
        for y in YIELDS {
            let slides = slider(&t.x, y * s.x);
            let away = slides.iter().zip(&t.x).map(|(z, x)| z * place(x).abs());
            all.push(away.collect());
            all.push(slides);
        }
        all.extend(RELAXES.map(|tau| relaxed(&t.x, tau * s.x / s.v, t.interval_s)));
        let way = travel(&t.v, t.interval_s, t.travel_before_mm);
        let worn = t.x.iter().zip(way).map(|(x, w)| x * w / s.travel);
        all.push(worn.collect());
        all
    }

    /// The evidence for a model with the rival's columns added.
    pub fn beside_free(&self, fit: &SpecimenModelFit, free: &[Vec<f64>]) -> Option<Evidence> {
        let mut columns = self.columns_on(&fit.terms, &fit.acts_on());
        let mut bounds = self.bounds(&fit.terms);
        let own = columns.len();
        columns.extend(free.iter().cloned());
        bounds.resize(columns.len(), Bound::FREE);
        let mut parts: Vec<Equations> = self.parts(&columns, &self.target);
        parts.iter_mut().for_each(|p| p.soft = own);
        let ties = self.ties(|i| self.frees(&fit.terms, i));
        let first: [f64; BLOCKS] = self.score.weights(&self.left_by(fit));
        let fitted = judged(&parts, &bounds, &ties, &self.score, &first)?;
        let price = fit.evidence.price + PRICE;
        Some(self.score.evidence(&fitted.left_out, price))
    }

    /// Residual squares of a fit on each block.
    fn left_by(&self, fit: &SpecimenModelFit) -> [f64; BLOCKS] {
        std::array::from_fn(|b| {
            let above = 1.0 + fit.evidence.left[b];
            above * self.score.noise * self.score.samples[b]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hats_add_up_to_one_everywhere() {
        for i in -30..=30 {
            let u = f64::from(i) / 20.0;
            let whole: f64 = (0..SPEEDS.len()).map(|k| hat(u, &SPEEDS, k)).sum();
            assert!((whole - 1.0).abs() < 1e-12, "{u}: {whole}");
        }
    }
}
