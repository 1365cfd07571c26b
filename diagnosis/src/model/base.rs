//! The declared parameters of a channel.

use crate::criteria::{POSITION_LOOP, REACH};
use crate::model::Model;
use crate::model::channel::ChannelModel;
use crate::model::saved_element::SavedElement;
use crate::numbers::linear::Bound;
use plant::{Channel, EffectSpec};

/// Time constants after which a start is forgotten.
const FORGOTTEN: f64 = 6.0;

/// A declared parameter that the fit may move.
#[derive(Clone, Copy, Debug)]
pub struct FreeParameter {
    /// Which of the channel's four.
    pub index: usize,
    /// One tolerance.
    pub tolerance: f64,
}

/// The declared parameters of a channel, in the order of [`Channel::parameters`].
#[derive(Clone, Debug)]
pub struct Base {
    /// Which channel.
    pub channel: Channel,
    /// Declared values; what is not declared is not there.
    pub values: [f64; 4],
    /// Those with a tolerance.
    pub free: Vec<FreeParameter>,
    /// Effects that the model already has.
    pub known: Vec<EffectSpec>,
    /// Elements beside the specimen that it already has.
    pub elements: Vec<SavedElement>,
}

impl Base {
    /// Of a channel that `model` declares.
    pub fn of(model: &Model, channel: Channel) -> Option<Self> {
        let ChannelModel {
            parameters,
            effects,
            elements,
            ..
        } = model.channel(channel)?;
        let absent = channel.parameters().each_ref().map(|p| p.absent);
        let tolerance = |index: usize| parameters[index].map_or(0.0, |d| d.tolerance);
        Some(Self {
            channel,
            values: std::array::from_fn(|i| parameters[i].map_or(absent[i], |d| d.value)),
            free: (0..4)
                .filter(|&i| tolerance(i) > 0.0)
                .map(|index| FreeParameter {
                    index,
                    tolerance: tolerance(index),
                })
                .collect(),
            known: effects.iter().filter(|e| e.enabled).cloned().collect(),
            elements: elements.iter().filter(|e| e.enabled).cloned().collect(),
        })
    }

    /// The tolerance of a parameter; 0 where it is not free.
    pub fn tolerance(&self, index: usize) -> f64 {
        let own = self.free.iter().find(|f| f.index == index);
        own.map_or(0.0, |f| f.tolerance)
    }

    /// How long the declared actuator, three tolerances slower, remembers a command, s.
    pub fn settling_s(&self) -> f64 {
        let slowest = |i: usize| self.values[i] + REACH * self.tolerance(i);
        1e-3 * (slowest(1) + FORGOTTEN * slowest(2))
    }

    /// The least that a parameter of a specimen can be: damping and mass are not negative, unless they are declared so.
    pub fn least(&self, index: usize) -> f64 {
        if (index == 1 || index == 2) && self.values[index] >= 0.0 {
            0.0
        } else {
            f64::NEG_INFINITY
        }
    }

    /// What a parameter of a specimen may be as long as it stays what was declared.
    pub fn within_tolerances(&self, index: usize) -> Bound {
        let (value, reach) = (self.values[index], REACH * self.tolerance(index));
        Bound {
            low: (value - reach).max(self.least(index)),
            high: value + reach,
        }
    }

    /// What any device of its kind leaves of its textbook model, as a share of the output ([`POSITION_LOOP`]); nothing of a specimen, and
    /// of a path without a lag, which is no position loop.
    pub fn ordinary(&self) -> f64 {
        if self.channel == Channel::Actuator && self.values[2] > 0.0 {
            POSITION_LOOP
        } else {
            0.0
        }
    }

    /// How far each free parameter may go from `theta`.
    pub fn bounds(&self, theta: &[f64; 4]) -> Vec<Bound> {
        let bound = |f: &FreeParameter| {
            let reach = REACH * f.tolerance;
            let own = self.channel.parameters()[f.index].least;
            let floor = match self.channel {
                Channel::Specimen => own.max(self.least(f.index)),
                Channel::Actuator => own,
            };
            let value = self.values[f.index];
            Bound {
                low: (value - reach).max(floor),
                high: value + reach,
            }
            .from(theta[f.index])
        };
        self.free.iter().map(bound).collect()
    }
}
