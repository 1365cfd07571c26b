//! From hypotheses to causes: which of them, since when; `judge/naming.rs`: on which side.

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

/// Where an offset stands out, and on each side on which it may be the cause with its drift.
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
/// The first columns of the force and the unloading, by which another side is told.
const REFERRED: usize = 3;
/// Columns of the regression of the actuator whose side another channel can tell.
const OFFSET: usize = 0;
const GAIN: usize = 1;
const LATE: usize = 2;
/// Blocks from one judgement to the next: 50 ms.
pub(super) const BLOCKS_A_ROUND: u8 = 25;
/// Causes whose values are kept.
const MOST_FINDINGS: usize = 8;
/// Twice the logarithm of the likelihood ratio from which there is a doubt: of the actuator, of the force, of the unloading.
const DOUBT: [f32; 3] = [8.0, 8.0, 32.0];
/// What stands for the share of a cause that has been in the set all the time.
const ALWAYS: f32 = 65_535.0;
/// Judgements after which a set that is still the same has settled.
const SETTLED: u8 = 3;
/// Rounds in a row; more of them where they began in the first second that is judged, in which few samples tell little.
const ROUNDS: u8 = 3;
const FIRST_ROUNDS: u8 = 20;
const ROUNDS_AT_FIRST: u8 = 12;
/// A doubt without a name falls back after so many natural periods; a new largest motion is new for so many.
const FALLS_BACK: f32 = 2.0;
const NEW_LARGEST: f32 = 4.0;
/// A secant below this share of the declared stiffness is one that has yielded, at a motion that tells, peaks.
const SECANT: f32 = 0.9;
const WORTH_A_SECANT: f32 = 0.1;
/// Where a motion has turned, back by this share, a force has yielded that is so far below what the declared stiffness with its
/// tolerance made of the largest, peaks.
const TURNED: f32 = 0.98;
const SHORT: f32 = 0.01;
/// What makes a largest motion a new one.
const LARGER: f32 = 1.02;
/// Periods of samples from which the reference is one.
const LEARNED: f32 = 1.0;
const LEARNED_UNLOADING: f32 = 0.25;
/// Twice the logarithm of the likelihood ratio below which what unloads is what it was.
const CALM: f32 = 4.0;
/// Columns of the unloading that may change: slope and lateness.
const CHANGES: usize = 2;
/// Deviations by which one side is possible and the other worse.
const POSSIBLE: f32 = 3.0;
const WORSE: f32 = 2.0;
/// What a reference may be off: slope, offset in peaks, lateness in half tolerances.
const SLOPE_OFF: f32 = 0.006;
const OFFSET_OFF: f32 = 0.002;
const LATE_OFF: f32 = 0.6;

/// The column of a regression that is the slope of the force.
fn slope_of(regression: usize) -> usize {
    1 - usize::from(regression == UNLOADING)
}

/// The column of a regression that is a stiffness which depends on the displacement: the specimen's own.
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
    /// Share by which a membership moves in a round.
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

    /// What a column of a regression stands for, with its unit in a half tolerance; nothing where the sign of its coefficient
    /// is no cause's: friction and forces that push, a force that is early. The bend of the phase is a part of the lateness, a
    /// stiffness that depends on the way the specimen's own.
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

/// What is thought of the rig.
#[derive(Clone, Debug)]
pub(super) struct Judge {
    pub(super) state: State,
    pub(super) published: Set,
    pub(super) findings: Vec<Finding, MOST_FINDINGS, u8>,
    /// False once the specimen has shown that it is not, whatever was declared.
    pub(super) elastic: bool,
    answers: Answers,
    /// Of the longest window while the test was sound: what the free fit left, and coefficients with deviations of the force and the
    /// unloading. Before there is one the declared value is it, with its tolerance.
    left: [f32; 3],
    reference: [[[f32; 2]; REFERRED]; 2],
    /// Slope and lateness of the unloading while they were what they had been, with deviations.
    learnt: [[f32; 2]; CHANGES],
    streaks: [u8; 3],
    /// Judgements of this test, as far as they are counted.
    rounds: u8,
    /// How what stands out as an offset goes on, between command and displacement and of the force.
    trends: [Trend; 2],
    /// Share of the last time in which each cause was in the set, of [`ALWAYS`].
    member: [u16; Cause::ALL.len()],
    /// Causes that are no regression's, named in this round.
    heard: Set,
    /// Blocks since the doubt began.
    doubt: Option<u32>,
    largest: f32,
    since_largest: u32,
    /// The furthest that it went to either side, and by how much the force was below the declared one there: what a specimen that
    /// has yielded may leave behind.
    furthest: [f32; 2],
    short: [f32; 2],
    limits: [f32; 2],
    speed: f32,
    /// A limit may explain what stands out between command and displacement.
    doubts_limit: bool,
    /// Judgements since the set was another one.
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

    /// Looks at how large the motion is.
    pub(super) fn see(&mut self, k: &Constants, row: &Row) {
        self.speed = row.y[1].abs();
        self.limits = row.limits;
        let x = row.x[0].abs();
        if x > LARGER * self.largest {
            (self.largest, self.since_largest) = (x, 0);
            // Its secant has fallen where it goes further than ever: it yields, whatever was declared.
            self.elastic &= x < WORTH_A_SECANT || row.r.abs() > SECANT * x;
        }
        let (side, sign) = if row.x[0] > 0.0 { (0, 1.0) } else { (1, -1.0) };
        if x > self.furthest[side] {
            self.furthest[side] = x;
            self.short[side] = larger(x - sign * row.r, 0.0);
        } else if x < TURNED * self.furthest[side] && self.furthest[side] > WORTH_A_SECANT {
            // So it does where its force falls short at the turn. On the way there one that is read late is behind as well.
            let most = 2.0 * k.half.force[1] * self.furthest[side] + SHORT;
            self.elastic &= self.short[side] < most;
        }
    }

    /// True if the specimen has gone as far before, and has been elastic all the time.
    pub(super) fn has_been_elastic_at(&self, x: f32) -> bool {
        let furthest = self.furthest[usize::from(x <= 0.0)];
        self.elastic && x.abs() < TURNED * furthest
    }

    /// The causes of a set that has settled, with their values.
    pub(super) fn settled(&self) -> impl Iterator<Item = &Finding> {
        let set = if self.unchanged < SETTLED {
            Set::EMPTY
        } else {
            self.published
        };
        self.findings.iter().filter(move |f| set.has(f.cause))
    }

    /// True if what has settled may be corrected for: it is one cause, or all of them are the actuator's, whatever a sensor shows beside
    /// them. Not while a limit is in doubt: what goes further then only runs into it sooner.
    pub(super) fn may_correct(&self) -> bool {
        let fitted = || self.settled().filter(|f| f.cause.is_fitted());
        let is_actuator = |f: &Finding| f.cause.side() == Side::Actuator;
        let told = fitted().all(is_actuator) || fitted().count() == 1;
        told && !self.doubts_limit
    }

    /// The least of `cause` that would be named at best if it acted now, in its unit; `None` where the motion tells nothing of it.
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

    /// What a window says of a regression.
    pub(super) fn take(&mut self, window: usize, regression: usize, answer: Option<Answer>) {
        self.answers.put(window, regression, answer);
    }

    pub(super) fn name_noise(&mut self, k: &Constants, sensor: usize, sigma: f32) {
        let (cause, unit) = match sensor {
            0 => (Cause::DisplacementNoise, k.peak_m),
            _ => (Cause::ForceNoise, k.peak_m * k.stiffness),
        };
        // Of a control step; a block has a few.
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

    /// Latches a trip on a sensor that stands still; true if it is new.
    pub(super) fn trip(&mut self, cause: Cause) -> bool {
        if !self.stop() {
            return false;
        }
        self.note(cause, 0.0, 0.0);
        self.published = Set::EMPTY;
        self.published.add(cause);
        true
    }

    /// Latches a trip on what is named; true if it is new.
    pub(super) fn stop(&mut self) -> bool {
        core::mem::replace(&mut self.state, State::Trip) != State::Trip
    }

    /// A cause of this round with its value in SI units.
    #[inline(never)] // It is asked for in a dozen places.
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

    /// The end of a round. True if state or set have changed.
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

    /// True soon after the motion went further than ever.
    fn is_recent(&self, k: &Constants) -> bool {
        (self.since_largest as f32) < NEW_LARGEST * k.blocks_a_period
    }

    /// A slope of what unloads that has fallen with the largest motion is what was learnt: the specimen degrades.
    fn soften(&mut self, k: &Constants) {
        let shortest = self.answers.of(0, UNLOADING);
        if let Some(now) =
            shortest.filter(|now| self.is_recent(k) && now.theta[0] < self.learnt[0][0])
        {
            self.learnt[0] = [now.theta[0], now.sd(0)];
        }
    }

    /// An offset that is named is followed, by the window that forgets soonest.
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

    /// An offset, or a drift where it goes on moving; `unit` is of the offset as of [`Constants::meaning`].
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

    /// True if a hypothesis stands out enough for a name: beside what is declared, or beside what the same test had learnt.
    fn is_name(&self, own: &Hypothesis, regression: usize) -> bool {
        own.is_name(regression) || self.is_change(own, regression)
    }

    /// True if the force of a specimen that unloads has another slope or another lateness than before.
    fn is_change(&self, own: &Hypothesis, regression: usize) -> bool {
        let learnt = self.learnt.get(own.column);
        let learnt = learnt.filter(|_| regression == UNLOADING);
        learnt.is_some_and(|learnt| own.is_change_from(*learnt))
    }

    /// The hypothesis of any window that stands out most.
    #[inline(never)] // It is asked for three times.
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
                // What can be named goes before what only stands out.
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
                // It stays named: a noise is looked for more seldom than a judgement is made, and has been there several times.
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
                // A new doubt long after the last one looks at fresh data again.
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
                    // What unloads is little of a motion, and what has changed already is no reference.
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
