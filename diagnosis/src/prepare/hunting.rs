//! A hunting loop: the command is constant or nearly so, but the rig moves; or it swings where the command does not.

use crate::criteria::{LITTLE, SWINGS};
use crate::numbers::coherence::linear_share;
use crate::numbers::signals::{deviation, difference, end_of, rms};
use crate::prepare::noise::hum::without_hum;
use crate::record::recording::{Recording, correlation};
use crate::record::rest;
use crate::record::spectrum::{low_passed, periodogram};
use fourier::Complex;
use std::ops::Range;

/// Frequencies at which the loop of an actuator swings by itself, Hz.
const LOOP_HZ: Range<f64> = 3.0..100.0;
/// A swing's band, in parts of its frequency.
const BAND: [f64; 2] = [0.7, 1.4];
/// Number of windows over which a coherence is averaged.
const WINDOWS: usize = 16;
/// Multiple of the spectrum beyond twice its frequency that a swing has in its band.
const STANDS_OUT: f64 = 10.0;
/// Its peak and what lies below its band, in parts of its frequency, and how far the one is above the other: what friction or a limit
/// makes of a command falls with frequency.
const PEAK: [f64; 2] = [0.85, 1.18];
const BELOW: [f64; 2] = [0.35, 0.6];
const IS_A_PEAK: f64 = 1.5;
/// A command with this share of its squares within this part of its frequency is a sine: its harmonics look like a swing up to this
/// share of the motion.
const SINE: f64 = 0.9;
const SINE_BAND: f64 = 0.1;
const HARMONIC: f64 = 0.4;
/// Squares at rest over those of the swing up to which it is none of another machine's, which goes on at rest.
const QUIET: f64 = 0.1;

/// What an actuator's loop swings by itself once it moves.
#[derive(Clone, Copy, Debug)]
pub struct OwnSwing {
    /// Its frequency, Hz.
    pub hz: f64,
    /// Uncertainty of that, Hz.
    pub bin_hz: f64,
    /// Its size, mm rms.
    pub rms_mm: f64,
    /// Share of the residual's squares.
    pub share: f64,
}

/// The swing in the residual of an actuator's record, if it is the loop's own: it is no linear response to the command, and the rest
/// before or after the motion does not have it. A position loop swings so whose oil column is soft for its gain.
pub fn own_swing(recording: &Recording, left: &[f64]) -> Option<OwnSwing> {
    let seen = |x: &Option<Vec<f64>>| Some(end_of(x.as_ref()?, left.len()).to_vec());
    let (command, moved) = (
        seen(&recording.command_mm)?,
        seen(&recording.displacement_mm)?,
    );
    let h = recording.interval_s();
    let motion = deviation(&moved);
    let own = NotSent::of(&command, left, h)?;
    let peak = own.bins([LOOP_HZ.start, LOOP_HZ.end.min(0.2 / h)]);
    let peak = peak.max_by(|a, b| own.power[*a].total_cmp(&own.power[*b]))?;
    let hz = peak as f64 * own.bin_hz;
    let band = &own.power[own.bins(BAND.map(|part| part * hz))];
    let within = band.iter().sum::<f64>();
    let mut beyond = own.power[own.bins([2.0 * hz, f64::INFINITY])].to_vec();
    beyond.sort_by(f64::total_cmp);
    let floor = *beyond.get(beyond.len() / 2)?;
    let squares = within / own.whole * deviation(left).powi(2);
    let offset = recording.time_s.len() - left.len();
    let quiet = rest::spans(recording).into_iter().any(|(first, end)| {
        let own = &left[first.saturating_sub(offset)..end.saturating_sub(offset)];
        // The residual may begin after the rest, and a rest shorter than the swing shows none.
        if (own.len() as f64) * h * hz < 2.0 {
            return false;
        }
        let [above, below] = BAND.map(|part| low_passed(own, h, part * hz));
        deviation(&difference(&below, &above)).powi(2) < QUIET * squares
    });
    let mean = |parts: [f64; 2]| {
        let own = &own.power[own.bins(parts.map(|part| part * hz))];
        own.iter().sum::<f64>() / own.len().max(1) as f64
    };
    let is_peak = mean(PEAK) > IS_A_PEAK * mean(BELOW);
    let stands_out = is_peak && within > STANDS_OUT * floor * band.len() as f64;
    let may_be_harmonic = squares.sqrt() < HARMONIC * motion && is_sine(&command);
    let is_own = quiet && stands_out && !may_be_harmonic;
    is_own.then_some(OwnSwing {
        hz,
        bin_hz: own.bin_hz,
        rms_mm: squares.sqrt(),
        share: within / own.whole,
    })
}

/// The spectrum of what a linear model of any order cannot derive from a command: the part that is not coherent with it.
struct NotSent {
    power: Vec<f64>,
    /// The squares of all, coherent or not.
    whole: f64,
    bin_hz: f64,
}

impl NotSent {
    fn of(command: &[f64], left: &[f64], interval_s: f64) -> Option<Self> {
        let spectra = fourier::cross_spectra(command, left, WINDOWS)?;
        let not_coherent = |(uu, yy, uy): &(f64, f64, Complex<f64>)| {
            (yy - uy.norm_sqr() / uu.max(f64::MIN_POSITIVE)).max(0.0)
        };
        Some(Self {
            power: spectra.lines.iter().map(not_coherent).collect(),
            whole: spectra.lines.iter().map(|s| s.1).sum(),
            bin_hz: 1.0 / (spectra.length as f64 * interval_s),
        })
    }

    /// The lines from one frequency to another, Hz.
    fn bins(&self, hz: [f64; 2]) -> Range<usize> {
        let [from, to] = hz.map(|hz| ((hz / self.bin_hz).round() as usize).min(self.power.len()));
        from..to
    }
}

/// True if a command has one frequency.
fn is_sine(command: &[f64]) -> bool {
    let power = periodogram(command);
    let Some(top) = (1..power.len()).max_by(|a, b| power[*a].total_cmp(&power[*b])) else {
        return false;
    };
    let near = (SINE_BAND * top as f64).ceil() as usize;
    let own = &power[top.saturating_sub(near)..(top + near + 1).min(power.len())];
    own.iter().sum::<f64>() > SINE * power.iter().sum::<f64>()
}

/// True if the specimen moves during a rest: a hunting loop swings displacement and force together, each well above its
/// sample noise. Such a force is not noise.
pub fn hunts(recording: &Recording, (first, end): (usize, usize)) -> bool {
    let (Some(x), Some(force)) = (&recording.displacement_mm, &recording.force_n) else {
        return false;
    };
    let clean = [x, force].map(|x| without_hum(x, recording)[first..end].to_vec());
    let swings = |x: &Vec<f64>| deviation(x) > SWINGS * sample_noise(x);
    let [x, force] = &clean;
    let together = || {
        let at_once = correlation(x, force).powi(2);
        linear_share(x, force).unwrap_or(0.0).max(at_once) > LITTLE
    };
    clean.iter().all(swings) && together()
}

/// Deviation of samples from a smooth curve through their neighbours, rms; for white noise its own rms.
fn sample_noise(x: &[f64]) -> f64 {
    let fourth = |w: &[f64]| w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4];
    // The squares of the weights sum to 70.
    rms(&[x.windows(5).map(fourth).collect()]) / 70.0_f64.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loop_that_hunts_is_not_at_rest_and_noise_of_the_displacement_is_no_motion() {
        let h = 1e-3;
        let noise = |i: usize, by: usize| ((i * by) % 1009) as f64 / 504.5 - 1.0;
        let record = |moves: &dyn Fn(f64) -> f64| {
            let time_s: Vec<f64> = (0..2000).map(|i| i as f64 * h).collect();
            let x: Vec<f64> = time_s.iter().map(|t| moves(*t)).collect();
            let read = |(i, x): (usize, &f64)| x + 0.01 * noise(i, 7919);
            let force = |(i, x): (usize, &f64)| 300.0 * (x / 0.05).tanh() + 15.0 * noise(i, 6007);
            Recording {
                displacement_mm: Some(x.iter().enumerate().map(read).collect()),
                force_n: Some(x.iter().enumerate().map(force).collect()),
                time_s,
                ..Recording::default()
            }
        };
        let hunting = record(&|t| 0.13 * (45.0 * t).sin());
        assert!(hunts(&hunting, (0, 1900)));
        assert!(!hunts(&record(&|_| 0.0), (0, 1900)));
        // Hum in the displacement only.
        let mut hums = record(&|_| 0.0);
        let read = hums.displacement_mm.iter_mut().flatten().enumerate();
        read.for_each(|(i, x)| *x += 0.2 * (std::f64::consts::TAU * 50.0 * i as f64 * h).sin());
        assert!(!hunts(&hums, (0, 1900)));
    }

    #[test]
    fn a_swing_is_the_loops_own_if_neither_the_command_nor_the_rest_has_it() {
        let h = 2e-3;
        let noise = |i: usize| ((i * 7919) % 1009) as f64 / 504.5 - 1.0;
        let moves = |t: f64| (2.0..20.0).contains(&t);
        let swells = |t: f64| {
            if moves(t) {
                (std::f64::consts::PI * (t - 2.0) / 18.0).sin()
            } else {
                0.0
            }
        };
        let command = |t: f64| swells(t) * (5.0 * (4.0 * t).sin() + 2.0 * (6.3 * t).sin());
        // Half a millimetre at 24 Hz, whose phase wanders.
        let swings = |t: f64| 0.5 * (150.0 * t + (0.7 * t).sin()).sin();
        let of = |sent: &dyn Fn(f64) -> f64, left: &dyn Fn(f64) -> f64| {
            let time_s: Vec<f64> = (0..11_000).map(|i| i as f64 * h).collect();
            let sent: Vec<f64> = time_s.iter().map(|t| sent(*t)).collect();
            let noisy = |(i, t): (usize, &f64)| left(*t) + 0.01 * noise(i);
            let left: Vec<f64> = time_s.iter().enumerate().map(noisy).collect();
            let moved = sent.iter().zip(&left).map(|(u, x)| u + x).collect();
            let record = Recording {
                command_mm: Some(sent),
                displacement_mm: Some(moved),
                time_s,
                ..Recording::default()
            };
            own_swing(&record, &left)
        };
        let hunts = |t: f64| if moves(t) { swings(t) } else { 0.0 };
        let found = of(&command, &hunts).unwrap();
        assert!((found.hz - 24.0).abs() < 1.5, "{found:?}");
        assert!((found.rms_mm - 0.32).abs() < 0.05, "{found:?}");
        assert!(found.share > 0.9, "{found:?}");
        // A random command has the frequency, too, and the swing does not follow it.
        let busy = |t: f64| command(t) + swells(t) * 2.0 * noise((t / h).round() as usize / 4);
        let found = of(&busy, &hunts).unwrap();
        assert!((found.hz - 24.0).abs() < 1.5, "{found:?}");
        // Another machine goes on at rest; a command that has the frequency moves the ram; noise is none.
        assert!(of(&command, &swings).is_none());
        let shaken = |t: f64| command(t) + hunts(t);
        assert!(of(&shaken, &hunts).is_none());
        assert!(of(&command, &|_| 0.0).is_none());
        // Harmonics of a sine, and what falls with frequency.
        let sine = |t: f64| swells(t) * 5.0 * (4.0 * t).sin();
        assert!(of(&sine, &hunts).is_none());
        let edges = |t: f64| 0.1 * command(t).signum() * f64::from(u8::from(moves(t)));
        assert!(of(&command, &edges).is_none());
    }
}
