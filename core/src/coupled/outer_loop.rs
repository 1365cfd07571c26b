//! A test whose interface two coupled actuators move in x and in rotation: the outer loop of such a rig.
//!
//! ```text
//!  strokes, forces ─► stale? ─► where the interface is ─► equation of motion ─► target ─► tracker ─► interlocks ─► commands
//! ```
//!
//! Modes, events and faults are those of [`crate::OuterLoop`]. Interlocks act in both systems of coordinates: on the strokes
//! and forces of the actuators (axes 0 and 1 of a [`Trip`]) and on x and rotation of the interface (axes 2 and 3; of axis 3
//! rad stands for m and N m for N). All of them have to be given: there is no test without limits.
//!
//! Degrees of freedom 0 and 1 of the structure are x and rotation of the interface; what stands in the laboratory is the
//! difference of its stiffness and its numerical stiffness. The integration is explicit: the target is a sample ahead.

use super::coupler::Coupler;
use super::pair::Pair;
use super::plant::Plant;
use super::tracker::{BrokenLimit, Limit, Tracker, TrackerConstants, TrackerSettings};
use crate::float::{larger, smaller};
use crate::ground_motion::GroundMotion;
use crate::newmark::{Coefficients, Newmark};
use crate::outer_loop::Sample;
use crate::refusal::Refusal;
use crate::structure::Structure;
use crate::supervise::{
    Checked, Event, Fault, Finding, InterlockLimits, Mode, Rejected, StaleWatch, Trip, first_fault,
    within,
};

/// What an actuator or a coordinate of the interface may do. Units: m and N; of a rotation rad and N m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Largest speed of the command, m/s.
    pub speed_per_s: f32,
    /// Largest force.
    pub force: f32,
    /// Largest difference between where it was sent and where it is.
    pub tracking: f32,
}

/// Settings of a test.
#[derive(Clone, Debug)]
pub struct CoupledSettings<const N: usize> {
    /// The structure; degrees of freedom 0 and 1 are x and rotation of the interface.
    pub structure: Structure<N>,
    /// Coupler, plant, observers and largest positions. The target is a sampling period ahead.
    pub tracker: TrackerSettings,
    /// What each actuator may do.
    pub actuator: Bounds,
    /// What x and rotation may do.
    pub interface: [Bounds; 2],
    /// Speed of the approach to the start, m/s and rad/s.
    pub approach_per_s: Pair,
    /// Deceleration to a hold, m/s^2 and rad/s^2.
    pub hold_per_s2: Pair,
    /// Samples that may be stale in a row.
    pub stale_steps: u16,
    /// Motion of a target that a standing reading may hide, m.
    pub frozen_m: f32,
}

/// What a control step gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoupledStep {
    /// Commands of the actuators for the next control period, m; always finite.
    pub command_m: Pair,
    /// True if they may move on them.
    pub permit: bool,
    /// Where the interface is to be, m and rad.
    pub target: Pair,
    /// Where it is, by readings and model, m and rad.
    pub interface: Pair,
    /// Force along x and moment about the interface, N and N m.
    pub force: Pair,
}

/// The outer loop of a rig with two coupled actuators.
#[derive(Clone, Debug)]
pub struct CoupledLoop<const N: usize> {
    coefficients: Coefficients<N>,
    newmark: Newmark<N>,
    tracker: Tracker,
    coupler: Coupler,
    stale: StaleWatch<2>,
    /// Of the actuators, of x, of the rotation.
    limits: [InterlockLimits; 3],
    approach_step: Pair,
    hold_step: Pair,
    mode: Mode,
    trip: Option<Trip>,
    obstacle: Option<Finding>,
    target: Pair,
    /// Change of the target in the last control step.
    motion: Pair,
    sent_m: Pair,
    standing: Option<Pair>,
    /// Share of the ground's acceleration that the observers get. It is 0 outside a running test and changes
    /// gradually, because a jump of it would jerk the actuators.
    shaken: f32,
    tick: u32,
    step: u32,
}

/// By how much that share changes in a control step.
const SHARE_STEP: f32 = 1.0 / 64.0;

impl<const N: usize> CoupledLoop<N> {
    /// An idle loop.
    ///
    /// # Errors
    /// The first setting that cannot be used.
    pub fn new(settings: &CoupledSettings<N>) -> Result<Self, Refusal> {
        let period_s = settings.tracker.estimate.period_s;
        let refused = |name, value: f32, accepted| Refusal {
            name,
            value: f64::from(value),
            accepted,
        };
        if settings.structure.physical != 2 || N < 2 {
            let count = settings.structure.physical as f32;
            return Err(refused("structure.physical", count, "2: x and rotation"));
        }
        let bounds = [
            settings.actuator,
            settings.interface[0],
            settings.interface[1],
        ];
        let numbers = bounds
            .iter()
            .flat_map(|b| [b.speed_per_s, b.force, b.tracking])
            .chain(settings.approach_per_s)
            .chain(settings.hold_per_s2)
            .chain([settings.frozen_m]);
        for value in numbers {
            if !(value > 0.0 && value.is_finite()) {
                return Err(refused("coupled.limits", value, "numbers above 0"));
            }
        }
        let tracker = TrackerConstants::new(&TrackerSettings {
            ahead_s: period_s,
            ..settings.tracker.clone()
        })?;
        let limits = |b: &Bounds| InterlockLimits {
            displacement_m: f32::MAX,
            reading_m: f32::MAX,
            increment_m: f32::MAX,
            velocity_step_m: b.speed_per_s * period_s,
            least_step_m: b.speed_per_s * period_s,
            rate_hz: 1.0 / period_s,
            force_n: b.force,
            tracking_m: b.tracking,
            energy_warning: f32::MAX,
            energy_trip: f32::MAX,
            stale_steps: settings.stale_steps,
            late_steps: u16::MAX,
            locked_damping_ratio: f32::MAX,
        };
        Ok(Self {
            coefficients: Coefficients::new(&settings.structure, f64::from(period_s), 1.0)?,
            newmark: Newmark::at_rest(),
            tracker: Tracker::at_rest(tracker),
            coupler: settings.tracker.coupler,
            stale: StaleWatch::new(settings.frozen_m),
            limits: [limits(&bounds[0]), limits(&bounds[1]), limits(&bounds[2])],
            approach_step: settings.approach_per_s.map(|v| v * period_s),
            hold_step: settings.hold_per_s2.map(|a| a * period_s * period_s),
            mode: Mode::Idle,
            trip: None,
            obstacle: None,
            target: [0.0; 2],
            motion: [0.0; 2],
            sent_m: [0.0; 2],
            standing: None,
            shaken: 0.0,
            tick: 0,
            step: 0,
        })
    }

    /// What the loop is doing.
    pub fn state(&self) -> Mode {
        self.mode
    }

    /// The first fault, until it is cleared.
    pub fn trip(&self) -> Option<Trip> {
        self.trip
    }

    /// Where every degree of freedom of the structure is to be, m and rad.
    pub fn displacement(&self) -> [f32; N] {
        self.newmark.displacement_m()
    }

    /// The plant as known now.
    pub fn plant(&self) -> &Plant {
        self.tracker.plant()
    }

    /// Takes an event from the operator or the link.
    ///
    /// # Errors
    /// The event means nothing in this mode, or an interlock stands against arming; nothing has changed then.
    pub fn handle(&mut self, event: Event) -> Result<Mode, Rejected> {
        let mut next = self.mode.after(event)?;
        if let (Mode::Approaching, Some(finding)) = (next, self.obstacle) {
            return Err(Rejected {
                state: self.mode,
                event,
                obstacle: Some(finding.fault),
            });
        }
        if next == Mode::Approaching {
            self.newmark = Newmark::at_rest();
            self.stale.reset();
            self.step = 0;
            if self.target == [0.0; 2] {
                next = Mode::Armed;
            }
        }
        if next == Mode::Idle {
            (self.trip, self.standing) = (None, None);
        }
        self.mode = next;
        Ok(next)
    }

    /// One control step: strokes (m) and forces (N) of both actuators in, commands out.
    #[inline(never)]
    pub fn step(&mut self, sample: &Sample<2>, ground: &GroundMotion<'_>) -> CoupledStep {
        let watched = if self.mode == Mode::Idle { 0 } else { 2 };
        let [x, theta] = self.target;
        let wanted_m = self.coupler.strokes_m(x, theta);
        let stale_steps =
            self.stale
                .update(sample.fresh, &sample.displacement_m, &wanted_m, watched);
        let (_, interface) = self.tracker.observe(&sample.displacement_m);
        // The arms are those of the reading: a model of the actuators that is wrong must not turn forces.
        let [_, turned] = self.coupler.interface(&sample.displacement_m);
        let force = self.coupler.resultant(&sample.force_n, turned);
        let change = if self.mode.integrates() {
            SHARE_STEP
        } else {
            -SHARE_STEP
        };
        self.shaken = smaller(larger(self.shaken + change, 0.0), 1.0);
        let next = match self.mode {
            Mode::Idle => self.follow(&interface),
            Mode::Approaching => self.approach([0.0; 2], Mode::Armed),
            Mode::Armed => [0.0; 2],
            Mode::Running | Mode::Resuming => {
                if stale_steps == 0 {
                    self.integrate(&force, ground);
                }
                self.reached()
            }
            Mode::Returning => self.approach(self.reached(), Mode::Running),
            Mode::Holding | Mode::Finished | Mode::Commissioning => self.slow_down(),
            Mode::Tripped => self.target,
        };
        let ground_m_per_s2 = self.shaken * ground.at(self.step);
        let (wanted_command_m, broken) = self.tracker.command(&next, ground_m_per_s2);
        let finding = broken.map(Finding::from).or_else(|| {
            self.interlock(
                sample,
                &wanted_m,
                &interface,
                &force,
                &next,
                &wanted_command_m,
                stale_steps,
            )
        });
        self.supervise(finding, next, wanted_command_m);
        if self.mode.integrates() && self.step > ground.steps() {
            self.mode = Mode::Finished;
        }
        self.tick = self.tick.wrapping_add(1);
        CoupledStep {
            command_m: self.sent_m,
            permit: self.mode.permits_motion(),
            target: self.target,
            interface,
            force,
        }
    }

    /// The target that the integration has come to.
    fn reached(&self) -> Pair {
        let u = self.newmark.displacement_m();
        let axis = |j: usize| u.get(j).copied().unwrap_or(0.0);
        [axis(0), axis(1)]
    }

    /// One integration step with the force at the interface.
    fn integrate(&mut self, force: &Pair, ground: &GroundMotion<'_>) {
        let mut force_n = [0.0; N];
        for (all, &at_interface) in force_n.iter_mut().zip(force) {
            *all = at_interface;
        }
        let load_n = self.coefficients.load_n(ground.at(self.step));
        self.newmark
            .advance(&self.coefficients, &load_n, &force_n, &[0.0; N]);
        self.step = self.step.wrapping_add(1);
    }

    /// Idle: the target follows where the interface stands, so that arming moves nothing.
    fn follow(&mut self, interface: &Pair) -> Pair {
        let mut standing = self.standing.unwrap_or(*interface);
        for (mean, &new) in standing.iter_mut().zip(interface) {
            // A mean over some 64 samples, so that noise is not a bump.
            let moved = *mean + (new - *mean) * (1.0 / 64.0);
            *mean = if moved.is_finite() { moved } else { 0.0 };
        }
        self.standing = Some(standing);
        standing
    }

    /// A step of the slow way to `goal`, and the mode in which it ends.
    fn approach(&mut self, goal: Pair, then: Mode) -> Pair {
        let next = core::array::from_fn(|i| {
            let rest = goal[i] - self.target[i];
            if rest.abs() <= self.approach_step[i] {
                goal[i]
            } else {
                self.target[i] + self.approach_step[i].copysign(rest)
            }
        });
        if next == goal {
            self.mode = then;
        }
        next
    }

    /// A step of the ramp to a standstill.
    fn slow_down(&self) -> Pair {
        core::array::from_fn(|i| {
            let (v, by) = (self.motion[i], self.hold_step[i]);
            let slower = if v.abs() <= by {
                0.0
            } else {
                v - by.copysign(v)
            };
            self.target[i] + slower
        })
    }

    /// The first interlock that forbids sending the commands, checked in both systems of coordinates.
    #[allow(clippy::too_many_arguments)] // Two systems of coordinates, each with a before and an after.
    fn interlock(
        &self,
        sample: &Sample<2>,
        wanted_m: &Pair,
        interface: &Pair,
        force: &Pair,
        next: &Pair,
        command_m: &Pair,
        stale_steps: u16,
    ) -> Option<Finding> {
        if let Some(fault) = sample.fault {
            return Some(Finding::fact(fault));
        }
        let [actuators, x, rotation] = &self.limits;
        let strokes = Checked {
            next_m: command_m,
            sent_m: &self.sent_m,
            aimed_m: wanted_m,
            displacement_m: &sample.displacement_m,
            force_n: &sample.force_n,
            energy_ratio: 0.0,
            stale_steps,
            late_steps: 0,
            physical: 2,
        };
        if !within(actuators, &strokes) {
            return first_fault(actuators, &strokes);
        }
        for (i, limits) in [x, rotation].into_iter().enumerate() {
            let coordinate = Checked {
                next_m: &[next[i]],
                sent_m: &[self.target[i]],
                aimed_m: &[self.target[i]],
                displacement_m: &[interface[i]],
                force_n: &[force[i]],
                energy_ratio: 0.0,
                stale_steps,
                late_steps: 0,
                physical: 1,
            };
            if !within(limits, &coordinate) {
                let found = first_fault(limits, &coordinate)?;
                return Some(Finding {
                    axis: 2 + i as u8,
                    ..found
                });
            }
        }
        None
    }

    /// Sends the commands or latches the fault.
    fn supervise(&mut self, finding: Option<Finding>, next: Pair, command_m: Pair) {
        self.obstacle = finding;
        if let (Some(found), Ok(tripped)) = (finding, self.mode.after(Event::Fault)) {
            self.mode = tripped;
            self.trip = Some(Trip {
                fault: found.fault,
                axis: found.axis,
                value: found.value,
                limit: found.limit,
                tick: self.tick,
            });
        }
        if self.mode == Mode::Tripped {
            self.tracker.was_sent(self.sent_m);
            return;
        }
        self.motion = core::array::from_fn(|i| next[i] - self.target[i]);
        self.target = next;
        self.sent_m = command_m;
    }
}

impl From<BrokenLimit> for Finding {
    fn from(broken: BrokenLimit) -> Self {
        let (fault, axis) = match broken.limit {
            Limit::NotFinite => (Fault::NonFinite, 0),
            Limit::Stroke(actuator) => (Fault::Displacement, actuator as u8),
            Limit::Displacement => (Fault::Displacement, 2),
            Limit::Rotation => (Fault::Displacement, 3),
        };
        Self {
            fault,
            axis,
            value: broken.value,
            limit: broken.largest,
        }
    }
}

#[cfg(test)]
mod tests;
