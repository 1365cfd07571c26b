//! The rigs of the bench.

use experiment::Experiment;
use outerloop_core::Config;
use plant::RigSpec;
use plant::actuator::{ActuatorKind, ActuatorSpec, DelayJump};
use plant::measurement::SensorsSpec;
use plant::specimen::{SpecimenKind, SpecimenSpec};
use serde::Serialize;

/// A group of conditions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// A linear specimen, delays from 1 to 60 ms, declared exactly.
    Linear,
    /// The same with a specimen that yields.
    Yielding,
    /// The lag and delay measured on a servo-hydraulic rig.
    MeasuredRig,
    /// Noise on both sensors.
    Noise,
    /// A delay that is declared wrong.
    DelayError,
    /// A delay that changes in the middle of the test.
    DelayJump,
    /// A gain of the actuator that is not 1.
    GainError,
}

impl Family {
    /// Every family, in the order of tables.
    pub const ALL: [Self; 7] = [
        Self::Linear,
        Self::Yielding,
        Self::MeasuredRig,
        Self::Noise,
        Self::DelayError,
        Self::DelayJump,
        Self::GainError,
    ];

    /// The head of its column.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Yielding => "yielding",
            Self::MeasuredRig => "measured rig",
            Self::Noise => "noise",
            Self::DelayError => "delay error",
            Self::DelayJump => "delay jump",
            Self::GainError => "gain error",
        }
    }
}

/// A rig, and the delay declared to the compensation.
#[derive(Clone, Debug)]
pub struct Condition {
    /// Its group.
    pub family: Family,
    /// Its description.
    pub name: String,
    /// Its delay on a slow motion, ms.
    pub delay_ms: f64,
    told_ms: f64,
    rig: RigSpec,
}

/// Delays of the bench, ms.
pub const DELAYS_MS: [f64; 7] = [1.0, 2.0, 4.0, 8.0, 16.0, 33.5, 60.0];

/// Actuators of the bench, by name.
pub const ACTUATORS: [(&str, ActuatorKind); 3] = [
    ("pure delay", ActuatorKind::Delay),
    ("first order", ActuatorKind::FirstOrder),
    ("second order", ActuatorKind::SecondOrder),
];

/// Delay and lag of the measured rig, ms.
const MEASURED_MS: (f64, f64) = (4.6, 22.2);

/// Noise of the paper's sensors, 5 mm and 16 kN peak to peak, taken as six standard deviations: mm and N rms.
const NOISE: (f64, f64) = (5.0 / 6.0, 16e3 / 6.0);

impl Condition {
    /// Every condition of the bench for tests like `config`; `yielding` is the yielding specimen.
    pub fn all(config: &Config, yielding: &SpecimenSpec) -> Vec<Self> {
        let linear = SpecimenSpec::default();
        // A lag acts on the held command from the beginning of a control period; the target is counted from its end.
        let half_period_ms = 0.5e3 / config.timing.rate_hz;
        let on = |family, specimen: &SpecimenSpec, name: &str, kind, delay_ms: f64| {
            let whole = kind == ActuatorKind::Delay;
            Self {
                family,
                name: format!("{}, {name} {delay_ms} ms", specimen_name(specimen)),
                delay_ms,
                told_ms: delay_ms - if whole { 0.0 } else { half_period_ms },
                rig: RigSpec {
                    actuator: ActuatorSpec {
                        kind,
                        delay_ms: delay_ms.into(),
                        ..ActuatorSpec::default()
                    },
                    specimen: specimen.clone(),
                    ..RigSpec::default()
                },
            }
        };
        let mut all = Vec::new();
        for (family, specimen) in [(Family::Linear, &linear), (Family::Yielding, yielding)] {
            for (name, kind) in ACTUATORS {
                all.extend(DELAYS_MS.map(|ms| on(family, specimen, name, kind, ms)));
            }
            let (delay_ms, lag_ms) = MEASURED_MS;
            let kind = ActuatorKind::LagDelay;
            let mut rig = on(
                Family::MeasuredRig,
                specimen,
                "measured rig",
                kind,
                delay_ms + lag_ms,
            );
            rig.name = format!(
                "{}, measured rig {delay_ms} + {lag_ms} ms",
                specimen_name(specimen)
            );
            rig.rig.actuator.delay_ms = delay_ms.into();
            rig.rig.actuator.lag_ms = lag_ms.into();
            all.push(rig);
        }
        let eight = |family, more: String| {
            let kind = ActuatorKind::SecondOrder;
            let mut c = on(family, yielding, "second order", kind, 8.0);
            c.name = format!("{}, {more}", c.name);
            c
        };
        for share in [0.01, 0.1, 1.0] {
            let mut c = eight(Family::Noise, format!("{share} of the paper's noise"));
            c.rig.sensors = SensorsSpec {
                displacement_noise_mm: share * NOISE.0,
                force_noise_n: share * NOISE.1,
                ..SensorsSpec::default()
            };
            all.push(c);
        }
        for share in [0.5, 0.75, 1.25, 1.5] {
            let mut c = eight(Family::DelayError, format!("told {share} of it"));
            c.told_ms *= share;
            all.push(c);
        }
        let kinds = [ACTUATORS[0], ACTUATORS[2]];
        for (name, kind) in kinds {
            let mut c = on(Family::DelayJump, yielding, name, kind, 4.0);
            c.name = format!("{}, 12 ms from 8 s on", c.name);
            c.rig.actuator.delay_jump = Some(DelayJump {
                at_s: 8.0 * config.timing.time_scale,
                delay_ms: 12.0,
            });
            all.push(c);
        }
        for gain in [0.95, 1.05] {
            let mut c = eight(Family::GainError, format!("gain {gain}"));
            c.rig.actuator.gain = gain.into();
            all.push(c);
        }
        all
    }

    /// `experiment` on this rig.
    pub fn put_on(&self, experiment: &Experiment) -> Experiment {
        let mut own = experiment.clone();
        own.test.plant = self.rig.clone();
        own.test.config.compensation.delay_ms = self.told_ms.into();
        own
    }
}

fn specimen_name(specimen: &SpecimenSpec) -> &'static str {
    match specimen.kind {
        SpecimenKind::Linear => "linear",
        _ => "yielding",
    }
}

/// The yielding specimen: the test file's own, otherwise one that yields at 30 mm and keeps 5 % of its stiffness.
pub fn yielding(own: &SpecimenSpec) -> SpecimenSpec {
    match own.kind {
        SpecimenKind::Bilinear | SpecimenKind::BoucWen => own.clone(),
        _ => SpecimenSpec {
            kind: SpecimenKind::Bilinear,
            yield_mm: Some(30.0.into()),
            hardening_ratio: Some(0.05.into()),
            ..SpecimenSpec::default()
        },
    }
}
