//! Watches one actuator of a running test: whether the rig still follows its declared model, and what it lacks if not.
//!
//! ```text
//!  interrupt: the report of each step ─►┐
//!  thread:    Taps: sums of a few steps ◄┘ run lengths ─► Block, 500 a second
//!             Block ─► declared model, filters ─► Row, 125 a second ─► three regressions, four windows
//!                   └► noise, hum, frozen sensors, play              20 times a second ─► hypotheses ─► state, set
//!  interrupt: orders ◄─ hold, correct, trip ◄──────────────────────────────────────────────────────────────────┘
//! ```
//!
//! | file | contents |
//! |---|---|
//! | `post.rs` | the part in the control interrupt: orders come back after a fixed time |
//! | `tap.rs` | blocks of steps |
//! | `orders.rs`, `correction.rs`, `foresight.rs` | requests to the loop; corrections; error at the end of the test |
//! | `declared.rs` | the declared model of the actuator and its tolerances |
//! | `signals.rs` | declared displacement, filters, velocities, guessed limits |
//! | `unloading.rs` | which samples show the specimen's elastic stiffness while it yields |
//! | `regression.rs`, `normal.rs`, `answers.rs` | normal equations; every single cause from one inverse; what is kept |
//! | `noise.rs`, `frozen.rs`, `play.rs` | judgements without regression |
//! | `trend.rs` | whether an offset keeps moving |
//! | `state.rs`, `name.rs`, `verdict.rs` | states, causes with their sides, sets, of all actuators together |
//! | `hypothesis.rs`, `judge.rs`, `judge/naming.rs` | from hypotheses to causes: which side, which set, when |
//!
//! A cause is named if freeing it alone explains the residual far better than the declared tolerances do: twice the
//! log-likelihood ratio above 12, a value two standard deviations beyond its tolerance, 70 % of the residual explained,
//! three times in a row (150 ms), twelve if that began in the first second. In unloading: 48 and five deviations, or
//! less relative to a slope and lateness learnt in the same test. A named offset that keeps moving is a drift. A force
//! constant where an elastic specimen has been before is frozen. A cause that the motion hides has no freedom, no name.
//! Yielding is no cause: displacement to force is judged during unloading, when every specimen is elastic. Nor is
//! hardening, softening or degradation: if a stiffness that depends on the displacement, or that falls slowly or with
//! the largest motion, explains the deviation best, nothing is named.

mod answers;
mod correction;
mod declared;
mod foresight;
mod frozen;
mod hypothesis;
mod judge;
mod name;
mod noise;
mod normal;
mod orders;
mod play;
mod post;
mod regression;
mod signals;
mod state;
mod tap;
mod trend;
mod unloading;
mod verdict;

pub use correction::Corrections;
pub use declared::{Declared, DeclaredActuator};
pub use foresight::{ErrorLimit, PARTS};
pub use name::{Cause, Set, Side};
pub use orders::{Alarm, AxisOrders, Orders};
pub use post::{BlockId, WatchedStep};
pub(crate) use post::{LATENCY, Post};
pub use state::{Finding, State};
pub use tap::{Block, Seen, Tap, Taps, steps_in_block};
pub use verdict::Verdict;

use crate::refusal::Refusal;
use correction::Corrector;
use foresight::Foresight;
use frozen::{Frozen, Standing};
use judge::{BLOCKS_A_ROUND, Judge};
use noise::{Heard, Listener};
use play::Play;
use regression::{FRESH, Regressions, WINDOWS};
use signals::{BLOCKS_IN_ROW, Signals};
use unloading::Unloading;

/// Least noise assumed for a sensor, even if declared without, peaks: nothing is judged below it.
const LEAST_NOISE: [f32; 2] = [1e-4, 2e-4];
/// Speed, peaks times omega, above which a converter's steps are noise.
const MOVES: f32 = 0.05;

/// What the watch may ask of the loop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Actions {
    /// Hold an adaptive compensation while the displacement transducer is among the causes.
    pub hold: bool,
    /// Stop the test on a sensor that stands still.
    pub trip: bool,
    /// Correct for these.
    pub correct: Corrections,
    /// Stop the test on the error that what is named will add to it.
    pub error_limit: Option<ErrorLimit>,
}

/// What the watch of one actuator is told before a test.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Instructions {
    /// What was declared of the actuator.
    pub declared: Declared,
    /// What the watch may do.
    pub actions: Actions,
}

impl Instructions {
    /// True if command or reading may be corrected.
    pub fn corrects(&self) -> bool {
        let Corrections {
            lateness,
            gain,
            late_sensor,
        } = self.actions.correct;
        lateness || gain || late_sensor
    }
}

/// Watches one actuator.
#[derive(Clone, Debug)]
pub struct Watch {
    constants: Constants,
    corrector: Corrector,
    /// Predicted error that passed its limit; 0 for a frozen sensor.
    alarm: Option<f32>,
    signals: Signals,
    regressions: Regressions,
    unloading: Unloading,
    listeners: [Listener; 2],
    frozen: Frozen,
    play: Play,
    judge: Judge,
    blocks: u32,
    phase: u8,
}

#[derive(Clone, Debug)]
struct Constants {
    signals: signals::Constants,
    regression: regression::Constants,
    noise: noise::Constants,
    judge: judge::Constants,
    correction: correction::Constants,
    hold: bool,
    trip: bool,
    foresight: Option<Foresight>,
    block_s: f32,
    /// Declared noise of a block, peaks.
    least_noise: [f32; 2],
    has: [bool; 2],
    alone: bool,
    elastic: bool,
    /// Mass at the load cell is declared: its force shakes with the motion, so its noise and hum are not the sensor's.
    heavy: bool,
}

impl Watch {
    /// A watch that has seen nothing yet.
    ///
    /// # Errors
    /// A declared number that is impossible.
    pub fn new(told: &Instructions) -> Result<Self, Refusal> {
        let Instructions { declared, actions } = told;
        declared.check()?;
        let steps = f64::from(tap::steps_in_block(declared.rate_hz));
        let blocks_hz = declared.rate_hz / steps;
        let rows_hz = blocks_hz / f64::from(BLOCKS_IN_ROW);
        let peaks = [
            1.0 / declared.peak_m,
            1.0 / (declared.peak_m * declared.stiffness_n_per_m),
        ];
        let per_block = 1.0 / libm::sqrt(steps);
        let noise = |j: usize| (declared.noise[j] * peaks[j] * per_block) as f32;
        Ok(Self {
            constants: Constants {
                signals: signals::Constants::new(declared, blocks_hz),
                regression: regression::Constants::new(declared, rows_hz),
                noise: noise::Constants::new(blocks_hz),
                judge: judge::Constants::new(declared, blocks_hz),
                correction: correction::Constants::new(declared, actions.correct, blocks_hz),
                hold: actions.hold,
                trip: actions.trip,
                foresight: actions
                    .error_limit
                    .map(|limit| Foresight::new(declared, &limit)),
                block_s: (1.0 / blocks_hz) as f32,
                least_noise: [0, 1].map(|j| noise(j).max(LEAST_NOISE[j])),
                has: [declared.has_actuator, declared.has_specimen],
                alone: declared.alone,
                elastic: declared.elastic,
                heavy: declared.mass_kg > 0.0,
            },
            corrector: Corrector::default(),
            alarm: None,
            signals: Signals::at_rest(),
            regressions: Regressions::new(),
            unloading: Unloading::default(),
            listeners: [const { Listener::new() }; 2],
            frozen: Frozen::default(),
            play: Play::default(),
            judge: Judge::new(declared.elastic),
            blocks: 0,
            phase: 0,
        })
    }

    /// Resets in place for the next test.
    pub fn rest(&mut self) {
        self.corrector = Corrector::default();
        self.alarm = None;
        self.signals = Signals::at_rest();
        self.regressions.rest();
        self.unloading = Unloading::default();
        self.listeners = [const { Listener::new() }; 2];
        (self.frozen, self.play) = (Frozen::default(), Play::default());
        self.judge = Judge::new(self.constants.elastic);
        (self.blocks, self.phase) = (0, 0);
    }

    /// The present state.
    pub fn state(&self) -> State {
        self.judge.state
    }

    /// The causes that the motion so far cannot tell apart; empty until something is named.
    pub fn set(&self) -> Set {
        self.judge.published
    }

    /// Value and standard deviation of a cause of the set, in its unit.
    pub fn findings(&self) -> impl Iterator<Item = &Finding> {
        let set = self.judge.published;
        self.judge.findings.iter().filter(move |f| set.has(f.cause))
    }

    /// The least `cause` that could be named if it acted now, in the unit of the cause; `None` if the motion so far
    /// carries no information on it.
    pub fn least(&self, cause: Cause) -> Option<f32> {
        self.judge.least(&self.constants.judge, cause)
    }

    /// The present correction for `cause`, in the unit of the cause.
    pub fn corrected(&self, cause: Cause) -> f32 {
        self.corrector.of(cause)
    }

    /// The requests to the loop for this actuator.
    pub fn axis_orders(&self) -> AxisOrders {
        let k = &self.constants;
        let hold = k.hold && self.judge.published.teaches_wrongly();
        self.corrector.orders(&k.correction, hold)
    }

    /// Why the test must stop, if it must; `axis` is this actuator's.
    pub fn alarm(&self, axis: u8) -> Option<Alarm> {
        let foresight = self.constants.foresight.as_ref();
        self.alarm.map(|value| Alarm {
            axis,
            value,
            limit: foresight
                .filter(|_| value > 0.0)
                .map_or(0.0, Foresight::largest),
        })
    }

    /// Adds a block, does a bounded piece of the work, and returns true if state or set have changed.
    pub fn add(&mut self, block: &Block) -> bool {
        let k = &self.constants;
        if self.blocks == 0 {
            self.signals.settle(&k.signals, block);
        }
        self.blocks = self.blocks.wrapping_add(1);
        let row = self.signals.add(&k.signals, block);
        self.judge.pass_block();
        self.corrector.pass_block(&k.correction);
        let changed = self.look_at_block(block);
        if let Some(row) = row {
            let k = &self.constants;
            self.judge.observe(&k.judge, &row);
            let [actuator, specimen] = k.has;
            let unloading = specimen.then(|| self.unloading.add(&row)).flatten();
            let kinds = [actuator, specimen && self.judge.elastic];
            let fresh = self.judge.doubts();
            self.regressions.add(
                (&k.regression, &k.judge.half),
                &row,
                fresh,
                kinds,
                unloading,
            );
        }
        self.work() | changed
    }

    /// Noise, hum, frozen sensors and play.
    fn look_at_block(&mut self, block: &Block) -> bool {
        let k = &self.constants;
        let [y, x, r] = self.signals.raw;
        let moves = self.judge.speed() > MOVES;
        for (j, pair) in [[x, y], [r, x]].into_iter().enumerate() {
            let least = k.least_noise[j];
            let heard = self.listeners[j].add(&k.noise, pair, moves, least);
            let sigma = self.listeners[j].sigma();
            match heard.filter(|_| j == 0 || !k.heavy) {
                Some(Heard::Noise(times)) => self.judge.name_noise(&k.judge, j, times * sigma),
                Some(Heard::Hum(amplitude)) => self.judge.name_hum(&k.judge, j, amplitude),
                None => {}
            }
        }
        if !self.listeners.iter().all(Listener::knows) {
            return false;
        }
        let sigma = [self.listeners[0].sigma(), self.listeners[1].sigma()];
        if let Some(width) = self.play.add(x, r, sigma)
            && k.alone
        {
            self.judge.name_play(&k.judge, width);
        }
        let elastic = k.has[1] && self.judge.has_been_elastic_at(x);
        match self.frozen.add([y, x, r], sigma, block.same, elastic) {
            Some(Standing::Displacement) if k.has[0] => self.stop(Cause::FrozenDisplacement),
            Some(Standing::Force) if k.alone => self.stop(Cause::FrozenForce),
            Some(Standing::Displacement | Standing::Force) | None => false,
        }
    }

    /// Handles a frozen sensor.
    fn stop(&mut self, cause: Cause) -> bool {
        if self.constants.trip && self.alarm.is_none() {
            self.alarm = Some(0.0);
        }
        self.judge.trip(cause)
    }

    /// Acts on a settled set: corrects, and stops the test if every possible cause will add more than the declared
    /// error. True if it stops.
    fn act(&mut self) -> bool {
        let k = &self.constants;
        let (settled, may) = (self.judge.settled(), self.judge.may_correct());
        self.corrector.aim(&k.correction, settled, may);
        let Some(foresight) = &k.foresight else {
            return false;
        };
        let now_s = self.blocks as f32 * k.block_s;
        let fitted = self.judge.settled().filter(|f| f.cause.is_fitted());
        let errors = fitted.map(|f| {
            let corrected = self.corrector.will_be_of(f.cause);
            foresight.error(f, corrected, now_s)
        });
        let least = errors.reduce(f32::min).unwrap_or(0.0);
        if !(least > foresight.largest()) || self.alarm.is_some() {
            return false;
        }
        self.alarm = Some(least);
        self.judge.stop()
    }

    /// One piece of a round: a solve, or the judgement.
    fn work(&mut self) -> bool {
        let k = &self.constants;
        let piece = usize::from(self.phase);
        self.phase = (self.phase + 1) % BLOCKS_A_ROUND;
        let (window, regression) = (piece / 3, piece % 3);
        if !self.listeners.iter().all(Listener::knows) {
            return false;
        }
        if window < WINDOWS {
            if window == FRESH && !self.judge.doubts() {
                return false;
            }
            let sigma = [self.listeners[0].sigma(), self.listeners[1].sigma()];
            let left = self.judge.left_while_sound(regression);
            let answer = self
                .regressions
                .solve(&k.regression, window, regression, sigma, left);
            self.judge.take(window, regression, answer);
            return false;
        }
        if piece != 3 * WINDOWS {
            return false;
        }
        let doubted = self.judge.doubts();
        let changed = self.judge.conclude(&k.judge);
        if self.judge.doubts() && !doubted {
            self.regressions.begin_fresh();
        }
        self.act() | changed
    }
}

/// For a board's tasks and a PC: gives each watch its actuator's block and updates its orders. A bounded piece of work.
pub fn judge<'a>(
    watches: impl Iterator<Item = &'a mut Watch>,
    blocks: &[Block],
    orders: &mut [AxisOrders],
) -> Verdict {
    let mut all = Verdict::NONE;
    for (axis, ((watch, block), orders)) in (0..).zip(watches.zip(blocks).zip(orders)) {
        let changed = watch.add(block);
        *orders = watch.axis_orders();
        all = all.with(Verdict {
            state: watch.state(),
            alarm: watch.alarm(axis),
            changed,
        });
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_watch_is_no_larger_than_a_board_has_room_for() {
        let parts = [
            ("constants", size_of::<Constants>()),
            ("regressions", size_of::<Regressions>()),
            ("judge", size_of::<Judge>()),
            ("signals", size_of::<Signals>()),
            ("listeners", size_of::<[Listener; 2]>()),
            ("frozen", size_of::<Frozen>()),
        ];
        // It contains no pointers: same size here and on a board.
        let bytes = size_of::<Watch>();
        assert!(bytes <= 4096, "{bytes} bytes, of these {parts:?}");
    }
}
