//! What moves an actuator apart from a test: a signal that the board makes by itself, or points that it is sent.

use super::connection::Connection;
use super::orders::done;
use super::port::Port;
use super::upload::load;
use experiment::failure::Failure;
use experiment::files::signal::SignalPoints as Points;
use link::Command;
use link::command::{CommissioningSignal, MAX_POINTS, SignalShape};
use outerloop_core::Config;

/// Rise of a constant signal, s.
const RISE_S: f64 = 0.5;

/// A way of the actuator over time.
#[derive(Clone, Debug)]
pub enum Trajectory {
    /// The board's own.
    Formula(CommissioningSignal),
    /// Sent to it.
    Points(Points),
}

impl Trajectory {
    /// Largest displacement, m.
    pub fn peak_m(&self) -> f64 {
        match self {
            Self::Formula(signal) => f64::from(signal.amplitude_m),
            Self::Points(points) => points.peak_m(),
        }
    }

    /// Largest velocity, m/s.
    pub fn speed_m_per_s(&self) -> f64 {
        match self {
            Self::Points(points) => points.speed_m_per_s(),
            Self::Formula(signal) => {
                let top_hz = match signal.shape {
                    SignalShape::Constant | SignalShape::Points => 1.0 / RISE_S,
                    SignalShape::Sine { frequency_hz } => f64::from(frequency_hz),
                    SignalShape::Chirp { from_hz, to_hz } => f64::from(from_hz.max(to_hz)),
                };
                std::f64::consts::TAU * top_hz * self.peak_m()
            }
        }
    }

    /// True if it stays inside the limits that a test states.
    ///
    /// # Errors
    /// The first limit that it would pass.
    pub fn check(&self, config: &Config) -> Result<(), Failure> {
        let limits = &config.limits;
        let (peak_m, speed) = (self.peak_m(), self.speed_m_per_s());
        let all = [
            ("limits.displacement_m", limits.displacement_m, peak_m, "m"),
            (
                "limits.velocity_m_per_s",
                limits.velocity_m_per_s,
                speed,
                "m/s",
            ),
            (
                "limits.increment_m",
                limits.increment_m,
                speed / config.timing.rate_hz,
                "m a step",
            ),
        ];
        let passed = |(name, limit, reached, unit): (&str, Option<f64>, f64, &str)| {
            let limit = limit.filter(|l| reached > *l)?;
            Some(Failure::input(format!(
                "the signal reaches {reached:.5} {unit}, and {name} = {limit}: accepted is a signal inside the limits of the test file"
            )))
        };
        all.into_iter().find_map(passed).map_or(Ok(()), Err)
    }

    /// How long it is, s.
    pub(super) fn seconds(&self) -> f64 {
        match self {
            Self::Formula(signal) => f64::from(signal.seconds),
            Self::Points(points) => points.seconds(),
        }
    }

    /// Sends it to a board, which moves `actuator`, from 0, by it with the next start.
    pub(super) fn send<P: Port>(
        &self,
        board: &mut Connection<P>,
        config: &Config,
        actuator: u8,
    ) -> Result<(), Failure> {
        let signal = match self {
            Self::Formula(signal) => CommissioningSignal {
                actuator,
                ..*signal
            },
            Self::Points(points) => {
                // As many points as there is room for, and no more than control steps.
                let room = points.seconds() / (MAX_POINTS - 2) as f64;
                let interval_s = points.interval_s.max(room).max(1.0 / config.timing.rate_hz);
                let sent: Vec<f32> = points.every(interval_s).iter().map(|x| *x as f32).collect();
                let amplitude_m = sent.iter().fold(0.0_f32, |m, x| m.max(x.abs()));
                // Laid over integration steps, which are of model time.
                load(board, &sent, interval_s / config.timing.time_scale)?;
                CommissioningSignal {
                    actuator,
                    shape: SignalShape::Points,
                    amplitude_m,
                    seconds: points.seconds() as f32,
                }
            }
        };
        done(board, "signal", &Command::Signal(Some(signal))).map(drop)
    }
}
