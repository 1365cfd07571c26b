//! What a board is made of. Nothing here knows the algorithm.
//!
//! An image is for one board, and [`this`] is the one that the features name.

#[cfg(all(target_os = "none", feature = "nucleo-f429zi"))]
pub mod nucleo_f429zi;

#[cfg(all(target_os = "none", feature = "nucleo-f429zi"))]
pub use nucleo_f429zi as this;

#[cfg(all(target_os = "none", feature = "qemu"))]
pub mod qemu;
