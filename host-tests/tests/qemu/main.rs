//! The image for QEMU and those for the boards: what they compute, how long they take, and what is in them.
#![allow(missing_docs)]

mod board_image;
mod cost;
mod coupled;
mod cycles;
mod methods;
mod proofs;
mod same_bits;
mod watched;
