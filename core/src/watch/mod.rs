//! Watches one actuator of a running test: whether the rig still does what its declared model says, and what it lacks if not.
//!
//! ```text
//!  interrupt: command, displacement, force ─► Tap: sums of a few steps, run lengths ─► Block, 500 a second
//!  thread:    Block ─► declared model, filters ─► Row, 125 a second ─► three regressions, four windows
//!                   └► noise, hum, standing sensors, play            20 times a second ─► hypotheses ─► state, set
//! ```
//!
//! | file | what is there |
//! |---|---|
//! | `tap.rs` | what is done in the control interrupt |
//! | `declared.rs` | the declared model of the actuator and its tolerances |
//! | `signals.rs` | declared displacement, filters, velocities, guessed limits |
//! | `unloading.rs` | which samples tell of the specimen's elastic stiffness while it yields |
//! | `regression.rs`, `normal.rs` | normal equations; every single cause from one inverse |
//! | `noise.rs`, `frozen.rs`, `play.rs` | what is no regression |
//! | `state.rs`, `name.rs` | states, causes with their sides, sets |
//! | `judge.rs` | from hypotheses to causes: which side, which set, when |
//!
//! A cause is named when letting it alone go explains the residual far better than the declared tolerances do: twice the
//! logarithm of the likelihood ratio above 12, a value beyond its tolerance by two standard deviations, 70 % of the residual
//! explained, three times in a row (150 ms). A motion that tells nothing of a cause gives it no freedom, and so no name.
//! A specimen that yields is no cause: displacement to force is judged while it unloads, where every specimen is elastic.

mod declared;
mod frozen;
mod judge;
mod name;
mod noise;
mod normal;
mod play;
mod regression;
mod signals;
mod state;
mod tap;
mod unloading;

pub use declared::{Declared, DeclaredActuator};
pub use name::{Cause, Set, Side};
pub use state::{Finding, State};
pub use tap::{Block, Tap};

use crate::refusal::Refusal;
use frozen::{Frozen, Standing};
use judge::{BLOCKS_A_ROUND, Judge};
use noise::{Heard, Listener};
use play::Play;
use regression::{FRESH, Regressions, WINDOWS};
use signals::{BLOCKS_IN_ROW, Signals};
use unloading::Unloading;

/// A sensor that is declared without noise still has this, peaks: below it nothing is judged.
const LEAST_NOISE: [f32; 2] = [1e-4, 2e-4];
/// Speed, peaks times omega, from which a converter's steps are noise.
const MOVES: f32 = 0.05;

/// Watches one actuator.
#[derive(Clone, Debug)]
pub struct Watch {
    constants: Constants,
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
    /// Noise of a block that is declared, peaks.
    least_noise: [f32; 2],
    has: [bool; 2],
}

impl Watch {
    /// Nothing seen yet.
    ///
    /// # Errors
    /// A number of `declared` that cannot be what it stands for.
    pub fn new(declared: &Declared) -> Result<Self, Refusal> {
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
                least_noise: [0, 1].map(|j| noise(j).max(LEAST_NOISE[j])),
                has: [declared.has_actuator, declared.has_specimen],
            },
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

    /// What it says now.
    pub fn state(&self) -> State {
        self.judge.state
    }

    /// The causes that a motion like this does not tell apart; empty until something is named.
    pub fn set(&self) -> Set {
        self.judge.published
    }

    /// Value and standard deviation of a cause of the set, in its unit.
    pub fn findings(&self) -> impl Iterator<Item = &Finding> {
        let set = self.judge.published;
        self.judge.findings.iter().filter(move |f| set.has(f.cause))
    }

    /// Takes a block in. It does a bounded piece of the work and gives true when state or set have changed.
    pub fn add(&mut self, block: &Block) -> bool {
        let k = &self.constants;
        if self.blocks == 0 {
            self.signals.settle(&k.signals, block);
        }
        self.blocks = self.blocks.wrapping_add(1);
        let row = self.signals.add(&k.signals, block);
        self.judge.pass_block();
        let changed = self.look_at_block(block);
        if let Some(row) = row {
            let k = &self.constants;
            self.judge.see(&row);
            let [actuator, specimen] = k.has;
            let unloading = specimen.then(|| self.unloading.add(&row)).flatten();
            let kinds = [actuator, specimen && self.judge.elastic];
            let fresh = self.judge.doubts();
            self.regressions
                .add(&k.regression, &row, fresh, kinds, unloading);
        }
        self.work() | changed
    }

    /// Noise, hum, standing sensors and play.
    fn look_at_block(&mut self, block: &Block) -> bool {
        let k = &self.constants;
        let [y, x, r] = self.signals.raw;
        let moves = self.judge.speed() > MOVES;
        for (j, value) in [x, r].into_iter().enumerate() {
            let least = k.least_noise[j];
            let heard = self.listeners[j].add(&k.noise, value, moves, least);
            let sigma = self.listeners[j].sigma();
            match heard {
                Some(Heard::Noise(times)) => self.judge.name_noise(&k.judge, j, times * sigma),
                Some(Heard::Hum(amplitude)) => self.judge.name_hum(&k.judge, j, amplitude),
                None => {}
            }
        }
        if !self.listeners.iter().all(Listener::knows) {
            return false;
        }
        let sigma = [self.listeners[0].sigma(), self.listeners[1].sigma()];
        if let Some(width) = self.play.add(x, r) {
            self.judge.name_play(&k.judge, width);
        }
        match self.frozen.add([y, x, r], sigma, block.same) {
            Some(Standing::Displacement) if k.has[0] => self.judge.trip(Cause::FrozenDisplacement),
            Some(Standing::Force) => self.judge.trip(Cause::FrozenForce),
            Some(Standing::Displacement) | None => false,
        }
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
        changed
    }
}
