//! One channel and the records that it is judged by.

use crate::model::base::Base;
use crate::record::recording::Recording;
use plant::Channel;

/// One channel and its data.
pub struct ChannelDiagnosis<'a> {
    /// What is declared.
    pub base: Base,
    /// Records to search in.
    pub train: &'a [Recording],
    /// Records to judge by.
    pub test: &'a [Recording],
    /// Records in which nothing moves.
    pub rest: &'a [Recording],
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
