//! A channel of a declared model, by its rows: what each of them holds, and where.

use crate::model::answer::Correction;
use crate::model::declared::Declared;
use crate::model::saved_element::SavedElement;
use crate::model::{ActuatorModel, Model, SpecimenModel};
use plant::{Channel, Effect, EffectSpec};

/// Places of a channel's parameters, in the order of [`Channel::parameters`], and of its effects.
type ChannelPlaces<'a> = ([&'a mut Option<Declared>; 4], &'a mut Vec<EffectSpec>);

/// One channel of a model. Parameters are in the order of [`Channel::parameters`].
#[derive(Clone, Copy, Debug)]
pub struct ChannelModel<'a> {
    /// Its parameters.
    pub parameters: [Option<Declared>; 4],
    /// What earlier diagnoses added.
    pub effects: &'a [EffectSpec],
    /// Elements beside a specimen.
    pub elements: &'a [SavedElement],
    /// What the remaining error depends on, without a name.
    pub remainder: Option<&'a Correction>,
}

impl Model {
    /// A channel, where it is declared.
    pub fn channel(&self, channel: Channel) -> Option<ChannelModel<'_>> {
        match channel {
            Channel::Actuator => self.actuator.as_ref().map(|actuator| {
                let ActuatorModel {
                    gain,
                    delay_ms,
                    lag_ms,
                    offset_mm,
                    effects,
                    remainder,
                } = actuator;
                ChannelModel {
                    parameters: [*gain, *delay_ms, *lag_ms, *offset_mm],
                    effects,
                    elements: &[],
                    remainder: remainder.as_ref(),
                }
            }),
            Channel::Specimen => self.specimen.as_ref().map(|specimen| {
                let SpecimenModel {
                    force_unit: _,
                    stiffness_n_per_mm,
                    damping_n_s_per_mm,
                    mass_kg,
                    offset_n,
                    effects,
                    remainder,
                    elements,
                } = specimen;
                ChannelModel {
                    parameters: [
                        *stiffness_n_per_mm,
                        *damping_n_s_per_mm,
                        *mass_kg,
                        *offset_n,
                    ],
                    effects,
                    elements,
                    remainder: remainder.as_ref(),
                }
            }),
        }
    }

    /// The model without what an earlier diagnosis added to a channel by this name.
    pub(crate) fn without(&self, channel: Channel, name: Effect) -> Self {
        let mut model = self.clone();
        if let Some((_, effects)) = model.channel_mut(channel) {
            effects.retain(|e| e.name != name);
        }
        if let (Channel::Specimen, Some(specimen)) = (channel, &mut model.specimen) {
            specimen.elements.retain(|e| e.name != name);
        }
        model
    }

    /// The model without anything that is known of a channel beyond its parameters.
    pub(crate) fn bare(&self, channel: Channel) -> Self {
        let mut model = self.clone();
        if let Some((_, effects)) = model.channel_mut(channel) {
            effects.clear();
        }
        if let (Channel::Specimen, Some(specimen)) = (channel, &mut model.specimen) {
            specimen.elements.clear();
        }
        model
    }

    /// Places of a channel's parameters and effects, where it is declared.
    pub(crate) fn channel_mut(&mut self, channel: Channel) -> Option<ChannelPlaces<'_>> {
        match channel {
            Channel::Actuator => self.actuator.as_mut().map(|a| {
                (
                    [
                        &mut a.gain,
                        &mut a.delay_ms,
                        &mut a.lag_ms,
                        &mut a.offset_mm,
                    ],
                    &mut a.effects,
                )
            }),
            Channel::Specimen => self.specimen.as_mut().map(|s| {
                (
                    [
                        &mut s.stiffness_n_per_mm,
                        &mut s.damping_n_s_per_mm,
                        &mut s.mass_kg,
                        &mut s.offset_n,
                    ],
                    &mut s.effects,
                )
            }),
        }
    }
}
