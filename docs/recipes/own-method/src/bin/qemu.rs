//! The image for QEMU's `netduinoplus2`, with our method.
#![no_std]
#![no_main]

firmware::qemu_image!(own lab::METHODS);
