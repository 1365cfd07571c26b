//! Specimens of earthquake laboratories: bearings, dampers, braces, walls and columns, moved by cycles and earthquakes of
//! their size, and declared as such laboratories declare them. They were first written, in another language, by somebody who
//! had read the tool's documents and none of its code; the kinds, sizes, motions and answers are that person's.
//!
//! [`set_device`] makes one [`Field`] from a seed.

mod law;
mod motion;

use crate::declared::Parameter;
use crate::draws::Draws;
use crate::field::{Believed, Field, Span, Truth, rms_apart};
use crate::fine::{FINE_HZ, peak};
use crate::noise::convert;
use crate::record::Record;
use motion::{AFTER_S, Motion};

/// The specimen in the rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Device {
    LeadRubberBearing,
    DampingRubberBearing,
    FrictionPendulum,
    FluidDamper,
    RestrainedBrace,
    Brace,
    TimberWall,
    ConcreteColumn,
    ShapeMemoryWires,
    RockingWall,
    BoltedJoint,
    MrDamper,
    StiffeningFrame,
}

const ALL: [Device; 13] = [
    Device::LeadRubberBearing,
    Device::DampingRubberBearing,
    Device::FrictionPendulum,
    Device::FluidDamper,
    Device::RestrainedBrace,
    Device::Brace,
    Device::TimberWall,
    Device::ConcreteColumn,
    Device::ShapeMemoryWires,
    Device::RockingWall,
    Device::BoltedJoint,
    Device::MrDamper,
    Device::StiffeningFrame,
];

/// All devices, by name.
pub fn devices() -> impl Iterator<Item = &'static str> {
    ALL.iter().map(|d| d.name())
}

/// A specimen's force, what is declared about it, and the key.
struct Specimen {
    force_n: Vec<f64>,
    /// Stiffness in N/mm, damping in N s/mm and mass in kg: value and tolerance.
    declared: [Option<[f64; 2]>; 3],
    truth: Truth,
}

/// The record of a seed; the devices take turns.
pub fn set_device(seed: u64) -> Field {
    let rng = &mut Draws::new(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0xDE71C);
    let device = ALL[(seed % ALL.len() as u64) as usize];
    let peak_mm = device.size_mm() * rng.log_between(0.7, 1.3);
    let motion = Motion::draw(peak_mm, device.is_slow(), rng);
    let specimen = device.specimen(&motion.x, peak_mm, rng);
    let twelve_bits = rng.chance(0.25);
    let record = recorded(&motion, &specimen.force_n, twelve_bits, rng);
    // The training part is the rest and 0.62 of the motion.
    let share =
        (motion.rest_s + 0.62 * (motion.seconds() - motion.rest_s - AFTER_S)) / motion.seconds();
    let n = record.time_s.len();
    let cut = (share * n as f64) as usize;
    let [k, c, m] = specimen
        .declared
        .map(|p| p.map(|[v, t]| Parameter::new(v, t)));
    let every = (FINE_HZ / motion.rate_hz) as usize;
    let exact: Vec<f64> = specimen.force_n.iter().step_by(every).copied().collect();
    let offset = Parameter::new(0.0, 0.005 * peak(&specimen.force_n));
    Field {
        id: format!(
            "{seed} {} {}, {} Hz, rest {} s{}",
            device.name(),
            motion.name,
            motion.rate_hz,
            motion.rest_s,
            if twelve_bits { ", 12 bits" } else { "" }
        ),
        believed: Believed::Specimen([k, c, m, Some(offset)]),
        noise_rms: rms_apart(&record.force_n[..cut], &exact),
        rests: true,
        stand: None,
        train: Span {
            record: record.samples(0..cut),
            before: None,
        },
        test: Span {
            record: record.samples(cut..n),
            before: Some(record.samples(0..cut)),
        },
        truth: Truth {
            cause: device.name(),
            steps: twelve_bits,
            ..specimen.truth
        },
    }
}

/// Samples the motion with white noise of both transducers and, with `twelve_bits`, a converter's steps.
fn recorded(motion: &Motion, force_n: &[f64], twelve_bits: bool, rng: &mut Draws) -> Record {
    let every = (FINE_HZ / motion.rate_hz) as usize;
    let read = |x: &[f64], noise: f64, rng: &mut Draws| -> Vec<f64> {
        let range = 1.2 * peak(x);
        let sampled = x.iter().step_by(every);
        sampled
            .map(|x| {
                let x = x + noise * range * rng.normal();
                if twelve_bits {
                    convert(x, range, 12)
                } else {
                    x
                }
            })
            .collect()
    };
    let noise = [rng.log_between(2e-4, 1e-3), rng.log_between(5e-4, 3e-3)];
    let displacement_mm = read(&motion.x, noise[0], rng);
    let force = read(force_n, noise[1], rng);
    Record {
        rate_hz: motion.rate_hz,
        time_s: (0..force.len())
            .map(|i| i as f64 / motion.rate_hz)
            .collect(),
        command_mm: Vec::new(),
        displacement_mm,
        force_n: force,
    }
}

const HYSTERESIS: [&str; 2] = ["bilinear_hysteresis", "bouc_wen_hysteresis"];

/// A key: the right names, and names that are no mistake beside them.
fn key(right: &[&[&'static str]], beside: &[&'static str]) -> Truth {
    Truth {
        right: right.concat(),
        beside: beside.to_vec(),
        ..Truth::default()
    }
}

impl Device {
    const fn name(self) -> &'static str {
        match self {
            Self::LeadRubberBearing => "lead-rubber bearing",
            Self::DampingRubberBearing => "high-damping rubber bearing",
            Self::FrictionPendulum => "friction pendulum",
            Self::FluidDamper => "fluid damper",
            Self::RestrainedBrace => "buckling-restrained brace",
            Self::Brace => "brace that buckles",
            Self::TimberWall => "nailed timber wall",
            Self::ConcreteColumn => "reinforced-concrete column",
            Self::ShapeMemoryWires => "shape-memory wires",
            Self::RockingWall => "rocking wall",
            Self::BoltedJoint => "bolted joint",
            Self::MrDamper => "magnetorheological damper",
            Self::StiffeningFrame => "stiffening frame",
        }
    }

    /// Typical largest displacement of its tests, mm; the actual one is drawn around it.
    const fn size_mm(self) -> f64 {
        match self {
            Self::LeadRubberBearing => 200.0,
            Self::DampingRubberBearing | Self::FrictionPendulum => 150.0,
            Self::FluidDamper => 60.0,
            Self::TimberWall | Self::RockingWall => 50.0,
            Self::ConcreteColumn => 40.0,
            Self::RestrainedBrace | Self::ShapeMemoryWires | Self::StiffeningFrame => 30.0,
            Self::Brace | Self::MrDamper => 20.0,
            Self::BoltedJoint => 12.0,
        }
    }

    /// Whether its force hardly depends on speed, so that laboratories test it slowly.
    const fn is_slow(self) -> bool {
        matches!(
            self,
            Self::RestrainedBrace
                | Self::Brace
                | Self::TimberWall
                | Self::ConcreteColumn
                | Self::ShapeMemoryWires
                | Self::RockingWall
                | Self::BoltedJoint
        )
    }

    fn specimen(self, x: &[f64], peak_mm: f64, rng: &mut Draws) -> Specimen {
        let size = rng.log_between(0.6, 1.5);
        // Only a stiffness, with a tolerance that is a share of it.
        let spring = |k: f64, share: f64| [Some([k, share * k]), None, None];
        match self {
            Self::LeadRubberBearing => {
                let k = 1000.0 * size;
                let strength = 150.0 * k * rng.log_between(0.7, 1.4);
                let yield_mm = 8.0 * rng.log_between(0.7, 1.5);
                Specimen {
                    force_n: law::lead_rubber(x, k, strength, yield_mm),
                    declared: [Some([k, 0.1 * k]), Some([0.0, 3.0]), None],
                    truth: key(&[&HYSTERESIS], &["coulomb_friction"]),
                }
            }
            Self::DampingRubberBearing => Specimen {
                force_n: law::rubber(x, peak_mm / 1.5, 1500.0 * size, rng.between(0.1, 0.35)),
                declared: [Some([1200.0, 250.0]), Some([20.0, 20.0]), None],
                truth: Truth {
                    nameless: true,
                    ..key(
                        &[&HYSTERESIS, &["degradation", "hardening", "softening"]],
                        &["coulomb_friction"],
                    )
                },
            },
            Self::FrictionPendulum => {
                let weight = 8e5 * size;
                Specimen {
                    force_n: law::pendulum(x, weight, rng.log_between(15.0, 80.0)),
                    declared: [
                        Some([weight / 2240.0, weight / 44_800.0]),
                        Some([0.0, 2.0]),
                        None,
                    ],
                    // Its friction is greater in motion than at rest; Stribeck friction is the opposite.
                    truth: key(&[&["coulomb_friction"], &HYSTERESIS], &["viscous_damping"]),
                }
            }
            Self::FluidDamper => {
                let power = rng.pick(&[0.3, 0.4, 0.6, 1.0]);
                let c = rng.log_between(2e5, 6e5);
                let brace = rng.chance(0.5).then(|| c * rng.log_between(15.0, 60.0));
                // A linear damper with the same force at 0.25 m/s; declared a tenth larger.
                let linear = 1e-3 * c * 0.25_f64.powf(power - 1.0);
                Specimen {
                    force_n: law::fluid_damper(x, c, power, brace),
                    declared: [Some([0.0, 10.0]), Some([1.1 * linear, 0.15 * linear]), None],
                    truth: match brace {
                        // The true constant is within the tolerance.
                        None if power == 1.0 => Truth::default(),
                        None => key(&[&["viscous_damping"]], &[]),
                        Some(_) => key(&[&["maxwell_damper"]], &["viscous_damping"]),
                    },
                }
            }
            Self::RestrainedBrace => {
                let k = 2.5e5 * size;
                Specimen {
                    force_n: law::restrained_brace(x, k, 0.1 * k * peak_mm),
                    declared: spring(k, 0.05),
                    truth: key(&[&HYSTERESIS], &["asymmetric_stiffness"]),
                }
            }
            Self::Brace => Specimen {
                force_n: law::brace(x, 4.5e5 * rng.log_between(0.7, 1.2)),
                declared: [Some([1.5e5, 8e3]), None, None],
                truth: Truth {
                    nameless: true,
                    ..key(
                        &[
                            &HYSTERESIS,
                            &["asymmetric_stiffness", "degradation", "softening"],
                        ],
                        &[],
                    )
                },
            },
            Self::TimberWall => Specimen {
                force_n: law::timber_wall(x, size),
                declared: [Some([1200.0 * size, 150.0 * size]), None, None],
                truth: Truth {
                    nameless: true,
                    ..key(
                        &[&HYSTERESIS, &["degradation", "slip_gap", "softening"]],
                        &["coulomb_friction", "hardening"],
                    )
                },
            },
            Self::ConcreteColumn => {
                let k = 2e4 * size;
                Specimen {
                    force_n: law::concrete_column(x, k, 0.25 * k * peak_mm, rng.between(0.2, 0.5)),
                    declared: spring(k, 0.1),
                    truth: Truth {
                        nameless: true,
                        ..key(&[&HYSTERESIS, &["degradation", "softening"]], &[])
                    },
                }
            }
            Self::ShapeMemoryWires => {
                let k = 8e3 * size;
                let up = 0.2 * k * peak_mm;
                let levels = [up, up * rng.between(0.3, 0.6)];
                Specimen {
                    force_n: law::flag(x, k, levels),
                    declared: spring(k, 0.05),
                    truth: key(
                        &[&HYSTERESIS, &["softening"]],
                        &["coulomb_friction", "saturation"],
                    ),
                }
            }
            Self::RockingWall => {
                let k = 3e4 * size;
                let bars = if rng.chance(0.5) {
                    0.05 * k * peak_mm
                } else {
                    0.0
                };
                let right: &[&[&'static str]] = if bars > 0.0 {
                    &[&["softening", "coulomb_friction"], &HYSTERESIS]
                } else {
                    &[&["softening"]]
                };
                Specimen {
                    force_n: law::rocking_wall(x, k, 0.1 * k * peak_mm, bars),
                    // Its bars are as stiff as the wall.
                    declared: spring(k, 0.1),
                    truth: key(right, &["saturation"]),
                }
            }
            Self::BoltedJoint => {
                let k = 6e4 * size;
                let gap = peak_mm * rng.log_between(0.1, 0.2);
                Specimen {
                    force_n: law::bolted_joint(x, k, 0.08 * k * peak_mm, gap),
                    declared: spring(k, 1.0 / 15.0),
                    truth: key(&[&["slip_gap"]], &[]),
                }
            }
            Self::MrDamper => {
                let volts = rng.between(0.5, 2.25);
                Specimen {
                    force_n: law::mr_damper(x, volts),
                    declared: [Some([0.5, 0.5]), Some([2.1 + 0.35 * volts, 0.5]), None],
                    truth: key(
                        &[&["coulomb_friction"], &HYSTERESIS],
                        // A dashpot is in series with the whole damper.
                        &["viscous_damping", "quadratic_damping", "maxwell_damper"],
                    ),
                }
            }
            Self::StiffeningFrame => {
                let k = 2e3 * size;
                let more = rng.log_between(0.1, 0.8);
                Specimen {
                    force_n: law::stiffening_frame(x, [k, 3.0, 100.0], more, peak_mm),
                    declared: [Some([k, k / 40.0]), Some([3.0, 1.0]), Some([100.0, 5.0])],
                    truth: key(&[&["hardening"]], &[]),
                }
            }
        }
    }
}
