//! Your own method without a fork: a program, on a PC or on a board, registers it at start.
//!
//! Write it like the methods of this crate, axis by axis: a predictor as a [`PredictAxis`], a force law as an
//! [`AxisLaw`]. A test file asks for it by `kind = "own"` (the predictor), `"own-force"` (the law) or a pair such as
//! `"paper+own"`, and gives it up to eight parameters, `own = [0.8]`. Everything else is as with any method: the
//! same loop, interlocks and records, and the same test on a board, whose steps the PC recomputes.
//!
//! ```
//! use outerloop_core::config::{Compensation, Timing};
//! use outerloop_core::own::{OwnMethods, Pod, Zeroable};
//! use outerloop_core::{ActuatorContext, LastCommand, PredictAxis, Refusal, TargetMotion};
//!
//! /// Sends the target ahead by a share of the delay.
//! #[derive(Clone, Copy, Debug, Pod, Zeroable)]
//! #[repr(C)]
//! struct Lead;
//!
//! impl PredictAxis for Lead {
//!     type Constants = f32; // control steps
//!
//!     fn check(c: &Compensation, _: &Timing) -> Result<(), Refusal> {
//!         let share = c.own.first().copied().unwrap_or(f64::NAN);
//!         outerloop_core::accept("compensation.own, the share", share, (0.0..=1.5).contains(&share), "0 to 1.5")
//!     }
//!
//!     fn design(context: &ActuatorContext<'_>) -> f32 {
//!         (context.parameters.own[0] * context.delay_steps()) as f32
//!     }
//!
//!     fn at_rest(_: &f32) -> Self {
//!         Self
//!     }
//!
//!     fn command(&mut self, steps: &f32, _: &LastCommand, ahead: &TargetMotion) -> f32 {
//!         ahead.after(*steps)
//!     }
//! }
//!
//! static METHODS: OwnMethods = OwnMethods::NONE.with_predictor::<Lead>();
//! METHODS.register().unwrap();
//!
//! let mut config = outerloop_core::Config::shear_frame([1000.0], [158e3], [0.02]);
//! config.compensation.kind = outerloop_core::Method::from_name("paper+own").unwrap();
//! config.compensation.own = [0.8].into_iter().collect();
//! assert!(outerloop_core::Design::<1>::new(&config).is_ok());
//! ```
//!
//! A force law sees the reached state and returns a force and a damping for the equation of motion:
//!
//! ```
//! use outerloop_core::own::{OwnMethods, Pod, Zeroable};
//! use outerloop_core::{ActuatorContext, AxisLaw, AxisOutput, AxisStep};
//!
//! /// The measured force, carried from where the actuator is to the target with the declared stiffness.
//! #[derive(Clone, Copy, Debug, Pod, Zeroable)]
//! #[repr(C)]
//! struct Carried;
//!
//! impl AxisLaw for Carried {
//!     type Constants = f32; // N/m
//!
//!     fn design(context: &ActuatorContext<'_>) -> f32 {
//!         context.stiffness_n_per_m as f32
//!     }
//!
//!     fn at_rest(_: &f32) -> Self {
//!         Self
//!     }
//!
//!     fn act(&mut self, stiffness_n_per_m: &f32, reached: &AxisStep) -> AxisOutput {
//!         let missing_m = reached.command_m - reached.displacement_m;
//!         AxisOutput {
//!             force_n: reached.force_n + stiffness_n_per_m * missing_m,
//!             damping_n_s_per_m: 0.0,
//!         }
//!     }
//! }
//!
//! static METHODS: OwnMethods = OwnMethods::NONE.with_force::<Carried>();
//! METHODS.register().unwrap();
//!
//! let mut config = outerloop_core::Config::shear_frame([1000.0], [158e3], [0.02]);
//! config.compensation.kind = outerloop_core::Method::from_name("own-force").unwrap();
//! assert!(outerloop_core::Design::<1>::new(&config).is_ok());
//! ```
//!
//! `docs/recipes/own-method` is a crate with such a method that builds a tool of its own, an image for QEMU and one for the
//! board.
//!
//! # Limitations
//! A method's constants and memory are plain data ([`Pod`]) of at most [`ROOM_BYTES`] an axis. It is called through a pointer:
//! the call graph of an image that contains one ends there, so its author must ensure that it does not panic and stays
//! in single precision.

use crate::config::{Compensation, Timing};
use crate::context::ActuatorContext;
use crate::force::{AxisLaw, AxisOutput, AxisStep};
use crate::predict::{LastCommand, PredictAxis, TargetMotion};
use crate::refusal::Refusal;
pub use bytemuck::{Pod, Zeroable};
use once_cell::race::OnceRef;

const WORDS: usize = 32;

/// Largest size of an axis's constants, and of its memory, in bytes.
pub const ROOM_BYTES: usize = 4 * WORDS;

static REGISTERED: OnceRef<'static, OwnMethods> = OnceRef::new();

/// The registered methods.
pub(crate) fn registered() -> Option<&'static OwnMethods> {
    REGISTERED.get()
}

/// The refusal of a method that the program does not supply.
pub(crate) const NONE_REGISTERED: Refusal = Refusal {
    name: "compensation.kind",
    value: 255.0,
    accepted: "the methods of the list: this program brings none of its own of that kind",
};

/// The methods that a program supplies: a predictor, a force law, or both.
#[derive(Clone, Copy, Debug)]
pub struct OwnMethods {
    pub(crate) predictor: Option<PredictorCalls>,
    pub(crate) force: Option<ForceCalls>,
}

/// Another method has been registered before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AlreadyRegistered;

impl core::fmt::Display for AlreadyRegistered {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("a program brings its own methods once: others are registered already")
    }
}

impl core::error::Error for AlreadyRegistered {}

impl OwnMethods {
    /// Neither predictor nor force law.
    pub const NONE: Self = Self {
        predictor: None,
        force: None,
    };

    /// With this predictor, `kind = "own"`.
    #[must_use]
    pub const fn with_predictor<P>(self) -> Self
    where
        P: PredictAxis<Constants: Pod> + Pod,
    {
        const { assert!(size_of::<P>() <= ROOM_BYTES && size_of::<P::Constants>() <= ROOM_BYTES) };
        Self {
            predictor: Some(PredictorCalls {
                check: P::check,
                design: |context| Room::of(P::design(context)),
                at_rest: |k| Room::of(P::at_rest(&k.get())),
                command: |room, k, followed, ahead| {
                    room.with(|own: &mut P| own.command(&k.get(), followed, ahead))
                },
                unlearn: |room, k| room.with(|own: &mut P| own.unlearn(&k.get())),
            }),
            ..self
        }
    }

    /// With this force law, `kind = "own-force"`.
    #[must_use]
    pub const fn with_force<L>(self) -> Self
    where
        L: AxisLaw<Constants: Pod> + Pod,
    {
        const { assert!(size_of::<L>() <= ROOM_BYTES && size_of::<L::Constants>() <= ROOM_BYTES) };
        Self {
            force: Some(ForceCalls {
                check: L::check,
                design: |context| Room::of(L::design(context)),
                at_rest: |k| Room::of(L::at_rest(&k.get())),
                act: |room, k, reached| room.with(|own: &mut L| own.act(&k.get(), reached)),
            }),
            ..self
        }
    }

    /// Registers these methods. Call it before a test is read.
    ///
    /// # Errors
    /// Others have been registered before.
    pub fn register(&'static self) -> Result<(), AlreadyRegistered> {
        REGISTERED.set(self).map_err(|()| AlreadyRegistered)
    }
}

/// Room for the constants or the memory of an axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Room([u32; WORDS]);

impl Room {
    /// An empty room.
    pub const EMPTY: Self = Self([0; WORDS]);

    fn of<T: Pod>(value: T) -> Self {
        let mut room = Self::EMPTY;
        room.put(&value);
        room
    }

    fn put<T: Pod>(&mut self, value: &T) {
        let bytes = bytemuck::bytes_of_mut(&mut self.0).iter_mut();
        bytes
            .zip(bytemuck::bytes_of(value))
            .for_each(|(to, from)| *to = *from);
    }

    fn get<T: Pod>(&self) -> T {
        let mut value = T::zeroed();
        let bytes = bytemuck::bytes_of_mut(&mut value).iter_mut();
        bytes
            .zip(bytemuck::bytes_of(&self.0))
            .for_each(|(to, from)| *to = *from);
        value
    }

    fn with<T: Pod, A>(&mut self, change: impl FnOnce(&mut T) -> A) -> A {
        let mut value = self.get();
        let answer = change(&mut value);
        self.put(&value);
        answer
    }
}

/// The functions through which a predictor is called.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PredictorCalls {
    pub check: fn(&Compensation, &Timing) -> Result<(), Refusal>,
    pub design: fn(&ActuatorContext<'_>) -> Room,
    pub at_rest: fn(&Room) -> Room,
    pub command: fn(&mut Room, &Room, &LastCommand, &TargetMotion) -> f32,
    pub unlearn: fn(&mut Room, &Room),
}

/// The functions through which a force law is called.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ForceCalls {
    pub check: fn(&Compensation) -> Result<(), Refusal>,
    pub design: fn(&ActuatorContext<'_>) -> Room,
    pub at_rest: fn(&Room) -> Room,
    pub act: fn(&mut Room, &Room, &AxisStep) -> AxisOutput,
}
