//! A specimen's motion and its forces: the displacement without its noise ([`band`], [`curvature`], [`track`]), the
//! force of an [`element`] of free strength ([`laws`], [`shape`], [`kind`]), and its parameters by name ([`figures`]).

mod band;
mod curvature;
pub(crate) mod element;
pub(crate) mod figures;
mod fit;
mod kind;
mod laws;
mod shape;
pub(crate) mod track;

pub use figures::{GAINED, KNEE, PINCHED, STIFFNESS_BEYOND, WORN_TRAVEL};
pub use fit::SpecimenFit;
pub(crate) use shape::{BEGINS, Scale};
pub use track::DECLARED;
