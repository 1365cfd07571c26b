//! The outer loop for a test's rig and number of degrees of freedom.

use super::rehearsal::rehearse;
use link::command::BoardTest;
#[cfg(coupled)]
use outerloop_core::coupled::{CoupledRig, CoupledSettings};
use outerloop_core::{Config, Design, Event, Mode, OuterLoop, Pace, Refusal, Rejected, Trip};

/// The most degrees of freedom of a test on a board: those with an actuator, and calculated ones.
pub const MAX_DOF: usize = 3;

/// An outer loop.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant)] // There is no heap; a test of one storey wastes the other variants' space.
pub enum AnyLoop {
    /// One degree of freedom.
    One(OuterLoop<1>),
    /// Two.
    Two(OuterLoop<2>),
    /// Three.
    Three(OuterLoop<3>),
    /// x and rotation of a coupler held by two actuators. Only images with that many actuators have it.
    #[cfg(coupled)]
    Coupled(OuterLoop<2, CoupledRig>),
}

/// Separate, so that its construction data are not on the stack beside the finished loop.
#[cfg(coupled)]
#[inline(never)]
fn coupled_design(
    config: &Config,
    coupled: &CoupledSettings<2>,
) -> Result<Design<2, CoupledRig>, Refusal> {
    Design::coupled(config, coupled)
}

/// Evaluates `$body` with the loop, whatever its size.
macro_rules! each_loop {
    ($any:expr, $outer:ident => $body:expr) => {
        match $any {
            $crate::station::any_loop::AnyLoop::One($outer) => $body,
            $crate::station::any_loop::AnyLoop::Two($outer) => $body,
            $crate::station::any_loop::AnyLoop::Three($outer) => $body,
            #[cfg(coupled)]
            $crate::station::any_loop::AnyLoop::Coupled($outer) => $body,
        }
    };
}
pub(super) use each_loop;

impl AnyLoop {
    /// The loop of a test without actuators on a coupler.
    ///
    /// # Errors
    /// The first parameter that is not accepted.
    #[inline(never)] // Inlined, the stack would hold the loop twice.
    pub fn new(config: &Config) -> Result<Self, Refusal> {
        match config.structure.mass_kg.len() {
            1 => Self::of(config, Self::One),
            2 => Self::of(config, Self::Two),
            3 => Self::of(config, Self::Three),
            floors => Err(too_many(floors)),
        }
    }

    /// Replaces this loop by that of another test; it stays if the test is refused.
    ///
    /// # Errors
    /// The first parameter that is not accepted.
    pub fn replace(&mut self, test: &BoardTest) -> Result<(), Refusal> {
        let config = &test.config;
        if let Some(_coupled) = &test.coupled {
            #[cfg(coupled)]
            return self.put_coupled(config, _coupled);
            #[cfg(not(coupled))]
            return Err(not_coupled());
        }
        match config.structure.mass_kg.len() {
            1 => self.put(config, Self::One),
            2 => self.put(config, Self::Two),
            3 => self.put(config, Self::Three),
            floors => Err(too_many(floors)),
        }
    }

    #[cfg(coupled)]
    #[inline(never)]
    fn put_coupled(
        &mut self,
        config: &Config,
        coupled: &CoupledSettings<2>,
    ) -> Result<(), Refusal> {
        *self = Self::Coupled(OuterLoop::new(coupled_design(config, coupled)?));
        Ok(())
    }

    /// Not inlined: a loop is a sixth of the stack, and its temporaries must not add up.
    #[inline(never)]
    fn put<const N: usize>(
        &mut self,
        config: &Config,
        wrap: fn(OuterLoop<N>) -> Self,
    ) -> Result<(), Refusal> {
        *self = wrap(OuterLoop::new(Design::new(config)?));
        Ok(())
    }

    /// One size at a time: inlined, the stack would hold all three loops at once.
    #[inline(never)]
    fn of<const N: usize>(
        config: &Config,
        wrap: fn(OuterLoop<N>) -> Self,
    ) -> Result<Self, Refusal> {
        Ok(wrap(OuterLoop::new(Design::new(config)?)))
    }

    /// Handles an event.
    ///
    /// # Errors
    /// See [`OuterLoop::handle`].
    #[inline(never)] // Inlined for every number of floors, the stack would hold the needs of each.
    pub fn handle(&mut self, event: Event) -> Result<Mode, Rejected> {
        each_loop!(self, outer => outer.handle(event))
    }

    /// An obstacle to arming this loop also obstructs the one that replaces it, which continues its count of tests.
    pub fn make_way_for(&self, next: &mut Self) {
        let (obstacle, last_test) =
            each_loop!(self, outer => (outer.obstacle(), outer.last_test()));
        each_loop!(next, outer => outer.take_over(obstacle, last_test));
    }

    /// Takes the next test's targets from the PC, or from the loop's own integration.
    pub fn set_pace(&mut self, pace: Option<Pace>) {
        each_loop!(self, outer => outer.set_pace(pace));
    }

    /// The next target of each actuator from the PC, m.
    pub fn set_next_target(&mut self, target_m: &[f32]) {
        each_loop!(self, outer => outer.set_next_target(on_axes(target_m)));
    }

    /// Turns on the watch of coming tests; `corrects`: command and reading may be corrected.
    pub fn watch(&mut self, corrects: bool) {
        each_loop!(self, outer => outer.watch(corrects));
    }

    /// The mode of the test.
    pub fn mode(&self) -> Mode {
        each_loop!(self, outer => outer.mode())
    }

    /// The first fault.
    pub fn trip(&self) -> Option<Trip> {
        each_loop!(self, outer => outer.trip())
    }

    /// The words of one of the records from before a fault, 0 the oldest.
    pub fn history(&self, index: usize, mut each_word: impl FnMut(u32)) {
        each_loop!(self, outer => {
            if let Some(record) = outer.history().nth(index) {
                record.for_each_word(&mut each_word);
            }
        });
    }

    /// Runs some solved steps and times them by `now`; returns the ticks of a long one, and leaves the loop as built.
    #[inline(never)]
    pub fn rehearse(&mut self, now: fn() -> u32) -> u32 {
        each_loop!(self, outer => rehearse(outer, now))
    }
}

/// The actuators' targets on the first floors; the others stay at zero.
#[inline]
fn on_axes<const N: usize>(target_m: &[f32]) -> [f32; N] {
    core::array::from_fn(|axis| target_m.get(axis).copied().unwrap_or(0.0))
}

/// A signal moves one actuator's floor, and the others stay at zero.
#[inline]
pub(super) fn on_one_axis<const N: usize>(actuator: usize, command_m: f32) -> [f32; N] {
    core::array::from_fn(|axis| if axis == actuator { command_m } else { 0.0 })
}

fn too_many(floors: usize) -> Refusal {
    Refusal {
        name: "structure.mass_kg",
        value: floors as f64,
        accepted: "1 to 3 floors on this board",
    }
}

/// For an image that has no loop for two coupled actuators.
pub(super) fn not_coupled() -> Refusal {
    Refusal {
        name: "coupled",
        value: f64::NAN,
        accepted: "a test without coupled actuators on this image, or the image for three actuators",
    }
}
