//! Numbers that both ends of the link are built with.

/// Version of everything in this crate; a frame of another version is counted and ignored. A test holds the bytes of
/// every frame (`link/tests/golden.txt`): they change only together with this number.
pub const VERSION: u8 = 23;

/// Bits per second on the wire. The board's 42 MHz peripheral clock divides to it exactly, and so does the 36 MHz of the
/// ST-LINK that makes a USB port of it.
pub const BAUD: u32 = 1_000_000;

/// Bits on the wire for a byte: start, eight, stop.
pub const BITS_PER_BYTE: u32 = 10;

/// Actuators of a board, at most.
pub const MAX_ACTUATORS: usize = 3;
