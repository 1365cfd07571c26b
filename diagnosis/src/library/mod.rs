//! The library: what each effect adds to the answer of a channel, as columns whose amplitudes are fitted, of shapes
//! that are searched.

mod actuator;
pub mod operators;
mod saved;
mod specimen;

pub use saved::{fit_of, form_names};

use crate::linear::Bound;
use crate::signals::{Scales, Signals};
use plant::{Channel, Effect, EffectSpec};

/// A parameter that the answer depends on other than in proportion; searched on a logarithmic scale where it is
/// positive, else on a straight one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Smallest value that is tried.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// How many values the search begins with.
    pub grid: usize,
}

impl Shape {
    const fn new(low: f64, high: f64, grid: usize) -> Self {
        Self { low, high, grid }
    }
}

/// Passes a signal on changed, for these shapes.
pub type Stage = fn(&[f64], &[f64], &Scales) -> Vec<f64>;

/// A parameter of the catalogue: its name, its unit, its value.
pub type Named = (&'static str, &'static str, f64);

/// An effect of the library in one channel.
#[derive(Clone, Copy)]
pub struct Candidate {
    /// Which effect.
    pub effect: Effect,
    /// Where.
    pub channel: Channel,
    /// Its shape parameters for data of these sizes.
    pub shapes: fn(&Scales) -> Vec<Shape>,
    /// What it adds to the answer, a column for each amplitude.
    pub columns: fn(&Signals, &[f64], &Scales) -> Vec<Vec<f64>>,
    /// Instead of columns: what the effect makes of the whole answer before it. Without amplitude.
    pub stage: Option<Stage>,
    /// The declared parameter that its stage takes out and puts in again with its shape added.
    pub instead_of: Option<usize>,
    /// Its columns are a reading, with the noise of that.
    pub from_reading: bool,
    /// What its amplitudes may be.
    pub bounds: fn(&Scales) -> Vec<Bound>,
    /// Amplitudes and shapes as the parameters of the catalogue: name, unit, value.
    pub parameters: fn(&[f64], &[f64], &Scales) -> Vec<Named>,
    /// Effects of which this one is a generalisation: it fits whatever they fit.
    pub includes: &'static [Effect],
}

impl std::fmt::Debug for Candidate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} in the {}", self.effect, self.channel)
    }
}

/// All candidates of a channel.
pub fn candidates(channel: Channel) -> Vec<Candidate> {
    match channel {
        Channel::Actuator => actuator::CANDIDATES.to_vec(),
        Channel::Specimen => specimen::CANDIDATES.to_vec(),
    }
}

/// What an effect of a model is in the library: a candidate, or one of its forms where it has the form's parameters.
pub fn form(channel: Channel, effect: &EffectSpec) -> Option<Candidate> {
    let own = form_names(channel, effect);
    let forms = actuator::FORMS.iter().copied();
    let form = forms
        .filter(|_| !own.is_empty())
        .find(|c| c.effect == effect.name);
    let all = candidates(channel);
    form.or_else(|| all.into_iter().find(|c| c.effect == effect.name))
}

/// No shape parameter.
fn no_shape(_: &Scales) -> Vec<Shape> {
    Vec::new()
}

/// An effect without amplitude.
fn none(_: &Scales) -> Vec<Bound> {
    Vec::new()
}

/// A replacement of the whole answer: its column is the difference that it makes, once.
fn once(_: &Scales) -> Vec<Bound> {
    vec![Bound {
        low: 0.85,
        high: 1.15,
    }]
}

fn any(_: &Scales) -> Vec<Bound> {
    vec![Bound::FREE]
}

fn positive(_: &Scales) -> Vec<Bound> {
    vec![Bound::POSITIVE]
}

/// Slow effects: how long they take to settle.
fn settling(s: &Scales) -> Vec<Shape> {
    vec![Shape::new(0.05 * s.seconds, 200.0 * s.seconds, 10)]
}

/// The frequency of hum: around the line that the residual shows.
fn humming(s: &Scales) -> Vec<Shape> {
    let hz = s.line_hz.unwrap_or(50.0);
    let width = 0.6 / s.seconds;
    vec![Shape::new(hz - width, hz + width, 7)]
}

fn hum_columns(s: &Signals, shape: &[f64]) -> Vec<Vec<f64>> {
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

fn four(_: &Scales) -> Vec<Bound> {
    vec![Bound::FREE; 4]
}

/// Amplitude of the fundamental, and the share of the third harmonic.
fn hum_size(amplitudes: &[f64]) -> (f64, f64) {
    let first = amplitudes[0].hypot(amplitudes[1]);
    (
        first,
        amplitudes[2].hypot(amplitudes[3]) / first.max(f64::MIN_POSITIVE),
    )
}

/// Friction at rest is at most so many times that in motion.
const MOST_AT_REST: f64 = 4.0;

/// Friction that is the same at any speed, and friction that falls from [`MOST_AT_REST`] times to its size by `slow`.
fn stribeck(friction: Vec<f64>, slow: impl Iterator<Item = f64>) -> Vec<Vec<f64>> {
    let falls = friction.iter().zip(slow);
    let falls = falls.map(|(z, slow)| z * (1.0 + (MOST_AT_REST - 1.0) * slow));
    let falls = falls.collect();
    vec![friction, falls]
}

/// Of the friction at rest to that in motion.
fn rest_ratio(amplitudes: &[f64]) -> f64 {
    let share = amplitudes[1] / (amplitudes[0] + amplitudes[1]).max(f64::MIN_POSITIVE);
    1.0 + (MOST_AT_REST - 1.0) * share
}

/// Growth towards an end value, `1 - exp(-t / tau)`.
fn growth(s: &Signals, tau_s: f64) -> impl Iterator<Item = f64> + '_ {
    s.time_s.iter().map(move |t| 1.0 - (-t / tau_s).exp())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signals::Transfer;

    #[test]
    fn every_name_has_a_candidate_in_every_channel_of_the_catalogue() {
        for entry in plant::catalogue() {
            for &channel in entry.channels {
                // Quantisation is read off the values themselves.
                let found = candidates(channel).iter().any(|c| c.effect == entry.effect);
                assert_eq!(
                    found,
                    entry.effect != Effect::Quantisation,
                    "{} {channel}",
                    entry.effect
                );
            }
        }
    }

    #[test]
    fn parameters_are_those_of_the_catalogue() {
        let scales = Scales {
            x: 10.0,
            v: 100.0,
            base: 1000.0,
            stiffness: 100.0,
            seconds: 20.0,
            interval_s: 1e-3,
            step_s: 1e-3,
            actuator: Transfer {
                gain: 1.0,
                delay_s: 5e-3,
                lag_s: 2e-2,
                offset_mm: 0.0,
            },
            declared: Transfer {
                gain: 1.0,
                delay_s: 5e-3,
                lag_s: 2e-2,
                offset_mm: 0.0,
            },
            line_hz: None,
        };
        for channel in [Channel::Actuator, Channel::Specimen] {
            for c in candidates(channel) {
                let shapes: Vec<f64> = (c.shapes)(&scales)
                    .iter()
                    .map(|s| s.high.min((s.low * s.high).abs().sqrt()))
                    .collect();
                let amplitudes = vec![0.5; (c.bounds)(&scales).len()];
                let named = (c.parameters)(&amplitudes, &shapes, &scales);
                let values: Vec<_> = named
                    .iter()
                    .map(|(name, _, value)| (*name, *value))
                    .collect();
                // The file has these alone: the way back gives the same.
                let saved = plant::EffectSpec::new(c.effect, &values);
                let (a, p) = fit_of(&c, &saved, &scales);
                for ((name, _, value), (_, _, again)) in
                    named.iter().zip((c.parameters)(&a, &p, &scales))
                {
                    let room = 1e-9 * value.abs() + 1e-12;
                    assert!(
                        (value - again).abs() < room,
                        "{c:?}: {name} {value} {again}"
                    );
                }
                for (name, unit, value) in named {
                    let known = c.effect.entry().parameters.iter().find(|p| p.name == name);
                    let known = known.unwrap_or_else(|| panic!("{c:?}: {name}"));
                    assert_eq!(known.accept.unit, unit, "{c:?}: {name}");
                    assert!(value.is_finite(), "{c:?}: {name} = {value}");
                }
            }
        }
    }
}
