//! The board's loop, repeated on the PC.
//!
//! The outer loop gives the same bits on both. From the converter codes that the board sampled and the events at the
//! steps at which it took them, the PC computes every word of every record; the digest sent with each step proves it.
//! After a missing step this is not possible any more, and a record holds only what the telemetry says.

use experiment::trace::TestObserver;
use link::channel::ErrorFeedback;
use link::reply::Identity;
use link::telemetry::{StepReport, digest};
use link::{Calibration, CodeRange};
use outerloop_core::{
    Design, DirectRig, Event, Fault, GroundMotion, InPlace, Mode, OuterLoop, Pace, Record, Rig,
    Sample, flag,
};
use std::collections::VecDeque;

/// Why a test is ended whose steps differ between board and PC.
pub(crate) const DIFFERS: &str = "the board worked a step out otherwise than the PC, though none was lost on its way: a bit of what it keeps of \
                       the test has turned over, or program and image are not of one build. The test was stopped on its ramp";

/// Counts of the mirror.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MirrorCounts {
    /// Steps whose every word was recomputed and proven.
    pub proven: u64,
    /// Steps whose record differs from the PC's.
    pub different: u64,
    /// Steps missing before others.
    pub missing: u64,
}

/// What was sent to the board.
#[derive(Clone, Copy, Debug)]
enum SentToBoard<const N: usize> {
    Event(Event),
    Target([f32; N]),
    Watch(bool),
}

/// The loop on the PC.
pub struct Mirror<'a, const N: usize, R: Rig<N> = DirectRig<N>> {
    outer: OuterLoop<N, R>,
    in_place: InPlace<N>,
    ground: GroundMotion<'a>,
    /// For each actuator its calibration, and the remainder from rounding its command to codes.
    actuators: Vec<(Calibration, ErrorFeedback)>,
    codes: CodeRange,
    out_of_range: bool,
    /// The next step; before the first one, the step at which the test came into force.
    next: u32,
    in_step: bool,
    /// A step differed from the PC's record, and none was missing before it.
    differs: bool,
    /// Offset of the board's step count over the loop's.
    ahead: u32,
    /// Integration steps, and control steps since the last of them.
    steps: u32,
    since_solved: u32,
    substeps: u32,
    sent: VecDeque<(u32, SentToBoard<N>)>,
    /// The step that waits for its successor, which shows whether it tripped.
    waiting: Option<(u32, StepReport)>,
    seen: MirrorCounts,
}

impl<'a, const N: usize, R: Rig<N>> Mirror<'a, N, R> {
    /// The loop in force on the board `identity` from step `since` on, with `substeps` control steps to an integration
    /// step.
    pub fn new(
        design: Design<N, R>,
        substeps: u32,
        ground: GroundMotion<'a>,
        identity: &Identity,
        since: u32,
    ) -> Self {
        let outer = OuterLoop::new(design);
        Self {
            in_place: InPlace::beside(&outer),
            outer,
            ground,
            actuators: identity
                .calibrations()
                .map(|calibration| (*calibration, ErrorFeedback::new()))
                .collect(),
            codes: identity.codes,
            out_of_range: false,
            next: since,
            in_step: true,
            differs: false,
            ahead: since,
            steps: 0,
            since_solved: 0,
            substeps: substeps.max(1),
            sent: VecDeque::new(),
            waiting: None,
            seen: MirrorCounts::default(),
        }
    }

    /// The board took `event`; step `tick` is the first with it.
    pub fn event(&mut self, tick: u32, event: Event) {
        self.sent.push_back((tick, SentToBoard::Event(event)));
    }

    /// The board takes its targets from the PC, at this pace.
    pub fn take_targets(&mut self, pace: Pace) {
        self.outer.set_pace(Some(pace));
    }

    /// The board took a target for each actuator, m; step `tick` is the first with it.
    pub fn target(&mut self, tick: u32, target_m: [f32; N]) {
        self.sent.push_back((tick, SentToBoard::Target(target_m)));
    }

    /// The board watches the tests to come, with or without the right to correct; step `tick` is the first with it.
    pub fn watch(&mut self, tick: u32, corrects: bool) {
        self.sent.push_back((tick, SentToBoard::Watch(corrects)));
    }

    /// Has `observer` judge the blocks of the board's rig watch, so that both loops do what it orders.
    pub fn be_judged(&mut self, observer: &mut dyn TestObserver) {
        // The next step says whether the board's tasks were too late with an answer. The PC is never late.
        let is_late = |s: &StepReport| {
            s.flags & flag::WATCH_LATE != 0 && s.mode().is_some_and(Mode::integrates)
        };
        if self.waiting.as_ref().is_some_and(|(_, next)| is_late(next)) {
            self.outer.end_watch();
        }
        self.in_place.judge(&mut self.outer, |blocks, orders| {
            observer.judge(blocks, orders)
        });
    }

    /// The force that answers the last target, N, if every step so far is proven.
    pub fn answer_n(&self) -> Option<&[f32; N]> {
        self.in_step.then(|| self.outer.answer_n())
    }

    /// The rig as the loop has it, if every step so far is proven.
    pub fn rig(&self) -> Option<&R> {
        self.in_step.then(|| self.outer.rig())
    }

    /// Every step so far is proven.
    pub fn is_in_step(&self) -> bool {
        self.in_step
    }

    /// The board computed a step differently from the PC, and no lost step explains it.
    pub fn differs(&self) -> bool {
        self.differs
    }

    /// The board has shown the step at which it was armed.
    pub fn has_armed(&self) -> bool {
        self.sent.is_empty()
    }

    /// The counts so far.
    pub fn seen(&self) -> MirrorCounts {
        self.seen
    }

    /// Takes a step of the telemetry; gives the record of the previous one.
    pub fn take(&mut self, tick: u32, report: StepReport) -> Option<Record<N>> {
        let before = self.waiting.replace((tick, report))?;
        Some(self.record(before, Some(&report)))
    }

    /// The record of the last step, when no more will come.
    pub fn last(&mut self) -> Option<Record<N>> {
        let last = self.waiting.take()?;
        Some(self.record(last, None))
    }

    fn record(
        &mut self,
        (tick, report): (u32, StepReport),
        after: Option<&StepReport>,
    ) -> Record<N> {
        let missing = tick.wrapping_sub(self.next);
        // Steps before the test came into force do not count as missing.
        if missing != 0 && missing < u32::MAX / 2 {
            self.seen.missing += u64::from(missing);
            self.in_step = false;
            if self.steps > 0 {
                let since = self.since_solved.saturating_add(missing);
                self.steps = self.steps.wrapping_add(since / self.substeps);
                self.since_solved = since % self.substeps;
            }
        }
        let solved = report.flags & flag::SOLVED != 0;
        self.since_solved = if solved {
            0
        } else {
            self.since_solved.saturating_add(1)
        };
        self.next = tick.wrapping_add(1);
        while let Some((_, sent)) = self
            .sent
            .pop_front_if(|(at, _)| tick.wrapping_sub(*at) < u32::MAX / 2)
        {
            match sent {
                // The board took it; if the loop here does not, the digests will show it.
                SentToBoard::Event(event) => drop(self.outer.handle(event)),
                SentToBoard::Target(target_m) => self.outer.set_next_target(target_m),
                SentToBoard::Watch(corrects) => self.outer.watch(corrects),
            }
        }
        // The board's own button: only the mode shows it.
        let own = match (report.mode(), self.outer.mode()) {
            (Some(Mode::Holding), Mode::Running | Mode::Resuming | Mode::Returning) => {
                Some(Event::Hold)
            }
            (Some(Mode::Idle), Mode::Approaching | Mode::Armed) => Some(Event::Stop),
            _ => None,
        };
        if let Some(event) = own {
            let _ = self.outer.handle(event);
        }
        if self.in_step {
            let record = self.step(&report, after);
            if digest(&record) == report.digest {
                self.seen.proven += 1;
                self.steps = record.step;
                self.ahead = tick.wrapping_sub(record.tick);
                return record;
            }
            (self.in_step, self.differs) = (false, true);
        }
        self.seen.different += 1;
        self.steps = self.steps.wrapping_add(u32::from(solved));
        self.as_reported(tick, &report)
    }

    /// One control step, with the input that the board's converters and its station give to the loop.
    fn step(&mut self, report: &StepReport, after: Option<&StepReport>) -> Record<N> {
        let (displacement_m, force_n) = self.read(report);
        let mut sample = Sample::new(displacement_m, force_n);
        sample.fault = self.fault(report, after);
        sample.chain_open = report.flags & flag::CHAIN_OPEN != 0;
        sample.fresh = report.flags & flag::MISSED == 0;
        if let (Some(Mode::Stopping), Some(_), Some(after)) = (report.mode(), sample.fault, after)
            && self.comes_to_its_end(&sample, after)
        {
            sample.fault = None;
        }
        let step = self.outer.step(&sample, &self.ground);
        let top = self.codes.command_top;
        self.out_of_range = false;
        for ((calibration, feedback), &command_m) in self.actuators.iter_mut().zip(&step.command_m)
        {
            let code = if step.permit {
                feedback.code(calibration, top, command_m)
            } else {
                feedback.code_at_standstill(calibration, top, command_m)
            };
            self.out_of_range |= code.is_none();
        }
        *step.record
    }

    /// Tells if the ramp after a fault goes on in this step and ends in the step `after` it: the record of a step is made
    /// before an emergency in it acts, so only the next record tells the two apart.
    fn comes_to_its_end(&self, sample: &Sample<N>, after: &StepReport) -> bool {
        let mut outer = self.outer.clone();
        let mut sample = *sample;
        sample.fault = None;
        outer.step(&sample, &self.ground);
        let (displacement_m, force_n) = self.read(after);
        let next = Sample::new(displacement_m, force_n);
        digest(outer.step(&next, &self.ground).record) == after.digest
    }

    /// Displacements, m, and forces, N, of a step; zero where there is no actuator.
    fn read(&self, report: &StepReport) -> ([f32; N], [f32; N]) {
        let (mut displacement_m, mut force_n) = ([0.0; N], [0.0; N]);
        for (actuator, (lines, _)) in self.actuators.iter().enumerate().take(N) {
            let codes = report.codes(actuator).unwrap_or_default();
            [displacement_m[actuator], force_n[actuator]] = lines.readings(codes);
        }
        (displacement_m, force_n)
    }

    /// The fault that the board reported to its loop with this sample.
    fn fault(&self, report: &StepReport, after: Option<&StepReport>) -> Option<Fault> {
        let codes = (0..self.actuators.len()).filter_map(|actuator| report.codes(actuator));
        let rail = codes.flatten().any(|code| self.codes.at_rail(code));
        let latched = after.and_then(StepReport::fault);
        let ends = after.and_then(StepReport::mode) == Some(Mode::Tripped);
        match latched {
            // An emergency on the ramp after a minor fault: the telemetry does not give its cause.
            Some(_) if report.mode() == Some(Mode::Stopping) => {
                ends.then_some(Fault::EmergencyStop)
            }
            // Known only to the board: the codes do not show it.
            Some(
                Fault::EmergencyStop
                | Fault::LinkLost
                | Fault::DeadlineMissed
                | Fault::PermitChain
                | Fault::Output
                | Fault::Disagree
                | Fault::ForceStands
                | Fault::Starved
                | Fault::Memory,
            ) if report.mode() != Some(Mode::Tripped) => latched,
            _ if rail => Some(Fault::AdcRail),
            _ if self.out_of_range => Some(Fault::Displacement),
            _ => None,
        }
    }

    /// What the telemetry itself says of a step: the first actuator's target, but not what a predictor sent for it; and
    /// the readings without estimation.
    fn as_reported(&self, tick: u32, report: &StepReport) -> Record<N> {
        let mut record = Record::<N>::EMPTY;
        record.tick = tick.wrapping_sub(self.ahead);
        record.step = self.steps;
        record.flags = report.flags;
        record.command_m = [f32::NAN; N];
        record.command_m[0] = report.command_m;
        record.sent_m = [f32::NAN; N];
        (record.displacement_m, record.force_n) = self.read(report);
        record.estimated_displacement_m = record.displacement_m;
        record.estimated_force_n = record.force_n;
        record.added_damping_n_s_per_m[0] = report.added_damping_n_s_per_m;
        record.energy_sum.modified_j = report.energy_j;
        record
    }
}
