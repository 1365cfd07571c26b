//! Records of test rigs that do something their declared model does not say, and the keys to them.
//!
//! This crate is separate on purpose: it shares no equations with the code it examines, neither with the repository's
//! simulated rigs nor with the diagnosis. Everything is computed here on an 8 kHz grid, from the commanded trajectory to the
//! codes of the converter.
//!
//! ```text
//! excitation ─► command ─► gain, delay, lag ─► effects ─► displacement ─► k, c, m ─► effects ─► force
//!                                                              │                                  │
//!                                                  noise, effects of the reading, bits   (the same)
//!                                                              ▼                                  ▼
//!                       Paper: declared model + training record + test record        Key: what was hidden
//! ```
//!
//! [`set`] makes one [`Case`] from a class and a seed. Units: mm, N, s, kg.
//!
//! An effect follows either [`Equations::Matched`], the textbook form in the effect list, or [`Equations::Unseen`],
//! another model of the same physics (LuGre for Coulomb, Iwan for a bilinear element, two Maxwell branches for one, ...).

pub mod aims;
mod case;
mod class;
mod declared;
pub mod devices;
mod draws;
pub mod effect;
mod excitation;
pub mod field;
mod fine;
mod key;
mod lab;
mod measure;
mod noise;
mod outside;
mod question;
mod record;
pub mod reliability;
mod rig;
mod size;

pub use case::{Case, Paper, hides, set};
pub use class::{Class, Options};
pub use declared::{Declared, DeclaredActuator, DeclaredSpecimen, Parameter};
pub use effect::{Channel, Equations};
pub use excitation::Excitation;
pub use key::{ChannelKey, Hidden, Key};
pub use record::Record;
