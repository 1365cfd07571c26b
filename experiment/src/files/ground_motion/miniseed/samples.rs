//! Samples of a record, plain or compressed (FDSN: SEED Reference Manual, version 2.4, appendix B; the same codes in version 3).

/// Samples of this encoding are a converter's whole numbers.
pub(super) fn is_counts(encoding: u8) -> bool {
    !matches!(encoding, 4 | 5)
}

/// Bytes in their order.
pub(super) struct Reader<'a> {
    pub(super) bytes: &'a [u8],
    /// The first byte of a word is its highest.
    pub(super) big: bool,
}

impl Reader<'_> {
    pub(super) fn array<const N: usize>(&self, at: usize) -> Option<[u8; N]> {
        let mut array: [u8; N] = self.bytes.get(at..at + N)?.try_into().ok()?;
        if !self.big {
            array.reverse();
        }
        Some(array)
    }

    pub(super) fn u16(&self, at: usize) -> Option<u16> {
        self.array(at).map(u16::from_be_bytes)
    }

    pub(super) fn u32(&self, at: usize) -> Option<u32> {
        self.array(at).map(u32::from_be_bytes)
    }

    /// The samples: whole numbers, floating point, or differences, which are packed the first byte first unless told.
    pub(super) fn values(&self, encoding: u8, count: usize) -> Result<Vec<f64>, String> {
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
