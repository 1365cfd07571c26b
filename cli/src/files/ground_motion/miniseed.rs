//! MiniSEED 2, as seismic networks hand it out: records of one channel, each with a header, its samples plain or
//! compressed by Steim's differences (FDSN: SEED Reference Manual, version 2.4, chapter 8 and appendix B).
//!
//! The file knows no unit. Physical values, such as ObsPy writes them once it has taken the instrument out, need `--unit`; the
//! counts of a recorder need its sensitivity, too, and have its zero in them, which is taken off as their mean.

use super::{Columns, Points};
use crate::failure::Failure;

/// Bytes of a record's header.
const HEADER: usize = 48;
/// Samples may come this share of an interval before or after their time.
const PUNCTUAL: f64 = 0.5;

/// True for what begins as a record does.
pub fn is_miniseed(bytes: &[u8]) -> bool {
    let digits = bytes
        .get(..6)
        .is_some_and(|d| d.iter().all(u8::is_ascii_digit));
    digits
        && matches!(bytes.get(6), Some(b'D' | b'R' | b'Q' | b'M'))
        && matches!(bytes.get(7), Some(b' ' | 0))
}

/// The one channel of a file, in the unit that is said beside it.
///
/// # Errors
/// A record that is cut or damaged, another channel, a gap, a unit or a sensitivity that is not said.
pub fn parse(file: &str, bytes: &[u8], columns: Columns) -> Result<Points, Failure> {
    let refuse = |number: usize, why: &str| {
        Failure::input(format!("{file}: record {number} of MiniSEED {why}"))
    };
    let (mut rest, mut number) = (bytes, 0);
    let mut whole: Option<Piece> = None;
    while !rest.is_empty() {
        number += 1;
        let (piece, length) = Piece::read(rest).map_err(|why| refuse(number, &why))?;
        rest = rest.get(length..).unwrap_or_default();
        match &mut whole {
            None => whole = Some(piece),
            Some(before) => before.append(piece).map_err(|why| refuse(number, &why))?,
        }
    }
    let Some(mut all) = whole.filter(|w| !w.values.is_empty()) else {
        return Err(refuse(
            number,
            "has no samples: accepted is a channel with some",
        ));
    };
    let Some(unit) = columns.unit else {
        return Err(Failure::input(format!(
            "{file}: is MiniSEED, which does not say its unit: accepted with --unit g|m/s2|gal{}",
            if all.counts {
                ", and with --sensitivity, counts for one of that unit"
            } else {
                ""
            }
        )));
    };
    if all.counts {
        if columns.sensitivity.is_none() {
            return Err(Failure::input(format!(
                "{file}: holds counts of a recorder and no accelerations: accepted with --sensitivity, counts for one {} (the \
                 station's metadata have it), or as values from which ObsPy has taken the instrument's response",
                unit.name()
            )));
        }
        let mean = all.values.iter().sum::<f64>() / all.values.len() as f64;
        all.values.iter_mut().for_each(|v| *v -= mean);
    }
    let in_si = unit.in_si() / columns.sensitivity.unwrap_or(1.0);
    Ok(Points {
        interval_s: 1.0 / all.rate_hz,
        acc_m_per_s2: all.values.iter().map(|v| v * in_si).collect(),
        unit: None,
    })
}

/// Samples of one channel without a gap.
struct Piece {
    /// Network, station, location and channel.
    channel: String,
    start_us: i64,
    rate_hz: f64,
    values: Vec<f64>,
    /// Whether they are a converter's whole numbers.
    counts: bool,
}

impl Piece {
    /// The first record of `bytes`, and its length.
    fn read(bytes: &[u8]) -> Result<(Self, usize), String> {
        let cut = || "is cut short: accepted are whole records".to_owned();
        let header = bytes.get(..HEADER).filter(|h| is_miniseed(h)).ok_or(
            "does not begin as one of version 2: accepted are such records alone; ObsPy rewrites what else there is",
        )?;
        let year = u16::from_be_bytes([header[20], header[21]]);
        let mut read = Reader {
            bytes,
            big: (1900..2100).contains(&year),
        };
        let word = |at| read.u16(at).ok_or_else(cut);
        let (mut next, data, count) = (word(46)?, word(44)?, word(30)?);
        let text = |range: std::ops::Range<usize>| {
            String::from_utf8_lossy(&header[range]).trim().to_owned()
        };
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
        if !(rate_hz.is_finite() && rate_hz > 0.0) {
            return Err(format!(
                "has a rate of {rate_hz} Hz: accepted are rates above 0"
            ));
        }
        read = Reader {
            bytes: samples,
            big: order == 1,
        };
        let values = read.values(encoding, usize::from(count))?;
        let counts = !matches!(encoding, 4 | 5);
        Ok((
            Self {
                channel,
                start_us,
                rate_hz,
                values,
                counts,
            },
            length,
        ))
    }

    /// What comes right after.
    fn append(&mut self, next: Self) -> Result<(), String> {
        if next.channel != self.channel {
            return Err(format!(
                "is of channel {} and those before it of {}: accepted is one channel; ObsPy selects it",
                next.channel, self.channel
            ));
        }
        if (next.rate_hz / self.rate_hz - 1.0).abs() > 1e-4 {
            return Err(format!(
                "has {} Hz, those before it {} Hz: accepted is one rate",
                next.rate_hz, self.rate_hz
            ));
        }
        let end_us = self.start_us as f64 + 1e6 * self.values.len() as f64 / self.rate_hz;
        let late_s = 1e-6 * (next.start_us as f64 - end_us);
        if late_s.abs() * self.rate_hz > PUNCTUAL {
            return Err(format!(
                "begins {late_s:.3} s after the end of what is before it: accepted are records without a gap"
            ));
        }
        self.values.extend(next.values);
        Ok(())
    }
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
    let years = i64::from(read.u16(20)?) - 1;
    let days = 365 * years + years / 4 - years / 100 + years / 400 + i64::from(read.u16(22)?);
    let [hour, minute, second] = [24, 25, 26].map(|at| i64::from(read.bytes[at]));
    // In units of 100 us, the correction too, unless it is in the time already.
    let corrected = read.bytes[36] & 2 != 0;
    let correction = if corrected {
        0
    } else {
        i64::from(read.u32(40)? as i32)
    };
    let seconds = ((days * 24 + hour) * 60 + minute) * 60 + second;
    Some(seconds * 1_000_000 + 100 * (i64::from(read.u16(28)?) + correction))
}

/// Bytes in their order.
struct Reader<'a> {
    bytes: &'a [u8],
    big: bool,
}

impl Reader<'_> {
    fn array<const N: usize>(&self, at: usize) -> Option<[u8; N]> {
        let mut array: [u8; N] = self.bytes.get(at..at + N)?.try_into().ok()?;
        if !self.big {
            array.reverse();
        }
        Some(array)
    }

    fn u16(&self, at: usize) -> Option<u16> {
        self.array(at).map(u16::from_be_bytes)
    }

    fn u32(&self, at: usize) -> Option<u32> {
        self.array(at).map(u32::from_be_bytes)
    }

    fn values(&self, encoding: u8, count: usize) -> Result<Vec<f64>, String> {
        let each = |read: &dyn Fn(usize) -> Option<f64>| {
            (0..count).map(read).collect::<Option<Vec<f64>>>()
        };
        match encoding {
            1 => each(&|i| self.u16(2 * i).map(|x| f64::from(x as i16))),
            3 => each(&|i| self.u32(4 * i).map(|x| f64::from(x as i32))),
            4 => each(&|i| self.u32(4 * i).map(|x| f64::from(f32::from_bits(x)))),
            5 => each(&|i| self.array(8 * i).map(f64::from_be_bytes)),
            10 | 11 => self.steim(encoding == 11, count),
            other => {
                return Err(format!(
                    "has encoding {other}: accepted are whole numbers, floating point, Steim 1 and Steim 2"
                ));
            }
        }
        .ok_or_else(|| format!("does not hold the {count} samples that it says"))
    }

    /// Differences from sample to sample in frames of sixteen words, the first of which says how the others are packed.
    /// The first and the last sample stand in the first frame; `None` where the differences do not lead there.
    fn steim(&self, second: bool, count: usize) -> Option<Vec<f64>> {
        if count == 0 {
            return Some(Vec::new());
        }
        let mut differences = Vec::with_capacity(count + 7);
        for frame in 0..self.bytes.len() / 64 {
            let packing = self.u32(64 * frame)?;
            for k in 1..16 {
                let word = self.u32(64 * frame + 4 * k)?;
                let code = packing >> (30 - 2 * k) & 3;
                let (many, bits) = match (code, second, word >> 30) {
                    (0, ..) => continue,
                    (1, ..) => (4, 8),
                    (2, false, _) => (2, 16),
                    (3, false, _) => (1, 32),
                    (2, true, 1) => (1, 30),
                    (2, true, 2) => (2, 15),
                    (2, true, 3) => (3, 10),
                    (3, true, 0) => (5, 6),
                    (3, true, 1) => (6, 5),
                    (3, true, 2) => (7, 4),
                    _ => return None,
                };
                // Right-justified, with the sign of each in its own first bit.
                let value = |j: u32| ((word >> (bits * j)) << (32 - bits)) as i32 >> (32 - bits);
                differences.extend((0..many).rev().map(value));
            }
        }
        let (first, last) = (self.u32(4)? as i32, self.u32(8)? as i32);
        let mut sample = first;
        let mut values = vec![f64::from(first)];
        // The first difference leads from the record before.
        for difference in differences.get(1..count)? {
            sample = sample.wrapping_add(*difference);
            values.push(f64::from(sample));
        }
        (sample == last).then_some(values)
    }
}
