//! A command over time: what `diagnose --next` designs and `board commission --signal` and `run --signal` play.
//! `time_s,command_mm`; any command of a recorded file does.

use super::columns::Columns;
use super::recording::SiRecording;
use crate::failure::Failure;
use fourier::Complex;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

/// A signal for measuring an actuator's frequency response.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "options", derive(clap::ValueEnum))]
pub enum SignalShape {
    /// A sine whose frequency rises exponentially: long at the low frequencies, where a cycle takes long
    Chirp,
    /// Periods of 10 s with odd lines alone, of which one in four is left out: what comes back elsewhere is distortion
    OddMultisine,
}

/// Interval of a generated signal, s; rise and fade time at its ends, s; period of a multisine, s.
const INTERVAL_S: f64 = 1e-3;
const FADE_S: f64 = 1.0;
const PERIOD_S: f64 = 10.0;
/// Above this frequency, Hz, lines and sweeps shrink with it: the speed stays constant, as suits a valve.
const LEVEL_HZ: f64 = 1.0;
/// Number of draws of phases, of which the one with the lowest peak is used.
const DRAWS: u64 = 20;

/// A command.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalPoints {
    /// Sampling interval, s.
    pub interval_s: f64,
    /// Commanded displacement, m.
    pub command_m: Vec<f64>,
}

/// The shortest and the longest signal, s.
const SECONDS: [f64; 2] = [1.0, 600.0];
/// Largest value at a signal's ends, as a fraction of its peak: the rig is at zero before and after it.
const NEAR_ZERO: f64 = 1e-3;

impl SignalPoints {
    /// Reads a file with a time and a command.
    ///
    /// # Errors
    /// A file that cannot be read; no command; uneven time; a signal that does not begin and end at zero, is too long
    /// or too short, or moves nothing.
    pub fn load(path: &Path) -> Result<Self, Failure> {
        let recording =
            SiRecording::load_with_any_time(path, &Columns::default())?.without_gaps()?;
        let refuse = |what: String| Failure::input(format!("{}: {what}", path.display()));
        let command = recording.command_m().ok_or_else(|| {
            refuse("has no command: accepted are the columns time_s and command_mm".into())
        })?;
        let time = &recording.time_s;
        let last = time.len() - 1;
        if last == 0 {
            return Err(refuse(
                "one sample is no signal: accepted are two and more".into(),
            ));
        }
        let interval_s = (time[last] - time[0]) / last as f64;
        let uneven = |i: &usize| (time[*i] - time[*i - 1] - interval_s).abs() > 0.05 * interval_s;
        if let Some(i) = (1..=last).find(uneven) {
            return Err(refuse(format!(
                "time goes from {} s to {} s at line {}: accepted is time that increases by equal intervals, to 5 %",
                time[i - 1],
                time[i],
                recording.lines.get(i).copied().unwrap_or(0)
            )));
        }
        Self {
            interval_s,
            command_m: command.to_vec(),
        }
        .checked()
        .map_err(refuse)
    }

    /// Makes a signal of this shape, with a peak in m, from one frequency to another, Hz, of about this many seconds.
    ///
    /// # Errors
    /// An inadmissible peak, band or length, with what is accepted.
    pub fn made(
        shape: SignalShape,
        peak_m: f64,
        band_hz: [f64; 2],
        seconds: f64,
    ) -> Result<Self, String> {
        let [low, high] = band_hz;
        if !(low > 0.0 && low < high && high <= 100.0) {
            return Err(format!(
                "a band of {low} to {high} Hz is refused: accepted are two frequencies that rise, to 100 Hz"
            ));
        }
        if !(peak_m > 0.0 && peak_m <= 10.0) {
            return Err(format!(
                "a peak of {} mm is refused: accepted are above 0 to 10000 mm",
                1e3 * peak_m
            ));
        }
        let shortest = match shape {
            SignalShape::Chirp => 2.0 * FADE_S + 4.0 / low,
            SignalShape::OddMultisine => 4.0 * PERIOD_S,
        };
        if !(shortest..=SECONDS[1]).contains(&seconds) {
            return Err(format!(
                "a signal of {seconds} s is refused: accepted are {shortest} to {} s for this shape and band",
                SECONDS[1]
            ));
        }
        let last = (seconds / INTERVAL_S).round() as usize;
        let time_s = |i: usize| i as f64 * INTERVAL_S;
        let shaped: Vec<f64> = match shape {
            SignalShape::Chirp => {
                // The phase of an exponential sweep; its size follows its frequency.
                let rate = (high / low).ln() / seconds;
                let at = |t: f64| low * (rate * t).exp();
                (0..=last)
                    .map(|i| (TAU * (at(time_s(i)) - low) / rate).sin() * level(at(time_s(i))))
                    .collect()
            }
            SignalShape::OddMultisine => multisine(last, band_hz),
        };
        // A raised cosine at both ends: the rig is at rest before and after it.
        let fade = |i: usize| {
            let inside_s = time_s(i.min(last - i));
            0.5 - 0.5 * (std::f64::consts::PI * (inside_s / FADE_S).min(1.0)).cos()
        };
        let faded: Vec<f64> = shaped
            .iter()
            .enumerate()
            .map(|(i, x)| x * fade(i))
            .collect();
        let largest = faded.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        Self {
            interval_s: INTERVAL_S,
            command_m: faded.iter().map(|x| x * peak_m / largest).collect(),
        }
        .checked()
    }

    /// As a file that [`load`](Self::load) can read.
    pub fn to_csv(&self) -> String {
        let mut text = String::from("time_s,command_mm\n");
        for (i, m) in self.command_m.iter().enumerate() {
            let _ = writeln!(text, "{:.4},{:.5}", i as f64 * self.interval_s, 1e3 * m);
        }
        text
    }

    /// From a designed test.
    pub fn of(next: &diagnosis::Next) -> Result<Self, Failure> {
        Self {
            interval_s: next.interval_s,
            command_m: next.command_mm.iter().map(|x| 1e-3 * x).collect(),
        }
        .checked()
        .map_err(|e| Failure::input(format!("the designed test: {e}")))
    }

    fn checked(self) -> Result<Self, String> {
        let far = self.peak_m();
        let seconds = self.seconds();
        if !(SECONDS[0]..=SECONDS[1]).contains(&seconds) {
            return Err(format!(
                "a signal of {seconds} s is refused: accepted are {} to {} s",
                SECONDS[0], SECONDS[1]
            ));
        }
        if far <= 0.0 || !far.is_finite() {
            return Err("its command never leaves zero: accepted is one that moves".into());
        }
        let ends = [self.command_m[0], self.command_m[self.command_m.len() - 1]];
        match ends.iter().find(|x| x.abs() > NEAR_ZERO * far) {
            None => Ok(self),
            Some(end) => Err(format!(
                "its command begins or ends at {:.4} mm: accepted is one that begins and ends at 0, where the rig stands",
                1e3 * end
            )),
        }
    }

    /// Its length, s.
    pub fn seconds(&self) -> f64 {
        (self.command_m.len() - 1) as f64 * self.interval_s
    }

    /// Largest distance from zero, m.
    pub fn peak_m(&self) -> f64 {
        self.command_m.iter().fold(0.0, |m, x| x.abs().max(m))
    }

    /// Top speed, m/s.
    pub fn speed_m_per_s(&self) -> f64 {
        let steps = self.command_m.windows(2).map(|w| (w[1] - w[0]).abs());
        steps.fold(0.0, f64::max) / self.interval_s
    }

    /// At a different interval, linear between its samples; the last sample is kept.
    pub fn every(&self, interval_s: f64) -> Vec<f64> {
        let steps = (self.seconds() / interval_s).round() as usize;
        let last = self.command_m.len() - 1;
        (0..=steps)
            .map(|i| {
                let at = (i as f64 * interval_s / self.interval_s).min(last as f64);
                let from = (at as usize).min(last.saturating_sub(1));
                let part = at - from as f64;
                self.command_m[from] * (1.0 - part) + self.command_m[from + 1] * part
            })
            .collect()
    }
}

/// Size of a line or of a sweep at a frequency, relative to that at low frequencies.
fn level(hz: f64) -> f64 {
    (LEVEL_HZ / hz).min(1.0)
}

/// Periods of odd lines with random phases, samples 0 to `last`. In each group of four odd lines one is left out.
fn multisine(last: usize, [low, high]: [f64; 2]) -> Vec<f64> {
    let samples = (PERIOD_S / INTERVAL_S).round() as usize;
    let odd = (1..samples / 2).step_by(2);
    let band: Vec<usize> = odd
        .filter(|h| (low..=high).contains(&(*h as f64 / PERIOD_S)))
        .collect();
    let drawn = (0..DRAWS).map(|seed| {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut bins = vec![Complex::default(); samples];
        for group in band.chunks(4) {
            let left_out = (random.next_u64() % 4) as usize;
            for (i, h) in group.iter().enumerate() {
                let phase = TAU * (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
                if i != left_out {
                    bins[*h] = Complex::from_polar(level(*h as f64 / PERIOD_S), phase);
                }
            }
        }
        fourier::inverse(samples).process(&mut bins);
        bins.iter().map(|b| b.re).collect::<Vec<f64>>()
    });
    let peak = |x: &Vec<f64>| x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let period = drawn.min_by(|a, b| {
        let crest = |x: &Vec<f64>| peak(x) / x.iter().map(|x| x * x).sum::<f64>().sqrt();
        crest(a).total_cmp(&crest(b))
    });
    let period = period.unwrap_or_default();
    (0..=last).map(|i| period[i % samples]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_made_signal_is_one_that_is_played_and_reads_back() {
        for shape in [SignalShape::Chirp, SignalShape::OddMultisine] {
            let made = SignalPoints::made(shape, 5e-3, [0.25, 10.0], 60.0).unwrap();
            assert!((made.peak_m() - 5e-3).abs() < 1e-9);
            assert!((made.seconds() - 60.0).abs() < 1e-9);
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("signal.csv");
            std::fs::write(&path, made.to_csv()).unwrap();
            let read = SignalPoints::load(&path).unwrap();
            assert_eq!(read.command_m.len(), made.command_m.len());
            assert!((read.peak_m() - made.peak_m()).abs() < 1e-8);
        }
        for (peak_m, band, seconds, said) in [
            (0.0, [0.2, 10.0], 60.0, "a peak of 0 mm"),
            (5e-3, [10.0, 0.2], 60.0, "two frequencies that rise"),
            (5e-3, [0.2, 10.0], 3.0, "a signal of 3 s"),
        ] {
            let e = SignalPoints::made(SignalShape::Chirp, peak_m, band, seconds).unwrap_err();
            assert!(e.contains(said), "{e}");
        }
    }

    fn signal(command_m: Vec<f64>) -> Result<SignalPoints, String> {
        SignalPoints {
            interval_s: 0.5,
            command_m,
        }
        .checked()
    }

    #[test]
    fn a_signal_begins_and_ends_at_zero_and_moves() {
        assert!(signal(vec![0.0, 0.01, -0.01, 0.0]).is_ok());
        for (command, said) in [
            (vec![0.0, 0.01, 0.01], "ends at 10.0000 mm"),
            (vec![0.0; 5], "never leaves zero"),
            (vec![0.0, 0.0], "0.5 s is refused"),
            (vec![0.0, f64::NAN, 0.0], "never leaves zero"),
        ] {
            let e = signal(command).unwrap_err();
            assert!(e.contains(said), "{e}");
        }
    }

    #[test]
    fn another_interval_has_the_same_ends() {
        let s = signal(vec![0.0, 0.02, -0.01, 0.0]).unwrap();
        let fine = s.every(0.125);
        assert_eq!(fine.len(), 13);
        assert_eq!((fine[0], fine[4], fine[12]), (0.0, 0.02, 0.0));
        assert!((fine[6] - 0.005).abs() < 1e-12);
        assert_eq!(s.speed_m_per_s(), 0.06);
    }
}
