#![doc = include_str!("../README.md")]
//!
//! # Method
//!
//! Regression lowers an error but names no cause. Here sets of laws, and of declared parameters that leave their
//! tolerances, are fitted to a channel together and scored on blocks of training data that were left out. They compete
//! with each other, with nothing, and with free functions without a name, which gives each name a probability. The
//! answer is a name, a set of which these data cannot tell one, nothing, or "unknown"; held-out data judge it.
//!
//! # Layers
//!
//! A folder imports only from those above it.
//!
//! | folder | responsibility |
//! |---|---|
//! | `numbers`, `criteria` | arithmetic on signals; thresholds used in several places, with their reasons |
//! | `record` | a record as it was taken: time stamps, rests, band |
//! | `laws` | the equations of what a rig may contain |
//! | `model` | what is declared, and the answer for a channel |
//! | `prepare` | what is known before the search: refusals, noise, what the motion can tell |
//! | `engine` | the only search, score, posterior and verdict |
//! | `diagnose` | the answer for a channel, several coordinates, a dial, a witness |
//! | `next` | the test that tells the open causes apart |

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
pub use record::identify::{Identified, USUAL_GAINS, identify};
pub use record::recording::{FEWEST_SAMPLES, Recording};
pub use record::refusal::Refusal;
pub use record::stamps::{gaps, missing_rows, usual_interval_s};
