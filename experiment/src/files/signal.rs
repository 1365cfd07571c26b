//! A command over time: what `diagnose --next` designs and `board commission --signal` and `run --signal` play.
//! `time_s,command_mm`; any command of a recorded file does.

use super::columns::Columns;
use super::recording::SiRecording;
use crate::failure::Failure;
use std::path::Path;

/// A command.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalPoints {
    /// Sampling interval, s.
    pub interval_s: f64,
    /// Displacement that is commanded, m.
    pub command_m: Vec<f64>,
}

/// The shortest and the longest signal, s.
const SECONDS: [f64; 2] = [1.0, 600.0];
/// A signal begins and ends this near to zero, as a share of its largest way: the rig stands at zero before and after it.
const NEAR_ZERO: f64 = 1e-3;

impl SignalPoints {
    /// Reads a file with a time and a command.
    ///
    /// # Errors
    /// A file that cannot be read; no command; uneven time; a signal that does not begin and end at zero, is too long or
    /// too short, or moves nothing.
    pub fn load(path: &Path) -> Result<Self, Failure> {
        let recording = SiRecording::load_with_any_time(path, &Columns::default())?;
        if let Some((_, refusal)) = recording.gap_in(&(0..recording.time_s.len())) {
            return Err(refusal.clone());
        }
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

    /// A designed test.
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

    /// Largest way from zero, m.
    pub fn peak_m(&self) -> f64 {
        self.command_m.iter().fold(0.0, |m, x| x.abs().max(m))
    }

    /// Top speed, m/s.
    pub fn speed_m_per_s(&self) -> f64 {
        let steps = self.command_m.windows(2).map(|w| (w[1] - w[0]).abs());
        steps.fold(0.0, f64::max) / self.interval_s
    }

    /// At another interval, straight between its samples; the last sample is kept.
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

#[cfg(test)]
mod tests {
    use super::*;

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
