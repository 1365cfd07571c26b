//! What was hidden, for the scorer alone.

use crate::class::Class;
use crate::effect::{Channel, Equations};
use crate::excitation::Excitation;

/// The key to one case.
#[derive(Clone, Debug)]
pub struct Key {
    /// The class of the case.
    pub class: Class,
    /// How the training record was excited.
    pub excitation: Excitation,
    /// Both channels, the actuator first.
    pub channels: [ChannelKey; 2],
}

/// What is hidden in one channel.
#[derive(Clone, Debug)]
pub struct ChannelKey {
    /// The channel.
    pub channel: Channel,
    /// Effects of the list.
    pub hidden: Vec<Hidden>,
    /// Something in the record that the list has no name for.
    pub outside: Option<&'static str>,
    /// An effect on the displacement's reading also shows in the specimen's channel, where naming it is no mistake.
    pub echo: Option<&'static str>,
    /// Rms that a perfect model would leave on the test record, mm or N.
    pub floor_rms: f64,
}

/// One hidden effect.
#[derive(Clone, Debug)]
pub struct Hidden {
    /// Its name in the effect list.
    pub name: &'static str,
    /// Its family.
    pub family: &'static str,
    /// The set of equations that it follows.
    pub equations: Equations,
    /// Its equation, in words.
    pub equation: &'static str,
    /// Rms in the training record beyond what the declared parameters can absorb, in units of the channel's floor.
    pub size: f64,
    /// True parameters under the effect list's names; empty for unseen equations.
    pub parameters: Vec<(&'static str, f64)>,
    /// Names that no analysis of this record could tell from it.
    pub same: &'static [&'static str],
}
