//! Slots in flash: each saving takes the next, and the largest sequence number counts.
//!
//! There are two sectors. When one is full, the other is erased and used next, so the last good record is never the one
//! being erased: a power failure at any moment costs at most the saving in progress.

use super::settings::{FlashRecord, MARK, NUMBERED};

/// Flash as seen by the slots.
pub trait Flash {
    /// Reads from `offset` on.
    fn read(&self, offset: u32, bytes: &mut [u8]);

    /// Writes at `offset`, which must be erased.
    fn write(&mut self, offset: u32, bytes: &[u8]) -> impl Future<Output = bool>;

    /// Erases the sector that begins at `offset`.
    fn erase(&mut self, offset: u32, bytes: u32) -> impl Future<Output = bool>;
}

/// Two sectors of slots of `BYTES`.
#[derive(Clone, Copy, Debug)]
pub struct Ring<const BYTES: usize> {
    /// Start of each sector.
    pub sectors: [u32; 2],
    /// Their length.
    pub sector_bytes: u32,
    /// Spacing of the slots, at least `BYTES`.
    pub slot_bytes: u32,
}

impl<const BYTES: usize> Ring<BYTES> {
    /// The last saved record; `None` if it was whole once but is damaged: an older one must not take its place.
    pub fn load<T: FlashRecord<BYTES>>(&self, flash: &impl Flash) -> Option<T> {
        let (slot, sequence, kept) = self.newest(flash)?;
        let is_last = !T::MARKED || !self.has_lost::<T>(flash, (slot, sequence));
        is_last.then_some(kept)
    }

    /// True if the record in `slot` was followed by another whole one that is now damaged: in its sector, or as the
    /// first of the other one, by its number.
    fn has_lost<T: FlashRecord<BYTES>>(
        &self,
        flash: &impl Flash,
        (slot, sequence): (u32, u32),
    ) -> bool {
        self.sectors.into_iter().any(|sector| {
            let is_here = (sector..sector + self.sector_bytes).contains(&slot);
            let mut behind = self.slots(sector).filter(|&other| match is_here {
                true => other > slot,
                false => other == sector,
            });
            behind.any(|other| {
                let mut head = [0; NUMBERED];
                flash.read(other, &mut head);
                let is_next = T::sequence(&head) == Some(sequence.wrapping_add(1));
                let may_be = if is_here {
                    head != [0xff; NUMBERED]
                } else {
                    is_next
                };
                may_be && {
                    let bytes = self.read(flash, other);
                    let was_whole = !bytes.ends_with(&[0xff; MARK]);
                    was_whole && T::decode(&bytes).is_none()
                }
            })
        })
    }

    /// Saves `kept` in the next slot; returns whether it reads back as written.
    pub async fn save<T: FlashRecord<BYTES>>(&self, flash: &mut impl Flash, kept: &T) -> bool {
        let last = self.newest::<T>(flash);
        let sequence = last
            .as_ref()
            .map_or(0, |(_, sequence, _)| sequence.wrapping_add(1));
        let Some(bytes) = kept.encode(sequence) else {
            return false;
        };
        let [one, other] = self.sectors;
        // Whether the last one lies in the second sector.
        let second = last
            .as_ref()
            .is_some_and(|(slot, _, _)| (other..other + self.sector_bytes).contains(slot));
        let (here, there) = if second { (other, one) } else { (one, other) };
        let behind = last.map_or(here, |(slot, _, _)| slot + self.slot_bytes);
        let free = self
            .slots(here)
            .find(|&slot| slot >= behind && self.is_erased(flash, slot));
        let slot = match free {
            Some(slot) => slot,
            None => {
                if !flash.erase(there, self.sector_bytes).await {
                    return false;
                }
                there
            }
        };
        let written = flash.write(slot, &bytes).await && self.read(flash, slot) == bytes;
        if written && T::MARKED {
            let mark = slot + BYTES as u32 - MARK as u32;
            return flash.write(mark, &[0; MARK]).await;
        }
        written
    }

    /// Starts at a sector's end, and reads no older record in full: checking a full sector's sums would keep the tasks
    /// longer than step reports can wait.
    #[inline(never)] // Only one copy in an image, for load and save.
    fn newest<T: FlashRecord<BYTES>>(&self, flash: &impl Flash) -> Option<(u32, u32, T)> {
        let mut newest: Option<(u32, u32, T)> = None;
        for slot in self
            .sectors
            .into_iter()
            .flat_map(|sector| self.slots(sector).rev())
        {
            let mut head = [0; NUMBERED];
            flash.read(slot, &mut head);
            let sequence = T::sequence(&head);
            if sequence.is_none() || sequence <= newest.as_ref().map(|(_, last, _)| *last) {
                continue;
            }
            let Some((sequence, kept)) = T::decode(&self.read(flash, slot)) else {
                continue;
            };
            newest = Some((slot, sequence, kept));
        }
        newest
    }

    fn slots(&self, sector: u32) -> impl DoubleEndedIterator<Item = u32> + use<BYTES> {
        (sector..sector + self.sector_bytes).step_by(self.slot_bytes as usize)
    }

    #[inline(never)] // As `newest`.
    fn read(&self, flash: &impl Flash, slot: u32) -> [u8; BYTES] {
        let mut bytes = [0; BYTES];
        flash.read(slot, &mut bytes);
        bytes
    }

    fn is_erased(&self, flash: &impl Flash, slot: u32) -> bool {
        self.read(flash, slot).iter().all(|&b| b == 0xff)
    }
}

#[cfg(test)]
mod tests {
    use super::super::settings::{CALIBRATION_BYTES, Wiring};
    use super::*;
    use crate::sim::CODES;
    use core::cell::Cell;
    use core::pin::pin;
    use core::task::{Context, Poll, Waker};
    use link::Calibration;

    /// Flash whose power fails after some words have been written or erased; bits only fall until erased.
    #[derive(Clone)]
    struct Array {
        bytes: Vec<u8>,
        words_left: usize,
        bytes_read: Cell<usize>,
    }

    impl Flash for Array {
        fn read(&self, offset: u32, bytes: &mut [u8]) {
            self.bytes_read.update(|read| read + bytes.len());
            bytes.copy_from_slice(&self.bytes[offset as usize..][..bytes.len()]);
        }

        async fn write(&mut self, offset: u32, bytes: &[u8]) -> bool {
            for (place, word) in self.bytes[offset as usize..]
                .chunks_exact_mut(4)
                .zip(bytes.chunks(4))
            {
                if self.words_left == 0 {
                    return false;
                }
                self.words_left -= 1;
                for (b, new) in place.iter_mut().zip(word) {
                    *b &= new;
                }
            }
            true
        }

        async fn erase(&mut self, offset: u32, bytes: u32) -> bool {
            for word in self.bytes[offset as usize..][..bytes as usize].chunks_exact_mut(4) {
                if self.words_left == 0 {
                    return false;
                }
                self.words_left -= 1;
                word.fill(0xff);
            }
            true
        }
    }

    const RING: Ring<CALIBRATION_BYTES> = Ring {
        sectors: [0, 512],
        sector_bytes: 512,
        slot_bytes: 64,
    };

    fn wiring(number: u16) -> Wiring {
        let mut calibration = Calibration::nominal(&CODES);
        calibration.force.zero_code = f32::from(number);
        Wiring::new(calibration, &CODES, 1)
    }

    /// Saves; nothing here ever waits.
    fn save(flash: &mut Array, number: u16) -> bool {
        let wiring = wiring(number);
        let mut saving = pin!(RING.save(flash, &wiring));
        match saving
            .as_mut()
            .poll(&mut Context::from_waker(Waker::noop()))
        {
            Poll::Ready(saved) => saved,
            Poll::Pending => panic!("it waits"),
        }
    }

    fn blank() -> Array {
        Array {
            bytes: vec![0xff; 1024],
            words_left: usize::MAX,
            bytes_read: Cell::new(0),
        }
    }

    #[test]
    fn of_a_full_sector_one_record_is_read_whole() {
        let mut flash = blank();
        for number in 0..8 {
            assert!(save(&mut flash, number));
        }
        flash.bytes_read.set(0);
        assert_eq!(RING.load(&flash), Some(wiring(7)));
        // The first slot of the other sector could hold a later record.
        assert_eq!(flash.bytes_read.get(), 17 * NUMBERED + CALIBRATION_BYTES);
    }

    #[test]
    fn the_last_one_counts_through_many_turns_of_both_sectors() {
        let mut flash = blank();
        assert_eq!(RING.load::<Wiring>(&flash), None);
        for number in 0..100 {
            assert!(save(&mut flash, number));
            assert_eq!(RING.load(&flash), Some(wiring(number)));
        }
    }

    /// A bit of the record in force flips: the board then counts as uncalibrated until someone calibrates it.
    #[test]
    fn a_record_that_was_whole_and_is_damaged_has_no_older_one_take_its_place() {
        let mut flash = blank();
        for number in 0..20_u32 {
            assert!(save(&mut flash, number as u16));
            let slot = (0..16).map(|s| s * 64).find(|&s| {
                let head = &flash.bytes[s..s + NUMBERED];
                <Wiring as FlashRecord<CALIBRATION_BYTES>>::sequence(head) == Some(number)
            });
            let slot = slot.unwrap();
            for bit in 0..42 * 8 {
                let mut damaged = flash.clone();
                damaged.bytes[slot + bit / 8] ^= 1 << (bit % 8);
                let kept = RING.load::<Wiring>(&damaged);
                // If a sector has just begun, only the number says that it is newer.
                let is_known = bit >= NUMBERED * 8 || !slot.is_multiple_of(512);
                let older = number.checked_sub(1).map(|n| wiring(n as u16));
                assert!(
                    kept.is_none() || (!is_known && kept == older),
                    "{number}, bit {bit}: {kept:?}"
                );
                assert!(save(&mut damaged, 999));
                if is_known {
                    assert_eq!(
                        RING.load(&damaged),
                        Some(wiring(999)),
                        "{number}, bit {bit}"
                    );
                }
            }
        }
    }

    #[test]
    fn power_that_fails_at_any_word_leaves_the_old_one_or_the_new_and_the_next_saving_works() {
        let mut flash = blank();
        for number in 0..40 {
            // A saving with an erasure takes at most 128 + 16 words.
            for words in 0..150 {
                let mut cut = flash.clone();
                cut.words_left = words;
                let saved = save(&mut cut, number + 1);
                let kept = RING.load(&cut);
                let old = (number > 0).then(|| wiring(number));
                assert!(
                    kept == Some(wiring(number + 1)) || (!saved && kept == old),
                    "{words} words: {kept:?}"
                );
                cut.words_left = usize::MAX;
                assert!(save(&mut cut, 999), "after a cut at word {words}");
                assert_eq!(RING.load(&cut), Some(wiring(999)));
            }
            assert!(save(&mut flash, number + 1));
        }
    }
}
