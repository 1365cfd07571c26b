//! Commissioning signals, to measure the actuator with: constant, sine and chirp around zero, and points sent by the
//! PC.
//!
//! micromath's sine is off by less than 1.2e-3 of the amplitude (the test below measures it): good enough here, since
//! the record has the actual command. The control path uses libm instead.

use core::num::NonZeroU32;
use link::command::{CommissioningSignal, SignalShape};
use micromath::F32Ext;
use outerloop_core::{Config, GroundMotion, Refusal};

/// Rise and fall, s.
pub const RAMP_S: f32 = 0.5;

/// The longest signal, s.
const LONGEST_S: f32 = 600.0;

/// A signal, step by step.
#[derive(Clone, Copy, Debug)]
pub struct Generator {
    signal: CommissioningSignal,
    step_s: f32,
    /// Control steps per integration step, onto which uploaded points are mapped.
    substeps: NonZeroU32,
    step: u32,
    steps: u32,
    /// Phase of the oscillation in turns, 0 to 1.
    phase: f32,
}

impl Generator {
    /// Checks the signal against the test's rate and limits. `uploaded_m` is the largest uploaded point.
    ///
    /// # Errors
    /// The first parameter that is not accepted.
    pub fn new(
        signal: CommissioningSignal,
        config: &Config,
        uploaded_m: Option<f32>,
    ) -> Result<Self, Refusal> {
        let refuse = |name, value, accepted| {
            Err(Refusal {
                name,
                value: f64::from(value),
                accepted,
            })
        };
        let stroke_m = config.limits.displacement_m.unwrap_or(0.0) as f32;
        if !(signal.amplitude_m.abs() <= stroke_m) {
            return refuse(
                "signal.amplitude_m",
                signal.amplitude_m,
                "up to limits.displacement_m, which must be set",
            );
        }
        if !(signal.seconds >= 2.0 * RAMP_S && signal.seconds <= LONGEST_S) {
            return refuse("signal.seconds", signal.seconds, "1 to 600 s");
        }
        let rate_hz = config.timing.rate_hz as f32;
        let top_hz = rate_hz / 20.0;
        if signal.shape == SignalShape::Points {
            let most_m = uploaded_m.unwrap_or(f32::NAN);
            if !(most_m <= signal.amplitude_m) {
                return refuse(
                    "signal.points_m",
                    most_m,
                    "points that were sent, none above signal.amplitude_m",
                );
            }
        }
        let frequencies: &[f32] = match &signal.shape {
            SignalShape::Constant | SignalShape::Points => &[],
            SignalShape::Sine { frequency_hz } => &[*frequency_hz],
            SignalShape::Chirp { from_hz, to_hz } => &[*from_hz, *to_hz],
        };
        for &f in frequencies {
            if !(f > 0.0 && f <= top_hz) {
                return refuse(
                    "signal.frequency_hz",
                    f,
                    "above 0 and at most a twentieth of loop.rate_hz",
                );
            }
        }
        Ok(Self {
            signal,
            step_s: 1.0 / rate_hz,
            substeps: NonZeroU32::new(config.timing.substeps.into()).unwrap_or(NonZeroU32::MIN),
            step: 0,
            steps: (signal.seconds * rate_hz) as u32,
            phase: 0.0,
        })
    }

    /// The actuator that it moves, from 0.
    pub fn actuator(&self) -> usize {
        usize::from(self.signal.actuator)
    }

    /// True if it plays the uploaded points.
    pub fn plays_points(&self) -> bool {
        self.signal.shape == SignalShape::Points
    }

    /// The next command, m; `None` after the end, where the command is zero. `points` are the uploaded ones.
    pub fn next_m(&mut self, points: &GroundMotion<'_>) -> Option<f32> {
        if self.step > self.steps {
            return None;
        }
        if self.signal.shape == SignalShape::Points {
            let at = self.step / self.substeps;
            let share = (self.step % self.substeps) as f32 / self.substeps.get() as f32;
            let here_m = points.at(at);
            self.step += 1;
            return Some(here_m + share * (points.at(at + 1) - here_m));
        }
        let t_s = self.step as f32 * self.step_s;
        let rest_s = (self.steps - self.step) as f32 * self.step_s;
        let shape = match self.signal.shape {
            SignalShape::Constant | SignalShape::Points => 1.0,
            SignalShape::Sine { .. } | SignalShape::Chirp { .. } => {
                F32Ext::sin(self.phase * core::f32::consts::TAU)
            }
        };
        self.phase += self.frequency_hz(t_s) * self.step_s;
        self.phase -= self.phase as u32 as f32;
        self.step += 1;
        Some(self.signal.amplitude_m * ramp(t_s) * ramp(rest_s) * shape)
    }

    fn frequency_hz(&self, t_s: f32) -> f32 {
        match self.signal.shape {
            SignalShape::Constant | SignalShape::Points => 0.0,
            SignalShape::Sine { frequency_hz } => frequency_hz,
            SignalShape::Chirp { from_hz, to_hz } => {
                from_hz + (to_hz - from_hz) * t_s / self.signal.seconds
            }
        }
    }
}

/// From 0 to 1 in [`RAMP_S`], with zero slope at both ends.
fn ramp(t_s: f32) -> f32 {
    let x = (t_s / RAMP_S).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config() -> Config {
        let mut config = Config::shear_frame([1000.0], [158e3], [0.02]);
        config.limits.displacement_m = Some(0.02);
        config
    }

    fn run(shape: SignalShape) -> Vec<f32> {
        let signal = CommissioningSignal {
            actuator: 0,
            shape,
            amplitude_m: 0.01,
            seconds: 10.0,
        };
        let mut generator = Generator::new(signal, &config(), None).unwrap();
        core::iter::from_fn(|| generator.next_m(&GroundMotion::none())).collect()
    }

    #[test]
    fn points_that_were_sent_are_gone_through_in_straight_lines() {
        let points = [0.0, 0.008, -0.004, 0.0];
        let mut config = config();
        config.timing.substeps = 4;
        // One point a second; 500 integration steps of four control steps each.
        let motion = GroundMotion::new(&points, 1.0, config.model_step_s()).unwrap();
        let signal = CommissioningSignal {
            actuator: 0,
            shape: SignalShape::Points,
            amplitude_m: 0.008,
            seconds: 3.0,
        };
        let mut generator = Generator::new(signal, &config, Some(0.008)).unwrap();
        let played: Vec<f32> = core::iter::from_fn(|| generator.next_m(&motion)).collect();
        assert_eq!(played.len(), 6001);
        for (step, wanted) in [
            (0, 0.0),
            (1001, 0.004_004),
            (2000, 0.008),
            (3000, 0.002),
            (6000, 0.0),
        ] {
            assert!(
                (played[step] - wanted).abs() < 1e-6,
                "{step}: {}",
                played[step]
            );
        }
        for sent in [None, Some(0.009), Some(f32::NAN)] {
            let refused = Generator::new(signal, &config, sent).unwrap_err();
            assert_eq!(refused.name, "signal.points_m");
        }
    }

    #[test]
    fn micromath_is_as_near_as_it_says() {
        let worst = (0..100_000)
            .map(|i| i as f32 / 100_000.0 * core::f32::consts::TAU)
            .map(|x| (f64::from(F32Ext::sin(x)) - f64::from(x).sin()).abs())
            .fold(0.0, f64::max);
        assert!(worst < 1.2e-3, "{worst}");
    }

    #[test]
    fn a_signal_begins_and_ends_at_zero_and_keeps_its_amplitude_and_frequency() {
        let sine = run(SignalShape::Sine { frequency_hz: 2.0 });
        assert_eq!(sine.len(), 20_001);
        assert!(sine[0] == 0.0 && sine[20_000].abs() < 1e-7);
        let largest = sine.iter().fold(0.0_f32, |a, x| a.max(x.abs()));
        assert!((largest - 0.01).abs() < 2e-5, "{largest}");
        let crossings = sine
            .windows(2)
            .filter(|w| w[0] < 0.0 && w[1] >= 0.0)
            .count();
        assert!(
            (19..=20).contains(&crossings),
            "20 periods; the first begins at zero"
        );
        // No step exceeds the sum of the sine's and the ramp's largest slopes.
        let bound = 0.01 * (core::f32::consts::TAU * 2.0 + 1.5 / RAMP_S) / 2000.0 + 3e-5;
        assert!(sine.windows(2).all(|w| (w[1] - w[0]).abs() < bound));

        let constant = run(SignalShape::Constant);
        assert_eq!(
            (constant[0], constant[10_000], constant[20_000]),
            (0.0, 0.01, 0.0)
        );
    }

    #[test]
    fn a_chirp_goes_through_its_frequencies() {
        let chirp = run(SignalShape::Chirp {
            from_hz: 1.0,
            to_hz: 9.0,
        });
        let rising = |part: &[f32]| {
            part.windows(2)
                .filter(|w| w[0] < 0.0 && w[1] >= 0.0)
                .count()
        };
        // From 4 s to 5 s the mean frequency is 1 + 8 * 0.45 = 4.6 Hz; over all ten seconds it is 5 Hz.
        assert!((4..=5).contains(&rising(&chirp[8000..10_000])));
        assert!((49..=50).contains(&rising(&chirp)));
    }

    #[test]
    fn a_signal_beyond_the_limits_is_refused_with_its_name() {
        let good = CommissioningSignal {
            actuator: 0,
            shape: SignalShape::Sine { frequency_hz: 2.0 },
            amplitude_m: 0.01,
            seconds: 10.0,
        };
        let refused =
            |s: CommissioningSignal| Generator::new(s, &config(), None).err().map(|r| r.name);
        assert_eq!(refused(good), None);
        for amplitude_m in [0.021, f32::NAN, -0.03] {
            let name = refused(CommissioningSignal {
                amplitude_m,
                ..good
            });
            assert_eq!(name, Some("signal.amplitude_m"));
        }
        for seconds in [0.9, 601.0, f32::NAN] {
            let name = refused(CommissioningSignal { seconds, ..good });
            assert_eq!(name, Some("signal.seconds"));
        }
        for frequency_hz in [0.0, -1.0, 101.0, f32::INFINITY] {
            let shape = SignalShape::Chirp {
                from_hz: 1.0,
                to_hz: frequency_hz,
            };
            let name = refused(CommissioningSignal { shape, ..good });
            assert_eq!(name, Some("signal.frequency_hz"));
        }
        let mut unlimited = config();
        unlimited.limits.displacement_m = None;
        assert!(Generator::new(good, &unlimited, None).is_err());
    }
}
