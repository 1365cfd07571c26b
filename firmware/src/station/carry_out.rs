//! Orders from the tasks, carried out in the control interrupt, one per period.

use super::order::{LoopStatus, Order, RefusedOrder, Returned};
use super::period::{Output, Station};
use super::spacing::Spacing;
use crate::hardware::Hardware;
use link::reply::NotReady;
use link::status::Timing;
use outerloop_core::{Event, Fault, Mode, Rejected};

impl<const A: usize> Station<A> {
    pub(super) fn carry_out(
        &mut self,
        order: Order,
        hardware: &mut impl Hardware<A>,
    ) -> Result<Returned, RefusedOrder> {
        let idle = self.mode() == Mode::Idle;
        match order {
            Order::Event(event) => {
                if event == Event::Arm {
                    self.output_lost |= !hardware.is_set_up();
                }
                self.event(event)
            }
            Order::History(index) => {
                let mut words = heapless::Vec::new();
                // There is room for a record of any size of loop.
                self.setup.outer.history(usize::from(index), |word| {
                    let _ = words.push(word);
                });
                Ok(Returned::Record(words))
            }
            Order::Target(target_m) => {
                // No effect if the loop integrates by itself; a non-finite number never moves anything.
                if target_m.iter().all(|m| m.is_finite()) {
                    self.setup.outer.set_next_target(&target_m);
                }
                Ok(Returned::Nothing)
            }
            Order::LoopStatus => Ok(Returned::LoopStatus(self.loop_status())),
            order if !idle => Err(RefusedOrder::NotIdle(Some(order))),
            Order::Exchange(setup) => {
                self.setup.outer.make_way_for(&mut setup.outer);
                let old = core::mem::replace(&mut self.setup, setup);
                hardware.set_period(self.setup.period_ticks);
                hardware.leave_late(self.setup.leaves_late);
                (self.signal, self.targets_from_pc) = (None, false);
                self.spacing = Spacing::new();
                Ok(Returned::Setup(old, self.motion.take()))
            }
            Order::Unload => {
                self.points_are_commands = false;
                // It would play whatever replaces them.
                self.signal.take_if(|signal| signal.plays_points());
                Ok(Returned::Motion(self.motion.take()))
            }
            Order::Load(motion) => Ok(Returned::Motion(self.motion.replace(motion))),
            Order::Signal(signal) => {
                self.points_are_commands |= signal.is_some_and(|s| s.plays_points());
                self.signal = signal;
                Ok(Returned::Nothing)
            }
            Order::Pace(pace) => {
                self.targets_from_pc = pace.is_some();
                self.setup.outer.set_pace(pace);
                Ok(Returned::Nothing)
            }
            Order::Watch(corrects) => {
                self.setup.outer.watch(corrects);
                Ok(Returned::Nothing)
            }
            Order::Calibrate(actuator, calibration) => {
                for copy in self.calibrations.both() {
                    if let Some(place) = copy.get_mut(usize::from(actuator)) {
                        *place = calibration;
                    }
                }
                self.output = Output::new();
                Ok(Returned::Nothing)
            }
        }
    }

    pub(super) fn event(&mut self, event: Event) -> Result<Returned, RefusedOrder> {
        if matches!(event, Event::Arm | Event::Start) && self.held {
            return Err(RefusedOrder::NotReady(NotReady::Held, None));
        }
        if event == Event::Arm && !self.setup.configured {
            return Err(RefusedOrder::NotConfigured);
        }
        let shaken = self.motion.is_some() && !self.points_are_commands;
        let something = shaken || self.signal.is_some() || self.targets_from_pc;
        if event == Event::Arm && !something {
            return Err(RefusedOrder::NothingToRun);
        }
        let integrates = shaken && self.signal.is_none() && !self.targets_from_pc;
        if event == Event::Arm && integrates && !self.setup.stops_by_energy {
            return Err(RefusedOrder::NotReady(NotReady::NoEnergyTrip, None));
        }
        if event == Event::Arm && self.output_lost {
            return Err(RefusedOrder::Event(Rejected {
                mode: self.mode(),
                event,
                obstacle: Some(Fault::Output),
            }));
        }
        // A commissioning signal may start under any force; a held one resumes under its own.
        if event == Event::Start && self.mode() == Mode::Armed && self.signal.is_none() {
            let strained = self.sensors.strained(&self.setup.sensors);
            if let Some(force_n) = strained {
                return Err(RefusedOrder::NotReady(NotReady::Strained, Some(force_n)));
            }
        }
        let mode = self.setup.outer.handle(event);
        if event == Event::Arm && mode.is_ok() {
            self.output.permission.arm();
        }
        if mode == Ok(Mode::Idle) {
            self.output.out_of_range = false;
            self.signal = None;
        }
        mode.map(|_| Returned::Nothing).map_err(RefusedOrder::Event)
    }

    fn loop_status(&self) -> LoopStatus {
        let time = &self.setup.time;
        let mean = time.total_ticks().checked_div(u64::from(time.steps()));
        LoopStatus {
            trip: self.setup.outer.trip(),
            permit: self.output.permission.is_given(),
            configured: self.setup.configured,
            points: self.motion.as_ref().map_or(0, |m| m.count() as u32),
            timing: Timing {
                period_cycles: self.period_cycles(),
                shortest_period_cycles: self.spacing.shortest(),
                longest_period_cycles: self.spacing.longest(),
                worst_step_cycles: time.worst_ticks(),
                mean_step_cycles: mean.and_then(|m| u32::try_from(m).ok()).unwrap_or(0),
                overruns: time.overruns(),
            },
            dropped_steps: self.dropped_steps,
        }
    }
}
