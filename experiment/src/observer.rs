//! Observers of a running test: they get every record of it, whatever the size of the loop.

use outerloop_core::watch::{AxisOrders, Block, Instructions, Verdict};
use outerloop_core::{EnergyWords, Event, Mode, Record};
use plant::coupled::CoupledReading;

/// The record of a loop of any size: whoever looks at it is compiled once, and the loop once for each size.
#[derive(Clone, Copy, Debug)]
pub struct AnyRecord<'a> {
    /// Control step since power-up.
    pub tick: u32,
    /// Integration steps solved since the start of the test.
    pub step: u32,
    /// As core's record has them.
    pub flags: u32,
    /// Ground acceleration, m/s^2.
    pub ground_m_per_s2: f32,
    /// u_c of every floor, m.
    pub command_m: &'a [f32],
    /// What was sent to the actuators for it, m.
    pub sent_m: &'a [f32],
    /// u_m as measured, m.
    pub displacement_m: &'a [f32],
    /// R_m as measured, N.
    pub force_n: &'a [f32],
    /// u_m as estimated, m.
    pub estimated_displacement_m: &'a [f32],
    /// R_m as estimated, N.
    pub estimated_force_n: &'a [f32],
    /// v, m/s of model time.
    pub velocity_m_per_s: &'a [f32],
    /// a, m/s^2 of model time.
    pub acceleration_m_per_s2: &'a [f32],
    /// C_cor, N s/m.
    pub added_damping_n_s_per_m: &'a [f32],
    /// G_v.
    pub gain: &'a [f32],
    /// Cumulative energy errors, J.
    pub energy_sum: EnergyWords,
    /// Work of the external load, J.
    pub energy_input_j: f32,
    /// Energy error relative to the energy in the test.
    pub energy_ratio: f32,
    /// Of two coupled actuators on a simulated rig: what was read of it, and what is true.
    pub coupled: Option<&'a CoupledReading>,
}

impl AnyRecord<'_> {
    /// True if a [`flag`] is set.
    pub fn has(&self, flag: u32) -> bool {
        self.flags & flag != 0
    }

    /// What the loop was doing.
    pub fn mode(&self) -> Option<Mode> {
        Mode::from_code(self.flags & 0xf)
    }
}

impl<'a, const N: usize> From<&'a Record<N>> for AnyRecord<'a> {
    #[inline]
    fn from(r: &'a Record<N>) -> Self {
        Self {
            tick: r.tick,
            step: r.step,
            flags: r.flags,
            ground_m_per_s2: r.ground_m_per_s2,
            command_m: &r.command_m,
            sent_m: &r.sent_m,
            displacement_m: &r.displacement_m,
            force_n: &r.force_n,
            estimated_displacement_m: &r.estimated_displacement_m,
            estimated_force_n: &r.estimated_force_n,
            velocity_m_per_s: &r.velocity_m_per_s,
            acceleration_m_per_s2: &r.acceleration_m_per_s2,
            added_damping_n_s_per_m: &r.added_damping_n_s_per_m,
            gain: &r.gain,
            energy_sum: r.energy_sum,
            energy_input_j: r.energy_input_j,
            energy_ratio: r.energy_ratio,
            coupled: None,
        }
    }
}

/// Sees every record of a running test, from its first step to its last.
pub trait TestObserver {
    /// One control step.
    fn on_step(&mut self, record: &AnyRecord<'_>);

    /// A control step that is not part of the test: before its start, while it is held, after its end.
    fn on_idle_step(&mut self, record: &AnyRecord<'_>) {
        let _ = record;
    }

    /// An event that the observer asks for, given once: a stop, for example.
    fn requested_event(&mut self) -> Option<Event> {
        None
    }

    /// Asked by a bench before the test: whether the observer is the rig watch, and then what it is told of each actuator.
    fn watches_the_loop(&mut self) -> Option<Vec<Instructions>> {
        None
    }

    /// Blocks of the running test, one for each axis; `orders` are given for each in answer.
    fn judge(&mut self, blocks: &[Block], orders: &mut [AxisOrders]) -> Verdict {
        let _ = (blocks, orders);
        Verdict::NONE
    }

    /// What the rig watch says, where this is it.
    fn says(&self) -> Option<String> {
        None
    }

    /// The rig watch says something else now.
    fn on_watch(&mut self, said: &str) {
        let _ = said;
    }
}

impl TestObserver for () {
    #[inline]
    fn on_step(&mut self, _: &AnyRecord<'_>) {}
}

impl<W: TestObserver + ?Sized> TestObserver for &mut W {
    #[inline]
    fn on_step(&mut self, record: &AnyRecord<'_>) {
        (**self).on_step(record);
    }

    #[inline]
    fn on_idle_step(&mut self, record: &AnyRecord<'_>) {
        (**self).on_idle_step(record);
    }

    #[inline]
    fn requested_event(&mut self) -> Option<Event> {
        (**self).requested_event()
    }

    #[inline]
    fn watches_the_loop(&mut self) -> Option<Vec<Instructions>> {
        (**self).watches_the_loop()
    }

    #[inline]
    fn judge(&mut self, blocks: &[Block], orders: &mut [AxisOrders]) -> Verdict {
        (**self).judge(blocks, orders)
    }

    fn says(&self) -> Option<String> {
        (**self).says()
    }

    fn on_watch(&mut self, said: &str) {
        (**self).on_watch(said);
    }
}

impl<W: TestObserver> TestObserver for Option<W> {
    #[inline]
    fn on_step(&mut self, record: &AnyRecord<'_>) {
        if let Some(observer) = self {
            observer.on_step(record);
        }
    }

    #[inline]
    fn on_idle_step(&mut self, record: &AnyRecord<'_>) {
        if let Some(observer) = self {
            observer.on_idle_step(record);
        }
    }

    #[inline]
    fn requested_event(&mut self) -> Option<Event> {
        self.as_mut()?.requested_event()
    }

    #[inline]
    fn watches_the_loop(&mut self) -> Option<Vec<Instructions>> {
        self.as_mut()?.watches_the_loop()
    }

    #[inline]
    fn judge(&mut self, blocks: &[Block], orders: &mut [AxisOrders]) -> Verdict {
        self.as_mut()
            .map_or(Verdict::NONE, |own| own.judge(blocks, orders))
    }

    fn says(&self) -> Option<String> {
        self.as_ref()?.says()
    }

    fn on_watch(&mut self, said: &str) {
        if let Some(observer) = self {
            observer.on_watch(said);
        }
    }
}

impl<A: TestObserver, B: TestObserver> TestObserver for (A, B) {
    #[inline]
    fn on_step(&mut self, record: &AnyRecord<'_>) {
        self.0.on_step(record);
        self.1.on_step(record);
    }

    #[inline]
    fn on_idle_step(&mut self, record: &AnyRecord<'_>) {
        self.0.on_idle_step(record);
        self.1.on_idle_step(record);
    }

    #[inline]
    fn requested_event(&mut self) -> Option<Event> {
        self.0
            .requested_event()
            .or_else(|| self.1.requested_event())
    }

    #[inline]
    fn watches_the_loop(&mut self) -> Option<Vec<Instructions>> {
        self.0
            .watches_the_loop()
            .or_else(|| self.1.watches_the_loop())
    }

    /// One of the two at most is the watch.
    #[inline]
    fn judge(&mut self, blocks: &[Block], orders: &mut [AxisOrders]) -> Verdict {
        let first = self.0.judge(blocks, orders);
        let second = self.1.judge(blocks, orders);
        if first.changed
            && let Some(said) = self.0.says()
        {
            self.1.on_watch(&said);
        } else if second.changed
            && let Some(said) = self.1.says()
        {
            self.0.on_watch(&said);
        }
        first.with(second)
    }

    fn says(&self) -> Option<String> {
        self.0.says().or_else(|| self.1.says())
    }

    fn on_watch(&mut self, said: &str) {
        self.0.on_watch(said);
        self.1.on_watch(said);
    }
}
