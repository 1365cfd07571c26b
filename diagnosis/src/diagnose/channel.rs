//! A channel and the records used to judge it.

use crate::model::answer::{ChannelAnswer, FoundEffect};
use crate::model::base::Base;
use crate::record::recording::Recording;
use plant::Channel;

/// A channel and its data.
pub struct ChannelDiagnosis<'a> {
    /// The declared model.
    pub base: Base,
    /// Records for the search.
    pub train: &'a [Recording],
    /// Records for the judgement.
    pub test: &'a [Recording],
    /// Records in which nothing moves.
    pub rest: &'a [Recording],
    /// The same with all samples, if some of the above count as not measured: the noise is read from it.
    pub whole: Option<&'a ChannelDiagnosis<'a>>,
    /// The hum that was taken off the displacement of the above.
    pub hum: Option<Hum<'a>>,
}

/// Mains hum in a reading.
pub struct Hum<'a> {
    /// Its name and figures.
    pub effect: FoundEffect,
    /// The answer of which it is what was left.
    pub with: &'a ChannelAnswer,
}

impl ChannelDiagnosis<'_> {
    pub fn input_of<'r>(&self, r: &'r Recording) -> Option<&'r Vec<f64>> {
        match self.base.channel {
            Channel::Actuator => r.command_mm.as_ref(),
            Channel::Specimen => r.displacement_mm.as_ref(),
        }
    }

    pub fn target_of<'r>(&self, r: &'r Recording) -> Option<&'r Vec<f64>> {
        match self.base.channel {
            Channel::Actuator => r.displacement_mm.as_ref(),
            Channel::Specimen => r.force_n.as_ref(),
        }
    }
}
