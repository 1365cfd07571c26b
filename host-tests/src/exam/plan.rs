//! The records of an exam.

use exam::{Class, Options};
use std::ops::Range;

/// Seeds that may be looked at during development of the diagnosis.
pub const TUNING: Range<u64> = 0..100_000;
/// Seeds for reported figures; never looked at before.
pub const SEALED: Range<u64> = 1_000_000..1_100_000;

/// Sizes for the detection limit, in units of the channel's noise floor.
pub const DETECTION_SIZES: [f64; 7] = [0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0];

/// One record to be set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Item {
    /// Its class.
    pub class: Class,
    /// Its seed.
    pub seed: u64,
    /// Size of the effect, in units of the channel's noise floor, if the record is for the detection limit.
    pub detection: Option<f64>,
}

impl Item {
    /// Its options.
    pub fn options(&self) -> Options {
        let nominal = Options::default();
        match self.detection {
            None => nominal,
            Some(size) => Options {
                size: (size, 1.0001 * size),
                ..nominal
            },
        }
    }

    /// The record with this id, `class-seed`.
    ///
    /// # Errors
    /// A sentence: there is no such class, or the seed is not a number.
    pub fn from_id(id: &str) -> Result<Self, String> {
        let refused = || format!("record id `{id}`: expected CLASS-SEED, as in `unseen-12`");
        let (class, seed) = id.split_once('-').ok_or_else(refused)?;
        let class = Class::ALL.into_iter().find(|c| c.name() == class);
        Ok(Self {
            class: class.ok_or_else(refused)?,
            seed: seed.parse().map_err(|_| refused())?,
            detection: None,
        })
    }
}

/// The records of an exam.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Range of their seeds; every class starts at its beginning.
    pub seeds: Range<u64>,
    /// The records, in the order in which they are set.
    pub items: Vec<Item>,
}

impl Plan {
    /// As many records of each class as the targets need.
    pub fn full(seeds: Range<u64>) -> Self {
        Self::new(seeds, [320, 400, 1000, 90, 160, 80], 40)
    }

    /// A quick exam: every effect once by each set of equations.
    pub fn quick(seeds: Range<u64>) -> Self {
        Self::new(seeds, [40, 40, 40, 18, 12, 8], 0)
    }

    /// At most this many records of each class.
    pub fn at_most(mut self, records: u64) -> Self {
        let end = self.seeds.start.saturating_add(records);
        self.items.retain(|i| i.seed < end);
        self
    }

    fn new(seeds: Range<u64>, records: [u64; 6], detection: u64) -> Self {
        let of = |class, n: u64, detection| {
            let end = seeds.end.min(seeds.start + n);
            (seeds.start..end).map(move |seed| Item {
                class,
                seed,
                detection,
            })
        };
        let mut items: Vec<Item> = Class::ALL
            .into_iter()
            .zip(records)
            .flat_map(|(class, n)| of(class, n, None))
            .collect();
        for size in DETECTION_SIZES {
            items.extend(of(Class::Matched, detection, Some(size)));
        }
        Self { seeds, items }
    }

    /// Whether the range is tuning, sealed or neither, in words.
    pub fn kind(&self) -> &'static str {
        let inside = |r: &Range<u64>| r.start <= self.seeds.start && self.seeds.end <= r.end;
        if inside(&TUNING) {
            "tuning"
        } else if inside(&SEALED) {
            "sealed"
        } else {
            "neither tuning nor sealed"
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tuning_and_sealed_seeds_have_none_in_common() {
        assert!(!TUNING.contains(&SEALED.start) && !SEALED.contains(&TUNING.start));
        assert_eq!(Plan::quick(TUNING).kind(), "tuning");
        assert_eq!(Plan::quick(SEALED).kind(), "sealed");
    }

    #[test]
    fn a_full_exam_has_a_thousand_clean_records_and_ids_read_back() {
        let plan = Plan::full(TUNING);
        let clean = plan.items.iter().filter(|i| i.class == Class::Clean);
        assert_eq!(clean.count(), 1000);
        assert_eq!(Item::from_id("clean-17").unwrap(), plan.items[720 + 17]);
        assert!(Item::from_id("clean").is_err());
    }
}
