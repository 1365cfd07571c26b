//! Uploads points to a board: announced with their checksum, then sent in chunks.

use super::connection::Connection;
use super::orders::done;
use super::port::Port;
use experiment::failure::Failure;
use link::Command;
use link::command::CHUNK;
use link::frame::checksum;

/// Sends a ground motion, or the points of a signal.
pub(super) fn load<P: Port>(
    board: &mut Connection<P>,
    points: &[f32],
    interval_s: f64,
) -> Result<(), Failure> {
    let announce = Command::Motion {
        points: points.len() as u32,
        interval_s,
        checksum: checksum(points.iter().flat_map(|p| p.to_le_bytes())),
    };
    done(board, "ground motion", &announce)?;
    for (first, chunk) in (0_u32..).step_by(CHUNK).zip(points.chunks(CHUNK)) {
        let points = chunk.iter().copied().collect();
        done(board, "ground motion", &Command::Points { first, points })?;
    }
    Ok(())
}
