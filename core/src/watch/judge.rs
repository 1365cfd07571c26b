//! From hypotheses to causes: which, and since when; `judge/naming.rs` decides on which side.

mod naming;

use super::answers::Answers;
use super::declared::Declared;
use super::hypothesis::{Hypothesis, least_named};
use super::name::{Cause, Set, Side};
use super::regression::{ACTUATOR, Answer, FORCE, FRESH, LONGEST as REFERENCE, UNLOADING, WINDOWS};
use super::signals::Row;
use super::state::{Finding, State};
use super::trend::Trend;
use crate::float::larger;
use heapless::Vec;

/// Regression in which an offset shows, and for each possible side the offset cause with its drift.
const OFFSETS: &[(usize, &[[Cause; 2]]); 2] = &[
    (
        ACTUATOR,
        &[
            [Cause::ActuatorOffset, Cause::ActuatorDrift],
            [Cause::DisplacementOffset, Cause::DisplacementDrift],
        ],
    ),
    (FORCE, &[[Cause::ForceOffset, Cause::ForceDrift]]),
];
/// The first columns of the force and the unloading, used to tell sides apart.
const REFERRED: usize = 3;
/// Columns of the actuator's regression whose side another channel can determine.
const OFFSET: usize = 0;
const GAIN: usize = 1;
const LATE: usize = 2;
/// Blocks between judgements: 50 ms.
pub(super) const BLOCKS_A_ROUND: u8 = 25;
/// Number of causes whose values are kept.
const MOST_FINDINGS: usize = 8;
/// Twice the log-likelihood ratio that raises a doubt: of the actuator, of the force, of the unloading.
const DOUBT: [f32; 3] = [8.0, 8.0, 32.0];
/// Represents the fraction of a cause that has always been in the set.
const ALWAYS: f32 = 65_535.0;
/// Judgements after which an unchanged set counts as settled.
const SETTLED: u8 = 3;
/// Consecutive rounds needed; more if they began in the first second judged, when there are few samples.
const ROUNDS: u8 = 3;
const FIRST_ROUNDS: u8 = 20;
const ROUNDS_AT_FIRST: u8 = 12;
/// Natural periods after which a doubt without a name lapses; those for which a new largest motion counts as new.
const FALLS_BACK: f32 = 2.0;
const NEW_LARGEST: f32 = 4.0;
/// A secant below this fraction of the declared stiffness means yielding, for motions above this size, peaks.
const SECANT: f32 = 0.9;
const WORTH_A_SECANT: f32 = 0.1;
/// After a turn back to this fraction of the largest displacement, the specimen has yielded if its force fell short of
/// the declared stiffness, allowing for the tolerance, by more than this, peaks.
const TURNED: f32 = 0.98;
const SHORT: f32 = 0.01;
/// Factor by which a motion must exceed the largest to be a new largest.
const LARGER: f32 = 1.02;
/// Periods of samples needed for a reference.
const LEARNED: f32 = 1.0;
const LEARNED_UNLOADING: f32 = 0.25;
/// Twice the log-likelihood ratio below which the unloading is considered unchanged.
const CALM: f32 = 4.0;
/// Columns of the unloading that may change: slope and lateness.
const CHANGES: usize = 2;
/// Deviations within which a side is possible, and by which the other side must be worse.
const POSSIBLE: f32 = 3.0;
const WORSE: f32 = 2.0;
/// Allowed errors of a reference: slope, offset in peaks, lateness in half tolerances.
const SLOPE_OFF: f32 = 0.006;
const OFFSET_OFF: f32 = 0.002;
const LATE_OFF: f32 = 0.6;

/// The column of a regression that is the slope of the force.
fn slope_of(regression: usize) -> usize {
    1 - usize::from(regression == UNLOADING)
}

/// The column of a regression for a displacement-dependent stiffness: the specimen's own.
fn bend_of(regression: usize) -> usize {
    if regression == UNLOADING { 4 } else { 6 }
}

/// Scales of the values.
#[derive(Clone, Debug)]
pub(super) struct Constants {
    pub(super) half: super::declared::HalfTolerances,
    peak_m: f32,
    omega: f32,
    stiffness: f32,
    blocks_a_period: f32,
    /// Fraction by which a membership moves in a round.
    settles: f32,
}

impl Constants {
    pub(super) fn new(d: &Declared, blocks_hz: f64) -> Self {
        let period_s = core::f64::consts::TAU / d.omega_rad_per_s;
        let round_s = f64::from(BLOCKS_A_ROUND) / blocks_hz;
        Self {
            half: d.half_tolerances(),
            peak_m: d.peak_m as f32,
            omega: d.omega_rad_per_s as f32,
            stiffness: d.stiffness_n_per_m as f32,
            blocks_a_period: (period_s * blocks_hz) as f32,
            settles: (round_s / (0.75 * period_s)).min(1.0) as f32,
        }
    }
}

impl Constants {
    /// Judgements in a natural period.
    fn rounds_a_period(&self) -> f32 {
        self.blocks_a_period / f32::from(BLOCKS_A_ROUND)
    }

    /// The cause that a column of a regression represents, with its unit per half tolerance; `None` if the sign of the
    /// coefficient fits no cause: friction and forces that push, a force that is early. The bend of the phase is part
    /// of the lateness, a displacement-dependent stiffness belongs to the specimen.
    fn meaning(&self, regression: usize, column: usize, theta: f32) -> Option<(Cause, f32)> {
        let force = self.peak_m * self.stiffness;
        let (cause, unit, half) = if regression == ACTUATOR {
            let (cause, unit) = match column {
                OFFSET => (Cause::ActuatorOffset, self.peak_m),
                GAIN => (Cause::ActuatorGain, 1.0),
                LATE => (Cause::ActuatorLate, 1.0 / self.omega),
                4 if theta > 0.0 => (Cause::ActuatorFriction, self.peak_m),
                7 if theta > 0.0 => (Cause::ActuatorOverlap, 2.0 * self.peak_m),
                _ => return None,
            };
            (cause, unit, self.half.actuator[column])
        } else {
            if column == bend_of(regression) {
                return None;
            }
            let (role, half) = match regression {
                FORCE => (column, self.half.force.get(column)?),
                _ => (column + 1, self.half.unloading.get(column)?),
            };
            let (cause, unit) = match role {
                0 => (Cause::ForceOffset, force),
                1 => (Cause::ForceGain, 1.0),
                2 if theta < 0.0 => (Cause::ForceLate, -1.0 / self.omega),
                3 if theta > 0.0 => {
                    let mass_kg = self.stiffness / (self.omega * self.omega);
                    (Cause::Mass, mass_kg)
                }
                4 if theta > 0.0 => (Cause::BearingFriction, force),
                5 if theta > 0.0 => (Cause::Play, 2.0 * self.peak_m),
                _ => return None,
            };
            (cause, unit, *half)
        };
        Some((cause, half * unit))
    }
}

/// The present judgement of the rig.
#[derive(Clone, Debug)]
pub(super) struct Judge {
    pub(super) state: State,
    pub(super) published: Set,
    pub(super) findings: Vec<Finding, MOST_FINDINGS, u8>,
    /// False once the specimen has shown that it is not elastic, whatever was declared.
    pub(super) elastic: bool,
    answers: Answers,
    /// From the longest window while the test was sound: the residual of the free fit, and coefficients with deviations
    /// of the force and the unloading. Until then, the declared value with its tolerance serves instead.
    left: [f32; 3],
    reference: [[[f32; 2]; REFERRED]; 2],
    /// Slope and lateness of the unloading from before any change, with deviations.
    learnt: [[f32; 2]; CHANGES],
    streaks: [u8; 3],
    /// Judgements of this test, saturating.
    rounds: u8,
    /// Trends of apparent offsets, from command to displacement and of the force.
    trends: [Trend; 2],
    /// Recent fraction of time that each cause was in the set, relative to [`ALWAYS`].
    member: [u16; Cause::ALL.len()],
    /// Causes found without regression, named in this round.
    heard: Set,
    /// Blocks since the doubt began.
    doubt: Option<u32>,
    largest: f32,
    since_largest: u32,
    /// The largest displacement to either side, and the shortfall of the force there relative to the declared one: a
    /// yielded specimen may leave that behind.
    furthest: [f32; 2],
    short: [f32; 2],
    limits: [f32; 2],
    speed: f32,
    /// A limit may explain the deviation between command and displacement.
    doubts_limit: bool,
    /// Judgements since the set last changed.
    unchanged: u8,
}

impl Judge {
    pub(super) const fn new(elastic: bool) -> Self {
        Self {
            state: State::Sound,
            published: Set::EMPTY,
            findings: Vec::new(),
            elastic,
            answers: Answers::NONE,
            left: [0.0; 3],
            reference: [[[0.0, 1.0]; REFERRED]; 2],
            learnt: [[0.0, 1.0]; CHANGES],
            streaks: [0; 3],
            rounds: 0,
            trends: [Trend::NONE; 2],
            member: [0; Cause::ALL.len()],
            heard: Set::EMPTY,
            doubt: None,
            largest: 0.0,
            since_largest: 0,
            furthest: [0.0; 2],
            short: [0.0; 2],
            limits: [0.0; 2],
            speed: 0.0,
            doubts_limit: false,
            unchanged: 0,
        }
    }

    pub(super) fn pass_block(&mut self) {
        self.since_largest = self.since_largest.saturating_add(1);
        if let Some(age) = &mut self.doubt {
            *age = age.saturating_add(1);
        }
    }

    /// Tracks the size of the motion.
    pub(super) fn observe(&mut self, k: &Constants, row: &Row) {
        self.speed = row.y[1].abs();
        self.limits = row.limits;
        let x = row.x[0].abs();
        if x > LARGER * self.largest {
            (self.largest, self.since_largest) = (x, 0);
            // A fallen secant at a new largest motion: the specimen yields, whatever was declared.
            self.elastic &= x < WORTH_A_SECANT || row.r.abs() > SECANT * x;
        }
        let (side, sign) = if row.x[0] > 0.0 { (0, 1.0) } else { (1, -1.0) };
        if x > self.furthest[side] {
            self.furthest[side] = x;
            self.short[side] = larger(x - sign * row.r, 0.0);
        } else if x < TURNED * self.furthest[side] && self.furthest[side] > WORTH_A_SECANT {
            // So does a force that falls short at the turn. On the way there a force that is read late lags as well.
            let most = 2.0 * k.half.force[1] * self.furthest[side] + SHORT;
            self.elastic &= self.short[side] < most;
        }
    }

    /// True if the specimen has gone this far before, and has always been elastic.
    pub(super) fn has_been_elastic_at(&self, x: f32) -> bool {
        let furthest = self.furthest[usize::from(x <= 0.0)];
        self.elastic && x.abs() < TURNED * furthest
    }

    /// The causes of a settled set, with their values.
    pub(super) fn settled(&self) -> impl Iterator<Item = &Finding> {
        let set = if self.unchanged < SETTLED {
            Set::EMPTY
        } else {
            self.published
        };
        self.findings.iter().filter(move |f| set.has(f.cause))
    }

    /// True if the settled causes may be corrected for: there is only one, or all belong to the actuator, whatever a
    /// sensor shows besides. Not while a limit is in doubt: a command that goes further would only reach it sooner.
    pub(super) fn may_correct(&self) -> bool {
        let fitted = || self.settled().filter(|f| f.cause.is_fitted());
        let is_actuator = |f: &Finding| f.cause.side() == Side::Actuator;
        let told = fitted().all(is_actuator) || fitted().count() == 1;
        told && !self.doubts_limit
    }

    /// The least `cause` that could be named if it acted now, in its unit; `None` if the motion does not show it.
    pub(super) fn least(&self, k: &Constants, cause: Cause) -> Option<f32> {
        let mut least: Option<f32> = None;
        for regression in [ACTUATOR, FORCE, UNLOADING] {
            for column in 0..8 {
                let unit = [-1.0, 1.0]
                    .into_iter()
                    .filter_map(|theta| k.meaning(regression, column, theta))
                    .find_map(|(own, unit)| (own == cause).then_some(unit));
                let Some(unit) = unit else { continue };
                for named in self
                    .answers
                    .all(regression)
                    .filter_map(|a| least_named(&a, regression, column))
                {
                    let value = named * (unit * cause.per_si()).abs();
                    least = Some(least.map_or(value, |least| least.min(value)));
                }
            }
        }
        least
    }

    pub(super) fn speed(&self) -> f32 {
        self.speed
    }

    /// True while there is a doubt.
    pub(super) fn doubts(&self) -> bool {
        self.doubt.is_some()
    }

    pub(super) fn left_while_sound(&self, regression: usize) -> f32 {
        self.left[regression]
    }

    /// Takes a window's answer for a regression.
    pub(super) fn take(&mut self, window: usize, regression: usize, answer: Option<Answer>) {
        self.answers.put(window, regression, answer);
    }

    pub(super) fn name_noise(&mut self, k: &Constants, sensor: usize, sigma: f32) {
        let (cause, unit) = match sensor {
            0 => (Cause::DisplacementNoise, k.peak_m),
            _ => (Cause::ForceNoise, k.peak_m * k.stiffness),
        };
        // Per control step; a block averages several.
        self.note(cause, 2.0 * sigma * unit, 0.2 * sigma * unit);
    }

    pub(super) fn name_hum(&mut self, k: &Constants, sensor: usize, amplitude: f32) {
        let (cause, unit) = match sensor {
            0 => (Cause::DisplacementHum, k.peak_m),
            _ => (Cause::ForceHum, k.peak_m * k.stiffness),
        };
        self.note(cause, amplitude * unit, 0.1 * amplitude * unit);
    }

    pub(super) fn name_play(&mut self, k: &Constants, width: f32) {
        self.note(Cause::Play, width * k.peak_m, 0.15 * width * k.peak_m);
    }

    /// Latches a trip on a frozen sensor; true if it is new.
    pub(super) fn trip(&mut self, cause: Cause) -> bool {
        if !self.stop() {
            return false;
        }
        self.note(cause, 0.0, 0.0);
        self.published = Set::EMPTY;
        self.published.add(cause);
        true
    }

    /// Latches a trip on the named causes; true if it is new.
    pub(super) fn stop(&mut self) -> bool {
        core::mem::replace(&mut self.state, State::Trip) != State::Trip
    }

    /// Notes a cause of this round with its value in SI units.
    #[inline(never)] // It is called from a dozen places.
    fn note(&mut self, cause: Cause, value: f32, sd: f32) {
        self.heard.add(cause);
        let finding = Finding {
            cause,
            value: value * cause.per_si(),
            sd: sd * cause.per_si(),
        };
        if let Some(old) = self.findings.iter_mut().find(|f| f.cause == cause) {
            *old = finding;
        } else if self.findings.push(finding).is_err()
            && let Some(gone) = self
                .findings
                .iter_mut()
                .find(|f| !self.published.has(f.cause) && !self.heard.has(f.cause))
        {
            *gone = finding;
        }
    }

    /// Ends a round. True if state or set have changed.
    pub(super) fn conclude(&mut self, k: &Constants) -> bool {
        if self.state == State::Trip {
            return false;
        }
        let best: [_; 3] = core::array::from_fn(|regression| self.best(regression));
        let is_limit = |a: Answer| Hypothesis::of(a).is_limit_in_doubt(DOUBT[ACTUATOR]);
        self.doubts_limit = self.answers.all(ACTUATOR).any(is_limit);
        let doubtful = best
            .iter()
            .zip(DOUBT)
            .any(|(b, doubt)| b.is_some_and(|b| b.d > doubt));
        for (regression, best) in best.iter().enumerate() {
            let named = best.as_ref().is_some_and(|b| self.is_name(b, regression));
            let streak = &mut self.streaks[regression];
            *streak = if named { streak.saturating_add(1) } else { 0 };
        }
        self.follow_offsets(k);
        self.soften(k);
        self.rounds = self.rounds.saturating_add(1);
        let settled = |own: &Self, regression: usize| {
            let streak = own.streaks[regression];
            let began = own.rounds.saturating_sub(streak);
            streak
                >= if began < FIRST_ROUNDS {
                    ROUNDS_AT_FIRST
                } else {
                    ROUNDS
                }
        };
        let mut decided_actuator = true;
        if settled(self, ACTUATOR)
            && let Some(best) = best[ACTUATOR]
        {
            decided_actuator = self.name_actuator(k, &best);
        }
        let clear = best[ACTUATOR].is_none_or(|b| b.d < DOUBT[ACTUATOR]);
        if clear || (settled(self, ACTUATOR) && decided_actuator) {
            for regression in [FORCE, UNLOADING] {
                if settled(self, regression)
                    && let Some(best) = best[regression]
                {
                    self.name_force(k, regression, &best);
                }
            }
        }
        let before = (self.state, self.published);
        self.settle(k, doubtful);
        self.unchanged = if before.1 == self.published {
            self.unchanged.saturating_add(1)
        } else {
            0
        };
        before != (self.state, self.published)
    }

    /// True for some time after a new largest motion.
    fn is_recent(&self, k: &Constants) -> bool {
        (self.since_largest as f32) < NEW_LARGEST * k.blocks_a_period
    }

    /// If the unloading slope falls with the largest motion, the new one is learnt: the specimen degrades.
    fn soften(&mut self, k: &Constants) {
        let shortest = self.answers.of(0, UNLOADING);
        if let Some(now) =
            shortest.filter(|now| self.is_recent(k) && now.theta[0] < self.learnt[0][0])
        {
            self.learnt[0] = [now.theta[0], now.sd(0)];
        }
    }

    /// Follows a named offset in the window that forgets fastest.
    fn follow_offsets(&mut self, k: &Constants) {
        for (trend, (regression, sides)) in self.trends.iter_mut().zip(OFFSETS) {
            let names = sides.iter().flatten();
            let is_named = { names }.any(|&cause| self.published.has(cause));
            let answer = self.answers.of(0, *regression);
            match answer.filter(|_| is_named) {
                Some(answer) => trend.add(answer.theta[OFFSET], k.rounds_a_period()),
                None => *trend = Trend::NONE,
            }
        }
    }

    /// Notes an offset, or a drift if it keeps moving; `unit` is of the offset, as in [`Constants::meaning`].
    fn note_offset(
        &mut self,
        k: &Constants,
        trend: usize,
        [offset, drift]: [Cause; 2],
        unit: f32,
        [theta, sd]: [f32; 2],
    ) {
        match self.trends[trend].of_a_period(2.0, k.rounds_a_period()) {
            Some((rate, sd)) => {
                let per_s = unit * k.omega / core::f32::consts::TAU;
                self.note(drift, rate * per_s, sd * per_s);
            }
            None => self.note(offset, theta * unit, sd * unit),
        }
    }

    /// True if a hypothesis can be named: relative to the declaration, or to values learnt in the same test.
    fn is_name(&self, own: &Hypothesis, regression: usize) -> bool {
        own.is_name(regression) || self.is_change(own, regression)
    }

    /// True if the unloading force of a specimen has a different slope or lateness than before.
    fn is_change(&self, own: &Hypothesis, regression: usize) -> bool {
        let learnt = self.learnt.get(own.column);
        let learnt = learnt.filter(|_| regression == UNLOADING);
        learnt.is_some_and(|learnt| own.is_change_from(*learnt))
    }

    /// The clearest hypothesis of any window.
    #[inline(never)] // It is called three times.
    fn best(&self, regression: usize) -> Option<Hypothesis> {
        let mut best: Option<Hypothesis> = None;
        for window in 0..WINDOWS {
            if window == FRESH && self.doubt.is_none() {
                continue;
            }
            let Some(answer) = self.answers.of(window, regression) else {
                continue;
            };
            let own = Hypothesis::of(answer);
            let better = match &best {
                None => true,
                // A hypothesis that can be named takes precedence over a merely clear one.
                Some(b) => {
                    (self.is_name(&own, regression), own.d) > (self.is_name(b, regression), b.d)
                }
            };
            if better {
                best = Some(own);
            }
        }
        best
    }

    /// State and published set at the end of a round.
    fn settle(&mut self, k: &Constants, doubtful: bool) {
        let heard = core::mem::take(&mut self.heard);
        let (mut set, mut beside) = (Set::EMPTY, Set::EMPTY);
        for (member, &cause) in self.member.iter_mut().zip(Cause::ALL) {
            if !cause.is_fitted() {
                // It stays named: noise is judged less often than a round ends, and it has been found several times.
                if heard.has(cause) || self.published.has(cause) {
                    beside.add(cause);
                }
                continue;
            }
            let (before, now) = (
                f32::from(*member),
                if heard.has(cause) { ALWAYS } else { 0.0 },
            );
            *member = (before + k.settles * (now - before)) as u16;
            if f32::from(*member) > 0.5 * ALWAYS {
                set.add(cause);
            }
        }
        let first = self.published.is_empty() && !heard.is_empty();
        if first {
            self.published = heard;
        } else if !set.is_empty() {
            self.published = set.with(beside);
        } else {
            self.published = self.published.with(beside);
        }
        if doubtful || !heard.is_empty() {
            let falls_back = (FALLS_BACK * k.blocks_a_period) as u32;
            match self.doubt {
                // A new doubt long after the last one uses fresh data again.
                Some(age) if age > falls_back && heard.is_empty() => self.doubt = None,
                Some(_) => {}
                None => self.doubt = Some(0),
            }
        } else if let Some(age) = self.doubt
            && age as f32 > FALLS_BACK * k.blocks_a_period
        {
            self.doubt = None;
        }
        if self.doubt.is_none() && self.published.is_empty() {
            for regression in 0..3 {
                if let Some(answer) = self.answers.of(REFERENCE, regression) {
                    self.left[regression] = answer.left;
                    let learnt = |j: usize| [answer.theta[j], answer.sd(j)];
                    if regression != ACTUATOR && answer.periods > LEARNED {
                        self.reference[regression - FORCE] = core::array::from_fn(learnt);
                    }
                    // Unloading is a small part of a motion, and a value that has already changed is no reference.
                    let calm =
                        answer.periods > LEARNED_UNLOADING && Hypothesis::of(answer).d < CALM;
                    if regression == UNLOADING && calm {
                        self.learnt = core::array::from_fn(learnt);
                    }
                }
            }
        }
        self.state = if !self.published.is_empty() {
            State::Named
        } else if self.doubt.is_some() {
            State::Doubtful
        } else {
            State::Sound
        };
    }
}
