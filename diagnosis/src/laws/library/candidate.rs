//! An effect of the library: its shapes, its columns, bounds of its amplitudes; and helpers for several effects.

use crate::numbers::linear::Bound;
use crate::numbers::signals::{Scales, Signals};
use plant::Effect;

/// A parameter on which the response depends nonlinearly; searched on a logarithmic scale if it is positive, otherwise
/// on a linear one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Smallest value tried.
    pub low: f64,
    /// Largest value tried.
    pub high: f64,
}

impl Shape {
    pub const fn new(low: f64, high: f64) -> Self {
        Self { low, high }
    }
}

/// Transforms a signal, for these shapes.
pub type Stage = fn(&[f64], &[f64], &Scales) -> Vec<f64>;

/// Adds to a signal, one column per amplitude, for these shapes.
pub type Columns = fn(&Signals, &[f64], &Scales) -> Vec<Vec<f64>>;

/// A parameter of the catalogue: name, unit, value.
pub type NamedValue = (&'static str, &'static str, f64);

/// An effect of the library in one channel.
#[derive(Clone, Copy)]
pub struct Candidate {
    /// Which effect.
    pub effect: Effect,
    /// Its shape parameters for data of these sizes.
    pub shapes: fn(&Scales) -> Vec<Shape>,
    /// Its contribution to the response, one column per amplitude.
    pub columns: Columns,
    /// Instead of columns: transforms the whole response before it. Without amplitude.
    pub stage: Option<Stage>,
    /// Bounds of its amplitudes.
    pub bounds: fn(&Scales) -> Vec<Bound>,
    /// Amplitudes and shapes as the parameters of the catalogue: name, unit, value.
    pub parameters: fn(&[f64], &[f64], &Scales) -> Vec<NamedValue>,
}

/// An effect from a model file, with known amplitudes and shapes.
#[derive(Clone, Copy)]
pub struct Known {
    /// Which effect.
    pub effect: Effect,
    /// Like those of a [`Candidate`].
    pub columns: Columns,
    /// Like that of a [`Candidate`].
    pub stage: Option<Stage>,
}

impl Candidate {
    /// The part of it that a model file needs.
    pub const fn known(&self) -> Known {
        Known {
            effect: self.effect,
            columns: self.columns,
            stage: self.stage,
        }
    }
}

impl std::fmt::Debug for Candidate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.effect)
    }
}

/// No shape parameter.
pub fn no_shape(_: &Scales) -> Vec<Shape> {
    Vec::new()
}

/// An effect without amplitude.
pub fn none(_: &Scales) -> Vec<Bound> {
    Vec::new()
}

/// A replacement of the whole response: its column is the difference that it makes, once.
pub fn once(_: &Scales) -> Vec<Bound> {
    vec![Bound {
        low: 0.85,
        high: 1.15,
    }]
}

/// Bounds: any size and sign.
pub fn any(_: &Scales) -> Vec<Bound> {
    vec![Bound::FREE]
}

/// Bounds: any size.
pub fn positive(_: &Scales) -> Vec<Bound> {
    vec![Bound::POSITIVE]
}

/// Slow effects: range of their settling times. A drift that has settled when the motion begins is an offset.
pub fn settling(s: &Scales) -> Vec<Shape> {
    vec![Shape::new(0.2 * s.seconds, 200.0 * s.seconds)]
}

/// Range of a hum's frequency: around the line in the residual.
pub fn humming(s: &Scales) -> Vec<Shape> {
    let hz = s.line_hz.unwrap_or(50.0);
    let width = 0.6 / s.seconds;
    vec![Shape::new(hz - width, hz + width)]
}

/// The line and its third harmonic, each in two phases.
pub fn hum_columns(s: &Signals, shape: &[f64]) -> Vec<Vec<f64>> {
    let omega = std::f64::consts::TAU * shape[0];
    let wave = |harmonic: f64, phase: f64| {
        s.time_s
            .iter()
            .map(|t| (harmonic * omega * t + phase).sin())
            .collect()
    };
    let quarter = std::f64::consts::FRAC_PI_2;
    vec![
        wave(1.0, 0.0),
        wave(1.0, quarter),
        wave(3.0, 0.0),
        wave(3.0, quarter),
    ]
}

/// Bounds of four amplitudes of any size and sign.
pub fn four(_: &Scales) -> Vec<Bound> {
    vec![Bound::FREE; 4]
}

/// Amplitude of the fundamental, and the relative third harmonic.
pub fn hum_size(amplitudes: &[f64]) -> (f64, f64) {
    let first = amplitudes[0].hypot(amplitudes[1]);
    (
        first,
        amplitudes[2].hypot(amplitudes[3]) / first.max(f64::MIN_POSITIVE),
    )
}

/// Largest ratio of friction at rest to that in motion.
pub const MOST_AT_REST: f64 = 4.0;

/// Friction independent of speed, and friction that falls to its level from [`MOST_AT_REST`] times that by `slow`.
pub fn stribeck(friction: Vec<f64>, slow: impl Iterator<Item = f64>) -> Vec<Vec<f64>> {
    let falls = friction.iter().zip(slow);
    let falls = falls.map(|(z, slow)| z * (1.0 + (MOST_AT_REST - 1.0) * slow));
    let falls = falls.collect();
    vec![friction, falls]
}

/// Ratio of the friction at rest to that in motion.
pub fn rest_ratio(amplitudes: &[f64]) -> f64 {
    let share = amplitudes[1] / (amplitudes[0] + amplitudes[1]).max(f64::MIN_POSITIVE);
    1.0 + (MOST_AT_REST - 1.0) * share
}

/// Growth towards an end value, `1 - exp(-t / tau)`.
pub fn growth(s: &Signals, tau_s: f64) -> impl Iterator<Item = f64> + '_ {
    s.time_s.iter().map(move |t| 1.0 - (-t / tau_s).exp())
}
