//! Turns blocks of command, displacement and force into the inputs of the regressions, in units of the planned peak and
//! of the structure's frequency.

use super::declared::Declared;
use super::tap::Block;
use crate::delay_line::{Delay, DelayLine};
use crate::estimate::{Biquad, LowPass};
use crate::float::{larger, smaller};

/// Blocks per row of the regressions.
pub(super) const BLOCKS_IN_ROW: u8 = 4;
/// Travel over which an actuator's friction builds up after a turn, peaks.
const BUILDS_UP: f32 = 0.01;
/// The longest transport delay of an actuator, blocks.
const LONGEST: usize = 64;
/// The largest speed and displacement are forgotten over this many natural periods.
const LEAK_PERIODS: f32 = 3.0;
/// Speeds and displacements above these fractions of the model's show no limit.
const SLOWER: f32 = 0.94;
const SHORTER: f32 = 0.96;
/// They must fall short by this, too, peaks: a structure's first cycles fall short without a stroke limit.
const SHORTER_PEAKS: f32 = 0.02;

/// Constants of the signals.
#[derive(Clone, Debug)]
pub(super) struct Constants {
    delay: Delay,
    /// First-order lag by first-order hold: weights of the old output, the new and the last input.
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

/// One sample for the regressions; displacement in peaks, velocity in peaks times omega, and so on.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Row {
    /// The actuator as declared: displacement, velocity, acceleration.
    pub(super) y: [f32; 3],
    /// As measured: displacement, velocity.
    pub(super) x: [f32; 2],
    /// Force in stiffness times peak.
    pub(super) r: f32,
    /// Built-up fraction of the friction that opposes the declared motion.
    pub(super) held: f32,
    /// Change of the declared displacement by a limit of speed and by one of stroke.
    pub(super) rate: f32,
    pub(super) stop: f32,
    /// The largest measured speed and displacement, if they are a limit.
    pub(super) limits: [f32; 2],
}

/// The state of the signals.
#[derive(Clone, Debug)]
pub(super) struct Signals {
    line: DelayLine<LONGEST>,
    lagged: [f32; 2],
    /// Raw declared displacement, raw displacement and raw force of this block, in peaks.
    pub(super) raw: [f32; 3],
    filters: [LowPass; 4],
    /// Declared displacement, displacement, force, rate-limited minus declared: the last three rows.
    past: [[f32; 3]; 4],
    slewed: f32,
    /// Declared travel since friction reversed, at most its build-up length.
    slides: f32,
    /// Leaky maxima of measured and declared speed, measured and declared displacement.
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
        // Commands that drive a lag are held: they lead commands joined by lines by half a control period.
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

    /// Settled, as if the input had always been the first block.
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

    /// Adds a block; every fourth returns a row, for the time one row earlier.
    pub(super) fn add(&mut self, k: &Constants, block: &Block) -> Option<Row> {
        let delayed = self.line.pass(k.delay, block.command_m * k.per_peak);
        let [stays, new, last] = k.lag;
        let lagged = stays * self.lagged[1] + new * delayed + last * self.lagged[0];
        self.lagged = [delayed, lagged];
        let y = k.gain * lagged + k.offset;
        let x = block.displacement_m * k.per_peak;
        let r = (block.force_n - k.force_offset_n) * k.per_force;
        self.raw = [y, x, r];
        // The declared motion under a limit of speed; without a limit it is unchanged.
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

    /// The most that a stroke limit explains in a motion of `peaks` peaks that goes no further than `stroke` peaks.
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
