//! Frozen sensors: with the same word for ever, or with noise around one value.

use crate::float::{larger, smaller};
use libm::sqrtf;

/// Blocks in a mean, and how many such means in a row.
const BLOCKS: u8 = 25;
const IN_A_ROW: u8 = 3;
/// A sensor counts as frozen if its mean moves by less than this many of its standard deviations, plus this many peaks.
const STANDS: f32 = 4.0;
const STANDS_PEAKS: f32 = 1e-3;
/// Least motion of the signal that it should have followed, for each mean, peaks.
const MOVES: f32 = 0.02;
/// Travel there and back without a change of force that no specimen shows, peaks, and relative to what counts as still.
const THERE_AND_BACK: f32 = 0.05;
const TIMES_STILL: f32 = 3.0;
/// Control steps with equal words while the measured quantity moves.
const SAME_STEPS: u16 = 40;

/// An elastic specimen's force is frozen if it moves by at most so many deviations, plus peaks, over this travel.
const ELASTIC_DEVIATIONS: f32 = 6.0;
const ELASTIC_PEAKS: f32 = 2e-3;
const ELASTIC_WAY: f32 = 0.1;
/// A force below this may be inside a gap, peaks.
const IN_A_GAP: f32 = 0.05;

/// The frozen sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Standing {
    Displacement,
    Force,
}

/// Watches both sensors.
#[derive(Clone, Debug, Default)]
pub(super) struct Frozen {
    sums: [f32; 3],
    last: Option<[f32; 3]>,
    count: u8,
    /// Consecutive means in which displacement and force stood still while the rest moved.
    stood: [u8; 2],
    /// The force at which it last began to stand still, and the displacement since.
    from: f32,
    stands: Followed,
    /// The signal that each sensor should have followed since its word last changed (or since the start), and the force
    /// since the displacement word last changed.
    since: [Option<Followed>; 3],
    /// Displacement and force where the force of an elastic specimen last moved.
    elastic: Option<[f32; 2]>,
}

/// The range of a motion, and the distance travelled from either end.
#[derive(Clone, Copy, Debug, Default)]
struct Followed {
    span: [f32; 2],
    ways: [f32; 2],
}

impl Followed {
    fn from(at: f32) -> Self {
        Self {
            span: [at; 2],
            ways: [0.0; 2],
        }
    }

    fn to(&mut self, at: f32) {
        let [low, high] = self.span;
        self.span = [smaller(low, at), larger(high, at)];
        self.ways = [
            larger(self.ways[0], at - low),
            larger(self.ways[1], high - at),
        ];
    }

    /// True if it travelled further than `way` in one direction.
    fn went(&self, way: f32) -> bool {
        self.ways.iter().any(|own| *own > way)
    }

    /// True if it travelled that far both ways. On a yield plateau a force is constant only until the motion turns.
    fn came_back(&self, way: f32) -> bool {
        self.ways.iter().all(|own| *own > way)
    }
}

impl Frozen {
    /// Adds a block: declared displacement, displacement and force in peaks, their noise per block, and for how many
    /// control steps the words have been the same. `elastic`: the specimen has been here before, and was elastic.
    pub(super) fn add(
        &mut self,
        raw: [f32; 3],
        sigma: [f32; 2],
        same: [u16; 2],
        elastic: bool,
    ) -> Option<Standing> {
        let [y, x, r] = raw;
        if self.stands_elastic([x, r], sigma, elastic) {
            return Some(Standing::Force);
        }
        let follows = [y, x, r];
        let changed = [same[0] < 4, same[1] < 4, same[0] < 4];
        let [displacement, force, beside] = core::array::from_fn(|j| {
            let since = self.since[j].get_or_insert(Followed::from(follows[j]));
            if changed[j] {
                *since = Followed::from(follows[j]);
            }
            since.to(follows[j]);
            *since
        });
        let moves = MOVES + 6.0 * sigma[0];
        // If a ram rests, within its play or at the end of its stroke, its force rests, too.
        let goes_on = beside.went(MOVES + 6.0 * sigma[1]);
        if same[0] > SAME_STEPS && displacement.went(moves) && goes_on {
            return Some(Standing::Displacement);
        }
        if same[1] > SAME_STEPS && force.came_back(moves) && r.abs() > IN_A_GAP {
            return Some(Standing::Force);
        }
        for (sum, now) in self.sums.iter_mut().zip([y, x, r]) {
            *sum += now;
        }
        self.count += 1;
        if self.count < BLOCKS {
            return None;
        }
        let means = self.sums.map(|sum| sum / f32::from(BLOCKS));
        (self.sums, self.count) = ([0.0; 3], 0);
        let last = self.last.replace(means)?;
        self.judge(means, last, sigma)
    }

    /// True if the force of an elastic specimen stays constant during motion within its previous range.
    fn stands_elastic(&mut self, [x, r]: [f32; 2], sigma: [f32; 2], elastic: bool) -> bool {
        let [from_x, from_r] = *self.elastic.get_or_insert([x, r]);
        let noise = ELASTIC_DEVIATIONS * larger(sigma[0], sigma[1]) + ELASTIC_PEAKS;
        // In a gap there is no force to change.
        if !elastic || r.abs() < IN_A_GAP || (r - from_r).abs() > noise {
            self.elastic = Some([x, r]);
            return false;
        }
        (x - from_x).abs() > ELASTIC_WAY + 2.0 * noise
    }

    fn judge(&mut self, means: [f32; 3], last: [f32; 3], sigma: [f32; 2]) -> Option<Standing> {
        let [dy, dx, dr] = core::array::from_fn(|j| means[j] - last[j]);
        // For a difference of two means.
        let per_mean = sqrtf(2.0 / f32::from(BLOCKS));
        let still = |j: usize| STANDS * per_mean * sigma[j] + STANDS_PEAKS;
        let clearly = |j: usize| MOVES + 2.0 * still(j);
        // The force continues with the motion: the reading is frozen, not the ram.
        if dx.abs() < still(0) && dy.abs() > clearly(0) && dr.abs() > clearly(1).max(0.2 * dy.abs())
        {
            self.stood[0] = self.stood[0].saturating_add(1);
        } else if dx.abs() >= still(0) {
            self.stood[0] = 0;
        }
        let [_, x, r] = means;
        if (r - self.from).abs() < still(1) && r.abs() > IN_A_GAP {
            self.stands.to(x);
            if dx.abs() > still(0) {
                self.stood[1] = self.stood[1].saturating_add(1);
            }
        } else {
            self.stood[1] = 0;
            (self.from, self.stands) = (r, Followed::from(x));
        }
        let enough = |stood: u8| stood >= IN_A_ROW;
        let noise = larger(still(0), still(1));
        let both_ways = larger(THERE_AND_BACK, TIMES_STILL * noise);
        if enough(self.stood[0]) {
            Some(Standing::Displacement)
        } else if enough(self.stood[1]) && self.stands.came_back(both_ways) {
            Some(Standing::Force)
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The frozen sensor found in 60 s of 1 Hz motion of a specimen that yields at `yields`, with noise of `sigma` per
    /// block; if `stands`, the force reading freezes after 5 s.
    fn standing(sigma: f32, yields: f32, stands: bool) -> Option<Standing> {
        let mut frozen = Frozen::default();
        let (mut seed, mut plastic, mut kept) = (1_u32, 0.0_f32, 0.3);
        let mut noise = || {
            seed ^= seed << 13;
            seed ^= seed >> 17;
            seed ^= seed << 5;
            3.46 * sigma * ((seed >> 8) as f32 / 16_777_216.0 - 0.5)
        };
        let mut found = None;
        for i in 0..30_000 {
            let x = libm::sinf(i as f32 * 0.004 * core::f32::consts::PI);
            plastic = larger(smaller(plastic, x + yields), x - yields);
            if i < 2500 || !stands {
                kept = x - plastic;
            }
            let raw = [x, x + noise(), kept + noise()];
            found = found.or(frozen.add(raw, [sigma; 2], [0; 2], false));
        }
        found
    }

    #[test]
    fn a_force_that_stands_is_found_and_one_under_noise_or_on_a_plateau_is_not() {
        for sigma in [1e-4, 1e-3, 1e-2, 0.1, 0.6] {
            for yields in [9.0, 0.3] {
                assert_eq!(standing(sigma, yields, false), None, "{sigma} {yields}");
            }
        }
        for sigma in [1e-4, 1e-3, 1e-2] {
            assert_eq!(standing(sigma, 0.3, true), Some(Standing::Force), "{sigma}");
        }
    }

    #[test]
    fn an_elastic_force_that_does_not_move_stands_but_for_that_of_a_gap() {
        // From -0.4 on, with a gap, or with a force that freezes at 0.2.
        let found = |gap: f32, stands: bool, elastic: bool| {
            let mut frozen = Frozen::default();
            (0..800_u16).find_map(|i| {
                let x = -0.4 + 1e-3 * f32::from(i);
                let force = if stands { smaller(x, 0.2) } else { x };
                let in_gap = larger(smaller(force, gap), -gap);
                let noise = if i % 2 == 0 { 1e-4 } else { -1e-4 };
                let raw = [x, x, force - in_gap + noise];
                let standing = frozen.add(raw, [1e-4; 2], [0; 2], elastic);
                standing.map(|standing| (standing, x))
            })
        };
        let (standing, at) = found(0.0, true, true).expect("it stands");
        assert_eq!(standing, Standing::Force);
        assert!(at > 0.3 && at < 0.32, "{at}");
        assert_eq!(found(0.0, true, false), None, "it may yield");
        assert_eq!(found(0.0, false, true), None);
        assert_eq!(found(0.15, false, true), None, "a gap");
    }

    #[test]
    fn a_word_that_stays_on_a_plateau_is_no_sensor_that_stands_until_the_motion_has_come_back() {
        // On a coarse converter the force keeps its word while the displacement continues; then it turns.
        let standing = |turns: bool| {
            let mut frozen = Frozen::default();
            (0..80_u16).find_map(|i| {
                let way = f32::from(if turns && i > 40 { 80 - i } else { i });
                let x = -0.2 + 2e-3 * way;
                frozen.add([x, x, 0.3], [1e-4; 2], [0, 4 * i], false)
            })
        };
        assert_eq!(standing(false), None);
        assert_eq!(standing(true), Some(Standing::Force));
    }
}
