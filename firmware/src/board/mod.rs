//! The parts of a board. Nothing here knows the algorithm.
//!
//! An image is for one board, and [`this`] is the one selected by the features.

#[cfg(all(target_os = "none", feature = "nucleo-f429zi"))]
pub mod nucleo_f429zi;

#[cfg(all(target_os = "none", feature = "nucleo-f429zi"))]
pub use nucleo_f429zi as this;

#[cfg(all(target_os = "none", feature = "qemu"))]
pub mod qemu;
