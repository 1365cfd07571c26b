//! One control period on the chip: sample, step, command.
//!
//! # Timing
//! [`ControlLoop::tick`] is called once a control period, by the end-of-conversion interrupt of a board or by the
//! exchange with the PC in QEMU. The command goes out before anything else is done with the step. A step that took
//! longer than its deadline is reported to the supervisor with the next sample: the loop trips, it does not slip.

use crate::converters::{Converters, Stopwatch};
use crate::step_time::StepTime;
use outerloop_core::supervise::Rejected;
use outerloop_core::{Design, Event, Fault, GroundMotion, OuterLoop, Record, State};

/// The outer loop with the time that it takes.
#[derive(Clone, Debug)]
pub struct ControlLoop<const N: usize> {
    outer: OuterLoop<N>,
    time: StepTime,
    late: bool,
}

impl<const N: usize> ControlLoop<N> {
    /// An idle loop whose step may take `deadline_ticks` of the stopwatch, `u32::MAX` for no deadline.
    pub fn new(design: Design<N>, deadline_ticks: u32) -> Self {
        Self {
            outer: OuterLoop::new(design),
            time: StepTime::new(deadline_ticks),
            late: false,
        }
    }

    /// One control period; returns its record.
    #[inline]
    pub fn tick<W: Stopwatch>(
        &mut self,
        converters: &mut impl Converters<N>,
        watch: &W,
        ground: &GroundMotion<'_>,
    ) -> &Record<N> {
        let begin = watch.now();
        let mut sample = converters.sample();
        if self.late {
            sample.fault = sample.fault.or(Some(Fault::DeadlineMissed));
        }
        let step = self.outer.step(&sample, ground);
        converters.command(&step.command_m, step.permit);
        self.late = !self.time.add(W::between(begin, watch.now()));
        step.record
    }

    /// Takes an event from the operator.
    ///
    /// # Errors
    /// As [`OuterLoop::handle`]; nothing has changed then.
    #[inline(never)] // Inlined for every number of floors, the stack would hold what each of them needs.
    pub fn handle(&mut self, event: Event) -> Result<State, Rejected> {
        self.outer.handle(event)
    }

    /// As [`OuterLoop::set_goal`].
    pub fn set_goal(&mut self, goal_m: Option<[f32; N]>) {
        self.outer.set_goal(goal_m);
    }

    /// The loop itself.
    pub const fn outer(&self) -> &OuterLoop<N> {
        &self.outer
    }

    /// How long the steps took.
    pub const fn time(&self) -> &StepTime {
        &self.time
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::cell::Cell;
    use outerloop_core::Config;
    use outerloop_core::Sample;

    /// A board whose every action takes time on one clock and is written down.
    struct Bench {
        sample: Sample<1>,
        log: Vec<(&'static str, u32)>,
        clock: &'static Clock,
        step_ticks: u32,
    }

    #[derive(Default)]
    struct Clock(Cell<u32>);

    impl Stopwatch for Clock {
        fn between(earlier: u32, later: u32) -> u32 {
            later.wrapping_sub(earlier)
        }
        fn now(&self) -> u32 {
            self.0.get()
        }
    }

    impl Converters<1> for Bench {
        fn sample(&mut self) -> Sample<1> {
            self.log.push(("sample", self.clock.now()));
            self.clock
                .0
                .set(self.clock.now().wrapping_add(self.step_ticks));
            self.sample
        }
        fn command(&mut self, _: &[f32; 1], permit: bool) {
            self.log.push((
                if permit { "permit" } else { "no permit" },
                self.clock.now(),
            ));
        }
    }

    fn bench() -> (ControlLoop<1>, Bench) {
        let config = Config::shear_frame([1000.0], [158e3], [0.02]);
        let clock: &Clock = Box::leak(Box::default());
        // Just before the counter turns over.
        clock.0.set(u32::MAX - 5);
        let control = ControlLoop::new(Design::new(&config).unwrap(), 100);
        let bench = Bench {
            sample: Sample::new([0.0], [0.0]),
            log: Vec::new(),
            clock,
            step_ticks: 50,
        };
        (control, bench)
    }

    #[test]
    fn samples_then_commands_and_counts_the_time_between() {
        let (mut control, mut bench) = bench();
        let clock = bench.clock;
        control.tick(&mut bench, clock, &GroundMotion::none());
        assert_eq!(bench.log, [("sample", u32::MAX - 5), ("no permit", 44)]);
        assert_eq!(control.time().worst_ticks(), 50);
        control.handle(Event::Arm).unwrap();
        control.tick(&mut bench, clock, &GroundMotion::none());
        assert_eq!(bench.log[3], ("permit", 94));
    }

    #[test]
    fn a_late_step_trips_the_armed_loop_in_the_next() {
        let (mut control, mut bench) = bench();
        let clock = bench.clock;
        control.tick(&mut bench, clock, &GroundMotion::none());
        control.handle(Event::Arm).unwrap();
        bench.step_ticks = 101;
        control.tick(&mut bench, clock, &GroundMotion::none());
        assert_eq!(control.outer().state(), State::Armed);
        bench.step_ticks = 50;
        control.tick(&mut bench, clock, &GroundMotion::none());
        assert_eq!(control.outer().state(), State::Tripped);
        assert_eq!(control.outer().trip().unwrap().fault, Fault::DeadlineMissed);
        assert_eq!(control.time().overruns(), 1);
    }

    #[test]
    fn what_the_board_reports_itself_is_not_hidden_by_a_late_step() {
        let (mut control, mut bench) = bench();
        let clock = bench.clock;
        control.tick(&mut bench, clock, &GroundMotion::none());
        control.handle(Event::Arm).unwrap();
        bench.step_ticks = 101;
        control.tick(&mut bench, clock, &GroundMotion::none());
        bench.sample.fault = Some(Fault::EmergencyStop);
        control.tick(&mut bench, clock, &GroundMotion::none());
        assert_eq!(control.outer().trip().unwrap().fault, Fault::EmergencyStop);
    }
}
