//! Sensors that stand still: with the same word for ever, or with their noise around one value.

use libm::sqrtf;

/// Blocks whose mean is looked at, and how many such means in a row.
const BLOCKS: u8 = 25;
const IN_A_ROW: u8 = 3;
/// The mean moves by less than this many of its standard deviations, and peaks, where the sensor stands.
const STANDS: f32 = 4.0;
const STANDS_PEAKS: f32 = 1e-3;
/// What it should have followed moves in each by at least so much, peaks.
const MOVES: f32 = 0.02;
/// Way there and back over which a force that never changed is no specimen's, peaks.
const THERE_AND_BACK: f32 = 0.05;
/// Equal words while what is measured moves by so much, peaks, and so many control steps.
const SAME_STEPS: u16 = 40;

/// What stands still.
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
    /// Means in a row in which displacement and force stood while the rest moved.
    stood: [u8; 2],
    /// Way that the displacement has gone either way while the force stood.
    ways: [f32; 2],
    /// The declared way when the words last changed.
    since: [f32; 2],
}

impl Frozen {
    /// Takes a block in: declared way, displacement and force in peaks, their noise a block, and for how many control steps
    /// the words have been the same.
    pub(super) fn add(
        &mut self,
        raw: [f32; 3],
        sigma: [f32; 2],
        same: [u16; 2],
    ) -> Option<Standing> {
        let [y, x, r] = raw;
        let follows = [y, x];
        for j in 0..2 {
            if same[j] < 4 {
                self.since[j] = follows[j];
            }
        }
        let moved = |j: usize| (follows[j] - self.since[j]).abs() > MOVES + 6.0 * sigma[0];
        if same[0] > SAME_STEPS && moved(0) {
            return Some(Standing::Displacement);
        }
        if same[1] > SAME_STEPS && moved(1) && r.abs() > 0.05 {
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

    fn judge(&mut self, means: [f32; 3], last: [f32; 3], sigma: [f32; 2]) -> Option<Standing> {
        let [dy, dx, dr] = core::array::from_fn(|j| means[j] - last[j]);
        // Of a difference of two means.
        let per_mean = sqrtf(2.0 / f32::from(BLOCKS));
        let still = |j: usize| STANDS * per_mean * sigma[j] + STANDS_PEAKS;
        let clearly = |j: usize| MOVES + 2.0 * still(j);
        // The force goes on with the motion: it is the reading that stands, not the ram.
        if dx.abs() < still(0) && dy.abs() > clearly(0) && dr.abs() > clearly(1).max(0.2 * dy.abs())
        {
            self.stood[0] += 1;
        } else if dx.abs() >= still(0) {
            self.stood[0] = 0;
        }
        if dr.abs() < still(1) && means[2].abs() > 0.05 {
            if dx.abs() > still(0) {
                self.stood[1] += 1;
                self.ways[usize::from(dx > 0.0)] += dx.abs();
            }
        } else {
            (self.stood[1], self.ways) = (0, [0.0; 2]);
        }
        let enough = |stood: u8| stood >= IN_A_ROW;
        let both_ways = self.ways.iter().all(|way| *way > THERE_AND_BACK);
        if enough(self.stood[0]) {
            Some(Standing::Displacement)
        } else if enough(self.stood[1]) && both_ways {
            Some(Standing::Force)
        } else {
            None
        }
    }
}
