//! Reduces 2000 steps a second to as many points as a screen shows, without losing a peak.

use experiment::trace::AnyRecord;
use outerloop_core::flag;
use std::fmt::Write as _;

/// Names and units of the curves, in the order in which they are sent.
pub const CHANNELS: [(&str, &str, f64); 12] = [
    ("target", "mm", 1e3),
    ("command", "mm", 1e3),
    ("measured", "mm", 1e3),
    ("force", "kN", 1e-3),
    ("estimated displacement", "mm", 1e3),
    ("estimated force", "kN", 1e-3),
    ("velocity", "m/s", 1.0),
    ("acceleration", "m/s²", 1.0),
    ("added damping", "kN s/m", 1e-3),
    ("sech gain", "", 1.0),
    ("energy error", "J", 1.0),
    ("energy error ratio", "%", 1e2),
];

/// Initial number of control steps in a point.
const SPAN: u32 = 10;
/// Largest number of points waiting for the next message: beyond it, pairs are joined.
const WAITING: usize = 128;

/// The channels of one step, in the units of [`CHANNELS`]; of the first storey.
#[derive(Clone, Copy, Debug)]
pub struct Band(pub [f64; CHANNELS.len()]);

impl Band {
    /// From a record.
    pub fn of(r: &AnyRecord<'_>) -> Self {
        let values = [
            r.command_m[0],
            r.sent_m[0],
            r.displacement_m[0],
            r.force_n[0],
            r.estimated_displacement_m[0],
            r.estimated_force_n[0],
            r.velocity_m_per_s[0],
            r.acceleration_m_per_s2[0],
            r.added_damping_n_s_per_m[0],
            r.gain[0],
            r.energy_sum.modified_j,
            r.energy_ratio,
        ];
        let mut band = [0.0; CHANNELS.len()];
        for ((to, value), (_, _, scale)) in band.iter_mut().zip(values).zip(CHANNELS) {
            *to = f64::from(value) * scale;
        }
        Self(band)
    }
}

/// The counters of a step.
#[derive(Clone, Copy, Debug)]
pub struct StepColumns {
    /// Control step.
    pub tick: u32,
    /// Integration steps.
    pub step: u32,
    /// The target is late.
    pub late: bool,
}

impl StepColumns {
    /// From a record.
    pub fn of(r: &AnyRecord<'_>) -> Self {
        Self {
            tick: r.tick,
            step: r.step,
            late: r.has(flag::LATE),
        }
    }
}

/// Several control steps as one point.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    first_tick: u32,
    /// Control steps in it.
    pub steps: u32,
    late: u32,
    low: [f64; CHANNELS.len()],
    high: [f64; CHANNELS.len()],
    last: [f64; CHANNELS.len()],
}

impl Point {
    fn of(columns: &StepColumns, band: &Band) -> Self {
        Self {
            first_tick: columns.tick,
            steps: 1,
            late: u32::from(columns.late),
            low: band.0,
            high: band.0,
            last: band.0,
        }
    }

    /// Adds the next point.
    fn and(&mut self, next: &Self) {
        self.steps += next.steps;
        self.late += next.late;
        for i in 0..CHANNELS.len() {
            self.low[i] = self.low[i].min(next.low[i]);
            self.high[i] = self.high[i].max(next.high[i]);
        }
        self.last = next.last;
    }

    /// As JSON: tick, steps, late steps, then the smallest, largest and last value of each channel.
    pub fn write(&self, text: &mut String) {
        let _ = write!(text, "[{},{},{}", self.first_tick, self.steps, self.late);
        for i in 0..CHANNELS.len() {
            for value in [self.low[i], self.high[i], self.last[i]] {
                // JSON has no NaN.
                if value.is_finite() {
                    let _ = write!(text, ",{}", short(value));
                } else {
                    text.push_str(",null");
                }
            }
        }
        text.push(']');
    }
}

/// Rounds to six digits, more than a screen shows.
fn short(value: f64) -> f64 {
    if value == 0.0 {
        return 0.0;
    }
    let scale = 10_f64.powi(5 - value.abs().log10().floor() as i32);
    let rounded = (value * scale).round() / scale;
    if rounded.is_finite() { rounded } else { value }
}

/// The points waiting to be sent.
#[derive(Clone, Debug)]
pub struct PendingPoints {
    points: Vec<Point>,
    span: u32,
}

impl PendingPoints {
    /// None yet.
    pub fn new() -> Self {
        Self {
            points: Vec::with_capacity(WAITING),
            span: SPAN,
        }
    }

    /// Adds a step.
    pub fn take(&mut self, columns: &StepColumns, band: &Band) {
        let step = Point::of(columns, band);
        match self.points.last_mut() {
            Some(point) if point.steps < self.span => point.and(&step),
            _ => {
                if self.points.len() == WAITING {
                    self.join_pairs();
                }
                self.points.push(step);
            }
        }
    }

    fn join_pairs(&mut self) {
        self.span = self.span.saturating_mul(2);
        self.points = self
            .points
            .chunks(2)
            .map(|pair| {
                let mut point = pair[0];
                pair.get(1).inspect(|next| point.and(next));
                point
            })
            .collect();
    }

    /// Removes and gives all waiting points.
    pub fn drain(&mut self) -> Vec<Point> {
        self.span = SPAN;
        std::mem::replace(&mut self.points, Vec::with_capacity(WAITING))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_step_and_no_peak_is_lost_however_many_wait() {
        for count in [5, 1000, 50_000] {
            let mut waiting = PendingPoints::new();
            for tick in 0..count {
                let mut band = [f64::from(tick % 7); CHANNELS.len()];
                if tick == count / 2 {
                    (band[0], band[1]) = (1e6, -1e6);
                }
                let columns = StepColumns {
                    tick,
                    step: tick,
                    late: tick % 10 == 0,
                };
                waiting.take(&columns, &Band(band));
            }
            let points = waiting.drain();
            assert!(points.len() <= WAITING);
            assert_eq!(points.iter().map(|p| p.steps).sum::<u32>(), count);
            assert_eq!(
                points.iter().map(|p| p.late).sum::<u32>(),
                count.div_ceil(10)
            );
            let mut next = 0;
            for p in &points {
                assert_eq!(p.first_tick, next, "in order and without a gap");
                next += p.steps;
            }
            assert_eq!(points.iter().map(|p| p.high[0]).fold(0.0, f64::max), 1e6);
            assert_eq!(points.iter().map(|p| p.low[1]).fold(0.0, f64::min), -1e6);
            assert!(waiting.drain().is_empty());
        }
    }

    #[test]
    fn a_point_is_json_whatever_is_in_it() {
        let mut band = [0.0; CHANNELS.len()];
        (band[0], band[1], band[2]) = (f64::NAN, 1.234_567_89e-3, -9.999_999_9e12);
        let columns = StepColumns {
            tick: 7,
            step: 1,
            late: true,
        };
        let mut text = String::new();
        Point::of(&columns, &Band(band)).write(&mut text);
        let read: Vec<Option<f64>> = serde_json::from_str(&text).unwrap();
        assert_eq!(read.len(), 3 + 3 * CHANNELS.len());
        assert_eq!(read[..4], [Some(7.0), Some(1.0), Some(1.0), None]);
        assert_eq!(read[6], Some(1.234_57e-3));
    }
}
