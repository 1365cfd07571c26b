//! What the watch can name: a cause and the side of the loop on which it is.

/// The side of the loop on which a cause is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Command to displacement.
    Actuator,
    /// The displacement transducer.
    Displacement,
    /// The load cell.
    Force,
    /// The specimen and its joints.
    Specimen,
}

impl Side {
    /// The word in files and on the terminal.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Actuator => "actuator",
            Self::Displacement => "displacement",
            Self::Force => "force",
            Self::Specimen => "specimen",
        }
    }
}

macro_rules! causes {
    ($($(#[$doc:meta])* $cause:ident = $name:literal $side:ident $unit:literal $per_unit:literal,)*) => {
        /// A cause with its side. Its number is its bit in a [`Set`] and never changes.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[repr(u8)]
        pub enum Cause { $($(#[$doc])* $cause,)* }

        impl Cause {
            /// Every cause, by number.
            pub const ALL: &'static [Self] = &[$(Self::$cause,)*];

            /// The effect's name in the catalogue of a simulated rig.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$cause => $name,)* }
            }

            /// Where it is.
            pub const fn side(self) -> Side {
                match self { $(Self::$cause => Side::$side,)* }
            }

            /// Unit of its value.
            pub const fn unit(self) -> &'static str {
                match self { $(Self::$cause => $unit,)* }
            }

            /// Its unit in a unit of SI.
            pub(super) const fn per_si(self) -> f32 {
                match self { $(Self::$cause => $per_unit,)* }
            }
        }
    };
}

causes! {
    /// The actuator is later than declared.
    ActuatorLate = "delay_error" Actuator "ms" 1e3,
    /// It goes further than commanded, or less far.
    ActuatorGain = "gain_error" Actuator "" 1.0,
    /// It stands beside its command.
    ActuatorOffset = "offset" Actuator "mm" 1e3,
    /// It is held back by friction.
    ActuatorFriction = "coulomb_friction" Actuator "mm" 1e3,
    /// It gets no faster.
    RateLimit = "rate_limit" Actuator "mm/s" 1e3,
    /// Its stroke ends.
    StrokeLimit = "saturation" Actuator "mm" 1e3,
    /// The transducer reads a share more or less.
    DisplacementGain = "gain_error" Displacement "" 1.0,
    /// The transducer's zero has moved.
    DisplacementOffset = "offset" Displacement "mm" 1e3,
    /// The displacement is read late.
    DisplacementLate = "channel_skew" Displacement "ms" 1e3,
    /// The load cell reads a share more or less.
    ForceGain = "gain_error" Force "" 1.0,
    /// The load cell's zero has moved.
    ForceOffset = "offset" Force "N" 1.0,
    /// The force is read late.
    ForceLate = "channel_skew" Force "ms" 1e3,
    /// Mass between specimen and load cell.
    Mass = "inertia_force" Force "kg" 1.0,
    /// A bearing or a guide beside the specimen rubs.
    BearingFriction = "coulomb_friction" Specimen "N" 1.0,
    /// Play between actuator and specimen: way at zero force.
    Play = "dead_band" Specimen "mm" 1e3,
    /// The specimen has lost stiffness at once: it broke, or what holds it.
    StiffnessLoss = "degradation" Specimen "" 1.0,
    /// The displacement stands still, with its noise or without.
    FrozenDisplacement = "frozen_sensor" Displacement "" 1.0,
    /// The force stands still, with its noise or without.
    FrozenForce = "frozen_sensor" Force "" 1.0,
    /// The displacement is noisier than it was.
    DisplacementNoise = "sensor_noise" Displacement "mm" 1e3,
    /// The force is noisier than it was.
    ForceNoise = "sensor_noise" Force "N" 1.0,
    /// The mains on the displacement.
    DisplacementHum = "mains_hum" Displacement "mm" 1e3,
    /// The mains on the force.
    ForceHum = "mains_hum" Force "N" 1.0,
    /// It goes less far to either side by as much whatever the way: its valve overlaps.
    ActuatorOverlap = "dead_band" Actuator "mm" 1e3,
    /// The transducer's zero moves on.
    DisplacementDrift = "drift" Displacement "mm/s" 1e3,
    /// The load cell's zero moves on.
    ForceDrift = "drift" Force "N/s" 1.0,
    /// The actuator moves on beside its command.
    ActuatorDrift = "drift" Actuator "mm/s" 1e3,
}

impl Cause {
    /// The cause on another side that looks the same until another channel decides.
    pub(super) const fn twin(self) -> Option<Self> {
        match self {
            Self::ActuatorLate => Some(Self::DisplacementLate),
            Self::ActuatorGain => Some(Self::DisplacementGain),
            Self::ActuatorOffset => Some(Self::DisplacementOffset),
            Self::ActuatorFriction
            | Self::RateLimit
            | Self::StrokeLimit
            | Self::DisplacementGain
            | Self::DisplacementOffset
            | Self::DisplacementLate
            | Self::ForceGain
            | Self::ForceOffset
            | Self::ForceLate
            | Self::Mass
            | Self::BearingFriction
            | Self::Play
            | Self::StiffnessLoss
            | Self::FrozenDisplacement
            | Self::FrozenForce
            | Self::DisplacementNoise
            | Self::ForceNoise
            | Self::DisplacementHum
            | Self::ForceHum
            | Self::ActuatorOverlap
            | Self::DisplacementDrift
            | Self::ForceDrift
            | Self::ActuatorDrift => None,
        }
    }

    /// True if it is found by fitting the motion, so that of several causes the motion may leave only one; false for
    /// what one sensor shows by itself, whatever else is wrong: noise, hum, a frozen reading.
    pub const fn is_fitted(self) -> bool {
        !matches!(
            self,
            Self::DisplacementNoise
                | Self::ForceNoise
                | Self::DisplacementHum
                | Self::ForceHum
                | Self::FrozenDisplacement
                | Self::FrozenForce
        )
    }
}

/// Causes that a motion does not tell apart, and what a sensor shows beside them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Set(u32);

impl Set {
    /// No cause.
    pub const EMPTY: Self = Self(0);

    /// As one word of a record.
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// True if nothing is in it.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Adds `cause`.
    pub fn add(&mut self, cause: Cause) {
        self.0 |= 1 << cause as u8;
    }

    /// The union with `other`.
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// True if `cause` is in it.
    pub const fn has(self, cause: Cause) -> bool {
        self.0 & 1 << cause as u8 != 0
    }

    /// Its causes by number.
    pub fn causes(self) -> impl Iterator<Item = Cause> {
        Cause::ALL.iter().copied().filter(move |c| self.has(*c))
    }

    /// True if one of them makes a learning compensation follow a faulty displacement transducer. Noise and hum do not:
    /// their mean is zero, and a shaking rig, which further learning may calm, shows them as well.
    pub fn teaches_wrongly(self) -> bool {
        let wrong = |c: Cause| c.side() == Side::Displacement && c.is_fitted();
        self.causes().any(wrong)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_names_are_for_ever() {
        for (i, cause) in Cause::ALL.iter().enumerate() {
            assert_eq!(*cause as usize, i);
            let same = |c: &&Cause| (c.name(), c.side()) == (cause.name(), cause.side());
            assert_eq!(Cause::ALL.iter().filter(same).count(), 1);
        }
        assert_eq!(Cause::ForceHum as u8, 21);
        assert_eq!(Cause::ActuatorDrift as u8, 25);
        let mut set = Set::EMPTY;
        set.add(Cause::ForceGain);
        set.add(Cause::StiffnessLoss);
        assert!(set.causes().eq([Cause::ForceGain, Cause::StiffnessLoss]));
        assert!(!set.teaches_wrongly());
        set.add(Cause::DisplacementHum);
        assert!(!set.teaches_wrongly());
        set.add(Cause::DisplacementGain);
        assert!(set.teaches_wrongly());
    }
}
