//! Play between actuator and specimen: way without force, whatever the specimen does otherwise.

/// Forces, of stiffness times peak, between which the way without force and the ways beside it are compared.
const FORCE: f32 = 0.07;
/// Crossings in a row, and the least play of each, peaks.
const CROSSINGS: u8 = 4;
const LEAST: f32 = 0.008;

/// The levels that a crossing passes, in the direction from which it comes.
const LEVELS: [f32; 4] = [2.0 * FORCE, FORCE, -FORCE, -2.0 * FORCE];
/// A force that rises again by this while it falls is no crossing.
const TURNS: f32 = 0.5 * FORCE;

/// Measures the way at every crossing of zero force.
#[derive(Clone, Debug, Default)]
pub(super) struct Play {
    /// Sign of the force from which it comes; 0 before it has been large, or after a turn.
    sign: f32,
    /// Displacement at the levels that have been passed.
    at: [f32; 4],
    passed: usize,
    last: [f32; 2],
    crossings: u8,
    /// Mean play of the crossings in a row, peaks.
    width: f32,
}

impl Play {
    /// Takes displacement and force in, peaks. Gives the width of a play, peaks, when it is certain.
    pub(super) fn add(&mut self, x: f32, r: f32) -> Option<f32> {
        let [last_x, last_r] = core::mem::replace(&mut self.last, [x, r]);
        let (now, before) = (r * self.sign, last_r * self.sign);
        while self.sign != 0.0 && self.passed < 4 && now <= LEVELS[self.passed] {
            let fall = before - now;
            let share = if fall > 0.0 {
                ((before - LEVELS[self.passed]) / fall).clamp(0.0, 1.0)
            } else {
                1.0
            };
            self.at[self.passed] = last_x + share * (x - last_x);
            self.passed += 1;
        }
        if self.passed == 4 {
            self.judge();
        } else if (1..4).contains(&self.passed) && now > LEVELS[self.passed - 1] + TURNS {
            self.sign = 0.0;
        }
        if r.abs() >= LEVELS[0] {
            let sign = if r > 0.0 { 1.0 } else { -1.0 };
            if sign != self.sign || self.passed == 4 {
                (self.sign, self.passed) = (sign, 0);
            }
        }
        (self.crossings >= CROSSINGS).then_some(self.width)
    }

    /// The way between the inner levels, less what the slopes beside it explain.
    fn judge(&mut self) {
        let [a, b, c, d] = self.at;
        let play = (b - c).abs() - (a - b).abs() - (c - d).abs();
        if play > LEAST {
            self.crossings = self.crossings.saturating_add(1);
            let share = 1.0 / f32::from(self.crossings.min(CROSSINGS));
            self.width += share * (play - self.width);
        } else {
            (self.crossings, self.width) = (0, 0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(width: f32, yields: f32) -> Option<f32> {
        let mut play = Play::default();
        let mut plastic = 0.0_f32;
        let mut answer = None;
        for i in 0..8000 {
            let t = i as f32 * 0.01;
            let x = (1.0 - libm::expf(-t)) * libm::sinf(t);
            // A gap at zero force in series with a specimen that yields.
            plastic = plastic
                .max(x - 0.5 * width - yields)
                .min(x + 0.5 * width + yields);
            let u = x - plastic;
            let r = u - u.clamp(-0.5 * width, 0.5 * width);
            let noise = 0.002 * libm::sinf(517.3 * t);
            answer = play.add(x, r + noise);
        }
        answer
    }

    #[test]
    fn a_play_is_found_and_measured_and_a_joint_without_has_none() {
        assert_eq!(found(0.0, 9.0), None);
        assert_eq!(found(0.0, 0.4), None);
        for yields in [9.0, 0.4] {
            let width = found(0.03, yields).unwrap();
            assert!((width - 0.03).abs() < 0.008, "{width}");
        }
    }
}
