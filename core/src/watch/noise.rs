//! How noisy a sensor is, and whether it has become noisier, or hums.

use crate::float::larger;
use libm::sqrtf;

/// Variance of a fourth difference of white noise.
const FOURTH: f32 = 70.0;
/// Blocks of motion from which the noise is learnt.
const LEARNED: u16 = 500;
/// Blocks in a judgement, and how many of them beyond how many standard deviations make a burst.
const BLOCKS: u8 = 100;
const BEYOND: u8 = 30;
const DEVIATIONS: f32 = 3.5;
/// The sensor's squared fourth difference must exceed that of the signal it follows by this factor to count as a burst.
const SHAKES: f32 = 4.0;
/// Ratio of a hum to its neighbours, and to the noise.
const STANDS_OUT: f32 = 3.0;
const OUT_OF_NOISE: f32 = 4.0;
/// Mains hum is steady: consecutive judgements needed, with amplitudes that differ by no more than this fraction.
const STEADY: u8 = 4;
const SWELLS: f32 = 0.3;
/// Consecutive judgements needed for noise.
const NOISY: u8 = 2;
/// Frequencies monitored, Hz: the mains between their neighbours.
const LISTENED_HZ: [f64; 4] = [40.0, 50.0, 60.0, 70.0];

/// What was heard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Heard {
    /// The noise is this many times its former level.
    Noise(f32),
    /// A hum with this amplitude, in the unit of the samples.
    Hum(f32),
}

/// Constants of a listener.
#[derive(Clone, Copy, Debug)]
pub(super) struct Constants {
    /// 2 cos of the angle per block, and the second difference's gain there.
    turn: [f32; 4],
    gain: [f32; 4],
    /// Rotation of the window's cosine per block.
    window: [f32; 2],
}

impl Constants {
    pub(super) fn new(blocks_hz: f64) -> Self {
        let angle = |hz: f64| core::f64::consts::TAU * hz / blocks_hz;
        let w = core::f64::consts::TAU / f64::from(BLOCKS);
        Self {
            turn: LISTENED_HZ.map(|hz| (2.0 * libm::cos(angle(hz))) as f32),
            gain: LISTENED_HZ.map(|hz| (2.0 - 2.0 * libm::cos(angle(hz))) as f32),
            window: [libm::cos(w) as f32, libm::sin(w) as f32],
        }
    }
}

/// The last samples of a signal.
#[derive(Clone, Debug)]
struct Past([f32; 4]);

impl Past {
    /// The fourth difference including a new sample.
    fn fourth(&self, value: f32) -> f32 {
        let [a, b, c, d] = self.0;
        value - 4.0 * a + 6.0 * b - 4.0 * c + d
    }

    fn push(&mut self, value: f32) {
        let [a, b, c, _] = self.0;
        self.0 = [value, a, b, c];
    }
}

/// Listens to one sensor.
#[derive(Clone, Debug)]
pub(super) struct Listener {
    past: Past,
    followed: Past,
    learned: u16,
    /// Mean square of a fourth difference, and the resulting standard deviation of a block once it is known.
    variance: f32,
    sigma: f32,
    goertzel: [[f32; 2]; 4],
    phase: [f32; 2],
    blocks: u8,
    beyond: u8,
    squares: f32,
    /// Consecutive judgements that heard noise, or a steady hum, and its latest amplitude.
    heard: [u8; 2],
    amplitude: f32,
}

impl Listener {
    pub(super) const fn new() -> Self {
        Self {
            past: Past([0.0; 4]),
            followed: Past([0.0; 4]),
            learned: 0,
            variance: 0.0,
            sigma: 0.0,
            goertzel: [[0.0; 2]; 4],
            phase: [1.0, 0.0],
            blocks: 0,
            beyond: 0,
            squares: 0.0,
            heard: [0; 2],
            amplitude: 0.0,
        }
    }

    /// Standard deviation of a block, 0 until it is known.
    pub(super) fn sigma(&self) -> f32 {
        self.sigma
    }

    /// True once the noise is known.
    pub(super) fn knows(&self) -> bool {
        self.learned >= LEARNED
    }

    /// Adds a block of the sensor and of the signal it follows; `moves`: fast enough for the steps of a converter to
    /// act as noise; `least`: declared noise.
    pub(super) fn add(
        &mut self,
        k: &Constants,
        [value, followed]: [f32; 2],
        moves: bool,
        least: f32,
    ) -> Option<Heard> {
        let fourth = self.past.fourth(value);
        let [a, b, ..] = self.past.0;
        let second = value - 2.0 * a + b;
        self.past.push(value);
        // A shaking motion is not noise of the sensor that follows it.
        let shakes = self.followed.fourth(followed);
        self.followed.push(followed);
        let square = fourth * fourth;
        if !self.knows() {
            if moves {
                self.learned += 1;
                self.variance += (square - self.variance) / f32::from(self.learned);
            }
            self.variance = self.variance.max(FOURTH * least * least);
            if self.knows() {
                self.sigma = sqrtf(self.variance / FOURTH);
            }
            return None;
        }
        let limit = larger(
            DEVIATIONS * DEVIATIONS * self.variance,
            SHAKES * shakes * shakes,
        );
        if square > limit {
            self.beyond += 1;
        }
        self.squares += square;
        let [cos, sin] = self.phase;
        let [turn_cos, turn_sin] = k.window;
        self.phase = [
            cos * turn_cos - sin * turn_sin,
            cos * turn_sin + sin * turn_cos,
        ];
        let windowed = (1.0 - cos) * second;
        for (state, turn) in self.goertzel.iter_mut().zip(k.turn) {
            *state = [windowed + turn * state[0] - state[1], state[0]];
        }
        self.blocks += 1;
        if self.blocks < BLOCKS {
            return None;
        }
        self.judge(k)
    }

    fn judge(&mut self, k: &Constants) -> Option<Heard> {
        let mut amplitudes = [0.0; 4];
        for j in 0..4 {
            let [s1, s2] = self.goertzel[j];
            let power = s1 * s1 + s2 * s2 - k.turn[j] * s1 * s2;
            // The window's mean is 1.
            amplitudes[j] = 2.0 * sqrtf(power.max(0.0)) / (f32::from(BLOCKS) * k.gain[j]);
        }
        let loud = sqrtf(self.squares / (f32::from(BLOCKS) * self.variance));
        let noisy = self.beyond >= BEYOND;
        let neighbours = amplitudes[0].max(amplitudes[3]);
        let hum = amplitudes[1].max(amplitudes[2]);
        // Amplitude due to the noise of a second difference over this many blocks.
        let of_noise = 0.42 * self.sigma() / k.gain[1];
        let hums = hum > STANDS_OUT * neighbours && hum > OUT_OF_NOISE * of_noise;
        (self.goertzel, self.phase) = ([[0.0; 2]; 4], [1.0, 0.0]);
        (self.blocks, self.beyond, self.squares) = (0, 0, 0.0);
        // A swelling amplitude is a harmonic of the motion.
        let before = core::mem::replace(&mut self.amplitude, hum);
        let steady = hums && (hum - before).abs() < SWELLS * hum;
        let [noise, mains] = &mut self.heard;
        *noise = if noisy { noise.saturating_add(1) } else { 0 };
        *mains = if steady {
            mains.saturating_add(1)
        } else {
            u8::from(hums)
        };
        if *mains >= STEADY {
            Some(Heard::Hum(hum))
        } else if *noise >= NOISY {
            Some(Heard::Noise(loud))
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The result for a motion with white noise of 1e-3 that changes after 3 s.
    fn listen(times: f32, hum: f32) -> Option<Heard> {
        listen_beside(times, hum, 0.0)
    }

    /// The same if the signal that the sensor follows shakes as well, by `shakes`.
    fn listen_beside(times: f32, hum: f32, shakes: f32) -> Option<Heard> {
        let k = Constants::new(500.0);
        let mut listener = Listener::new();
        let mut seed = 1_u32;
        let mut heard = None;
        for i in 0..4000 {
            let t = i as f32 / 500.0;
            let noise: f32 = (0..12)
                .map(|_| {
                    seed ^= seed << 13;
                    seed ^= seed >> 17;
                    seed ^= seed << 5;
                    (seed >> 8) as f32 / 16_777_216.0 - 0.5
                })
                .sum();
            let late = t > 3.0;
            let value = libm::sinf(6.0 * t)
                + 1e-3 * noise * if late { times } else { 1.0 }
                + if late {
                    hum * libm::sinf(314.16 * t)
                } else {
                    0.0
                };
            let shaken = if late {
                shakes * libm::sinf(900.0 * t)
            } else {
                0.0
            };
            let followed = libm::sinf(6.0 * t) + shaken;
            heard = heard.or(listener.add(&k, [value + shaken, followed], true, 0.0));
            assert!(late || heard.is_none(), "{heard:?} at {t}");
        }
        assert!(
            (listener.sigma() / 1e-3 - 1.0).abs() < 0.1,
            "{}",
            listener.sigma()
        );
        heard
    }

    #[test]
    fn noise_and_hum_are_told_from_what_was_there_and_from_each_other() {
        assert_eq!(listen(1.0, 0.0), None);
        let Some(Heard::Noise(times)) = listen(6.0, 0.0) else {
            panic!("no noise");
        };
        assert!((times / 6.0 - 1.0).abs() < 0.3, "{times}");
        // The rig shakes, and the sensor follows.
        assert_eq!(listen_beside(1.0, 0.0, 0.02), None);
        let Some(Heard::Hum(amplitude)) = listen(1.0, 0.01) else {
            panic!("no hum");
        };
        assert!((amplitude / 0.01 - 1.0).abs() < 0.2, "{amplitude}");
    }
}
