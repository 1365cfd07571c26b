//! The shape of an element: how it may change, and its bounds.

use super::element::{Element, Law};
use super::track::MotionScales;
use crate::criteria::FRICTION_YIELD;

/// How a shape changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// By factors: it stays positive.
    Log,
    /// By steps of this unit.
    Straight,
}

/// Where distributed sliders may begin, as a share of their largest yield displacement; the first yields a fifth of the way
/// further.
pub const BEGINS: std::ops::Range<f64> = -0.2..0.9;

/// Half ranges over which the growth of a stiffening loop is judged.
const MOST_GROWTH: f64 = 1.0;

/// The rates of a loop out and back, together, over the larger of them: with opposite ones the way back is the way out, which is a
/// spring, and with less it would give energy.
const DISSIPATES: f64 = 0.1;

/// Heat by the own motion over that of time beyond which the latter is none.
const MOST_OWN_HEAT: f64 = 1e3;

impl Element {
    /// The shapes that may change, and how.
    pub fn movable(&self) -> &'static [(usize, Scale)] {
        use Scale::{Log, Straight};
        match self.law {
            Law::Slider
            | Law::Bristles
            | Law::PowerOfSpeed
            | Law::Saturating
            | Law::Relaxing
            | Law::Lost
            | Law::Lessened
            | Law::Fatigued => &[(0, Log)],
            // If it has rates of its own, the give is the unit of its force.
            Law::BoucWen if self.shape[2] != 1.0 => &[(2, Straight), (3, Straight), (1, Log)],
            Law::BoucWen => &[(0, Log), (3, Straight), (1, Log)],
            Law::Distributed => &[(0, Log), (1, Straight)],
            Law::InSeries => &[(0, Log), (1, Log), (2, Log)],
            Law::PowerOfPlace => &[(0, Straight)],
            Law::SliderAway | Law::SliderAlong => &[(0, Log)],
            Law::Worn | Law::Pinched | Law::SlippingJoint | Law::Recentring => {
                &[(0, Log), (1, Log)]
            }
            Law::Beyond if self.shape[1] == 0.0 => &[(0, Log)],
            Law::Beyond if self.shape[3] > 0.0 => &[(0, Straight), (3, Log)],
            Law::Beyond => &[(0, Straight)],
            Law::Warming if self.shape[1] > 0.0 => &[(0, Log), (1, Log)],
            Law::Away if self.shape[1] > 0.0 => &[(0, Straight), (1, Log)],
            Law::Away | Law::Warming => &[],
            Law::Square | Law::SizeOfSpeed => &[],
        }
    }

    /// True if the shape is admissible for its law.
    pub fn is_sound(&self, sizes: &MotionScales) -> bool {
        let [p, q, r, s] = self.shape;
        let x = sizes.x;
        match self.law {
            Law::Slider => (1e-4 * x..=0.97 * x).contains(&p),
            // With a longer give it would be Bouc-Wen's.
            Law::Bristles => (1e-4 * x..=1.5 * FRICTION_YIELD * x).contains(&p),
            Law::BoucWen => {
                let grows = r * (MOST_GROWTH * x / p).powf(q);
                (2e-3 * x..=3.0 * x).contains(&p)
                    && (0.5..=8.0).contains(&q)
                    && (-1.0..=30.0).contains(&r)
                    && (-0.95..=30.0).contains(&s)
                    && grows > -4.0
                    && r + s > DISSIPATES * r.abs().max(s.abs())
            }
            // Longer yields would be springs of unknown state.
            Law::Distributed => (5e-3 * x..=0.97 * x).contains(&p) && BEGINS.contains(&q),
            Law::InSeries => {
                (1e-3 * x..=0.6 * x).contains(&p)
                    && (1e-3 * sizes.v..=3.0 * sizes.v).contains(&q)
                    && (1.1..=12.0).contains(&r)
            }
            Law::PowerOfSpeed => (0.1..=4.0).contains(&p),
            Law::Saturating => (3e-3 * sizes.v..=2.0 * sizes.v).contains(&p),
            Law::Relaxing => (2.0 * sizes.interval_s..=0.3 * sizes.seconds).contains(&p),
            Law::PowerOfPlace => (0.3..=7.0).contains(&p),
            Law::Lessened => (0.1..=4.0).contains(&p),
            Law::Lost => (5e-3 * x..=0.95 * x).contains(&p),
            Law::SliderAway | Law::SliderAlong => (1e-4 * x..=0.5 * x).contains(&p),
            Law::Warming => {
                p > 0.02 * sizes.seconds && p < 5.0 * sizes.seconds && q < MOST_OWN_HEAT
            }
            Law::Fatigued => p > 0.02 * sizes.travel && p < 20.0 * sizes.travel,
            Law::Worn => {
                (1e-3 * x..=0.9 * x).contains(&p)
                    && (0.1 * sizes.travel..=30.0 * sizes.travel).contains(&q)
            }
            Law::Pinched => (1e-3 * x..=0.9 * x).contains(&p) && (0.03 * x..=x).contains(&q),
            // If it returned at once it would be a spring that gives way.
            Law::Recentring => (0.02 * x..0.8 * x).contains(&p) && (0.05..0.8).contains(&q),
            // If it held less it would be a gap; if it bore nowhere, or hardly within the motion, a slider.
            Law::SlippingJoint => p.min(q) >= 0.02 * x && p + 0.5 * q < 0.65 * x,
            // A two-sided gap has no negative width; a one-sided contact lies inside the motion's range.
            Law::Beyond if q == 0.0 => (0.0..1e12).contains(&p),
            // Less damping is only the corner response of a motion without its noise.
            Law::Beyond if s > 0.0 && !(0.05..3.0).contains(&(s * sizes.v / x)) => false,
            Law::Beyond => (p - sizes.middle).abs() < 0.9 * x,
            // Narrower, it is a corner; wider, a square.
            Law::Away if q > 0.0 => {
                (p - sizes.middle).abs() < 0.9 * x && (0.01 * x..0.5 * x).contains(&q)
            }
            Law::Away | Law::Square | Law::SizeOfSpeed => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::laws;
    use super::*;
    use crate::numbers::signals::peak;

    #[test]
    fn a_loop_that_returns_on_the_way_out_is_a_spring() {
        let sizes = MotionScales {
            x: 1.0,
            ..MotionScales::default()
        };
        let x: Vec<f64> = (0..2000).map(|i| (0.01 * f64::from(i)).sin()).collect();
        // Work over the second cycle, of the largest force and the range.
        let dissipated = |load, unload| {
            let f = laws::bouc_wen(&x, 1.0, 1.0, load, unload);
            let work = (628..1256).map(|i| 0.5 * (f[i] + f[i + 1]) * (x[i + 1] - x[i]));
            work.sum::<f64>() / peak(&f)
        };
        let is_sound =
            |load, unload| Element::new(Law::BoucWen, [1.0, 1.0, load, unload]).is_sound(&sizes);
        assert!(is_sound(1.0, 0.5) && dissipated(1.0, 0.5) > 0.1);
        assert!(is_sound(-0.4, 1.0) && dissipated(-0.4, 1.0) > 0.1);
        assert!(!is_sound(-0.4, 0.4) && dissipated(-0.4, 0.4).abs() < 1e-3);
        assert!(!is_sound(0.4, -0.4) && dissipated(0.4, -0.4).abs() < 1e-3);
        assert!(!is_sound(-0.8, 0.4) && dissipated(-0.8, 0.4) < 0.0);
    }

    #[test]
    fn a_gap_is_no_narrower_than_nothing() {
        let sizes = MotionScales {
            x: 4.0,
            ..MotionScales::default()
        };
        let is_sound = |p, side| Element::new(Law::Beyond, [p, side]).is_sound(&sizes);
        assert!(is_sound(0.5, 0.0) && is_sound(0.0, 0.0) && !is_sound(-0.5, 0.0));
        assert!(is_sound(-0.5, 1.0) && is_sound(-0.5, -1.0));
    }
}
