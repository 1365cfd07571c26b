//! Blocks of command, displacement and force become what the regressions are made of, in units of the planned peak and of
//! the structure's frequency.

use super::declared::Declared;
use super::tap::Block;
use crate::delay_line::{Delay, DelayLine};
use crate::estimate::{Biquad, LowPass};
use crate::float::{larger, smaller};

/// Blocks in a row of the regressions.
pub(super) const BLOCKS_IN_ROW: u8 = 4;
/// Way over which an actuator's friction builds up after a turn, peaks.
const BUILDS_UP: f32 = 0.01;
/// The longest transport delay of an actuator, blocks.
const LONGEST: usize = 64;
/// The largest speed and the largest way are forgotten in so many natural periods.
const LEAK_PERIODS: f32 = 3.0;
/// What is faster or further than the model by less than this is no limit.
const SLOWER: f32 = 0.94;
const SHORTER: f32 = 0.96;
/// And by this at least, peaks: how the first cycles of a structure fall short of the model is not the end of a stroke.
const SHORTER_PEAKS: f32 = 0.02;

/// Constants of the signals.
#[derive(Clone, Debug)]
pub(super) struct Constants {
    delay: Delay,
    /// First-order lag by first-order hold: what stays, what the new and the last input add.
    lag: [f32; 3],
    gain: f32,
    offset: f32,
    per_peak: f32,
    per_force: f32,
    force_offset_n: f32,
    low_pass: Biquad,
    /// 1 / (omega times two rows), 1 / (omega times a row)^2.
    slope: f32,
    curvature: f32,
    leak: f32,
    /// omega times a block.
    phase: f32,
}

/// What one sample of the regressions knows; displacement in peaks, velocity in peaks times omega, and so on.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Row {
    /// The actuator as declared: way, velocity, acceleration.
    pub(super) y: [f32; 3],
    /// The displacement as measured: way, velocity.
    pub(super) x: [f32; 2],
    /// Force in stiffness times peak.
    pub(super) r: f32,
    /// How far friction is built up that holds the declared way back, of what it is at most.
    pub(super) held: f32,
    /// How a limit of speed and one of stroke would change the declared way.
    pub(super) rate: f32,
    pub(super) stop: f32,
    /// The largest speed and way that were measured, where they are a limit.
    pub(super) limits: [f32; 2],
}

/// The memory of the signals.
#[derive(Clone, Debug)]
pub(super) struct Signals {
    line: DelayLine<LONGEST>,
    lagged: [f32; 2],
    /// Raw declared way, raw displacement and raw force of this block, in peaks.
    pub(super) raw: [f32; 3],
    filters: [LowPass; 4],
    /// Declared way, displacement, force, rate-limited less declared: the last three rows.
    past: [[f32; 3]; 4],
    slewed: f32,
    /// Declared way since friction has turned, at most what it builds up over.
    slides: f32,
    /// Leaky maxima of measured and declared speed, measured and declared way.
    most: [f32; 4],
    blocks: u8,
}

impl Constants {
    pub(super) fn new(d: &Declared, blocks_hz: f64) -> Self {
        let h = 1.0 / blocks_hz;
        let omega = d.omega_rad_per_s;
        let period = core::f64::consts::TAU / omega;
        let cutoff_hz = (16.0 / period).clamp(10.0, 40.0).min(0.2 * blocks_hz);
        let a = &d.actuator;
        let (stays, new, last) = if a.lag_s > 0.0 {
            let stays = libm::exp(-h / a.lag_s);
            let passed = (1.0 - stays) * a.lag_s / h;
            (stays, 1.0 - passed, passed - stays)
        } else {
            (0.0, 1.0, 0.0)
        };
        // A lag is driven by commands that are held: half a control period ahead of commands joined by lines.
        let held_s = if a.lag_s > 0.0 { 0.5 / d.rate_hz } else { 0.0 };
        let row = h * f64::from(BLOCKS_IN_ROW);
        let delay = (a.delay_s - held_s).max(0.0) / h;
        Self {
            delay: Delay::new(delay.min((LONGEST - 2) as f64)),
            lag: [stays as f32, new as f32, last as f32],
            gain: a.gain as f32,
            offset: (a.offset_m / d.peak_m) as f32,
            per_peak: (1.0 / d.peak_m) as f32,
            per_force: (1.0 / (d.stiffness_n_per_m * d.peak_m * d.force_gain)) as f32,
            force_offset_n: d.force_offset_n as f32,
            low_pass: Biquad::butterworth(cutoff_hz, blocks_hz),
            slope: (1.0 / (2.0 * omega * row)) as f32,
            curvature: (1.0 / (omega * row * omega * row)) as f32,
            leak: libm::exp(-row / (f64::from(LEAK_PERIODS) * period)) as f32,
            phase: (omega * h) as f32,
        }
    }
}

impl Signals {
    pub(super) const fn at_rest() -> Self {
        Self {
            line: DelayLine::filled(0.0),
            lagged: [0.0; 2],
            raw: [0.0; 3],
            filters: [LowPass::settled(0.0); 4],
            past: [[0.0; 3]; 4],
            slewed: 0.0,
            slides: 0.0,
            most: [0.0; 4],
            blocks: 0,
        }
    }

    /// As if the first block had been there for ever.
    pub(super) fn settle(&mut self, k: &Constants, block: &Block) {
        let command = block.command_m * k.per_peak;
        let y = k.gain * command + k.offset;
        let x = block.displacement_m * k.per_peak;
        let r = (block.force_n - k.force_offset_n) * k.per_force;
        self.line = DelayLine::filled(command);
        self.lagged = [command; 2];
        self.slewed = y;
        self.filters = [y, x, r, 0.0].map(LowPass::settled);
        self.past = [y, x, r, 0.0].map(|v| [v; 3]);
    }

    /// Takes a block in; every fourth gives a row, of one row before.
    pub(super) fn add(&mut self, k: &Constants, block: &Block) -> Option<Row> {
        let delayed = self.line.pass(k.delay, block.command_m * k.per_peak);
        let [stays, new, last] = k.lag;
        let lagged = stays * self.lagged[1] + new * delayed + last * self.lagged[0];
        self.lagged = [delayed, lagged];
        let y = k.gain * lagged + k.offset;
        let x = block.displacement_m * k.per_peak;
        let r = (block.force_n - k.force_offset_n) * k.per_force;
        self.raw = [y, x, r];
        // What a limit of speed would make of it; without one it is the same.
        let [speed, own_speed, ..] = self.most;
        let most = speed * k.phase;
        let limited = speed < SLOWER * own_speed;
        let way = y - self.slewed;
        let way = if limited {
            larger(smaller(way, most), -most)
        } else {
            way
        };
        self.slewed += way;
        let inputs = [y, x, r, self.slewed - y];
        let mut now = [0.0; 4];
        for ((now, filter), input) in now.iter_mut().zip(&mut self.filters).zip(inputs) {
            *now = filter.update(&k.low_pass, input);
        }
        self.blocks += 1;
        if self.blocks < BLOCKS_IN_ROW {
            return None;
        }
        self.blocks = 0;
        for (past, now) in self.past.iter_mut().zip(now) {
            *past = [now, past[0], past[1]];
        }
        Some(self.row(k))
    }

    fn row(&mut self, k: &Constants) -> Row {
        let [y, x, r, rate] = &self.past;
        let velocity = |p: &[f32; 3]| (p[0] - p[2]) * k.slope;
        let (v, v_x) = (velocity(y), velocity(x));
        let builds_up = BUILDS_UP;
        self.slides = larger(smaller(self.slides + y[1] - y[2], builds_up), -builds_up);
        let acceleration = (y[0] - 2.0 * y[1] + y[2]) * k.curvature;
        let now = [v_x.abs(), v.abs(), x[1].abs(), y[1].abs()];
        for (most, now) in self.most.iter_mut().zip(now) {
            *most = larger(*most * k.leak, now);
        }
        let [speed, own_speed, far, own_far] = self.most;
        let stopped = far < smaller(SHORTER * own_far, own_far - SHORTER_PEAKS);
        let clipped = larger(smaller(y[1], far), -far);
        Row {
            y: [y[1], v, acceleration],
            x: [x[1], v_x],
            r: r[1],
            held: self.slides / builds_up,
            rate: if speed < SLOWER * own_speed {
                rate[1]
            } else {
                0.0
            },
            stop: if stopped { clipped - y[1] } else { 0.0 },
            limits: [speed, far],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest that the end of a stroke explains of a motion of so many peaks that goes no further than `stroke` peaks.
    fn stop(peaks: f32, stroke: f32) -> f32 {
        let k = Constants::new(&Declared::exact(), 500.0);
        let mut signals = Signals::at_rest();
        let rows = (0..2000_u16).filter_map(|i| {
            let way = peaks * libm::sinf(6.0 * f32::from(i) / 500.0);
            let block = Block {
                command_m: 0.05 * way,
                displacement_m: 0.05 * way.clamp(-stroke, stroke),
                ..Block::EMPTY
            };
            signals.add(&k, &block)
        });
        rows.map(|row| row.stop.abs()).fold(0.0, f32::max)
    }

    #[test]
    fn a_small_motion_that_falls_short_is_no_end_of_a_stroke_and_a_large_one_is() {
        assert_eq!(stop(0.05, 0.04), 0.0);
        let half = stop(1.0, 0.5);
        assert!((half - 0.5).abs() < 0.03, "{half}");
        assert!(stop(0.1, 0.05) > 0.04);
    }
}
