//! What is known of a channel before anything is searched: whether its records can be judged ([`plausible`], [`anomalies`]), what their
//! motion can tell ([`input`], [`wear`]), their noise ([`noise`], [`hunting`]), and what the declared model answers ([`problem`],
//! [`segment`], [`fit`], [`modelled`], [`known`]). The sentences of the notes stand in [`advice`].

pub mod advice;
pub mod anomalies;
pub mod fit;
pub mod hunting;
pub mod input;
pub mod known;
pub mod modelled;
pub mod noise;
pub mod plausible;
pub mod problem;
pub mod segment;
pub mod wear;
