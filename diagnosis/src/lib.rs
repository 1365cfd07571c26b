#![doc = include_str!("../README.md")]
//!
//! # Method
//!
//! Regression lowers an error and names no cause. Here sets of laws, and of declared parameters that leave their tolerances, are fitted
//! to a channel together, scored on blocks of the training data that were left out, and weighed against each other, against nothing, and
//! against free functions that have no name. What comes of it is how probable each name is. The answer is a name, a set of which these
//! data cannot tell one, nothing, or "unknown"; held-out data say what it is worth.

mod advice;
mod anomalies;
mod answer;
mod base;
mod channel;
mod coherence;
mod converter_step;
mod coupled;
mod criteria;
mod declared;
mod diagnose;
mod dial;
mod drivetrain;
mod engine;
mod expected_error;
mod fit;
mod hunting;
mod identify;
mod in_question;
mod input;
mod interpretation;
mod interval;
mod library;
mod linear;
mod model;
mod modelled;
mod next;
mod noise;
mod plausible;
mod problem;
mod recording;
mod refusal;
mod remainder;
mod rest;
mod saved_element;
mod segment;
mod signals;
mod specimen;
mod spectrum;
mod stamps;
mod travel;
mod unmeasured;
mod wear;
mod witness;

pub use answer::{
    ChannelAnswer, Correction, DependsOn, Errors, FoundEffect, FoundParameter, Line, Member,
    Nearest, Range, Refitted, Remainder, Share, Traces, Verdict,
};
pub use channel::ChannelModel;
pub use coupled::{
    CoordinateAnswer, CoupledDiagnosis, CoupledRecord, CoupledSpecimen, CoupledTraces,
    CoupledVerdict, MATRICES, WrongEntry, diagnose_coupled,
};
pub use declared::Declared;
pub use diagnose::{Diagnosis, diagnose};
pub use dial::{DialNumber, Dose, Turned, turned};
pub use identify::{Identified, identify};
pub use model::{ActuatorModel, ForceUnit, Model, RigLimits, SpecimenModel};
pub use next::{
    Form, Narrowed, Next, Origin, Outlook, Phase, Prediction, TestLimits, next, why_no_test,
};
pub use recording::{FEWEST_SAMPLES, Recording};
pub use refusal::Refusal;
pub use saved_element::SavedElement;
pub use stamps::{gaps, missing_rows, usual_interval_s};
pub use witness::{Heard, Other, Says, Testimony, Witnessed, testimonies};
