//! Gain, phase and coherence by averaged cross spectra.

use fourier::Complex;
use schemars::JsonSchema;
use serde::Serialize;

/// Hann windows that overlap by half.
const WINDOWS: usize = 8;
/// A line at which the command has less than this share of its largest line is not looked at.
const LEAST_POWER: f64 = 1e-4;
/// The command moves in the band from below that holds this share of its power.
const MOVES: f64 = 0.9995;
/// Lines of the drawing.
const MOST_LINES: usize = 400;

/// The answer at a frequency.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ResponseLine {
    /// Frequency, Hz.
    pub hz: f64,
    /// Displacement per command.
    pub gain: f64,
    /// Phase, degrees, without steps of 360: below 0 the displacement is late.
    pub phase_deg: f64,
    /// Share of the displacement's power that is a linear answer, 0 to 1.
    pub coherence: f64,
}

/// Lines at which the command moves.
pub fn lines(command: &[f64], displacement: &[f64], interval_s: f64) -> Vec<ResponseLine> {
    let Some(spectra) = fourier::cross_spectra(command, displacement, WINDOWS) else {
        return Vec::new();
    };
    let sums = &spectra.lines;
    let largest = sums.iter().skip(1).map(|s| s.0).fold(0.0, f64::max);
    // A recorded command has its converter's noise at all frequencies: it moves up to where nearly all of its power is.
    let whole: f64 = sums.iter().skip(1).map(|s| s.0).sum();
    let mut below = 0.0;
    let top = sums.iter().skip(1).take_while(|s| {
        below += s.0;
        below < MOVES * whole
    });
    let top = 1 + top.count();
    let moving = |k: &usize| *k <= top && sums[*k].0 > LEAST_POWER * largest;
    let used: Vec<usize> = (1..sums.len()).filter(moving).collect();
    let every = used.len().div_ceil(MOST_LINES).max(1);
    let mut phase_deg = 0.0;
    let mut before = Complex::new(1.0_f64, 0.0);
    let mut found = Vec::new();
    for (place, k) in used.into_iter().enumerate() {
        let (uu, yy, uy) = sums[k];
        // The nearest to the phase of the line before: a delay turns it by little from line to line.
        phase_deg += (uy / before).arg().to_degrees();
        before = uy;
        if place % every == 0 {
            found.push(ResponseLine {
                hz: k as f64 / (spectra.length as f64 * interval_s),
                gain: uy.norm() / uu,
                phase_deg,
                coherence: uy.norm_sqr() / (uu * yy).max(f64::MIN_POSITIVE),
            });
        }
    }
    found
}
