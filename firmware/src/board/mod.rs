//! What a board is made of. Nothing here knows the algorithm.

#[cfg(feature = "nucleo-f429zi")]
mod image;

#[cfg(target_os = "none")]
pub mod stack;

#[cfg(all(target_os = "none", feature = "nucleo-f429zi"))]
pub mod nucleo_f429zi;

#[cfg(all(target_os = "none", feature = "nucleo-f429zi"))]
pub mod nucleo_f429zi_16;

#[cfg(all(target_os = "none", feature = "nucleo-f429zi"))]
pub mod nucleo_f429zi_3;

#[cfg(all(target_os = "none", feature = "qemu"))]
pub mod qemu;
