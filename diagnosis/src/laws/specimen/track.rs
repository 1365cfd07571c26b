//! A span as its elements experience it, with its past.

use super::band::Band;
use crate::criteria::specimen::BOTH_SIDES;
use crate::criteria::{A_CYCLE, BAND_ROOM, MOST_SEARCHED, SEARCHED};
use crate::numbers::signals::{Signals, add_scaled, averaged, clear, peak};
use crate::record::recording::{Recording, begins_at_rest, range};
use crate::record::rest;
use crate::record::spectrum::motion_band_hz;
use crate::record::travel;

/// Declared parameters of a specimen: stiffness, damping, mass, offset.
pub const DECLARED: usize = 4;
/// Look-back, in lengths of the span: what an element remembers from earlier has been wiped out by later motion.
const LOOK_BACK: f64 = 2.0;
/// A span with a past shorter than this fraction of itself is preceded by a copy of itself.
const LEAST_BEFORE: f64 = 0.1;
/// Fewest samples per cycle of the cut-off for elements with memory.
const MOTION_A_CYCLE: f64 = 12.0;
/// Most samples of the motion per sample of the record.
const MOST_FINE: usize = 8;
/// A motion below this share of its top speed is at rest.
const AT_REST: f64 = 0.01;

/// Motion, time and force of a span. The motion begins before the span and is sampled more finely than the record if
/// its cycles have few samples.
#[derive(Clone, Debug)]
pub struct Track {
    /// Interval of the motion's samples, s.
    pub interval_s: f64,
    /// Number of these per sample of the record.
    pub fine: usize,
    /// Displacement, mm, starting before the span.
    pub x: Vec<f64>,
    /// Largest earlier displacement in either direction, mm.
    pub largest_before_mm: f64,
    /// Travel before the first of `x`, mm; negative if that precedes the first known sample.
    pub travel_before_mm: f64,
    /// Velocity, mm/s.
    pub v: Vec<f64>,
    /// Acceleration, mm/s^2.
    pub a: Vec<f64>,
    /// First sample of the span in `x`.
    pub first: usize,
    /// Time of the span's samples, s.
    pub time_s: Vec<f64>,
    /// Measured force of the span's samples, N; 0 where nothing was measured.
    pub force: Vec<f64>,
    /// Unmeasured samples of the span.
    pub unmeasured: Vec<usize>,
}

/// A span and its displacement, before any cut-off.
#[derive(Debug)]
pub struct UnfilteredSpan<'a> {
    recording: &'a Recording,
    force: &'a [f64],
    band: Band,
    before: usize,
}

impl<'a> UnfilteredSpan<'a> {
    /// `None` if a signal is missing.
    pub fn new(recording: &'a Recording) -> Option<Self> {
        let here = recording.displacement_mm.as_ref()?;
        let force = recording.force_n.as_deref()?;
        let earlier = recording
            .before
            .as_ref()
            .and_then(|b| b.displacement_mm.as_ref());
        let most = (LOOK_BACK * here.len() as f64) as usize;
        let earlier = earlier.map_or(&[][..], |x| &x[x.len().saturating_sub(most)..]);
        let x: Vec<f64> = earlier.iter().chain(here).copied().collect();
        Some(Self {
            recording,
            force,
            band: Band::new(&x, recording.interval_s()),
            before: earlier.len(),
        })
    }

    /// Sampling interval of the record, s.
    pub fn interval_s(&self) -> f64 {
        self.recording.interval_s()
    }

    /// Upper end of the motion's band, Hz.
    pub fn band_hz(&self) -> f64 {
        let x = self.recording.displacement_mm.as_deref();
        band_hz(&self.band, x.unwrap_or_default(), self.interval_s())
    }

    /// A cut-off, Hz, raised if it is inside the motion's band.
    pub fn past_band_hz(&self, cutoff_hz: f64) -> f64 {
        past(self.band_hz(), cutoff_hz, self.interval_s())
    }

    /// The span below a cut-off.
    pub fn track(&self, cutoff_hz: f64) -> Track {
        let fine = fine(cutoff_hz, self.recording.interval_s());
        let motion = self.band.motion(cutoff_hz, fine);
        let unmeasured = self.recording.unmeasured();
        let mut force = self.force.to_vec();
        clear(&mut force, &unmeasured);
        let mut track = Track {
            interval_s: self.recording.interval_s() / fine as f64,
            fine,
            x: motion.x,
            largest_before_mm: self.recording.largest_before_mm(),
            travel_before_mm: travel::before_mm(self.recording, self.before),
            v: motion.v,
            a: motion.a,
            first: self.before * fine,
            time_s: self.recording.time_s.clone(),
            force,
            unmeasured,
        };
        // Noise has a speed, too: several samples decide whether it starts at rest, not one.
        let starts_at_rest = begins_at_rest(&track.x)
            || rest::spans(self.recording)
                .first()
                .is_some_and(|r| r.0 == 0);
        if !starts_at_rest {
            track.put_before_itself();
        }
        track
    }
}

/// Number of samples of the motion per sample of the record.
fn fine(cutoff_hz: f64, interval_s: f64) -> usize {
    let rate_hz = 1.0 / interval_s;
    let fine = (MOTION_A_CYCLE * cutoff_hz.min(0.5 * rate_hz) / rate_hz).ceil();
    (fine as usize).clamp(1, MOST_FINE)
}

/// Upper end of a motion's band, Hz. The steps of a coarse converter are not white noise: what does not exceed the
/// floor of an averaged spectrum is not motion.
fn band_hz(band: &Band, x: &[f64], interval_s: f64) -> f64 {
    let averaged = motion_band_hz(x, interval_s).unwrap_or(f64::INFINITY);
    averaged.min(band.of_motion_hz())
}

/// Raises a cut-off out of the band of a motion: otherwise its accelerations would be missing.
fn past(band_hz: f64, cutoff_hz: f64, interval_s: f64) -> f64 {
    cutoff_hz.max((BAND_ROOM * band_hz).min(0.5 / interval_s))
}

impl Track {
    /// The motion of a channel's signals below a cut-off, which is raised if they move too fast for it, from their
    /// first sample on, for a known force.
    pub fn below(s: &Signals, cutoff_hz: f64) -> Self {
        let band = Band::new(&s.reading, s.interval_s);
        let cutoff_hz = past(
            band_hz(&band, &s.reading, s.interval_s),
            cutoff_hz,
            s.interval_s,
        );
        let fine = fine(cutoff_hz, s.interval_s);
        let motion = band.motion(cutoff_hz, fine);
        Self {
            interval_s: s.interval_s / fine as f64,
            fine,
            x: motion.x,
            largest_before_mm: s.largest_before_mm,
            travel_before_mm: s.travel_before_mm,
            v: motion.v,
            a: motion.a,
            first: 0,
            time_s: s.time_s.clone(),
            force: Vec::new(),
            unmeasured: Vec::new(),
        }
    }

    /// Number of the record's samples that span the whole motion.
    pub fn samples(&self) -> usize {
        self.x.len().div_ceil(self.fine) + 1
    }

    /// Adds a multiple of noise of the record's sampling rate, as it is below the cut-off.
    pub fn shake(&mut self, noise: &[f64], times: f64, cutoff_hz: f64) {
        let interval_s = self.interval_s * self.fine as f64;
        let noise = Band::new(noise, interval_s).motion(cutoff_hz, self.fine);
        add_scaled(&mut self.x, &noise.x, times);
        add_scaled(&mut self.v, &noise.v, times);
        add_scaled(&mut self.a, &noise.a, times);
    }

    /// Length of the span, samples.
    pub fn len(&self) -> usize {
        self.force.len()
    }

    /// If the past is unknown and the span begins in motion, prepends the span itself up to the sample that is most
    /// like its first. A mirror image would add a reversal.
    fn put_before_itself(&mut self) {
        let n = self.len() * self.fine;
        if self.first as f64 > LEAST_BEFORE * n as f64 {
            return;
        }
        let half = 0.5 * range(&self.x);
        let top = peak(&self.v);
        if self.v[0].abs() < AT_REST * top {
            return;
        }
        let (x0, v0) = (self.x[0], self.v[0]);
        let like = |i: usize| ((self.x[i] - x0) / half).abs() + ((self.v[i] - v0) / top).abs();
        // Not within the first tenth, which still belongs to the same pass.
        let from = (self.len() / 10).max(1);
        let Some(best) = (from..self.x.len() / self.fine)
            .map(|i| i * self.fine)
            .min_by(|&i, &j| like(i).total_cmp(&like(j)))
        else {
            return;
        };
        let speeds = self.v[..best].iter().map(|v| v.abs());
        self.travel_before_mm -= self.interval_s * speeds.sum::<f64>();
        for signal in [&mut self.x, &mut self.v, &mut self.a] {
            let prefix = signal[..best].to_vec();
            signal.splice(0..0, prefix);
        }
        self.first += best;
    }

    /// The part of a whole motion's signal within the span.
    pub fn span_of(&self, whole: &[f64]) -> Vec<f64> {
        let own = whole[self.first..].iter().step_by(self.fine);
        own.copied().collect()
    }

    /// Columns of the declared parameters over the whole motion: N for one unit of each parameter.
    pub fn declared_columns(&self) -> [Vec<f64>; DECLARED] {
        [
            self.x.clone(),
            self.v.clone(),
            self.a.iter().map(|a| 1e-3 * a).collect(),
            vec![1.0; self.x.len()],
        ]
    }

    /// The same as a column for fitting [`Track::force`], averaged over `every` samples.
    pub fn column_of(&self, whole: &[f64], every: usize) -> Vec<f64> {
        let mut own = self.span_of(whole);
        clear(&mut own, &self.unmeasured);
        averaged(&own, every)
    }
}

/// Sizes of a motion, the reference for shapes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionScales {
    /// Half the range of the displacement, mm.
    pub x: f64,
    /// Middle of that range, mm.
    pub middle: f64,
    /// Top speed, mm/s: exceeded by one sample in two hundred.
    pub v: f64,
    /// Length of all spans, s.
    pub seconds: f64,
    /// Sampling interval, s.
    pub interval_s: f64,
    /// Total travel of all spans, mm.
    pub travel: f64,
}

impl MotionScales {
    pub fn of(tracks: &[Track]) -> Self {
        let spans = || tracks.iter().map(|t| (&t.x[t.first..], &t.v[t.first..]));
        let fine = tracks[0].fine as f64;
        let low = spans().flat_map(|s| s.0).copied().fold(f64::MAX, f64::min);
        let high = spans().flat_map(|s| s.0).copied().fold(f64::MIN, f64::max);
        let mut speeds: Vec<f64> = spans().flat_map(|s| s.1).map(|v| v.abs()).collect();
        let h = tracks[0].interval_s;
        let travel = h * speeds.iter().sum::<f64>();
        let at = speeds.len() - 1 - speeds.len() / 200;
        let v = *speeds.select_nth_unstable_by(at, f64::total_cmp).1;
        Self {
            x: (0.5 * (high - low)).max(1e-12),
            middle: 0.5 * (high + low),
            v: v.max(1e-12),
            seconds: h * speeds.len() as f64,
            interval_s: h * fine,
            travel,
        }
    }

    /// Centre and reach of the range covered on both sides, mm: about zero if the motion passes through it, otherwise
    /// about the middle of the range.
    pub fn both_sides(&self) -> [f64; 2] {
        let reach = self.x - self.middle.abs();
        if reach > BOTH_SIDES * self.x {
            [0.0, reach]
        } else {
            [self.middle, self.x]
        }
    }
}

/// Number of samples averaged into one, leaving enough samples per cycle of the cut-off.
pub fn thinning(tracks: &[Track], cutoff_hz: f64) -> usize {
    let n: usize = tracks.iter().map(Track::len).sum();
    let rate_hz = 1.0 / tracks[0].interval_s;
    let allowed = (rate_hz / (A_CYCLE * cutoff_hz)).floor().max(1.0) as usize;
    let wanted = n.div_ceil(SEARCHED);
    allowed.min(wanted).max(n.div_ceil(MOST_SEARCHED))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// 100 Hz: some seconds of rest, then a sine of 100 mm and 0.5 Hz, with a sensor's noise of up to 0.5 mm.
    fn record(rest_s: f64) -> Recording {
        let time_s: Vec<f64> = (0..4000).map(|i| 0.01 * f64::from(i)).collect();
        let noise = |i: usize| 0.5 * (7.1 * (i * i % 997) as f64).sin();
        let at =
            |(i, t): (usize, &f64)| 100.0 * (TAU * 0.5 * (t - rest_s).max(0.0)).sin() + noise(i);
        let x: Vec<f64> = time_s.iter().enumerate().map(at).collect();
        Recording {
            name: "a run".into(),
            force_n: Some(x.clone()),
            displacement_mm: Some(x),
            time_s,
            ..Recording::default()
        }
    }

    fn run_up(record: &Recording) -> usize {
        UnfilteredSpan::new(record).unwrap().track(10.0).first
    }

    #[test]
    fn a_run_that_begins_with_a_rest_has_nothing_before_it_whatever_the_noise_of_its_first_sample()
    {
        for tenths in 10..60 {
            assert_eq!(run_up(&record(0.1 * f64::from(tenths))), 0, "{tenths}");
        }
        let mut in_motion = record(3.0).slice(450, 4000);
        in_motion.before = None;
        assert!(run_up(&in_motion) > 0);
    }
}
