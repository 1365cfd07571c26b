//! Records of version 2 (FDSN: SEED Reference Manual, version 2.4, chapter 8): a header of 48 bytes, blockettes, samples; in
//! all a power of two.

use super::piece::{Piece, cut, seconds_us};
use super::samples::{Reader, is_counts};

/// Bytes of a record's header.
const HEADER: usize = 48;

/// True for what begins as a record does.
pub(super) fn begins(bytes: &[u8]) -> bool {
    let digits = bytes
        .get(..6)
        .is_some_and(|d| d.iter().all(u8::is_ascii_digit));
    digits
        && matches!(bytes.get(6), Some(b'D' | b'R' | b'Q' | b'M'))
        && matches!(bytes.get(7), Some(b' ' | 0))
}

/// The first record of `bytes`, and its length.
pub(super) fn read(bytes: &[u8]) -> Result<(Piece, usize), String> {
    let header = bytes.get(..HEADER).ok_or_else(cut)?;
    let year = u16::from_be_bytes([header[20], header[21]]);
    let mut read = Reader {
        bytes,
        big: (1900..2100).contains(&year),
    };
    let word = |at| read.u16(at).ok_or_else(cut);
    let (mut next, data, count) = (word(46)?, word(44)?, word(30)?);
    let text =
        |range: std::ops::Range<usize>| String::from_utf8_lossy(&header[range]).trim().to_owned();
    let channel = [text(18..20), text(8..13), text(13..15), text(15..18)].join(".");
    let mut rate_hz = rate(word(32)? as i16, word(34)? as i16);
    let mut start_us = start_us(&read).ok_or_else(cut)?;
    let mut format = None;
    for _ in 0..read.bytes[39] {
        let at = usize::from(next);
        match read.u16(at).ok_or_else(cut)? {
            100 => rate_hz = f64::from(f32::from_bits(read.u32(at + 4).ok_or_else(cut)?)),
            1000 => format = bytes.get(at + 4..at + 7),
            1001 => start_us += i64::from(*bytes.get(at + 5).ok_or_else(cut)? as i8),
            _ => {}
        }
        next = read.u16(at + 2).ok_or_else(cut)?;
    }
    let [encoding, order, exponent] =
        *format.ok_or("has no blockette 1000, which says its encoding")?
    else {
        return Err(cut());
    };
    let length = 1_usize << exponent.min(30);
    let samples = bytes
        .get(..length)
        .and_then(|r| r.get(usize::from(data)..))
        .ok_or_else(cut)?;
    read = Reader {
        bytes: samples,
        big: order == 1,
    };
    let values = read.values(encoding, usize::from(count))?;
    let counts = is_counts(encoding);
    Ok((
        Piece {
            channel,
            start_us,
            rate_hz,
            values,
            counts,
        },
        length,
    ))
}

/// The rate of a factor and a multiplier, of which a negative one divides.
fn rate(factor: i16, multiplier: i16) -> f64 {
    let power = |x: i16| {
        if x < 0 {
            -1.0 / f64::from(x)
        } else {
            f64::from(x)
        }
    };
    power(factor) * power(multiplier)
}

/// The first sample's time, us since the year 1.
fn start_us(read: &Reader<'_>) -> Option<i64> {
    let [hour, minute, second] = [24, 25, 26].map(|at| i64::from(read.bytes[at]));
    let (year, day) = (i64::from(read.u16(20)?), i64::from(read.u16(22)?));
    // In units of 100 us, the correction too, unless it is in the time already.
    let corrected = read.bytes[36] & 2 != 0;
    let correction = if corrected {
        0
    } else {
        i64::from(read.u32(40)? as i32)
    };
    let second_us = seconds_us([year, day, hour, minute, second]);
    Some(second_us + 100 * (i64::from(read.u16(28)?) + correction))
}
