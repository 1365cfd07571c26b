//! The `[plant.sensors]` table, and the measuring channels that it describes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::converter::Converter;
use crate::delay_line::DelayLine;
use crate::effect::{Additions, ChannelAdditions};
use crate::error::{Accept, RigError};
use crate::random::{Normal, Purpose};
use crate::sensor::{Sensor, SensorSpec};
use crate::stage::{Stage, Stages};

/// The `[plant.sensors]` table; the same sensors on every axis. The default is perfect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SensorsSpec {
    /// White noise of the displacement, mm rms.
    pub displacement_noise_mm: f64,
    /// White noise of the force, N rms.
    pub force_noise_n: f64,
    /// Coloured noise of the displacement, mm rms.
    pub displacement_coloured_noise_mm: f64,
    /// Coloured noise of the force, N rms.
    pub force_coloured_noise_n: f64,
    /// Corner frequency of the coloured noise, Hz.
    pub coloured_noise_corner_hz: f64,
    /// Displacement read per displacement, 1.
    pub displacement_gain: f64,
    /// Force read per force, 1.
    pub force_gain: f64,
    /// Displacement read at zero, mm.
    pub displacement_offset_mm: f64,
    /// Force read at zero, N.
    pub force_offset_n: f64,
    /// Frequency of the mains hum, Hz.
    pub hum_hz: f64,
    /// Amplitude of the hum on the displacement, mm.
    pub displacement_hum_mm: f64,
    /// Amplitude of the hum on the force, N.
    pub force_hum_n: f64,
    /// The force is read later than the displacement by this, ms; negative: the displacement later than the force.
    pub skew_ms: f64,
    /// Bits of the converters, 2 to 32; without, nothing is quantised.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bits: Option<u32>,
    /// The displacement converter takes plus and minus this, mm. Without: no rails, but 250 mm where there are bits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement_range_mm: Option<f64>,
    /// The force converter takes plus and minus this, N. Without: no rails, but what the structure's stiffest
    /// storey resists over the displacement range where there are bits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force_range_n: Option<f64>,
}

impl Default for SensorsSpec {
    fn default() -> Self {
        Self {
            displacement_noise_mm: 0.0,
            force_noise_n: 0.0,
            displacement_coloured_noise_mm: 0.0,
            force_coloured_noise_n: 0.0,
            coloured_noise_corner_hz: 50.0,
            displacement_gain: 1.0,
            force_gain: 1.0,
            displacement_offset_mm: 0.0,
            force_offset_n: 0.0,
            hum_hz: 50.0,
            displacement_hum_mm: 0.0,
            force_hum_n: 0.0,
            skew_ms: 0.0,
            bits: None,
            displacement_range_mm: None,
            force_range_n: None,
        }
    }
}

const GAIN: Accept = Accept::new(0.1, 10.0, "");
const AT_MM: Accept = Accept::new(-1e4, 1e4, "mm");
const MM: Accept = Accept::new(0.0, 1e4, "mm");
const AT_N: Accept = Accept::new(-1e9, 1e9, "N");
const N: Accept = Accept::new(0.0, 1e9, "N");
const CORNER: Accept = Accept::new(1e-3, 1e6, "Hz");
const HUM: Accept = Accept::new(1e-3, 1e4, "Hz");
const SKEW: Accept = Accept::new(-1000.0, 1000.0, "ms");
const BITS: Accept = Accept::new(2.0, 32.0, "");

/// Default displacement range for the converter's bits, mm.
const DISPLACEMENT_RANGE_MM: f64 = 250.0;

/// Displacement and force channel of one axis.
#[derive(Clone, Debug)]
pub(crate) struct Channels {
    pub(crate) displacement: Channel,
    pub(crate) force: Channel,
}

/// One measured quantity: when it is sampled, its sensor, its converter.
#[derive(Clone, Debug)]
pub(crate) struct Channel {
    before_sampling: Stages,
    sensor: Sensor,
    after_sensor: Stages,
    converter: Converter,
    /// It reads the true value: none of the above has an effect.
    exact: bool,
}

impl Channel {
    /// The reading of `quantity` for the loop, and whether it is at a rail.
    #[inline]
    pub(crate) fn read(&mut self, quantity: f64) -> (f64, bool) {
        if self.exact {
            // Adding 0 makes a zero positive, as in a sensor without offset.
            return (quantity + 0.0, quantity.is_infinite());
        }
        self.pass(quantity)
    }

    /// Takes the effects that begin in the next period.
    pub(crate) fn begin(&mut self, added: ChannelAdditions) {
        self.before_sampling.begin(added.before_sampling);
        self.after_sensor.begin(added.after_sensor);
        self.exact &= self.before_sampling.is_empty() && self.after_sensor.is_empty();
    }

    /// Not inlined: most channels are exact, and the registers needed by the others are costly.
    #[inline(never)]
    fn pass(&mut self, quantity: f64) -> (f64, bool) {
        let sampled = self.before_sampling.step(quantity);
        let signal = self.after_sensor.step(self.sensor.step(sampled));
        self.converter.convert(signal)
    }
}

impl SensorsSpec {
    /// Noise of displacement, m, and force, N, rms: white, coloured and hum.
    pub fn noise_rms(&self) -> [f64; 2] {
        let rms = |white: f64, coloured: f64, hum: f64| {
            (white * white + coloured * coloured + 0.5 * hum * hum).sqrt()
        };
        let mm = rms(
            self.displacement_noise_mm,
            self.displacement_coloured_noise_mm,
            self.displacement_hum_mm,
        );
        let force_n = rms(
            self.force_noise_n,
            self.force_coloured_noise_n,
            self.force_hum_n,
        );
        [1e-3 * mm, force_n]
    }

    /// The transducers' errors for displacement and force, in m and N.
    fn sensors(&self) -> Result<[SensorSpec; 2], RigError> {
        let mm = |name, mm, accept| Ok::<_, RigError>(1e-3 * checked(name, mm, accept)?);
        let corner_hz = self.coloured_noise_corner_hz;
        let corner_hz = checked("coloured_noise_corner_hz", corner_hz, CORNER)?;
        let hum_hz = checked("hum_hz", self.hum_hz, HUM)?;
        let coloured_mm = self.displacement_coloured_noise_mm;
        let displacement = SensorSpec {
            gain: checked("displacement_gain", self.displacement_gain, GAIN)?,
            offset: mm("displacement_offset_mm", self.displacement_offset_mm, AT_MM)?,
            white_rms: mm("displacement_noise_mm", self.displacement_noise_mm, MM)?,
            coloured_rms: mm("displacement_coloured_noise_mm", coloured_mm, MM)?,
            coloured_corner_hz: corner_hz,
            hum_amplitude: mm("displacement_hum_mm", self.displacement_hum_mm, MM)?,
            hum_hz,
        };
        let coloured_n = self.force_coloured_noise_n;
        let force = SensorSpec {
            gain: checked("force_gain", self.force_gain, GAIN)?,
            offset: checked("force_offset_n", self.force_offset_n, AT_N)?,
            white_rms: checked("force_noise_n", self.force_noise_n, N)?,
            coloured_rms: checked("force_coloured_noise_n", coloured_n, N)?,
            coloured_corner_hz: corner_hz,
            hum_amplitude: checked("force_hum_n", self.force_hum_n, N)?,
            hum_hz,
        };
        Ok([displacement, force])
    }

    /// The ranges of the converters, m and N, if any.
    fn ranges(&self, stiffness_n_per_m: &[f64]) -> Result<[Option<f64>; 2], RigError> {
        if let Some(bits) = self.bits {
            checked("bits", f64::from(bits), BITS)?;
        }
        let range = |name, value: Option<f64>, most, unit| {
            let accept = Accept::new(1e-6, most, unit);
            value.map(|value| checked(name, value, accept)).transpose()
        };
        let range_m = range(
            "displacement_range_mm",
            self.displacement_range_mm,
            1e5,
            "mm",
        )?
        .or(self.bits.map(|_| DISPLACEMENT_RANGE_MM))
        .map(|mm| mm * 1e-3);
        let stiffest = stiffness_n_per_m.iter().copied().fold(0.0, f64::max);
        let range_n = match range("force_range_n", self.force_range_n, 1e9, "N")? {
            None => self.bits.and(range_m).map(|range_m| stiffest * range_m),
            given => given,
        };
        Ok([range_m, range_n])
    }

    pub(crate) fn build(
        &self,
        stiffness_n_per_m: &[f64],
        additions: &[Additions],
        rate_hz: f64,
        seed: u64,
    ) -> Result<Vec<Channels>, RigError> {
        let [displacement, force] = self.sensors()?;
        let [range_m, range_n] = self.ranges(stiffness_n_per_m)?;
        let skew = checked("skew_ms", self.skew_ms, SKEW)? * rate_hz / 1e3;
        let channel = |late: f64, spec: &SensorSpec, normal, range, added: &ChannelAdditions| {
            let mut before_sampling = added.before_sampling.clone();
            if late > 0.0 {
                before_sampling.push(Stage::Delay(DelayLine::new(late, 0.0)));
            }
            let converter = Converter::new(range, self.bits);
            let through = before_sampling.is_empty() && added.after_sensor.is_empty();
            Channel {
                exact: through && spec.is_exact() && converter.is_wire(),
                before_sampling,
                sensor: Sensor::new(spec, rate_hz, normal),
                after_sensor: added.after_sensor.clone(),
                converter,
            }
        };
        let axis = |(axis, added): (usize, &Additions)| {
            let normal = |purpose| Normal::new(seed, purpose, axis);
            let (at_m, at_n) = (
                normal(Purpose::DisplacementNoise),
                normal(Purpose::ForceNoise),
            );
            Channels {
                displacement: channel(-skew, &displacement, at_m, range_m, &added.displacement),
                force: channel(skew, &force, at_n, range_n, &added.force),
            }
        };
        Ok(additions.iter().enumerate().map(axis).collect())
    }
}

fn checked(name: &str, value: f64, accept: Accept) -> Result<f64, RigError> {
    accept.check(&format!("plant.sensors.{name}"), value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exact_channel_reads_with_the_bits_of_the_whole_way() {
        let additions = [Additions::default()];
        let built = |spec: SensorsSpec| spec.build(&[1e6], &additions, 2000.0, 1).unwrap();
        let exact = built(SensorsSpec::default())[0].force.clone();
        assert!(exact.exact);
        for value in [
            0.0,
            -0.0,
            1.5e-3,
            -7e5,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NAN,
        ] {
            let (short, whole) = (exact.clone().read(value), exact.clone().pass(value));
            assert_eq!(
                (short.0.to_bits(), short.1),
                (whole.0.to_bits(), whole.1),
                "{value}"
            );
        }
        for other in [
            SensorsSpec {
                force_gain: 1.01,
                ..SensorsSpec::default()
            },
            SensorsSpec {
                force_offset_n: 1.0,
                ..SensorsSpec::default()
            },
            SensorsSpec {
                force_noise_n: 1.0,
                ..SensorsSpec::default()
            },
            SensorsSpec {
                force_hum_n: 1.0,
                ..SensorsSpec::default()
            },
            SensorsSpec {
                force_range_n: Some(1e3),
                ..SensorsSpec::default()
            },
            SensorsSpec {
                bits: Some(16),
                ..SensorsSpec::default()
            },
            SensorsSpec {
                skew_ms: 1.0,
                ..SensorsSpec::default()
            },
        ] {
            assert!(!built(other)[0].force.exact);
        }
    }
}
