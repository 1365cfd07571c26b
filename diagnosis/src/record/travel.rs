//! The travel of a motion.

use crate::numbers::operators::travel;
use crate::record::recording::Recording;
use crate::record::spectrum::{motion_band_hz, smooth};

/// Multiple of a motion's band above which nothing contributes to its travel.
const BAND: f64 = 6.0;
/// Largest cut-off, as a fraction of the sampling rate.
const MOST_RATE: f64 = 0.4;

/// Fewest samples that determine a travel.
const LEAST: usize = 16;

/// Velocity of a motion without its noise, whose own travel would add up.
fn velocity(x: &[f64], interval_s: f64) -> Option<Vec<f64>> {
    if x.len() < LEAST {
        return None;
    }
    let band_hz = motion_band_hz(x, interval_s)?;
    Some(smooth(x, interval_s, (BAND * band_hz).min(MOST_RATE / interval_s)).v)
}

/// Travel up to each sample, mm; `None` if nothing moves.
pub fn cumulative(x: &[f64], interval_s: f64) -> Option<Vec<f64>> {
    Some(travel(&velocity(x, interval_s)?, interval_s, 0.0).collect())
}

/// Travel in the file before a span, except its `last` samples, mm: what fatigue remembers.
pub fn before_mm(span: &Recording, last: usize) -> f64 {
    let past = span.before.as_deref();
    let x = past.and_then(|b| b.displacement_mm.as_deref());
    let x = x.unwrap_or_default();
    let here: Vec<f64> = x[..x.len().saturating_sub(last)]
        .iter()
        .copied()
        .filter(|x| x.is_finite())
        .collect();
    let travel = cumulative(&here, span.interval_s());
    travel.and_then(|w| w.last().copied()).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_goes_no_way() {
        let h = 1e-3;
        let mut seed = 1_u32;
        let mut noise = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            0.05 * (f64::from(seed >> 8) / f64::from(1 << 24) - 0.5)
        };
        let x: Vec<f64> = (0..20_000)
            .map(|i| 5.0 * (std::f64::consts::TAU * 0.5 * f64::from(i) * h).sin() + noise())
            .collect();
        let past = Recording {
            time_s: (0..x.len()).map(|i| i as f64 * h).collect(),
            displacement_mm: Some(x),
            ..Recording::default()
        };
        let span = past.slice(15_000, 20_000);
        // Ten and a half cycles of 20 mm, less the last five seconds.
        let travel = before_mm(&span, 5000);
        assert!((travel / 100.0 - 1.0).abs() < 0.02, "{travel}");
        assert_eq!(before_mm(&past, 0), 0.0);
    }
}
