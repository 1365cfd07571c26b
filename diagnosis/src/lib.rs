#![doc = include_str!("../README.md")]
//!
//! # Method
//!
//! Regression lowers an error and names no cause. Here sets of laws, and of declared parameters that leave their tolerances, are fitted
//! to a channel together, scored on blocks of the training data that were left out, and weighed against each other, against nothing, and
//! against free functions that have no name. What comes of it is how probable each name is. The answer is a name, a set of which these
//! data cannot tell one, nothing, or "unknown"; held-out data say what it is worth.
//!
//! # Layers
//!
//! A folder imports from those above it alone.
//!
//! | folder | what it knows |
//! |---|---|
//! | `numbers`, `criteria` | arithmetic on signals; thresholds that several use, with their reasons |
//! | `record` | a record as it was taken: stamps, rests, band |
//! | `laws` | what may be in a rig, as equations |
//! | `model` | what is declared, and what is said of a channel |
//! | `prepare` | what is known before anything is searched: refusals, noise, what the motion can tell |
//! | `engine` | the one search, score, posterior and verdict |
//! | `diagnose` | the answer for a channel, several coordinates, a dial, a witness |
//! | `next` | the test that tells apart what is open |

mod criteria;
mod diagnose;
mod engine;
mod laws;
mod model;
mod next;
mod numbers;
mod prepare;
mod record;

pub use diagnose::coupled::{
    CoordinateAnswer, CoupledDiagnosis, CoupledRecord, CoupledTraces, CoupledVerdict, WrongEntry,
    diagnose_coupled,
};
pub use diagnose::dial::{DialNumber, Dose, Turned, turned};
pub use diagnose::witness::{Heard, Other, Says, Testimony, Witnessed, testimonies};
pub use diagnose::{Diagnosis, diagnose};
pub use model::answer::{
    ChannelAnswer, Correction, DependsOn, Errors, FoundEffect, FoundParameter, Line, Member,
    Nearest, Range, Refitted, Remainder, Share, Traces, Verdict,
};
pub use model::channel::ChannelModel;
pub use model::coordinates::{CoupledSpecimen, MATRICES};
pub use model::declared::Declared;
pub use model::saved_element::SavedElement;
pub use model::{ActuatorModel, ForceUnit, Model, RigLimits, SpecimenModel};
pub use next::{
    Form, Narrowed, Next, Origin, Outlook, Phase, Prediction, TestLimits, next, why_no_test,
};
pub use record::identify::{Identified, identify};
pub use record::recording::{FEWEST_SAMPLES, Recording};
pub use record::refusal::Refusal;
pub use record::stamps::{gaps, missing_rows, usual_interval_s};
