//! A pair of coupled actuators on a simulated plant, the same on every machine: the image for QEMU and the host work it out and
//! compare the bits.
//!
//! The plant is the published one of the multi-axial benchmark problem with its slow poles 5 % off; the target is one mode of
//! a structure that the ground shakes. Only the tracker's step is timed.

use outerloop_core::Refusal;
use outerloop_core::coupled::{
    Coupler, EstimatorSettings, Forward, MAX_PARAMETERS, ObserverSettings, Pair, Parameter, Plant,
    Spreads, Tracker, TrackerConstants, TrackerSettings, VibrationMode,
};

const TURN: f32 = core::f32::consts::TAU;
const PERIOD_S: f32 = 1.0 / 1024.0;

/// Samples of the scenario.
pub const SAMPLES: u32 = 1024;

/// The mode, and what x and the rotation show of it.
const OMEGA_RAD_PER_S: f32 = 2.29 * TURN;
const RATIO: f32 = 0.047;
const SHOWN: Pair = [-0.257, 0.64];

const PLANT: Plant = Plant {
    gain: [[0.8636, 0.1312], [0.1396, 0.9265]],
    slow_pole_rad_per_s: [2.65 * TURN, 3.5 * TURN],
    fast_pole_rad_per_s: [40.0 * TURN, 18.5 * TURN],
    lead_s: [[1.0 / (120.0 * TURN), 1.0 / (90.0 * TURN)], [0.0; 2]],
    path_lead_s: [[0.0, 1.0 / (3.0 * TURN)], [0.0, 1.0 / (5.0 * TURN)]],
    natural_rad_per_s: 80.43 * TURN,
    damping_ratio: 0.6217,
    delay_s: [0.0; 2],
};

/// What the tracker gets at a sample.
#[derive(Clone, Copy, Debug)]
pub struct Input {
    /// x (m) and rotation (rad) that are wanted.
    pub target: Pair,
    /// Strokes as read, m.
    pub measured_m: Pair,
    /// Ground acceleration, m/s^2.
    pub ground_m_per_s2: f32,
}

/// What the tracker answers.
#[derive(Clone, Copy, Debug)]
pub struct Tracked {
    /// Commands for the next period, m.
    pub command_m: Pair,
    /// Where the interface is, m and rad.
    pub interface: Pair,
}

/// The scenario in motion.
pub struct Scenario {
    tracker: Tracker,
    rig: Forward,
    truth: Plant,
    sent_m: Pair,
    /// Displacement (m) and velocity (m/s) of the mode.
    mode: Pair,
    sample: u32,
    hash: u64,
    worst_error_m: f32,
    peak_m: f32,
}

impl Scenario {
    /// At rest.
    ///
    /// # Errors
    /// None that are known; core checks its settings.
    pub fn new() -> Result<Self, Refusal> {
        let mut truth = PLANT;
        for pole in &mut truth.slow_pole_rad_per_s {
            *pole *= 1.05;
        }
        let target = |participation: f32, noise| {
            let observer = ObserverSettings {
                modes: core::iter::once(VibrationMode {
                    omega_rad_per_s: f64::from(OMEGA_RAD_PER_S),
                    damping_ratio: f64::from(RATIO),
                    participation: f64::from(participation),
                })
                .collect(),
                noise,
                process_per_s2: 0.2,
            };
            observer.steady(f64::from(PERIOD_S))
        };
        let constants = TrackerConstants::new(&TrackerSettings {
            coupler: Coupler {
                pin_x_m: [0.2667; 2],
                pin_y_m: [-0.127, 0.127],
            },
            estimate: EstimatorSettings {
                plant: PLANT,
                spreads: spreads(),
                noise_m: 12e-6,
                period_s: PERIOD_S,
            },
            inverse: true,
            target: [target(SHOWN[0], 2e-8)?, target(SHOWN[1], 1.2e-7)?],
            ahead_s: 0.0,
            trust_reading_hz: 5.0,
        })?;
        Ok(Self {
            tracker: Tracker::at_rest(constants),
            rig: Forward::at_rest(),
            truth,
            sent_m: [0.0; 2],
            mode: [0.0; 2],
            sample: 0,
            hash: 0xcbf2_9ce4_8422_2325,
            worst_error_m: 0.0,
            peak_m: 0.0,
        })
    }

    /// What the tracker gets next; none at the end.
    pub fn next_input(&mut self) -> Option<Input> {
        if self.sample >= SAMPLES {
            return None;
        }
        let t = self.sample as f32 * PERIOD_S;
        let mut slopes = [[0.0; MAX_PARAMETERS]; 2];
        let none = Spreads::new();
        let measured_m = self
            .rig
            .step(&self.truth, &none, PERIOD_S, &self.sent_m, &mut slopes);
        let ground_m_per_s2 = 2.0 * libm::sinf(11.0 * t) + libm::sinf(29.0 * t);
        let input = Input {
            target: SHOWN.map(|shown| shown * self.mode[0]),
            measured_m,
            ground_m_per_s2,
        };
        let [q, v] = self.mode;
        let pull = 2.0 * RATIO * OMEGA_RAD_PER_S * v + OMEGA_RAD_PER_S * OMEGA_RAD_PER_S * q;
        self.mode[1] = v + PERIOD_S * (ground_m_per_s2 - pull);
        self.mode[0] = q + PERIOD_S * self.mode[1];
        Some(input)
    }

    /// A sample of the tracker.
    #[inline(never)]
    pub fn track(&mut self, input: &Input) -> Tracked {
        let (_, interface) = self.tracker.observe(&self.sent_m, &input.measured_m, true);
        let command_m = self.tracker.command(&input.target, input.ground_m_per_s2);
        Tracked {
            command_m,
            interface,
        }
    }

    /// Takes what the tracker answered.
    pub fn take(&mut self, input: &Input, tracked: &Tracked) {
        self.sent_m = tracked.command_m;
        for x in tracked.command_m.iter().chain(&tracked.interface) {
            // FNV-1a over the bits.
            for byte in x.to_bits().to_le_bytes() {
                self.hash = (self.hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
            }
        }
        if self.sample > SAMPLES / 2 {
            let error_m = (tracked.interface[0] - input.target[0]).abs();
            self.worst_error_m = self.worst_error_m.max(error_m);
            self.peak_m = self.peak_m.max(input.target[0].abs());
        }
        self.sample += 1;
    }

    /// Hash of all commands and estimates.
    pub fn hash(&self) -> u64 {
        self.hash
    }

    /// Largest target of x in the second half, m.
    pub fn peak_m(&self) -> f32 {
        self.peak_m
    }

    /// Largest error of x in the second half, m.
    pub fn worst_error_m(&self) -> f32 {
        self.worst_error_m
    }
}

/// All 13 parameters.
fn spreads() -> Spreads {
    use Parameter::{FastPole, Gain, Lead, NaturalFrequency, PathLead, SlowPole};
    [
        SlowPole(0),
        FastPole(0),
        Lead(0, 0),
        Lead(0, 1),
        NaturalFrequency,
        SlowPole(1),
        FastPole(1),
        PathLead(0, 1),
        PathLead(1, 1),
        Gain(0, 0),
        Gain(0, 1),
        Gain(1, 0),
        Gain(1, 1),
    ]
    .into_iter()
    .map(|p| (p, 0.05))
    .collect()
}
