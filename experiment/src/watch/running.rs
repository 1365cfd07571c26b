//! Watches a running test, in its loop.

use super::place::Place;
use super::report::{CorrectionStep, NamedCause, WatchEvent, WatchReport, Watchable};
use super::told::{actions, declared, gaps};
use crate::failure::Failure;
use crate::files::test::TestFile;
use crate::trace::{AnyRecord, TestObserver};
use outerloop_core::watch::{
    AxisOrders, Block, Cause, Instructions, State, Verdict, Watch, judge, steps_in_block,
};
use std::f64::consts::TAU;

/// Watches a running test, in its loop.
#[derive(Clone, Debug)]
pub struct TestWatch {
    told: Vec<Instructions>,
    actuators: Vec<Watch>,
    events: Vec<WatchEvent>,
    corrections: Vec<CorrectionStep>,
    watchable: Vec<Watchable>,
    not_watched: Vec<String>,
    steps: u64,
    /// Blocks that were judged; fewer than were full where steps of a board were lost.
    blocks: u64,
    steps_per_s: f64,
    rate_hz: f64,
    learns: bool,
}

/// Blocks at the end of a test that nobody has to judge.
const UNSEEN_BLOCKS: u64 = 8;
/// How often it is asked what would be named.
const BLOCKS_A_LOOK: u64 = 50;
/// Of two actuators on one coupler the coordinates are not the actuators'.
const COUPLED: &str =
    "Nothing is watched: the rig watch does not look at two actuators on one coupler.";
/// A correction is noted when it has changed by more than this, in its unit, and so long after the last one, s of the model.
const CHANGED: f64 = 1e-3;
const LEAST_S: f64 = 0.05;

impl TestWatch {
    /// For `test`. `None` where the watch is off or nothing moves.
    ///
    /// # Errors
    /// A declared value that cannot be watched; something to do where it cannot be done.
    pub fn of(test: &TestFile, place: &Place<'_>) -> Result<Option<Self>, Failure> {
        let (settings, hz) = (&test.watch, place.first_hz);
        if !settings.on || hz <= 0.0 || hz.is_nan() {
            return Ok(None);
        }
        let timing = &test.config.timing;
        if test.coupled.is_some() {
            return Ok(Some(Self {
                not_watched: vec![COUPLED.to_owned()],
                ..Self::at_rate(timing.rate_hz, timing.time_scale)
            }));
        }
        let (mut not_watched, mut refused) = (Vec::new(), Vec::new());
        let (mut told, mut actuators) = (Vec::new(), Vec::new());
        let peaks_m = place.ideal.peaks_m();
        let floors = test.config.physical_storeys();
        for (j, &peak_m) in peaks_m.iter().enumerate().take(floors) {
            let actions = actions(test, place, (j, peak_m))?;
            let declared = declared(test, j, peak_m, TAU * hz / timing.time_scale);
            for sentence in gaps(&declared) {
                if !not_watched.contains(&sentence) {
                    not_watched.push(sentence);
                }
            }
            let own = Instructions { declared, actions };
            match Watch::new(&own) {
                Ok(watch) => {
                    actuators.push(watch);
                    told.push(own);
                }
                Err(refusal) => refused.push(format!(
                    "Nothing is watched: for actuator {}, {refusal}",
                    j + 1
                )),
            }
        }
        // A block has all of them, in turn.
        if !refused.is_empty() {
            told.clear();
            actuators.clear();
            not_watched = refused;
        }
        Ok(Some(Self {
            told,
            actuators,
            not_watched,
            learns: test.config.compensation.kind.predictor.learns(),
            ..Self::at_rate(timing.rate_hz, timing.time_scale)
        }))
    }

    /// Of one actuator whose record is there already, with what `not_watched` says.
    ///
    /// # Errors
    /// A declared value that cannot be watched.
    pub(super) fn over(told: Instructions, not_watched: Vec<String>) -> Result<Self, Failure> {
        let refused = |why| Failure::input(format!("cannot be watched: {why}"));
        let rate_hz = told.declared.rate_hz;
        Ok(Self {
            actuators: vec![Watch::new(&told).map_err(refused)?],
            told: vec![told],
            not_watched,
            ..Self::at_rate(rate_hz, 1.0)
        })
    }

    /// Nothing watched yet.
    fn at_rate(rate_hz: f64, time_scale: f64) -> Self {
        Self {
            told: Vec::new(),
            actuators: Vec::new(),
            events: Vec::new(),
            corrections: Vec::new(),
            watchable: Vec::new(),
            not_watched: Vec::new(),
            steps: 0,
            blocks: 0,
            steps_per_s: rate_hz * time_scale,
            rate_hz,
            learns: false,
        }
    }

    fn state(&self) -> State {
        let states = self.actuators.iter().map(Watch::state);
        states.max().unwrap_or_default()
    }

    /// A control step has passed.
    pub(super) fn pass_step(&mut self) {
        self.steps += 1;
    }

    fn number(&self, j: usize) -> Option<usize> {
        (self.actuators.len() > 1).then_some(j + 1)
    }

    fn set(&self) -> Vec<NamedCause> {
        let mut set = Vec::new();
        for (j, watch) in self.actuators.iter().enumerate() {
            set.extend(watch.findings().map(|f| {
                let corrected = f64::from(watch.corrected(f.cause));
                NamedCause {
                    corrected: (corrected != 0.0).then_some(corrected),
                    ..NamedCause::of(f, self.number(j))
                }
            }));
        }
        set
    }

    fn now_s(&self) -> f64 {
        self.steps as f64 / self.steps_per_s
    }

    fn note(&mut self) {
        let set = self.set();
        let holds = |watch: &Watch| watch.axis_orders().hold;
        let event = WatchEvent {
            t_s: self.now_s(),
            state: self.state().name(),
            corrected: set.iter().any(|cause| cause.corrected.is_some()),
            held: self.learns && self.actuators.iter().any(holds),
            set,
        };
        self.events.push(event);
    }

    /// Notes the corrections that have changed, at most 20 times a second.
    fn note_corrections(&mut self) {
        let now_s = self.now_s();
        for (j, watch) in self.actuators.iter().enumerate() {
            for &cause in Cause::ALL {
                let corrected = f64::from(watch.corrected(cause));
                let actuator = self.number(j);
                let own = |c: &&CorrectionStep| {
                    (c.name, c.side, c.actuator) == (cause.name(), cause.side().name(), actuator)
                };
                let last = self.corrections.iter().rev().find(own);
                let (last_s, before) = last.map_or((-1.0, 0.0), |c| (c.t_s, c.corrected));
                if now_s - last_s < LEAST_S || (corrected - before).abs() <= CHANGED {
                    continue;
                }
                self.corrections.push(CorrectionStep {
                    t_s: now_s,
                    name: cause.name(),
                    side: cause.side().name(),
                    actuator,
                    corrected,
                    unit: cause.unit(),
                });
            }
        }
    }

    /// Notes what would be named now, while nothing is.
    fn note_watchable(&mut self) {
        for (j, watch) in self.actuators.iter().enumerate() {
            if watch.state() != State::Sound {
                continue;
            }
            let actuator = self.number(j);
            for &cause in Cause::ALL {
                let Some(least) = watch.least(cause).map(f64::from) else {
                    continue;
                };
                let own = |w: &&mut Watchable| {
                    (w.name, w.side, w.actuator) == (cause.name(), cause.side().name(), actuator)
                };
                match self.watchable.iter_mut().find(own) {
                    Some(known) => known.least = known.least.min(least),
                    None => self.watchable.push(Watchable {
                        name: cause.name(),
                        side: cause.side().name(),
                        actuator,
                        least,
                        unit: cause.unit(),
                    }),
                }
            }
        }
    }

    /// What it had to say. The last event is what had settled at the end.
    pub fn report(mut self) -> WatchReport {
        let blocks = self.steps / u64::from(steps_in_block(self.rate_hz));
        let seen_s =
            self.blocks as f64 * f64::from(steps_in_block(self.rate_hz)) / self.steps_per_s;
        if !self.told.is_empty() && self.blocks + UNSEEN_BLOCKS < blocks {
            self.not_watched.push(format!(
                "Names and values end at {seen_s:.2} s, where steps were lost on their way from the board: its own watch went on, and \
                 `outerloop board status` has what it named."
            ));
        }
        if self.events.last().is_some_and(|last| !last.set.is_empty()) {
            self.note();
        }
        WatchReport {
            state: self.state().name(),
            events: self.events,
            corrections: self.corrections,
            diagnosis: None,
            watchable: self.watchable,
            not_watched: self.not_watched,
        }
    }
}

impl TestObserver for TestWatch {
    fn on_step(&mut self, _: &AnyRecord<'_>) {
        self.pass_step();
    }

    fn watches_the_loop(&mut self) -> Option<Vec<Instructions>> {
        (!self.told.is_empty()).then(|| self.told.clone())
    }

    fn judge(&mut self, blocks: &[Block], orders: &mut [AxisOrders]) -> Verdict {
        self.blocks += 1;
        let verdict = judge(self.actuators.iter_mut(), blocks, orders);
        if verdict.changed {
            self.note();
        }
        self.note_corrections();
        if self.blocks.is_multiple_of(BLOCKS_A_LOOK) {
            self.note_watchable();
        }
        verdict
    }

    fn says(&self) -> Option<String> {
        self.events.last().map(WatchEvent::in_words)
    }
}
