//! The multi-axial benchmark problem of real-time hybrid simulation, in f64.
//!
//! Condori Uribe, Salmeron, Patino, Montoya, Dyke, Silva, Maghareh, Najarian and Montoya, "Experimental benchmark control
//! problem for multi-axial real-time hybrid simulation", Frontiers in Built Environment 9 (2023) 1270996. A plane frame of
//! 29 degrees of freedom, of which one bay stands in the laboratory; two actuators on a coupler give its corner a
//! translation and a rotation.
//!
//! ```text
//!  ground ─► numerical part ─► x, theta ─► controller ─► two commands ─► plant ─► two strokes ─► noise
//!                  ▲                                                                              │
//!                  └───────────── force and moment ◄── frame ◄── x, theta ◄── controller ◄────────┘
//! ```
//!
//! | look in | for |
//! |---|---|
//! | [`structure`] | the reference, what is declared physical, and the numerical rest |
//! | [`frame`] | the frame that answers in the laboratory |
//! | [`rig`] | the 2 x 2 plant with its drawn uncertainties, noise and limits |
//! | [`controller`] | the contestants: from the problem, from the literature, from core |
//! | [`trial`] | the closed loop, and what it leaves |
//! | [`criteria`] | J1 to J9 |
//! | [`mod@bench`] | every controller under every record, on the nominal and on drawn plants |
//! | [`follow`] | a controller from outside as a table of commands |
//! | [`declared`] | what the declared physical part costs, and the record that tells what is wrong in it |
//!
//! The problem's own files give the structure, the plant and the geometry; its Simulink model is not among them. What
//! that left open is stated where it was decided: the derivatives of the strokes behind damping and inertia ([`frame`]),
//! the sign of the rotation ([`SIGN`]), and the order of a sample ([`trial`]).

pub mod bench;
pub mod contestants;
pub mod controller;
pub mod criteria;
pub mod declared;
pub mod follow;
pub mod frame;
pub mod regression;
pub mod rig;
pub mod structure;
pub mod table;
pub mod trial;

/// Sampling rate of the problem, Hz.
pub const RATE_HZ: f64 = 1024.0;
/// Sampling period, s.
pub const PERIOD_S: f64 = 1.0 / RATE_HZ;
/// What a ground motion is multiplied by.
pub const GROUND_SCALE: f64 = 0.4;
/// A rotation of the rig per rotation of the structure. The coupler counts them against each other: with the other sign the
/// loop with a perfect tracker is 58 % off, with this one 9.8 %, as others found.
pub const SIGN: f64 = -1.0;
