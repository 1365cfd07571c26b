//! The compensation methods: one list, from which names, enums, files and calls are made.
//!
//! A method has two halves. A *force law* gives the restoring force of the equation of motion: the measured force, the
//! measured force plus a damping, or a corrected force. A *predictor* computes the command that brings the late actuator
//! to the target in time. Every force law can be combined with every predictor.
//!
//! # To add a method
//! Write `force/NAME.rs` or `predict/NAME.rs` and add a line to [`for_each_method`] below, before the last one, which is
//! for a method that a program [brings itself](crate::own). The line has a number, the variant, the name in test files, the
//! type and its file; for a force law also the predictor that is used if the test file names only the force law.
//!
//! A `feature` is the cargo feature that compiles the method in; without it a build knows only the name and the number.
//! A board needs only the methods that its laboratory uses. A test with a missing method is refused with the name of the
//! feature.
//!
//! The number is sent to the board and stored in its flash. Take the next free one and never reuse one, even after a method
//! is removed: a board with other firmware would run another method. `link/tests/golden.txt` pins all numbers.

/// Calls a macro with all methods.
macro_rules! for_each_method {
    ($then:ident) => {
        $then! {
            forces {
                /// The measured force goes into the equation of motion as it is.
                0 None "none" behind None = measured::Measured, file measured;
                /// Eq 14 as the paper published it: hold on a change of sign only.
                1 Eq14Unguarded "eq14-unguarded" behind None = damping::VariableDamping<N, damping::Unguarded>, file damping;
                /// Eq 14 with the hold rule, the clamp and the effective-mass guard.
                2 Eq14 "eq14" behind None = damping::VariableDamping<N, damping::Guarded>;
                /// Eq 20 with the sech gain of Eq 19, and the guards.
                3 Paper "paper" behind None = damping::VariableDamping<N, damping::Gained>;
                /// Force at the time the target was reached (Ahmadizadeh).
                4 Ahmadizadeh "ahmadizadeh" behind Afp = Corrected<fit::FittedForce<N>, N>, file fit, feature "ahmadizadeh";
                /// Measured force, and tangent stiffness times the remaining displacement.
                5 Tangent "tangent" behind Afp = Corrected<tangent::TangentForce<N>, N>, file tangent, feature "tangent";
                /// What the program brings itself.
                255 OwnForce "own-force" behind None = own::OwnForce<N>, file own, feature "own-methods";
            }
            predictors {
                /// Polynomial extrapolation of the command (Horiuchi).
                1 Lagrange "lagrange" = Axes<lagrange::Lagrange, N>, file lagrange, feature "lagrange";
                /// The same with the delay estimated on line (Darby).
                2 Darby "darby" = Axes<darby::Darby, N>, file darby, feature "darby";
                /// Prediction by the structure's own model (Carrion and Spencer).
                3 ModelPrediction "model-prediction" = model::ModelPrediction, file model, feature "model-prediction";
                /// First-order phase lead (Zhao).
                4 PhaseLead "phase-lead" = Axes<phase_lead::PhaseLead, N>, file phase_lead, feature "phase-lead";
                /// Minimal control synthesis with modified demand (Bonnet).
                5 Mcs "mcs" = Axes<mcs::Mcs, N>, file mcs, feature "mcs";
                /// Inverse model and feedback of the error (Carrion).
                6 FeedforwardFeedback "feedforward-feedback" = Axes<feedforward_feedback::FeedforwardFeedback, N>, file feedforward_feedback, feature "feedforward-feedback";
                /// Adaptive forward prediction (Wallace).
                7 Afp "afp" = Axes<afp::Afp, N>, file afp, feature "afp";
                /// Inverse compensation (Chen and Ricles).
                8 Inverse "inverse" = Axes<inverse::Inverse, N>, file inverse, feature "inverse";
                /// The same, adaptive.
                9 AdaptiveInverse "adaptive-inverse" = Axes<adaptive_inverse::AdaptiveInverse, N>, file adaptive_inverse, feature "adaptive-inverse";
                /// Adaptive time series (Chae).
                10 Ats "ats" = Axes<ats::Ats, N>, file ats, feature "ats";
                /// Adaptive model-based compensation (Galmez and Fermandois).
                11 Amb "amb" = Axes<amb::Amb, N>, file amb, feature "amb";
                /// Inverse of a servo-hydraulic actuator whose parameters are estimated from the noise-free command.
                12 Hydraulic "hydraulic" = Axes<hydraulic::Hydraulic, N>, file hydraulic, feature "hydraulic";
                /// What the program brings itself.
                255 Own "own" = own::OwnPredictor<N>, file own, feature "own-methods";
            }
        }
    };
}
pub(crate) use for_each_method;

/// All but what a program brings itself.
const fn but_last<T>(named: &'static [T]) -> &'static [T] {
    match named.split_last() {
        Some((_, all)) => all,
        None => named,
    }
}

/// What a refusal says of a method that the build leaves out.
pub const NOT_BUILT_IN: &str = "the methods that were built in";

/// Refuses a method whose feature this build has not.
#[allow(unused_macros)] // A build with every method leaves none out.
macro_rules! left_out {
    ($number:literal, $name:literal, $feature:literal) => {
        Err($crate::refusal::Refusal {
            name: "compensation.kind",
            value: $number as f64,
            accepted: concat!(
                "the methods that were built in: ",
                $name,
                " needs the cargo feature `",
                $feature,
                "`"
            ),
        })
    };
}
#[allow(unused_imports)]
pub(crate) use left_out;

/// The name of one force law with the predictor `$behind`.
macro_rules! with_predictor {
    ($behind:expr, $force:literal {$($(#[$doc:meta])* $number:literal $P:ident $name:literal = $stage:ty $(, file $file:ident)? $(, feature $feature:literal)?;)*}) => {
        match $behind {
            Prediction::None => concat!($force, "+none"),
            $(Prediction::$P => concat!($force, "+", $name),)*
        }
    };
}

/// An enum of named halves of a method, with their numbers and sentences.
macro_rules! halves {
    ($(#[$about:meta])* $Half:ident: $($(#[doc = $doc:literal])* $number:literal $V:ident $name:literal;)*) => {
        $(#[$about])*
        ///
        /// The numbers are on the link and in flash: they never change, and none is given again.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u8)]
        #[non_exhaustive]
        pub enum $Half {
            $($(#[doc = $doc])* $V = $number,)*
        }

        impl $Half {
            /// All of them, in the order of the documentation, without what a program brings itself.
            pub const ALL: &[Self] = but_last(Self::NAMED);

            const NAMED: &[Self] = &[$(Self::$V),*];

            /// The name on the command line and in files.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$V => $name,)*
                }
            }

            /// What it does, in a sentence.
            pub const fn meaning(self) -> &'static str {
                match self {
                    $(Self::$V => concat!($($doc),*).trim_ascii_start(),)*
                }
            }

            /// The number on the link and in flash.
            pub const fn code(self) -> u8 {
                self as u8
            }

            /// The one with this number.
            pub fn from_code(code: u8) -> Option<Self> {
                Self::NAMED.iter().copied().find(|half| half.code() == code)
            }
        }
    };
}

macro_rules! predictor_names {
    ($($(#[doc = $doc:literal])* $number:literal $P:ident $name:literal = $stage:ty $(, file $file:ident)? $(, feature $feature:literal)?;)*) => {
        halves! {
            /// What stands between the target and the command that is sent; each is a method of the same name.
            Prediction:
            /// The target is sent as it is.
            0 None "none";
            $($(#[doc = $doc])* $number $P $name;)*
        }

        #[allow(non_upper_case_globals)] // They are read as what they name: `Method::Lagrange`.
        impl Method {
            $($(#[doc = $doc])* pub const $P: Self = Self { force: Force::None, predictor: Prediction::$P };)*
        }
    };
}

macro_rules! names {
    (
        forces {$($(#[doc = $doc:literal])* $number:literal $F:ident $name:literal behind $own:ident = $stage:ty $(, file $file:ident)? $(, feature $feature:literal)?;)*}
        predictors {$($predictors:tt)*}
    ) => {
        names!(@ [$($(#[doc = $doc])* $number $F $name $own;)*] {$($predictors)*});
        predictor_names!{$($predictors)*}
    };
    (@ [$($(#[doc = $doc:literal])* $number:literal $F:ident $name:literal $own:ident;)*] $predictors:tt) => {
        halves! {
            /// How the restoring force enters the equation of motion.
            Force: $($(#[doc = $doc])* $number $F $name;)*
        }

        impl Force {
            /// The predictor behind which it stands where it is named alone.
            pub const fn own_predictor(self) -> Prediction {
                match self {
                    $(Self::$F => Prediction::$own,)*
                }
            }
        }

        #[allow(non_upper_case_globals)] // They are read as what they name: `Method::Paper`.
        impl Method {
            $($(#[doc = $doc])* pub const $F: Self = Self { force: Force::$F, predictor: Prediction::$own };)*
        }

        /// `force+predictor`.
        const fn pair(force: Force, predictor: Prediction) -> &'static str {
            match force {
                $(Force::$F => with_predictor!(predictor, $name $predictors),)*
            }
        }
    };
}

for_each_method!(names);

/// A compensation: a force law behind a predictor.
///
/// Its name is that of the force law where the predictor is the law's own (`paper`, `tangent`), that of the predictor
/// where the force is used as measured (`ats`), else both (`tangent+ats`, `paper+afp`, `tangent+none`).
///
/// ```
/// use outerloop_core::{Force, Method, Prediction};
///
/// let method = Method::from_name("tangent+ats").unwrap();
/// assert_eq!((method.force, method.predictor), (Force::Tangent, Prediction::Ats));
/// assert_eq!(Method::Paper.behind(Prediction::Afp).name(), "paper+afp");
/// assert!(Method::from_name("magic").is_none());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Method {
    /// What acts in the equation of motion.
    pub force: Force,
    /// What acts on the command.
    pub predictor: Prediction,
}

impl Default for Method {
    fn default() -> Self {
        Self::Paper
    }
}

impl Method {
    /// Every method that has a name of its own: force laws without a predictor, predictors, force laws behind theirs.
    pub const ALL: [Self; Force::ALL.len() + Prediction::ALL.len() - 1] = {
        let mut all = [Self::None; Force::ALL.len() + Prediction::ALL.len() - 1];
        let (mut place, mut i) = (0, 0);
        while i < Force::ALL.len() {
            if matches!(Force::ALL[i].own_predictor(), Prediction::None) {
                all[place] = Self::alone(Force::ALL[i]);
                place += 1;
            }
            i += 1;
        }
        i = 1;
        while i < Prediction::ALL.len() {
            all[place] = Self {
                force: Force::None,
                predictor: Prediction::ALL[i],
            };
            place += 1;
            i += 1;
        }
        i = 0;
        while i < Force::ALL.len() {
            if !matches!(Force::ALL[i].own_predictor(), Prediction::None) {
                all[place] = Self::alone(Force::ALL[i]);
                place += 1;
            }
            i += 1;
        }
        all
    };

    /// A force law behind its own predictor.
    const fn alone(force: Force) -> Self {
        Self {
            force,
            predictor: force.own_predictor(),
        }
    }

    /// The same force law behind another predictor.
    #[must_use]
    pub const fn behind(self, predictor: Prediction) -> Self {
        Self {
            force: self.force,
            predictor,
        }
    }

    /// The name on the command line, in files and in reports.
    pub const fn name(self) -> &'static str {
        if self.predictor as usize == self.force.own_predictor() as usize {
            self.force.name()
        } else if matches!(self.force, Force::None) {
            self.predictor.name()
        } else {
            pair(self.force, self.predictor)
        }
    }

    /// What it does, in a sentence: of its predictor where it has the predictor's name, else of its force law.
    pub const fn meaning(self) -> &'static str {
        if matches!(self.force, Force::None) && !matches!(self.predictor, Prediction::None) {
            self.predictor.meaning()
        } else {
            self.force.meaning()
        }
    }

    /// The method with this name; `None` where there is none: [`Accepted`] says what there is.
    pub fn from_name(name: &str) -> Option<Self> {
        let force = |name| Force::NAMED.iter().copied().find(|f| f.name() == name);
        let predictor = |name| Prediction::NAMED.iter().copied().find(|p| p.name() == name);
        match name.split_once('+') {
            Some((law, behind)) => Some(Self {
                force: force(law)?,
                predictor: predictor(behind)?,
            }),
            None => force(name)
                .map(Self::alone)
                .or_else(|| predictor(name).map(|p| Self::None.behind(p))),
        }
    }
}

impl core::fmt::Display for Method {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.pad(self.name())
    }
}

/// What is accepted as the name of a method, for messages.
#[derive(Clone, Copy, Debug)]
pub struct Accepted;

impl core::fmt::Display for Accepted {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        for method in Method::ALL {
            write!(f, "{method}, ")?;
        }
        f.write_str("and FORCE+PREDICTOR, as in tangent+ats")
    }
}

/// By name in files; as two numbers on the link.
#[cfg(feature = "serde")]
mod travel {
    use super::{Accepted, Force, Method, Prediction};
    use serde::de::{Deserialize, Deserializer, Error, Visitor};
    use serde::ser::{Serialize, Serializer};

    impl Serialize for Method {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            if serializer.is_human_readable() {
                serializer.serialize_str(self.name())
            } else {
                (self.force.code(), self.predictor.code()).serialize(serializer)
            }
        }
    }

    struct Name;

    impl Visitor<'_> for Name {
        type Value = Method;

        fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
            write!(f, "the name of a compensation: {Accepted}")
        }

        fn visit_str<E: Error>(self, name: &str) -> Result<Method, E> {
            Method::from_name(name).ok_or_else(|| {
                E::custom(format_args!(
                    "the compensation `{name}` is unknown: accepted are {Accepted}"
                ))
            })
        }
    }

    #[cfg(feature = "schema")]
    impl schemars::JsonSchema for Method {
        fn schema_name() -> std::borrow::Cow<'static, str> {
            "Method".into()
        }

        /// A name of the list, or a force and a predictor.
        fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
            let names = Self::ALL.map(Self::name);
            schemars::json_schema!({
                "anyOf": [
                    { "type": "string", "enum": names.as_slice() },
                    { "type": "string", "pattern": r"^[a-z0-9-]+\+[a-z0-9-]+$" },
                ]
            })
        }
    }

    impl<'de> Deserialize<'de> for Method {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            if deserializer.is_human_readable() {
                deserializer.deserialize_str(Name)
            } else {
                let (force, predictor) = <(u8, u8)>::deserialize(deserializer)?;
                let unknown = || D::Error::custom("a compensation of another firmware");
                Ok(Self {
                    force: Force::from_code(force).ok_or_else(unknown)?,
                    predictor: Prediction::from_code(predictor).ok_or_else(unknown)?,
                })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Scripts outside the repository call these.
    #[test]
    fn the_names_of_the_contract_stay() {
        let names = "none eq14-unguarded eq14 paper lagrange darby model-prediction phase-lead mcs \
                     feedforward-feedback afp inverse adaptive-inverse ats ahmadizadeh tangent";
        let mut found = Method::ALL.into_iter().map(Method::name);
        for name in names.split_whitespace() {
            assert!(found.any(|f| f == name), "{name} is gone, or out of order");
        }
    }

    #[test]
    fn every_pair_has_one_name_and_is_found_by_it() {
        for &force in Force::ALL {
            for &predictor in Prediction::ALL {
                let method = Method { force, predictor };
                assert_eq!(Method::from_name(method.name()), Some(method));
                // Both names are understood even where one says it.
                assert_eq!(Method::from_name(pair(force, predictor)), Some(method));
            }
        }
        let names = [
            ("tangent+ats", Method::Tangent.behind(Prediction::Ats)),
            ("tangent", Method::Tangent.behind(Prediction::Afp)),
            ("tangent+none", Method::Tangent.behind(Prediction::None)),
            ("ats", Method::Ats),
        ];
        for (name, method) in names {
            assert_eq!(method.name(), name);
        }
        for wrong in [
            "",
            "magic",
            "tangent+",
            "+ats",
            "ats+tangent",
            "paper+afp+ats",
        ] {
            assert_eq!(Method::from_name(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn every_named_method_is_listed_once() {
        for (i, method) in Method::ALL.iter().enumerate() {
            assert!(!method.name().contains('+'));
            assert!(!Method::ALL[..i].contains(method), "{method} twice");
        }
    }
}
