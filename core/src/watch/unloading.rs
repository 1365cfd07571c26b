//! Samples of a specimen during unloading, which is elastic whatever happens under load.

use super::signals::Row;

/// Distance from an extreme that makes it a reversal, peaks.
const LEFT: f32 = 0.01;
/// Samples count if their force is between these fractions of that at the last reversal.
const SHARES: [f32; 2] = [0.94, 0.5];
/// Reversals at less force than this, stiffness times peak, do not count: friction dominates small motions.
const LEAST_FORCE: f32 = 0.1;

/// Data of the last reversal.
#[derive(Clone, Copy, Debug, Default)]
struct Extreme {
    x: f32,
    r: f32,
    acceleration: f32,
}

/// Finds reversals.
#[derive(Clone, Debug, Default)]
pub(super) struct Unloading {
    /// True while the displacement rises.
    rising: bool,
    furthest: Extreme,
    reversal: Option<Extreme>,
}

impl Unloading {
    /// Adds a row. During unloading: columns displacement, velocity, acceleration, sign of the velocity and cube of the
    /// displacement, counted from the reversal, and the force that the declared stiffness does not explain.
    pub(super) fn add(&mut self, row: &Row) -> Option<([f32; 5], f32)> {
        let sign = if self.rising { 1.0 } else { -1.0 };
        let x = row.x[0];
        if sign * (x - self.furthest.x) >= 0.0 {
            self.furthest = Extreme {
                x,
                r: row.r,
                acceleration: row.y[2],
            };
        } else if sign * (self.furthest.x - x) > LEFT {
            // A reversal near zero force also overwrites the one before it.
            let loaded = self.furthest.r * sign > LEAST_FORCE;
            self.reversal = loaded.then_some(self.furthest);
            self.rising = !self.rising;
            self.furthest = Extreme {
                x,
                r: row.r,
                acceleration: row.y[2],
            };
        }
        let from = self.reversal?;
        let share = row.r / from.r;
        if share < SHARES[1] {
            self.reversal = None;
            return None;
        }
        if share > SHARES[0] {
            return None;
        }
        let way = x - from.x;
        // Friction has changed sign: twice its force.
        let rub = if self.rising { 2.0 } else { -2.0 };
        let bend = x * x * x - from.x * from.x * from.x;
        let columns = [way, row.x[1], row.y[2] - from.acceleration, rub, bend];
        Some((columns, row.r - from.r - way))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples, and the largest departure of their slope from the declared stiffness, for a force `r(x)` along a path.
    fn slopes(force: impl FnMut(f32) -> f32) -> (usize, f32) {
        let mut force = force;
        let mut unloading = Unloading::default();
        let (mut n, mut worst) = (0, 0.0_f32);
        for i in 0..2000 {
            let x = libm::sinf(i as f32 * 0.02) * (0.2 + i as f32 * 4e-4);
            let row = Row {
                x: [x, 0.0],
                r: force(x),
                ..Row::default()
            };
            if let Some((columns, beyond)) = unloading.add(&row) {
                n += 1;
                worst = worst.max((beyond / columns[0]).abs());
            }
        }
        (n, worst)
    }

    #[test]
    fn a_specimen_that_yields_unloads_with_its_elastic_slope() {
        let (mut plastic, mut last) = (0.0_f32, 0.0);
        let (n, worst) = slopes(|x| {
            plastic = plastic.max(x - 0.3).min(x + 0.3);
            last = 0.05 * x + 0.95 * (x - plastic);
            last
        });
        // The kinematic hardening of 5 % is part of the elastic slope.
        assert!(n > 60 && worst < 0.02, "{n} samples, {worst}");
        let (n, worst) = slopes(|x| 0.7 * x);
        assert!(n > 60 && (worst - 0.3).abs() < 0.02, "{n} samples, {worst}");
    }
}
