//! Play between actuator and specimen: travel without force, whatever the specimen does otherwise.

use libm::sqrtf;

/// Forces, relative to stiffness times peak, between which the force-free travel and the adjacent travel are compared.
const FORCE: f32 = 0.07;
/// Consecutive crossings needed, and the least play of each, peaks.
const CROSSINGS: u8 = 4;
const LEAST: f32 = 0.008;
/// Standard deviations by which the mean play of consecutive crossings must exceed zero; most crossings that count.
const BEYOND: f32 = 6.0;
const MOST_CROSSINGS: u8 = 16;
/// Variance of a crossing's play relative to that of displacement minus force: outer levels once, inner ones twice.
const VARIANCE: f32 = 10.0;

/// The levels that a crossing passes, in the order of its direction.
const LEVELS: [f32; 4] = [2.0 * FORCE, FORCE, -FORCE, -2.0 * FORCE];
/// A falling force that rises again by this much is no crossing.
const TURNS: f32 = 0.5 * FORCE;

/// Measures the travel at every crossing of zero force.
#[derive(Clone, Debug, Default)]
pub(super) struct Play {
    /// Sign of the force at the start of the crossing; 0 before it has been large, or after a turn.
    sign: f32,
    /// Displacement at the levels passed so far.
    at: [f32; 4],
    passed: usize,
    last: [f32; 2],
    crossings: u8,
    /// Mean play of consecutive crossings, peaks.
    width: f32,
}

impl Play {
    /// Adds displacement and force, peaks, with their noise. Returns the width of a play, peaks, once it is certain.
    pub(super) fn add(&mut self, x: f32, r: f32, [x_sd, r_sd]: [f32; 2]) -> Option<f32> {
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
        let variance = VARIANCE * (x_sd * x_sd + r_sd * r_sd);
        let least = BEYOND * sqrtf(variance / f32::from(self.crossings.max(1)));
        (self.crossings >= CROSSINGS && self.width > least).then_some(self.width)
    }

    /// The travel between the inner levels, minus the part explained by the slopes beside it.
    fn judge(&mut self) {
        let [a, b, c, d] = self.at;
        let play = (b - c).abs() - (a - b).abs() - (c - d).abs();
        if play > LEAST {
            self.crossings = (self.crossings + 1).min(MOST_CROSSINGS);
            let share = 1.0 / f32::from(self.crossings);
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
            // A gap at zero force in series with a yielding specimen.
            plastic = plastic
                .max(x - 0.5 * width - yields)
                .min(x + 0.5 * width + yields);
            let u = x - plastic;
            let r = u - u.clamp(-0.5 * width, 0.5 * width);
            let noise = 0.002 * libm::sinf(517.3 * t);
            answer = play.add(x, r + noise, [0.0, 0.0014]);
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

    /// Whether play is found anywhere in a long motion, with white noise of standard deviation `sd` in both channels.
    fn found_in_noise(width: f32, sd: f32) -> bool {
        let mut play = Play::default();
        let mut seed = 1_u32;
        let mut noise = || {
            let even = |seed: &mut u32| {
                *seed ^= *seed << 13;
                *seed ^= *seed >> 17;
                *seed ^= *seed << 5;
                (*seed >> 8) as f32 / 16_777_216.0 - 0.5
            };
            sd * (0..12).map(|_| even(&mut seed)).sum::<f32>()
        };
        (0..120_000).any(|i| {
            let x = libm::sinf(i as f32 * 0.01);
            let r = x - x.clamp(-0.5 * width, 0.5 * width);
            let (x, r) = (x + noise(), r + noise());
            play.add(x, r, [sd; 2]).is_some()
        })
    }

    #[test]
    fn noise_alone_is_no_play_and_a_wide_one_is_found_in_it() {
        assert!(!found_in_noise(0.0, 0.004));
        assert!(found_in_noise(0.06, 0.004));
    }
}
