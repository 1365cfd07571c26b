//! What is known of a channel before the search: whether its records can be judged ([`plausible`], [`anomalies`]), what
//! their motion can tell ([`input`], [`wear`]), their noise ([`noise`], [`hunting`]), and the declared model's response
//! ([`problem`], [`segment`], [`fit`], [`modelled`], [`known`]). [`advice`] has the wording of the notes.

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
