//! Power on, until the driver ends the run.

use crate::gaps::Guarded;
use crate::nucleo::Nucleo;
use rigless::emulator::{Driver, Start};
use rigless::image::Image;
use rigless::session::Session;
use rigless::time::VirtualNanos;

/// Runs the flashed images on a board until `driver`, the laboratory around it, ends the run.
///
/// # Errors
/// A sentence: the board's description or the image is inconsistent.
pub fn run(
    board: Nucleo,
    flashed: &[Image],
    driver: impl Driver<Nucleo> + 'static,
) -> Result<(), String> {
    run_boxed(board, flashed, Box::new(driver))
}

/// The emulator's session is generic over its driver: with a boxed one it is compiled once here, not in each program and test
/// that runs a board.
fn run_boxed(
    board: Nucleo,
    flashed: &[Image],
    driver: Box<dyn Driver<Nucleo>>,
) -> Result<(), String> {
    let mut session =
        Session::new(Box::new(board), 0, VirtualNanos(1)).map_err(|e| e.to_string())?;
    let driver = Guarded::new(&mut session, driver);
    let start = Start::new(flashed);
    rigless::emulator::run(session, &start, driver)
        .map(drop)
        .map_err(|e| e.to_string())
}
