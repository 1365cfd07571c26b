//! The given parameters of an effect, checked against the catalogue.

use super::catalogue::Effect;
use super::row::Channel;
use super::spec::{EffectSpec, Sensor};
use crate::error::{Accept, RigError};

/// An effect whose parameters are complete and in range.
#[derive(Debug)]
pub(crate) struct CheckedEffect {
    pub(crate) channel: Channel,
    values: Vec<(&'static str, f64)>,
}

impl CheckedEffect {
    /// Checks `spec`, which is at `path` in the test file.
    pub(crate) fn new(spec: &EffectSpec, path: &str) -> Result<Self, RigError> {
        let entry = spec.name.entry();
        let channel = Self::channel(spec, path)?;
        let here = entry
            .parameters
            .iter()
            .filter(|p| p.channel.is_none_or(|own| own == channel));
        for (name, value) in &spec.parameters {
            if !here.clone().any(|p| p.name == name) {
                let names: Vec<_> = here.clone().map(|p| p.name).collect();
                return Err(RigError::new(
                    format!("{path}.{name} of {}", spec.name),
                    value,
                    format!("in the {channel} channel {}", names.join(", ")),
                ));
            }
        }
        let values = here
            .map(|p| {
                let path = format!("{path}.{} of {}", p.name, spec.name);
                match spec.parameters.get(p.name).copied().or(p.default) {
                    Some(value) => Ok((p.name, p.accept.check(&path, value)?)),
                    None => Err(RigError::new(path, "missing", p.accept.to_string())),
                }
            })
            .collect::<Result<_, _>>()?;
        let checked = Self { channel, values };
        if let Some(from_s) = spec.from_s {
            Accept::new(0.0, 1e6, "s").check(&format!("{path}.from_s of {}", spec.name), from_s)?;
        }
        checked.sensor_fits(spec, path)?;
        if spec.name == Effect::Degradation {
            checked.one_of("reference_mm", "travel_mm", path)?;
        }
        Ok(checked)
    }

    /// Refuses a sensor that cannot have this error, and `frozen` with another effect.
    fn sensor_fits(&self, spec: &EffectSpec, path: &str) -> Result<(), RigError> {
        use Effect::*;
        let refuse = |key: &str, found: String, accepted: &str| {
            let place = format!("{path}.{key} of {}", spec.name);
            Err(RigError::new(place, found, accepted))
        };
        let frozen = spec.name == FrozenSensor;
        if frozen && !spec.frozen && spec.sensor.is_none() && spec.channel.is_none() {
            let accepted = "displacement or force; another effect has a name";
            return refuse("sensor", "missing".into(), accepted);
        }
        if spec.frozen && !frozen {
            return refuse("frozen", "true".into(), "it without another name beside it");
        }
        let Some(sensor) = spec.sensor else {
            return if frozen && spec.channel.is_none() {
                refuse("sensor", "missing".into(), "displacement or force")
            } else {
                Ok(())
            };
        };
        let reads = match sensor {
            Sensor::Displacement => Channel::Actuator,
            Sensor::Force => Channel::Specimen,
        };
        let possible = matches!(
            spec.name,
            GainError
                | Offset
                | Drift
                | TemperatureGain
                | Saturation
                | MainsHum
                | Quantisation
                | FrozenSensor
                | SensorNoise
        );
        if possible && reads == self.channel {
            return Ok(());
        }
        let accepted = "a sensor's own effect in its own channel (displacement: actuator, force: specimen): gain_error, offset, \
                        drift, temperature_gain, saturation, mains_hum, quantisation, frozen_sensor, sensor_noise; a late \
                        sensor is channel_skew";
        refuse("sensor", format!("{sensor:?}").to_lowercase(), accepted)
    }

    /// Refuses an effect with neither of two sizes, or with both: they exclude each other.
    fn one_of(&self, one: &str, other: &str, path: &str) -> Result<(), RigError> {
        let given = [one, other].map(|name| self.get(name) > 0.0);
        if given[0] != given[1] {
            return Ok(());
        }
        let (and, found) = if given[0] {
            let found = format!("{} and {}", self.get(one), self.get(other));
            ("and", found)
        } else {
            ("or", "missing".to_owned())
        };
        let place = format!("{path}.{one} {and} {other} of {}", Effect::Degradation);
        Err(RigError::new(place, found, "one of the two above 0"))
    }

    /// The requested channel, or the one that a parameter belongs to, or the first.
    fn channel(spec: &EffectSpec, path: &str) -> Result<Channel, RigError> {
        let entry = spec.name.entry();
        if let Some(channel) = spec.channel
            && !entry.channels.contains(&channel)
        {
            let names: Vec<_> = entry.channels.iter().map(|c| c.name()).collect();
            return Err(RigError::new(
                format!("{path}.channel of {}", spec.name),
                channel,
                names.join(" or "),
            ));
        }
        Ok(spec.shows_in())
    }

    /// The value of a parameter that the catalogue has for this effect in this channel. An unknown name is a bug of
    /// this crate (the tests build every effect); it shows as NaN.
    pub(crate) fn get(&self, name: &str) -> f64 {
        let found = self.values.iter().find(|(own, _)| *own == name);
        debug_assert!(found.is_some(), "no parameter {name}");
        found.map_or(f64::NAN, |(_, value)| *value)
    }

    /// A parameter in thousandths (mm, ms), converted to SI.
    pub(crate) fn milli(&self, name: &str) -> f64 {
        self.get(name) * 1e-3
    }
}

impl EffectSpec {
    /// Checks that name, channel and parameters match; `path` is the effect's place in its file.
    ///
    /// # Errors
    /// A parameter that is missing, unknown or out of range, by its name.
    pub fn check(&self, path: &str) -> Result<(), RigError> {
        CheckedEffect::new(self, path).map(drop)
    }
}
