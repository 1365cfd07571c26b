//! A law of the table: its equation, the shapes to search, and its price.

use crate::criteria::MAY_BE_FRICTION;
use crate::laws::library::candidate::{Shape, rest_ratio};
use crate::laws::library::{CANDIDATES, Candidate};
use crate::laws::specimen::element::{Element, Law};
use crate::laws::specimen::track::MotionScales;
use crate::numbers::linear::Bound;
use crate::numbers::signals::Scales;
use plant::{Channel, Effect, Family};

/// The equation of a law.
#[derive(Clone, Copy, Debug)]
pub enum Form {
    /// A declared parameter that leaves its tolerance, in the order of [`Channel::parameters`].
    Parameter(usize),
    /// An element of free strength beside the specimen.
    Element(Law),
    /// An effect of the catalogue, as a change of the declared specimen.
    Effect(Candidate),
}

/// Where a law acts between specimen and record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PointOfAction {
    /// A force of the specimen, or one beside it.
    Force,
    /// A fraction of the whole force.
    Calibration,
    /// The range of what reads it.
    Range,
    /// Added to the reading.
    Cable,
}

/// A law of the table.
#[derive(Clone, Debug)]
pub struct Row {
    /// Its equation.
    pub form: Form,
    /// Shapes to search.
    pub grid: Vec<[f64; 4]>,
    /// Its price, nats.
    pub price: f64,
    /// The declared parameter that it may free from its tolerance, without a name for that.
    pub frees: Option<usize>,
}

/// Sizes of the motion, for elements and for effects.
#[derive(Clone, Copy, Debug)]
pub struct Sizes {
    /// For elements.
    pub motion: MotionScales,
    /// For effects.
    pub scales: Scales,
    /// True if the motion has one speed each way: what builds up in time and along the travel is then the same.
    pub one_speed: bool,
}

impl Sizes {
    /// Sizes for effects on a specimen of these parameters.
    pub fn on(&self, parameters: &[f64; 4]) -> Self {
        let mut own = *self;
        if parameters[0] != 0.0 {
            own.scales.stiffness = parameters[0];
        }
        own
    }
}

/// Price of an additional shape number.
const A_SHAPE: f64 = 0.7;
/// Price of an additional strength.
const A_STRENGTH: f64 = 0.4;
/// Price of a declared parameter freed along with the law, without a name: as high as under a name of its own,
/// otherwise every law of zero strength would be a rival of `gain_error`.
pub const A_PARAMETER: f64 = 3.2;

impl Row {
    /// A declared parameter that leaves its tolerance.
    pub fn parameter(which: usize, price: f64) -> Self {
        Self {
            form: Form::Parameter(which),
            grid: vec![[0.0; 4]],
            price,
            frees: None,
        }
    }

    /// An element of free strength with these shapes.
    pub fn element(law: Law, price: f64, grid: impl IntoIterator<Item = [f64; 4]>) -> Self {
        let grid: Vec<[f64; 4]> = grid.into_iter().collect();
        let shapes = grid
            .first()
            .map_or(0, |shape| Element { law, shape: *shape }.movable().len());
        Self {
            form: Form::Element(law),
            grid,
            price: price + A_SHAPE * shapes as f64,
            frees: None,
        }
    }

    /// An effect of the catalogue by its name, with this number of values for each of its shapes.
    pub fn effect(name: Effect, price: f64, sizes: &Sizes, counts: &[usize]) -> Option<Self> {
        let candidate = CANDIDATES.iter().find(|c| c.effect == name)?;
        Some(Self::of(*candidate, price, sizes, counts))
    }

    /// The same for a form of an effect that is not the one under the catalogue's name.
    pub fn of(candidate: Candidate, price: f64, sizes: &Sizes, counts: &[usize]) -> Self {
        let shapes = (candidate.shapes)(&sizes.scales);
        let strengths = (candidate.bounds)(&sizes.scales).len().max(1);
        let mut grid = vec![[0.0; 4]];
        for (i, shape) in shapes.iter().enumerate() {
            let count = counts.get(i).copied().unwrap_or(4);
            grid = grid
                .iter()
                .flat_map(|g| {
                    spread(shape, count).into_iter().map(move |value| {
                        let mut own = *g;
                        own[i] = value;
                        own
                    })
                })
                .collect();
        }
        Self {
            form: Form::Effect(candidate),
            grid,
            price: price + A_SHAPE * shapes.len() as f64 + A_STRENGTH * (strengths - 1) as f64,
            frees: None,
        }
    }

    /// The same law with a declared parameter that it may free from its tolerance.
    pub fn with_own(&self, parameter: usize) -> Self {
        Self {
            price: self.price + A_PARAMETER,
            frees: Some(parameter),
            ..self.clone()
        }
    }

    /// Where it acts, in order: the forces, a calibration or a frame that changes them all, the range of what reads them, and
    /// hum that its cable picks up.
    pub fn point_of_action(&self) -> PointOfAction {
        match self.form {
            Form::Effect(c) => match c.effect {
                Effect::GainError | Effect::RigCompliance | Effect::TemperatureGain => {
                    PointOfAction::Calibration
                }
                Effect::Saturation => PointOfAction::Range,
                Effect::MainsHum => PointOfAction::Cable,
                _ => PointOfAction::Force,
            },
            Form::Element(_) | Form::Parameter(_) => PointOfAction::Force,
        }
    }

    /// True for an effect that acts on the force of all before it, as in a saved model.
    pub fn acts_on_the_whole_force(&self) -> bool {
        matches!(
            self.point_of_action(),
            PointOfAction::Calibration | PointOfAction::Range
        )
    }

    /// True for a delay: it has no force of its own, and all others pass through it.
    pub fn is_delay(&self) -> bool {
        matches!(self.form, Form::Effect(c) if c.stage.is_some())
    }

    /// True if it is a spring whose stiffness depends on the displacement.
    pub fn is_spring(&self) -> bool {
        matches!(self.form, Form::Element(Law::PowerOfPlace | Law::Beyond))
    }

    /// True if it can only be named by family: something beyond such a name remains.
    pub fn has_its_familys_name(&self) -> bool {
        matches!(self.form, Form::Element(Law::Recentring))
    }

    /// Its name for a shape and a strength.
    pub fn name(&self, shape: [f64; 4], strength: f64, sizes: &Sizes) -> Effect {
        match self.form {
            Form::Parameter(i) => Channel::Specimen.mistakes()[i],
            Form::Element(law) => Element { law, shape }.name(&sizes.motion, strength),
            Form::Effect(candidate) => candidate.effect,
        }
    }

    /// The other name of the same force, if the motion cannot tell: the give of a sliding contact or a yielding spring,
    /// a dashpot or one behind a stiff spring.
    pub fn other_name(
        &self,
        shape: [f64; 4],
        strengths: &[f64],
        own: Effect,
        sizes: &Sizes,
    ) -> Option<Effect> {
        let law = match self.form {
            Form::Element(law) => law,
            // Early yielding may be the give of a sliding contact.
            Form::Effect(c) if c.effect.entry().family == Family::Hysteresis => {
                let early = shape[0] < MAY_BE_FRICTION * sizes.motion.x;
                return early.then_some(Effect::CoulombFriction);
            }
            // A small fall with speed that ends while friction still builds up may be how it builds up.
            Form::Effect(c) if c.effect == Effect::StribeckFriction => {
                let m = &sizes.motion;
                let built_up = m.v * (2.0 * BUILDS_UP * shape[0] / m.x).sqrt();
                let small = rest_ratio(strengths) < FALLS_LITTLE;
                return (small && shape[1] < built_up).then_some(Effect::CoulombFriction);
            }
            Form::Effect(_) | Form::Parameter(_) => return None,
        };
        let element = Element { law, shape };
        let friction = element.may_be_friction(&sizes.motion);
        let levels_off = law == Law::Saturating && shape[0] < LEVELS_OFF * sizes.motion.v;
        let dashpot = law == Law::Relaxing && element.is_dashpot(&sizes.motion);
        let other = match own.entry().family {
            Family::Hysteresis if friction => Effect::CoulombFriction,
            Family::Damping if levels_off => Effect::CoulombFriction,
            Family::Damping if dashpot => Effect::ViscousDamping,
            _ => return None,
        };
        (other != own).then_some(other)
    }

    /// Its family, whatever its strength's sign.
    pub fn family(&self, shape: [f64; 4], sizes: &Sizes) -> Family {
        self.name(shape, 1.0, sizes).entry().family
    }

    /// Bounds of its strengths.
    pub fn bounds(&self, sizes: &Sizes, shape: [f64; 4]) -> Vec<Bound> {
        match self.form {
            Form::Parameter(_) => Vec::new(),
            // Beyond a place the spring can at most vanish.
            Form::Element(Law::Beyond) if shape[1] == 0.0 => vec![Bound {
                low: -NO_SPRING * sizes.scales.stiffness,
                high: f64::INFINITY,
            }],
            Form::Element(law) => vec![Element { law, shape }.bound()],
            Form::Effect(c) if c.stage.is_some() => vec![ONCE],
            Form::Effect(c) if matches!(c.effect, Effect::GainError | Effect::TemperatureGain) => {
                vec![Bound {
                    low: -OF_A_CALIBRATION,
                    high: f64::INFINITY,
                }]
            }
            Form::Effect(c) if c.effect == Effect::RigCompliance => vec![Bound {
                low: 0.0,
                high: OF_A_CALIBRATION / sizes.scales.stiffness,
            }],
            Form::Effect(c) => (c.bounds)(&sizes.scales),
        }
    }

    /// The shapes that may be refined, whether by factors, and their ranges.
    pub fn movable(&self, shape: [f64; 4], sizes: &Sizes) -> Vec<(usize, bool, [f64; 2])> {
        match self.form {
            Form::Parameter(_) => Vec::new(),
            Form::Element(law) => {
                let own = Element { law, shape };
                let all = own.movable().iter();
                all.map(|&(i, scale)| {
                    let log = scale == crate::laws::specimen::Scale::Log;
                    // A place moves by fractions of the motion.
                    let range = match law {
                        Law::Beyond if !log => [-sizes.motion.x, sizes.motion.x],
                        _ => [f64::NEG_INFINITY, f64::INFINITY],
                    };
                    (i, log, range)
                })
                .collect()
            }
            Form::Effect(c) => (c.shapes)(&sizes.scales)
                .iter()
                .enumerate()
                .map(|(i, s)| (i, s.low > 0.0 && s.high > SEVERAL * s.low, [s.low, s.high]))
                .collect(),
        }
    }

    /// True if a shape is admissible for the law.
    pub fn is_sound(&self, shape: [f64; 4], sizes: &Sizes) -> bool {
        match self.form {
            Form::Parameter(_) => true,
            Form::Element(law) => Element { law, shape }.is_sound(&sizes.motion),
            Form::Effect(c) => (c.shapes)(&sizes.scales)
                .iter()
                .zip(shape)
                .all(|(s, x)| (0.5 * s.low.min(2.0 * s.low)..=2.0 * s.high).contains(&x)),
        }
    }
}

/// A shape moves by factors if its range spans more than this one; the frequency of a line does not.
const SEVERAL: f64 = 2.0;

/// Presliding displacements over which friction builds up after a reversal, by an unknown law.
const BUILDS_UP: f64 = 4.0;

/// Largest ratio of friction at rest to that in motion that may be a wrong law of how it builds up.
const FALLS_LITTLE: f64 = 1.25;

/// Unit in which a shape moves: its own value if by factors, else a part of its range.
pub fn unit(log: bool, value: f64, [low, high]: [f64; 2]) -> f64 {
    let span = if high.is_finite() { high - low } else { 1.0 };
    if log {
        value.abs()
    } else {
        span.min(1.0).max(0.1 * span)
    }
}

/// A damper whose force saturates below this fraction of the top speed may be friction that slips softly.
const LEVELS_OFF: f64 = 1.0;

/// Largest fraction of a force that a calibration error or the rig's give can remove: beyond that it is another force.
const OF_A_CALIBRATION: f64 = 0.6;

/// A declared spring that has vanished may have been a little stiffer.
const NO_SPRING: f64 = 1.05;

/// The strength of a law that acts once.
const ONCE: Bound = Bound {
    low: 0.85,
    high: 1.15,
};

/// Values of a shape over its range.
fn spread(shape: &Shape, count: usize) -> Vec<f64> {
    let (low, high) = (shape.low, shape.high);
    let at = |i: usize| {
        let share = (i as f64 + 0.5) / count as f64;
        if low > 0.0 {
            low * (high / low).powf(share)
        } else {
            low + share * (high - low)
        }
    };
    (0..count).map(at).collect()
}

/// First shapes, the others 0.
pub fn over<const N: usize>(values: [f64; N], unit: f64) -> [[f64; 4]; N] {
    values.map(|v| [v * unit, 0.0, 0.0, 0.0])
}
