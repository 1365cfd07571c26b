//! The benchmark problems of the field.

mod followed;
mod marths;
pub mod physical_part;
mod rths;

pub use followed::of_followed;
pub use marths::of_marths;
pub use rths::of_rths;
