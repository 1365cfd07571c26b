//! What the operator does with a loop, between steps.

use super::{
    Correction, Design, EnergyErrors, Event, LockWatch, Monitor, Newmark, OuterLoop, Record,
    Rejected, SignalGenerator, StaleWatch, State, Trip,
};

impl<const N: usize> OuterLoop<N> {
    /// Where the test stands.
    pub fn state(&self) -> State {
        self.state
    }

    /// The first fault, until it is cleared.
    pub fn trip(&self) -> Option<Trip> {
        self.trip
    }

    /// The last steps, oldest first; after a trip, those that led to it.
    pub fn history(&self) -> impl Iterator<Item = &Record<N>> {
        self.history.kept()
    }

    /// Takes an event from the operator or the link.
    ///
    /// # Errors
    /// The event means nothing in this state, an interlock stands against arming, or the approach to the start
    /// position has not ended; nothing has changed then.
    pub fn handle(&mut self, event: Event) -> Result<State, Rejected> {
        let rejected = Rejected {
            state: self.state,
            event,
            obstacle: self.obstacle.map(|f| f.fault),
        };
        let next = self.state.after(event)?;
        match (self.state, next) {
            (State::Idle, State::Armed) if self.obstacle.is_some() => return Err(rejected),
            (State::Armed, State::Running) if self.target_m != [0.0; N] => return Err(rejected),
            (State::Idle, State::Armed) => self.reset(),
            (State::Armed, State::Running) => self.blend = 1.0,
            (State::Holding, State::Running) => (self.returning, self.blend) = (true, 0.0),
            (State::Running, State::Holding | State::Finished) => self.stop_where_it_is(),
            (_, State::Idle) => {
                self.trip = None;
                self.standing_m = None;
                self.history.clear();
            }
            _ => {}
        }
        self.state = next;
        Ok(next)
    }

    /// Gives the command of the next step while running, in place of the integration: a commissioning signal. All
    /// interlocks are in force. `None`, and arming, go back to the test.
    pub fn set_goal(&mut self, goal_m: Option<[f32; N]>) {
        self.goal_m = goal_m;
    }

    /// Exchanges the whole design while idle.
    ///
    /// # Errors
    /// The loop is not idle; it goes on as it was.
    pub fn configure(&mut self, design: Design<N>) -> Result<(), Rejected> {
        if self.state != State::Idle {
            return Err(Rejected {
                state: self.state,
                event: Event::Arm,
                obstacle: None,
            });
        }
        let tick = self.tick;
        *self = Self::new(design);
        self.tick = tick;
        Ok(())
    }

    /// Everything back to the start, standing at the present command.
    ///
    /// Part by part: a loop that is built anew stands on the stack before it is moved here, and a board resets its loop in
    /// the control interrupt.
    fn reset(&mut self) {
        let Self {
            // What stays.
            design,
            tick: _,
            sent_m: _,
            aimed_m,
            // What goes back.
            state,
            returning,
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
            standing_m,
            goal_m,
            energy,
            estimator,
            history,
            predictor,
            rig,
            aimed_step_m,
            blend,
            pace: _,
            next_target_m,
            answer_n,
        } = self;
        *state = State::Idle;
        (*returning, *step, *flags) = (false, 0, 0);
        (*trip, *obstacle, *standing_m, *goal_m) = (None, None, None, None);
        (*next_target_m, *answer_n) = (None, [0.0; N]);
        (*ground_m_per_s2, *blend) = (0.0, 1.0);
        (*target_m, *aimed_step_m) = (*aimed_m, [0.0; N]);
        let diagonal = core::array::from_fn(|j| design.specimen_stiffness[j][j]);
        *monitor = Monitor::new(diagonal, design.energy_floor_j);
        *energy = EnergyErrors::new(design.specimen_stiffness, usize::from(design.window_steps));
        estimator.rest(*aimed_m);
        law.rest();
        *correction = Correction::NONE;
        *newmark = Newmark::at_rest();
        *signal = SignalGenerator::standing_at([0.0; N]);
        *stale = StaleWatch::new();
        *lock = LockWatch::default();
        history.clear();
        predictor.rest();
        rig.rest();
    }
}
