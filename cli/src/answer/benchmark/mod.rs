//! The benchmark problems of the field.

mod goals;
mod marths;
pub mod physical_part;
mod rths;

pub use marths::{DeclaredPart, of_marths};
pub use rths::of_rths;
