//! The building blocks of a test: motions around a middle that begin and end there at rest.

use super::test_limits::TestLimits;
use schemars::JsonSchema;
use serde::Serialize;
use std::f64::consts::TAU;

/// The form of a phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// Nothing moves.
    Rest,
    /// Sines of one frequency.
    Sine,
    /// There and back at a constant speed, with a stop at either end.
    Ramps,
    /// To one side only, then to the other.
    OneSided,
    /// A large ramp with smaller turns on the way.
    Turns,
    /// A small sine whose frequency rises.
    Chirp,
}

impl Form {
    /// In words.
    pub const fn in_words(self) -> &'static str {
        match self {
            Self::Rest => "rest",
            Self::Sine => "sine",
            Self::Ramps => "ramps with stops",
            Self::OneSided => "to one side, then the other",
            Self::Turns => "ramp with smaller turns",
            Self::Chirp => "chirp",
        }
    }
}

/// A part of a test.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Phase {
    /// Its form.
    pub form: Form,
    /// Largest distance from the middle, mm.
    pub amplitude_mm: f64,
    /// Top speed, mm/s.
    pub speed_mm_per_s: f64,
    /// Frequency of a sine, the highest of a chirp, Hz; 0 where there is none.
    pub frequency_hz: f64,
    /// How long it takes, s.
    pub seconds: f64,
}

/// Amplitudes to try, as fractions of the room.
const AMPLITUDES: [f64; 4] = [0.06, 0.2, 0.5, 0.95];
/// Top speeds to try, as fractions of the limit.
const SPEEDS: [f64; 4] = [0.02, 0.1, 0.35, 0.95];
/// Factor on a sine's speed by its rising and falling envelope.
const ENVELOPE: f64 = 1.12;
/// Full cycles of a sine; it rises over one additional cycle and falls over another.
const CYCLES: f64 = 2.0;
/// Stop at the end of a ramp, s.
const STOP_S: f64 = 1.0;
/// Shortest and longest phase, s.
const SECONDS: [f64; 2] = [0.4, 24.0];
/// Lowest frequency of a chirp, as a fraction of the highest.
const CHIRP: f64 = 0.05;
/// Length of a chirp, s.
const CHIRP_S: f64 = 10.0;

/// A phase and its command around 0, mm.
pub type Played = (Phase, Vec<f64>);

/// Nothing moves.
pub fn rest(seconds: f64, interval_s: f64) -> Played {
    let n = (seconds / interval_s).round().max(1.0) as usize;
    (
        phase(Form::Rest, 0.0, 0.0, &vec![0.0; n], interval_s),
        vec![0.0; n],
    )
}

/// A smooth passage from one position to another.
pub fn passage(from_mm: f64, to_mm: f64, speed_mm_per_s: f64, interval_s: f64) -> Vec<f64> {
    let way = to_mm - from_mm;
    let seconds = 1.6 * way.abs() / speed_mm_per_s;
    let n = (seconds / interval_s).ceil().max(1.0) as usize;
    let part = |i: usize| 0.5 - 0.5 * (0.5 * TAU * i as f64 / n as f64).cos();
    (1..=n).map(|i| from_mm + way * part(i)).collect()
}

/// Everything that fits into a room, up to a highest frequency.
pub fn all(test_limits: &TestLimits, highest_hz: f64, interval_s: f64) -> Vec<Played> {
    let (x, v) = (test_limits.half_mm, test_limits.velocity_mm_per_s);
    let mut all: Vec<Played> = Vec::new();
    let mut add = |form, hz: f64, command: Vec<f64>| {
        all.push((phase(form, hz, 0.0, &command, interval_s), command));
    };
    for a in AMPLITUDES.map(|a| a * x) {
        for v in SPEEDS.map(|s| s * v) {
            let hz = v / (TAU * a) / ENVELOPE;
            if hz <= highest_hz && (CYCLES + 2.0) / hz <= SECONDS[1] {
                add(Form::Sine, hz, sine(a, hz, interval_s));
                add(Form::OneSided, hz, one_sided(a, hz, interval_s));
            }
            let corner_s = (0.2 * a / v).max(6.0 * interval_s);
            let stops = |at: &[f64]| ramps(at, v, STOP_S, corner_s, interval_s);
            let turns = |at: &[f64]| ramps(at, v, 0.0, corner_s, interval_s);
            if a / v < 4.0 && a / v > 12.0 * interval_s {
                add(Form::Ramps, 0.0, stops(&[0.0, a, -a, a, -a, 0.0]));
                let way = [
                    0.0, 0.5, 0.1, 1.0, 0.3, 0.7, -0.3, 0.2, -1.0, -0.3, -0.7, 0.0,
                ];
                add(Form::Turns, 0.0, turns(&way.map(|w| w * a)));
            }
        }
        // The highest frequency that the speed allows.
        let hz = (0.95 * v / (TAU * a)).min(highest_hz);
        if hz > 0.5 {
            add(Form::Chirp, hz, chirp(a, hz, interval_s));
        }
    }
    all.retain(|(p, _)| {
        (SECONDS[0]..=SECONDS[1]).contains(&p.seconds)
            && p.speed_mm_per_s <= v
            && p.amplitude_mm <= x
    });
    all
}

fn phase(form: Form, frequency_hz: f64, middle: f64, command: &[f64], interval_s: f64) -> Phase {
    let far = command
        .iter()
        .fold(0.0_f64, |m, x| m.max((x - middle).abs()));
    let steps = command.windows(2).map(|w| (w[1] - w[0]).abs());
    Phase {
        form,
        amplitude_mm: far,
        speed_mm_per_s: steps.fold(0.0, f64::max) / interval_s,
        frequency_hz,
        seconds: command.len() as f64 * interval_s,
    }
}

/// From 0 to 1 and back to 0, with `rise` of the whole at either end.
fn envelope(part: f64, rise: f64) -> f64 {
    let near = (part.min(1.0 - part) / rise).clamp(0.0, 1.0);
    0.5 - 0.5 * (0.5 * TAU * near).cos()
}

fn sine(a: f64, hz: f64, h: f64) -> Vec<f64> {
    let cycles = CYCLES + 2.0;
    let n = (cycles / hz / h).ceil() as usize;
    let at = |i: usize| i as f64 / n as f64;
    (0..n)
        .map(|i| a * envelope(at(i), 1.0 / cycles) * (TAU * cycles * at(i)).sin())
        .collect()
}

fn one_sided(a: f64, hz: f64, h: f64) -> Vec<f64> {
    let n = (1.0 / hz / h).ceil() as usize;
    let turn = |i: usize| 0.5 - 0.5 * (TAU * i as f64 / n as f64).cos();
    let side = |way: f64| (0..n).map(move |i| way * a * turn(i));
    side(1.0)
        .chain(side(1.0))
        .chain(side(-1.0))
        .chain(side(-1.0))
        .collect()
}

/// Through positions at a constant speed, with stops; corners are rounded over `corner_s`.
fn ramps(places: &[f64], v: f64, stop_s: f64, corner_s: f64, h: f64) -> Vec<f64> {
    let stop = ((stop_s + corner_s) / h) as usize;
    let mut sharp = vec![places[0]; stop + 1];
    for pair in places.windows(2) {
        let steps = ((pair[1] - pair[0]).abs() / v / h).ceil().max(1.0) as usize;
        let on = |i: usize| pair[0] + (pair[1] - pair[0]) * i as f64 / steps as f64;
        sharp.extend((1..=steps).map(on));
        sharp.extend(std::iter::repeat_n(pair[1], (stop_s / h) as usize));
    }
    let last = sharp[sharp.len() - 1];
    sharp.extend(std::iter::repeat_n(last, stop + 1));
    let width = ((0.5 * corner_s / h) as usize).max(1);
    running_mean(&running_mean(&sharp, width), width)
}

/// Mean over `width` samples to either side.
fn running_mean(x: &[f64], width: usize) -> Vec<f64> {
    let sums: Vec<f64> = std::iter::once(0.0)
        .chain(x.iter().scan(0.0, |sum, x| {
            *sum += x;
            Some(*sum)
        }))
        .collect();
    (0..x.len())
        .map(|i| {
            let (from, end) = (i.saturating_sub(width), (i + width + 1).min(x.len()));
            (sums[end] - sums[from]) / (end - from) as f64
        })
        .collect()
}

fn chirp(a: f64, hz: f64, h: f64) -> Vec<f64> {
    let n = (CHIRP_S / h).ceil() as usize;
    let low = CHIRP * hz;
    let phase = |t: f64| low * t + 0.5 * (hz - low) * t * t / CHIRP_S;
    (0..n)
        .map(|i| {
            let t = i as f64 * h;
            a * envelope(i as f64 / n as f64, 0.1) * (TAU * phase(t)).sin()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_phase_stays_inside_the_room_and_begins_and_ends_at_rest() {
        let test_limits = TestLimits {
            half_mm: 20.0,
            velocity_mm_per_s: 100.0,
            ..TestLimits::default()
        };
        let h = 1e-3;
        let all = all(&test_limits, 10.0, h);
        for form in [
            Form::Sine,
            Form::Ramps,
            Form::OneSided,
            Form::Turns,
            Form::Chirp,
        ] {
            assert!(all.iter().any(|(p, _)| p.form == form), "{form:?}");
        }
        for (p, x) in &all {
            let far = x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            let fast = x
                .windows(2)
                .map(|w| (w[1] - w[0]).abs() / h)
                .fold(0.0, f64::max);
            assert!(far <= 20.0 && fast <= 100.0, "{p:?}");
            let n = x.len();
            assert!(
                x[0].abs() < 0.01 && x[n - 1].abs() < 0.2,
                "{p:?}: {} {}",
                x[0],
                x[n - 1]
            );
            let jump = (x[1] - x[0]).abs().max((x[n - 1] - x[n - 2]).abs()) / h;
            assert!(jump < 0.05 * p.speed_mm_per_s.max(1.0), "{p:?}: {jump}");
        }
        // Slow and fast, small and large.
        let speeds = all.iter().map(|(p, _)| p.speed_mm_per_s);
        assert!(speeds.clone().fold(0.0, f64::max) > 10.0 * speeds.fold(f64::MAX, f64::min));
    }
}
