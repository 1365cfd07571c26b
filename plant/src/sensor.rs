//! From the true quantity to the voltage at the converter: gain and offset errors, noise, hum.

use std::f64::consts::TAU;

use crate::random::Normal;

/// The errors of one analogue channel; SI units of its quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorSpec {
    /// Reading per true value, dimensionless.
    pub gain: f64,
    /// Added to the reading.
    pub offset: f64,
    /// White noise, rms, independent from sample to sample.
    pub white_rms: f64,
    /// Coloured noise, rms: first-order low-pass noise.
    pub coloured_rms: f64,
    /// Corner frequency of the coloured noise, Hz.
    pub coloured_corner_hz: f64,
    /// Amplitude of the mains hum.
    pub hum_amplitude: f64,
    /// Frequency of the mains hum, Hz.
    pub hum_hz: f64,
}

impl SensorSpec {
    /// True if the reading equals the quantity.
    pub(crate) fn is_exact(&self) -> bool {
        let noise = [self.white_rms, self.coloured_rms, self.hum_amplitude];
        self.gain == 1.0 && self.offset == 0.0 && noise == [0.0; 3]
    }
}

/// One analogue channel.
#[derive(Clone, Debug)]
pub struct Sensor {
    gain: f64,
    offset: f64,
    white_rms: f64,
    coloured: Option<Coloured>,
    hum: Option<Hum>,
    normal: Normal,
}

impl Sensor {
    pub(crate) fn new(spec: &SensorSpec, rate_hz: f64, normal: Normal) -> Self {
        Self {
            gain: spec.gain,
            offset: spec.offset,
            white_rms: spec.white_rms,
            coloured: (spec.coloured_rms > 0.0)
                .then(|| Coloured::new(spec.coloured_rms, spec.coloured_corner_hz, rate_hz)),
            hum: (spec.hum_amplitude > 0.0)
                .then(|| Hum::new(spec.hum_amplitude, spec.hum_hz, rate_hz)),
            normal,
        }
    }

    /// The voltage, in units of the quantity, for a true value of `quantity`.
    #[inline]
    pub fn step(&mut self, quantity: f64) -> f64 {
        let mut reading = self.gain * quantity + self.offset;
        if self.white_rms > 0.0 {
            reading += self.white_rms * self.normal.sample();
        }
        if let Some(coloured) = &mut self.coloured {
            reading += coloured.step(self.normal.sample());
        }
        if let Some(hum) = &mut self.hum {
            reading += hum.step();
        }
        reading
    }
}

/// First-order noise: `n = a n + b g`, `a = exp(-2 pi f_c dt)`, stationary from the first sample.
#[derive(Clone, Debug)]
struct Coloured {
    keeps: f64,
    adds: f64,
    rms: f64,
    value: Option<f64>,
}

impl Coloured {
    fn new(rms: f64, corner_hz: f64, rate_hz: f64) -> Self {
        let keeps = (-TAU * corner_hz / rate_hz).exp();
        Self {
            keeps,
            adds: rms * (1.0 - keeps * keeps).sqrt(),
            rms,
            value: None,
        }
    }

    #[inline]
    fn step(&mut self, normal: f64) -> f64 {
        let value = match self.value {
            Some(value) => self.keeps * value + self.adds * normal,
            None => self.rms * normal,
        };
        self.value = Some(value);
        value
    }
}

/// A sine by rotation.
#[derive(Clone, Debug)]
pub(crate) struct Hum {
    cos: f64,
    sin: f64,
    re: f64,
    im: f64,
}

impl Hum {
    pub(crate) fn new(amplitude: f64, frequency_hz: f64, rate_hz: f64) -> Self {
        let (sin, cos) = (TAU * frequency_hz / rate_hz).sin_cos();
        Self {
            cos,
            sin,
            re: amplitude,
            im: 0.0,
        }
    }

    #[inline]
    pub(crate) fn step(&mut self) -> f64 {
        let re = self.cos * self.re - self.sin * self.im;
        self.im = self.sin * self.re + self.cos * self.im;
        self.re = re;
        self.im
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Purpose;

    const CLEAN: SensorSpec = SensorSpec {
        gain: 1.0,
        offset: 0.0,
        white_rms: 0.0,
        coloured_rms: 0.0,
        coloured_corner_hz: 50.0,
        hum_amplitude: 0.0,
        hum_hz: 50.0,
    };

    fn record(spec: SensorSpec, n: usize) -> Vec<f64> {
        let mut s = Sensor::new(&spec, 2000.0, Normal::new(1, Purpose::ForceNoise, 0));
        (0..n).map(|_| s.step(2.0)).collect()
    }

    fn moments(x: &[f64]) -> (f64, f64, f64) {
        let n = x.len() as f64;
        let mean = x.iter().sum::<f64>() / n;
        let var = x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
        let lag1 = x
            .windows(2)
            .map(|w| (w[0] - mean) * (w[1] - mean))
            .sum::<f64>()
            / n;
        (mean, var.sqrt(), lag1 / var)
    }

    #[test]
    fn gain_and_offset_are_applied_to_the_quantity() {
        let spec = SensorSpec {
            gain: 1.01,
            offset: -0.5,
            ..CLEAN
        };
        assert_eq!(record(spec, 1)[0], 2.0 * 1.01 - 0.5);
    }

    #[test]
    fn white_noise_has_its_rms_and_no_memory() {
        let (mean, rms, lag1) = moments(&record(
            SensorSpec {
                white_rms: 0.3,
                ..CLEAN
            },
            200_000,
        ));
        assert!((mean - 2.0).abs() < 4.0 * 0.3 / 447.0, "{mean}");
        assert!((rms / 0.3 - 1.0).abs() < 0.01, "{rms}");
        assert!(lag1.abs() < 0.01, "{lag1}");
    }

    #[test]
    fn coloured_noise_has_its_rms_and_its_memory() {
        let spec = SensorSpec {
            coloured_rms: 0.3,
            coloured_corner_hz: 40.0,
            ..CLEAN
        };
        let (_, rms, lag1) = moments(&record(spec, 400_000));
        assert!((rms / 0.3 - 1.0).abs() < 0.02, "{rms}");
        assert!(
            (lag1 - (-TAU * 40.0 / 2000.0_f64).exp()).abs() < 0.01,
            "{lag1}"
        );
    }

    #[test]
    fn hum_has_its_amplitude_at_its_frequency_for_hours() {
        let spec = SensorSpec {
            hum_amplitude: 0.1,
            hum_hz: 49.7,
            ..CLEAN
        };
        let x = record(spec, 8_000_000);
        for i in (0..x.len()).step_by(999_983) {
            let t = (i + 1) as f64 / 2000.0;
            let exact = 2.0 + 0.1 * (TAU * 49.7 * t).sin();
            assert!((x[i] - exact).abs() < 1e-8, "sample {i}");
        }
    }
}
