//! Records of version 3 (FDSN: miniSEED 3, 2023): a header of 40 bytes with a check sum, an identifier, extra headers, samples.
//! Everything has its lowest byte first, but for Steim's frames.

use super::piece::{Piece, cut, seconds_us};
use super::samples::{Reader, is_counts};
use crc::{CRC_32_ISCSI, Crc};

/// Bytes of a record's header before the identifier.
const HEADER: usize = 40;
/// Where the check sum stands, four bytes.
const CHECK: usize = 28;
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISCSI);

/// True for what begins as a record does.
pub(super) fn begins(bytes: &[u8]) -> bool {
    bytes.starts_with(b"MS\x03")
}

/// The first record of `bytes`, and its length.
pub(super) fn read(bytes: &[u8]) -> Result<(Piece, usize), String> {
    let header = bytes.get(..HEADER).ok_or_else(cut)?;
    let reader = |bytes, big| Reader { bytes, big };
    let read = reader(header, false);
    let (half, word) = (
        |at| read.u16(at).ok_or_else(cut),
        |at| read.u32(at).ok_or_else(cut),
    );
    let (identifier, extra) = (usize::from(header[33]), usize::from(half(34)?));
    let samples = HEADER + identifier + extra;
    let length = samples + word(36)? as usize;
    let record = bytes.get(..length).ok_or_else(cut)?;
    let mut digest = CRC.digest();
    digest.update(&record[..CHECK]);
    digest.update(&[0; 4]);
    digest.update(&record[CHECK + 4..]);
    if digest.finalize() != word(CHECK)? {
        return Err("is damaged: its check sum is another one; accepted are whole records".into());
    }
    let [hour, minute, second] = [12, 13, 14].map(|at| i64::from(header[at]));
    let at = [
        i64::from(half(8)?),
        i64::from(half(10)?),
        hour,
        minute,
        second,
    ];
    let stored = read.array(16).map(f64::from_be_bytes).ok_or_else(cut)?;
    let encoding = header[15];
    let steim = matches!(encoding, 10 | 11);
    let values = reader(&record[samples..], steim).values(encoding, word(24)? as usize)?;
    let channel = String::from_utf8_lossy(&record[HEADER..HEADER + identifier]).into_owned();
    Ok((
        Piece {
            channel,
            start_us: seconds_us(at) + i64::from(word(4)?) / 1000,
            // Below zero it is the interval, s.
            rate_hz: if stored < 0.0 { -1.0 / stored } else { stored },
            values,
            counts: is_counts(encoding),
        },
        length,
    ))
}
