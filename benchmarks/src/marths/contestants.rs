//! The contestants, by name.

use super::controller::{OutsidePair, PairController, TargetSample, Uncompensated};
use super::regression::{FourTaps, Start};
use super::rig::{ActuatorParameters, COUPLER, FRAME_RATIO, noise_m};
use super::structure::{FrameMatrices, ROTATION, X};
use super::{PERIOD_S, SIGN};
use crate::Refused;
use outerloop_core::coupled::{
    EstimatorSettings, ObserverSettings, Parameter, Plant, Spreads, Tracker, TrackerConstants,
    TrackerSettings,
};

/// One of the contestants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PairContestant {
    /// Sends the target itself.
    None,
    /// Four taps as published, fixed.
    Fir,
    /// Four taps by recursive least squares.
    Rodeac,
    /// No controller: the strokes are the targets of the last sample. Nothing that waits for its reading can be better.
    Perfect,
    /// Core's inverse of the nominal plant, with cross terms.
    CoupledFixed,
    /// The same with an estimated plant; the force comes from the raw readings.
    CoupledRaw,
    /// The same, but the force comes from the estimated strokes.
    Coupled,
    /// A controller of another crate.
    Outside(&'static OutsidePair),
}

/// The contestants of the command's table with their names and what they know; the perfect one is last.
pub const ALL: [(PairContestant, &str, &str); 7] = [
    (PairContestant::None, "none", "nothing"),
    (
        PairContestant::Fir,
        "fir",
        "a calibration on the nominal plant",
    ),
    (
        PairContestant::Rodeac,
        "rodeac",
        "a calibration on the nominal plant, to start from",
    ),
    (
        PairContestant::CoupledFixed,
        "coupled-fixed",
        "the nominal plant, the structure's modes, the ground motion",
    ),
    (
        PairContestant::CoupledRaw,
        "coupled-raw",
        "the plant's form, its nominal numbers and their spread; modes, ground motion",
    ),
    (
        PairContestant::Coupled,
        "coupled",
        "the same; force from estimated strokes",
    ),
    (
        PairContestant::Perfect,
        "perfect",
        "nothing, since it is no controller: its strokes are the last targets",
    ),
];

impl PairContestant {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Outside(outside) => outside.name,
            own => ALL.iter().find(|c| c.0 == own).map_or("", |c| c.1),
        }
    }

    /// The contestant of a name.
    ///
    /// # Errors
    /// A name that no contestant has.
    pub fn named(name: &str) -> Result<Self, Refused> {
        ALL.iter()
            .find(|c| c.1 == name)
            .map(|c| c.0)
            .ok_or_else(|| {
                let names: Vec<_> = ALL.iter().map(|c| c.1).collect();
                Refused::new(format!(
                    "the controller `{name}` is unknown: accepted are {}",
                    names.join(", ")
                ))
            })
    }
}

/// The calibration of the contestants.
#[derive(Clone, Debug)]
pub struct Calibration {
    start: [Start; 2],
    coupled: [TrackerConstants; 2],
}

/// Number of modes that are visible at the interface.
const MODES: usize = 3;
/// Noise of the numerical part's x (m) and rotation (rad), rms: the reading's noise through the structure.
const TARGET_NOISE: [f64; 2] = [2e-8, 1.2e-5];
/// White acceleration of a mode in a sample, in addition to the ground's.
const PROCESS: f64 = 0.2;
/// Below this frequency the estimated strokes follow the reading, Hz.
const TRUST_READING_HZ: f64 = 5.0;

impl Calibration {
    /// From the published start values, the nominal plant and the modes of the reference structure.
    ///
    /// # Errors
    /// A tracker that core refuses.
    pub fn new(start: [Start; 2], reference: &FrameMatrices) -> Result<Self, Refused> {
        let plant = nominal();
        let refused = |e: outerloop_core::Refusal| Refused::new(format!("marths: {e}"));
        let tracker = |spreads: Spreads| {
            TrackerConstants::new(&TrackerSettings {
                coupler: COUPLER,
                estimate: EstimatorSettings {
                    plant,
                    spreads,
                    noise_m: noise_m() as f32,
                    period_s: PERIOD_S as f32,
                },
                inverse: true,
                target: [
                    target(reference, X, 0).steady(PERIOD_S).map_err(refused)?,
                    target(reference, ROTATION, 1)
                        .steady(PERIOD_S)
                        .map_err(refused)?,
                ],
                ahead_s: 0.0,
                trust_reading_hz: TRUST_READING_HZ as f32,
            })
            .map_err(refused)
        };
        Ok(Self {
            start,
            coupled: [tracker(Spreads::new())?, tracker(spreads())?],
        })
    }

    /// A contestant's controller at rest; none for the perfect one.
    pub fn controller(&self, contestant: PairContestant) -> Option<Box<dyn PairController + Send>> {
        let coupled = |k: &TrackerConstants, estimated| {
            Box::new(CoreTracker {
                tracker: Tracker::at_rest(k.clone()),
                sent_m: [0.0; 2],
                estimated,
            })
        };
        Some(match contestant {
            PairContestant::None => Box::new(Uncompensated),
            PairContestant::Fir => Box::new(FourTaps::new(&self.start, false)),
            PairContestant::Rodeac => Box::new(FourTaps::new(&self.start, true)),
            PairContestant::CoupledFixed => coupled(&self.coupled[0], false),
            PairContestant::CoupledRaw => coupled(&self.coupled[1], false),
            PairContestant::Coupled => coupled(&self.coupled[1], true),
            PairContestant::Outside(outside) => (outside.make)(),
            PairContestant::Perfect => return None,
        })
    }
}

/// The nominal plant in core's form.
fn nominal() -> Plant {
    let p = ActuatorParameters::nominal();
    let pair = |a: f64, b: f64| [a as f32, b as f32];
    Plant {
        gain: p.gain.map(|row| row.map(|k| k as f32)),
        slow_pole_rad_per_s: pair(p.p[0], p.q[0]),
        fast_pole_rad_per_s: pair(p.p[1], p.q[1]),
        lead_s: [pair(1.0 / p.z[0], 1.0 / p.z[1]), [0.0; 2]],
        path_lead_s: [pair(0.0, 1.0 / p.z2[0]), pair(0.0, 1.0 / p.z2[1])],
        natural_rad_per_s: p.f as f32,
        damping_ratio: FRAME_RATIO as f32,
        delay_s: [0.0; 2],
    }
}

/// The plant's uncertain parameters: the published spread, and 3 % for the gains.
fn spreads() -> Spreads {
    use Parameter::{FastPole, Gain, Lead, NaturalFrequency, PathLead, SlowPole};
    [
        (SlowPole(0), 0.06),
        (FastPole(0), 0.06),
        (Lead(0, 0), 0.055),
        (Lead(0, 1), 0.055),
        (NaturalFrequency, 0.05),
        (SlowPole(1), 0.03),
        (FastPole(1), 0.03),
        (PathLead(0, 1), 0.03),
        (PathLead(1, 1), 0.03),
        (Gain(0, 0), 0.03),
        (Gain(0, 1), 0.03),
        (Gain(1, 0), 0.03),
        (Gain(1, 1), 0.03),
    ]
    .into_iter()
    .collect()
}

/// The modes of the reference as seen at the interface, in the rig's sign.
fn target(reference: &FrameMatrices, at: usize, coordinate: usize) -> ObserverSettings {
    let sign = if coordinate == 1 { SIGN } else { 1.0 };
    let mut modes = reference.modes(at, MODES);
    for mode in &mut modes {
        mode.participation *= sign;
    }
    ObserverSettings {
        modes: modes.into_iter().collect(),
        noise: TARGET_NOISE[coordinate],
        process_per_s2: PROCESS,
    }
}

/// Core's tracker.
struct CoreTracker {
    tracker: Tracker,
    sent_m: [f32; 2],
    estimated: bool,
}

impl PairController for CoreTracker {
    fn observe(&mut self, read_m: [f64; 2]) -> [f64; 2] {
        let read_f32_m = read_m.map(|x| x as f32);
        let (stroke_m, _) = self.tracker.observe(&self.sent_m, &read_f32_m, true);
        if self.estimated {
            stroke_m.map(f64::from)
        } else {
            read_m
        }
    }

    fn command(&mut self, target: &TargetSample) -> [f64; 2] {
        let interface = target.interface.map(|x| x as f32);
        self.sent_m = self
            .tracker
            .command(&interface, target.ground_m_per_s2 as f32);
        self.sent_m.map(f64::from)
    }
}
