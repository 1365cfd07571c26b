//! The name of an element, from its shape and not from its equation.

use super::element::{Element, Law};
use super::track::MotionScales;
use crate::criteria::{
    BRISTLES, EXPONENTS, FRICTION_SPEED, FRICTION_YIELD, GIVES, MAY_BE_BRISTLES, MAY_BE_FRICTION,
    RELAXES,
};
use plant::Effect;

/// Where sliders begin, as a share of the largest yield displacement, beyond which they yield together.
const AT_ONCE: f64 = 0.5;

impl Element {
    /// Its name, from its shape. `strength` tells a stiffening spring from a softening one.
    pub fn name(&self, sizes: &MotionScales, strength: f64) -> Effect {
        let [p, q, ..] = self.shape;
        match self.law {
            Law::InSeries if self.relaxes() => Effect::MaxwellDamper,
            Law::Slider
            | Law::Bristles
            | Law::InSeries
            | Law::SliderAway
            | Law::SliderAlong
            | Law::Distributed
            | Law::BoucWen
                if self.yields_at() < FRICTION_YIELD * sizes.x =>
            {
                Effect::CoulombFriction
            }
            Law::Slider | Law::SliderAway | Law::SliderAlong => Effect::BilinearHysteresis,
            Law::Distributed if q > AT_ONCE => Effect::BilinearHysteresis,
            Law::Bristles
            | Law::BoucWen
            | Law::Distributed
            | Law::InSeries
            | Law::Worn
            | Law::Recentring
            | Law::Pinched => Effect::BoucWenHysteresis,
            Law::PowerOfSpeed if p < EXPONENTS[0] => Effect::CoulombFriction,
            Law::PowerOfSpeed if p < EXPONENTS[1] => Effect::ViscousDamping,
            Law::PowerOfSpeed => Effect::QuadraticDamping,
            Law::Saturating if p < FRICTION_SPEED * sizes.v => Effect::CoulombFriction,
            Law::Saturating | Law::SizeOfSpeed => Effect::ViscousDamping,
            Law::Relaxing => Effect::MaxwellDamper,
            Law::PowerOfPlace if strength < 0.0 => Effect::Softening,
            Law::PowerOfPlace => Effect::Hardening,
            Law::Beyond if q == 0.0 && strength < 0.0 => Effect::Softening,
            Law::Beyond if q == 0.0 => Effect::Hardening,
            Law::Away | Law::Square | Law::Beyond => Effect::AsymmetricStiffness,
            Law::Lost => Effect::Backlash,
            Law::SlippingJoint => Effect::SlipGap,
            Law::Lessened | Law::Fatigued => Effect::Degradation,
            Law::Warming => Effect::TemperatureGain,
        }
    }

    /// True if a dashpot may be its cause: a force nearly proportional to speed, or a dashpot behind a spring that gives
    /// as little as a damper's own oil and clevises do.
    pub fn is_dashpot(&self, sizes: &MotionScales) -> bool {
        match self.law {
            Law::Relaxing => self.shape[0] < GIVES * sizes.x / sizes.v,
            Law::InSeries => self.relaxes() && self.shape[0] < MAY_BE_FRICTION * sizes.x,
            _ => self.name(sizes, 1.0) == Effect::ViscousDamping,
        }
    }

    /// True if it yields early enough to be the give of a sliding contact, and late enough to be more than that.
    pub fn may_be_friction(&self, sizes: &MotionScales) -> bool {
        let yield_at = self.yields_at() / sizes.x;
        let most = if self.is_bristles() {
            MAY_BE_BRISTLES
        } else {
            MAY_BE_FRICTION
        };
        self.law.slides() && yield_at > FRICTION_YIELD && yield_at < most
    }

    /// True if its equation is close to Dahl's friction, Bouc-Wen's with an exponent of 1 and equal rates out and back:
    /// a yielding material returns with the stiffness of its loading.
    fn is_bristles(&self) -> bool {
        let [_, n, load, unload] = self.shape;
        self.law == Law::BoucWen && n < BRISTLES && unload > load / 3.0
    }

    /// True if the part in series with the spring is more a dashpot than friction.
    fn relaxes(&self) -> bool {
        self.law == Law::InSeries && self.shape[2] < RELAXES
    }

    /// Its force where it slides, at strength 1; of one that creeps, at `v` mm/s or its law's own speed if that is less.
    pub fn level(&self, v: f64) -> f64 {
        let [_, q, r, _] = self.shape;
        match self.law {
            Law::BoucWen if r > 0.0 => r.powf(-1.0 / q),
            // Their force grows with travel, or acts at one place only: they have no constant force.
            Law::BoucWen | Law::SliderAway | Law::SliderAlong => 0.0,
            Law::InSeries => (v / q).powf(1.0 / r).min(1.0),
            _ => 1.0,
        }
    }

    /// Its yield displacement, mm.
    pub fn yields_at(&self) -> f64 {
        let [yield_at, n, load, _] = self.shape;
        match self.law {
            // The limiting force of its loading rate, over its initial stiffness.
            Law::BoucWen if load > 0.0 => yield_at * load.powf(-1.0 / n),
            Law::BoucWen => f64::INFINITY,
            // The mean of its five yield displacements.
            Law::Distributed => yield_at * (0.6 + 0.4 * n),
            _ => yield_at,
        }
    }
}
