//! What the operator can do with a loop between steps.

use super::{
    Correction, Design, EnergyErrors, LockWatch, Mode, Monitor, Newmark, OuterLoop, Record,
    SignalGenerator, Trip,
};
use crate::rig::Rig;
use crate::supervise::{Event, Fault, Finding, OBSTACLE_STEPS, Rejected};

impl<const N: usize, R: Rig<N>> OuterLoop<N, R> {
    /// Control steps since power-up.
    pub fn tick(&self) -> u32 {
        self.tick
    }

    /// What the loop is doing.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// The first fault, until it is cleared.
    pub fn trip(&self) -> Option<Trip> {
        self.trip
    }

    /// The loop's rig.
    pub fn rig(&self) -> &R {
        &self.rig
    }

    /// The last steps, oldest first; after a trip, those that led to it.
    pub fn history(&self) -> impl Iterator<Item = &Record<N>> {
        self.history.kept()
    }

    /// Takes an event from the operator or the link.
    ///
    /// # Errors
    /// The event is invalid in this mode, or an interlock prevents arming; nothing has changed then.
    pub fn handle(&mut self, event: Event) -> Result<Mode, Rejected> {
        // Before the first sample the actuator's position is unknown.
        let unseen = self.idle_mean_m.is_none().then_some(Fault::StaleSample);
        let rejected = Rejected {
            mode: self.mode,
            event,
            obstacle: self.obstacle().map(|o| o.0).or(unseen),
        };
        let mut next = self.mode.after(event)?;
        match next {
            Mode::Approaching if rejected.obstacle.is_some() => return Err(rejected),
            Mode::Approaching => {
                // Keep the mean of the rig's position: it is followed until the chain has closed.
                let idle_mean_m = self.idle_mean_m;
                self.reset();
                self.idle_mean_m = idle_mean_m;
                if self.target_m == [0.0; N] {
                    next = Mode::Armed;
                }
            }
            Mode::Holding | Mode::Finished | Mode::Stopping => self.stop_at_command(),
            Mode::Idle => {
                self.trip = None;
                self.idle_mean_m = None;
                self.history.clear();
            }
            Mode::Running | Mode::Returning | Mode::Tripped => {}
            // No event leads to these modes.
            Mode::Armed | Mode::Resuming | Mode::Commissioning => {}
        }
        self.mode = next;
        Ok(next)
    }

    /// Sets the command of the next step in place of the integration (a commissioning signal), or returns to the test
    /// (`None`). All interlocks stay active. No effect while no test runs.
    pub fn set_commissioning_command(&mut self, commissioning_m: Option<[f32; N]>) {
        match commissioning_m {
            Some(commissioning_m) if self.mode.integrates() || self.mode == Mode::Commissioning => {
                (self.mode, self.commissioning_m) = (Mode::Commissioning, commissioning_m);
            }
            None if self.mode == Mode::Commissioning => self.mode = Mode::Running,
            Some(_) | None => {}
        }
    }

    /// The obstacle to arming: a fault seen in the last [`OBSTACLE_STEPS`], and how many steps ago.
    pub fn obstacle(&self) -> Option<(Fault, u32)> {
        let since = self.tick.wrapping_sub(self.obstacle_tick);
        let obstacle = self.obstacle.filter(|_| since <= OBSTACLE_STEPS);
        obstacle.map(|f| (f.fault, since))
    }

    /// The last test that was armed, as [`WatchedStep::test`](crate::watch::WatchedStep::test); 0 before the first.
    pub fn last_test(&self) -> u8 {
        self.post.last_test()
    }

    /// This loop replaces another. It inherits that loop's obstacle to arming, with its age in steps, and no other; its
    /// test count continues from the other's last.
    pub fn take_over(&mut self, obstacle: Option<(Fault, u32)>, last_test: u8) {
        self.post.count_on_from(last_test);
        let (fault, since) = obstacle.unzip();
        self.obstacle = fault.map(Finding::fact);
        self.obstacle_tick = self.tick.wrapping_sub(since.unwrap_or(0));
    }

    /// Exchanges the whole design while idle.
    ///
    /// # Errors
    /// The loop is not idle; it continues unchanged.
    pub fn configure(&mut self, design: Design<N, R>) -> Result<(), Rejected> {
        if self.mode != Mode::Idle {
            return Err(Rejected {
                mode: self.mode,
                event: Event::Arm,
                obstacle: None,
            });
        }
        let (tick, last_test) = (self.tick, self.last_test());
        *self = Self::new(design);
        self.tick = tick;
        self.post.count_on_from(last_test);
        Ok(())
    }

    /// Back to the state after [`OuterLoop::new`], with the step count and the command at 0: what has run was a
    /// rehearsal.
    pub fn restart(&mut self) {
        (self.tick, self.sent_m, self.aimed_m) = (0, [0.0; N], [0.0; N]);
        self.rig.restart();
        self.reset();
    }

    /// Resets everything, at rest at the present command. Field by field: a newly built loop would first lie on the
    /// stack, and a board resets its loop in the control interrupt.
    fn reset(&mut self) {
        let Self {
            // Kept.
            design,
            tick: _,
            sent_m: _,
            aimed_m,
            // Reset.
            mode,
            step,
            flags,
            ground_m_per_s2,
            target_m,
            monitor,
            law,
            correction,
            newmark,
            signal,
            stale,
            lock,
            trip,
            obstacle,
            obstacle_tick,
            idle_mean_m,
            commissioning_m,
            energy,
            estimator,
            history,
            predictor,
            rig,
            lead_m,
            lead_acceleration_m,
            resume_share,
            pace: _,
            next_target_m,
            answer_n,
            post,
        } = self;
        *mode = Mode::Idle;
        (*step, *flags, *obstacle_tick) = (0, 0, 0);
        (*trip, *obstacle, *idle_mean_m) = (None, None, None);
        (*next_target_m, *answer_n) = (None, [0.0; N]);
        (*ground_m_per_s2, *resume_share, *commissioning_m) = (0.0, 0.0, [0.0; N]);
        (*target_m, *lead_m) = (*aimed_m, [0.0; N]);
        *lead_acceleration_m = [0.0; N];
        let diagonal = core::array::from_fn(|j| design.specimen_stiffness[j][j]);
        *monitor = Monitor::new(diagonal, design.energy_floor_j);
        *energy = EnergyErrors::new(design.specimen_stiffness, usize::from(design.window_steps));
        estimator.rest(*aimed_m);
        law.rest();
        *correction = Correction::NONE;
        *newmark = Newmark::at_rest();
        *signal = SignalGenerator::standing_at([0.0; N]);
        stale.reset();
        *lock = LockWatch::default();
        history.clear();
        predictor.rest();
        rig.rest();
        post.rest();
    }
}
