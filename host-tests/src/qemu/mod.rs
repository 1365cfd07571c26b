//! The image of the firmware in QEMU, with the rig in this process.
//!
//! A test that needs an image asks [`image::image`] for it. If there is no compiler for the target or no emulator, the test
//! says so and is not run; with `OUTERLOOP_REQUIRE_QEMU` set, as `scripts/test --all` does, it fails.

pub mod bench;
pub mod cycles;
pub mod image;
pub mod machine;
pub mod most_expensive;
pub mod profile;
pub mod spent;
pub mod traced;
