//! Elements in the path of a displacement or of a signal: one number in, one number out, every control period.

mod friction;
mod lost_motion;
mod slow;

pub use friction::Friction;
pub use lost_motion::{Play, SlipGap};
pub use slow::{Drift, WarmUp};

use crate::delay_line::DelayLine;
use crate::lag::{FirstOrder, SecondOrder};
use crate::random::Normal;
use crate::sensor::Hum;

/// One stage. Numbers are in SI units of the passing quantity.
#[derive(Clone, Debug)]
pub(crate) enum Stage {
    /// Transport delay.
    Delay(DelayLine),
    /// First-order lag.
    Lag(FirstOrder),
    /// Second-order resonance.
    Resonance(SecondOrder),
    /// First-order lag on the way down only, as in a piston with unequal areas.
    RetractLag(FirstOrder, f64),
    /// Multiplies.
    Gain(f64),
    /// Multiplies by `1 + d/2` above zero, by `1 - d/2` below.
    UnequalGain(f64),
    /// Adds.
    Offset(f64),
    /// Adds an amount that grows with time.
    Drift(Drift),
    /// Multiplies by a gain that changes with time.
    WarmUp(WarmUp),
    /// Follows a reversal only after the play.
    Play(Play),
    /// Passes nothing within this distance from zero.
    DeadZone(f64),
    /// Slips in a bolt hole.
    SlipGap(SlipGap),
    /// Falls short by the amount that friction holds back.
    Friction(Friction),
    /// Does not go beyond this, either way.
    Stop(f64),
    /// Moves by no more than this per period.
    Slew(f64, f64),
    /// Adds a sine.
    Hum(Hum),
    /// Rounds to multiples of this.
    Rounding(f64),
    /// Keeps the value at which it began.
    Held(Option<f64>),
    /// Adds white noise of this rms.
    Noise(Box<Normal>, f64),
}

impl Stage {
    #[inline]
    fn step(&mut self, x: f64) -> f64 {
        match self {
            Self::Delay(line) => line.step(x),
            Self::Lag(lag) => lag.step(x),
            Self::Resonance(lag) => lag.step(x),
            Self::RetractLag(lag, at) => {
                if x >= *at {
                    lag.move_to(x);
                    *at = x;
                } else {
                    *at = lag.step(x);
                }
                *at
            }
            Self::Gain(gain) => *gain * x,
            Self::UnequalGain(difference) => x + 0.5 * *difference * x.abs(),
            Self::Offset(offset) => x + *offset,
            Self::Drift(drift) => x + drift.step(),
            Self::WarmUp(warm_up) => x * warm_up.step(),
            Self::Play(play) => play.step(x),
            Self::DeadZone(half) => x - x.clamp(-*half, *half),
            Self::SlipGap(gap) => gap.step(x),
            Self::Friction(friction) => x - friction.step(x),
            Self::Stop(limit) => x.clamp(-*limit, *limit),
            Self::Slew(most, at) => {
                *at += (x - *at).clamp(-*most, *most);
                *at
            }
            Self::Hum(hum) => x + hum.step(),
            Self::Rounding(step) => (x / *step).round() * *step,
            Self::Held(at) => *at.get_or_insert(x),
            Self::Noise(normal, rms) => x + *rms * normal.sample(),
        }
    }

    /// Begins while the signal is at `x`: stages with memory are at rest there. A delay holds this value until new
    /// input comes out.
    fn begin_at(&mut self, x: f64) {
        match self {
            Self::Delay(line) => line.fill(x),
            Self::Lag(lag) => lag.move_to(x),
            Self::Resonance(lag) => lag.move_to(x),
            Self::RetractLag(lag, at) => {
                lag.move_to(x);
                *at = x;
            }
            Self::Play(play) => play.move_to(x),
            Self::Friction(friction) => friction.move_to(x),
            Self::Slew(_, at) => *at = x,
            Self::Gain(_)
            | Self::UnequalGain(_)
            | Self::Offset(_)
            | Self::Drift(_)
            | Self::WarmUp(_)
            | Self::DeadZone(_)
            | Self::SlipGap(_)
            | Self::Stop(_)
            | Self::Hum(_)
            | Self::Rounding(_)
            | Self::Held(_)
            | Self::Noise(..) => {}
        }
    }
}

/// A series of stages, usually none.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stages {
    all: Vec<Stage>,
    /// Number of final stages that begin in the next period.
    beginning: usize,
}

impl Stages {
    pub(crate) fn push(&mut self, stage: Stage) {
        self.all.push(stage);
    }

    /// Appends `later`, at rest where the next period finds them.
    pub(crate) fn begin(&mut self, later: Self) {
        self.beginning += later.all.len();
        self.all.extend(later.all);
    }

    #[inline]
    pub(crate) fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    #[inline]
    pub(crate) fn step(&mut self, x: f64) -> f64 {
        if self.all.is_empty() {
            return x;
        }
        self.pass(x)
    }

    /// Not inlined: most channels have no stages, and the registers that they would need are costly.
    #[inline(never)]
    fn pass(&mut self, x: f64) -> f64 {
        let settled = self.all.len() - std::mem::take(&mut self.beginning);
        let mut x = x;
        for (i, stage) in self.all.iter_mut().enumerate() {
            if i >= settled {
                stage.begin_at(x);
            }
            x = stage.step(x);
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_piston_that_retracts_slowly_lags_on_the_way_down_only() {
        let mut stage = Stage::RetractLag(FirstOrder::new(0.02, 5e-4), 0.0);
        for i in 1..=100 {
            assert_eq!(stage.step(f64::from(i)), f64::from(i));
        }
        let mut down = 0.0;
        for _ in 0..40 {
            down = stage.step(0.0);
        }
        assert!(
            (down / (100.0 * (-1.0_f64).exp()) - 1.0).abs() < 1e-9,
            "{down}"
        );
    }

    #[test]
    fn stops_slews_zones_and_rounding() {
        assert_eq!(Stage::Stop(2.0).step(-3.0), -2.0);
        let mut slew = Stage::Slew(0.5, 0.0);
        assert_eq!(
            [slew.step(1.2), slew.step(1.2), slew.step(1.2)],
            [0.5, 1.0, 1.2]
        );
        assert_eq!(Stage::DeadZone(0.5).step(-2.0), -1.5);
        assert_eq!(Stage::DeadZone(0.5).step(0.4), 0.0);
        assert_eq!(Stage::Rounding(0.25).step(0.9), 1.0);
        assert_eq!(Stage::UnequalGain(0.2).step(-1.0), -0.9);
        assert_eq!(Stage::UnequalGain(0.2).step(1.0), 1.1);
    }
}
