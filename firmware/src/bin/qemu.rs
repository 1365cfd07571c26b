//! The image for QEMU's `netduinoplus2`: one session with the PC over the emulator's standard input and output.
//!
//! Exit status: 0 session closed by the PC, 1 the PC disappeared, 2 panic, 3 fault.

#![no_std]
#![no_main]

firmware::qemu_image!();
