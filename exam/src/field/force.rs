//! Specimens: a spring, damper and mass, and undeclared elements in parallel or in series.

use super::mark::Truth;
use super::motion::{Move, Plan};
use crate::draws::Draws;
use crate::fine::{DT, derivative, rms};
use std::f64::consts::TAU;

/// What the specimen contains besides spring, damper and mass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cause {
    Nothing,
    Friction,
    FrictionAndDashpot,
    FrictionAndQuadratic,
    FrictionAndHardening,
    MoreDamping,
    MoreMass,
    PowerLaw,
    FluidDamper,
    MrDamper,
    Sliders,
    RambergOsgood,
    Degrading,
    FadesWithPeak,
    FadesWithTravel,
    Pinching,
    Flag,
    Contact,
    GasSpring,
    Play,
    Cogging,
    SecondAxis,
    PumpLine,
}

const FRICTION: [&str; 2] = ["coulomb_friction", "stribeck_friction"];
const FRICTION_AND_DASHPOT: [&str; 2] = ["coulomb_friction", "viscous_damping"];
const HYSTERESIS: [&str; 2] = ["bilinear_hysteresis", "bouc_wen_hysteresis"];

impl Cause {
    pub(super) const ALL: [Self; 23] = [
        Self::Nothing,
        Self::Friction,
        Self::FrictionAndDashpot,
        Self::FrictionAndQuadratic,
        Self::FrictionAndHardening,
        Self::MoreDamping,
        Self::MoreMass,
        Self::PowerLaw,
        Self::FluidDamper,
        Self::MrDamper,
        Self::Sliders,
        Self::RambergOsgood,
        Self::Degrading,
        Self::FadesWithPeak,
        Self::FadesWithTravel,
        Self::Pinching,
        Self::Flag,
        Self::Contact,
        Self::GasSpring,
        Self::Play,
        Self::Cogging,
        Self::SecondAxis,
        Self::PumpLine,
    ];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Nothing => "specimen: nothing",
            Self::Friction => "friction (LuGre)",
            Self::FrictionAndDashpot => "Coulomb friction and a dashpot",
            Self::FrictionAndQuadratic => "friction and quadratic damping",
            Self::FrictionAndHardening => "friction and hardening",
            Self::MoreDamping => "more damping than declared",
            Self::MoreMass => "more mass than declared",
            Self::PowerLaw => "damper |v|^a, a .5 to .9",
            Self::FluidDamper => "fluid damper behind a spring",
            Self::MrDamper => "magnetorheological damper",
            Self::Sliders => "thirty sliders (Iwan)",
            Self::RambergOsgood => "Ramberg-Osgood",
            Self::Degrading => "degrading Bouc-Wen",
            Self::FadesWithPeak => "stiffness lost with the peak so far",
            Self::FadesWithTravel => "stiffness lost with travel",
            Self::Pinching => "pinching",
            Self::Flag => "self-centring flag",
            Self::Contact => "Hertz contact behind a gap",
            Self::GasSpring => "gas spring",
            Self::Play => "play before the spring",
            Self::Cogging => "cogging",
            Self::SecondAxis => "motion of a second axis",
            Self::PumpLine => "wandering line of a pump",
        }
    }

    /// Whether the cause shows only over many amplitudes or rates. A single frequency would be another question.
    const fn needs_breadth(self) -> bool {
        matches!(
            self,
            Self::Degrading | Self::FadesWithTravel | Self::Pinching | Self::Cogging
        )
    }

    /// The motion that a laboratory uses: growing cycles if damage follows the peak.
    pub(super) fn motion(self, rng: &mut Draws) -> Move {
        if self == Self::FadesWithPeak {
            return Move::Growing;
        }
        Move::of_specimens(self.needs_breadth(), rng)
    }
}

/// Tolerance of the declared damping, as a share of it.
pub(super) const DAMPING_KNOWN: f64 = 0.1;
/// Number of tolerances within which a declared parameter may be refitted.
const WITHIN: f64 = 3.0;
/// Share of the stiffness that is lost at a `size` of 1.
const LOST: f64 = 0.7;

/// A specimen.
#[derive(Clone, Debug)]
pub(super) struct Rig {
    cause: Cause,
    /// Stiffness in N/mm, damping in N s/mm, mass in kg.
    pub(super) linear: [f64; 3],
    amplitude_mm: f64,
    speed: f64,
    /// The cause's force over the spring's.
    size: f64,
    /// Three numbers from 0 to 1 that give its shape.
    shape: [f64; 3],
    /// Frequencies and phases of disturbances from elsewhere.
    lines: Vec<[f64; 2]>,
    /// Mass beyond the declared one, kg: in the first motion its force is the share `size` of the spring's.
    more_mass_kg: Option<f64>,
}

impl Rig {
    pub(super) fn draw(plan: &Plan, cause: Cause, rng: &mut Draws) -> Self {
        let k = rng.log_between(50.0, 5000.0) / plan.amplitude_mm;
        let omega = TAU * 0.5 * plan.high_hz;
        // The rig is moved below its own natural frequency.
        let m = if rng.chance(0.5) {
            1e3 * k * rng.between(0.05, 0.5) / omega.powi(2)
        } else {
            0.0
        };
        Self {
            cause,
            linear: [k, rng.between(0.02, 0.2) * k / omega, m],
            amplitude_mm: plan.amplitude_mm,
            speed: plan.speed(),
            size: rng.log_between(0.1, 0.8),
            shape: [0.0; 3].map(|_: f64| rng.between(0.0, 1.0)),
            lines: (0..4)
                .map(|_| [rng.between(0.4, 3.0) * plan.high_hz, rng.between(0.0, TAU)])
                .collect(),
            more_mass_kg: None,
        }
    }

    pub(super) fn linear_force(&self) -> f64 {
        self.linear[0] * self.amplitude_mm
    }

    /// Damping whose force at top speed equals the spring's, N s/mm.
    pub(super) fn damping_unit(&self) -> f64 {
        self.linear_force() / self.speed
    }

    /// Constant of a dashpot beside friction, N s/mm: at top speed its force is half to twice the friction.
    fn dashpot(&self) -> f64 {
        (0.5 + 1.5 * self.shape[1]) * self.size * self.damping_unit()
    }

    pub(super) fn force(&mut self, x: &[f64], rng: &mut Draws) -> Vec<f64> {
        let v = derivative(x);
        let a = derivative(&v);
        let [k, c, m] = self.linear;
        let more = self.element(x, &v, rng);
        let (mut c, mut m) = (c, m);
        if self.cause == Cause::MoreDamping {
            c += self.size * self.damping_unit();
        }
        if self.cause == Cause::MoreMass {
            let share = || 1e3 * self.size * k * rms(x) / rms(&a).max(f64::MIN_POSITIVE);
            m += *self.more_mass_kg.get_or_insert_with(share);
        }
        (0..x.len())
            .map(|i| k * x[i] + c * v[i] + 1e-3 * m * a[i] + more[i])
            .collect()
    }

    /// Force of the undeclared element, N.
    fn element(&self, x: &[f64], v: &[f64], rng: &mut Draws) -> Vec<f64> {
        let force = self.size * self.linear_force();
        let (big, top, [s, r, q]) = (self.amplitude_mm, self.speed, self.shape);
        let each = |of: &mut dyn FnMut(usize) -> f64| -> Vec<f64> {
            (0..x.len()).map(|i| force * of(i)).collect()
        };
        let step = |i: usize| x[i] - x[i.saturating_sub(1)];
        let stiff = 1.0 / (big * (0.001 + 0.015 * s));
        // Beside a dashpot the friction is Coulomb's: the same at any speed.
        let falls = f64::from(self.cause != Cause::FrictionAndDashpot);
        let (drop, slow) = (0.5 * r * falls, (0.03 + 0.15 * q) * top);
        let mut bristle = 0.0_f64;
        // Implicit: bristles are stiff.
        let mut lugre = move |v: f64| {
            let level = 1.0 + drop * (-(v / slow).powi(2)).exp();
            bristle = (bristle + DT * v) / (1.0 + DT * stiff * v.abs() / level);
            stiff * bristle
        };
        match self.cause {
            Cause::Nothing | Cause::MoreDamping | Cause::MoreMass => vec![0.0; x.len()],
            Cause::Friction => each(&mut |i| lugre(v[i])),
            Cause::FrictionAndDashpot => {
                let dashpot = self.dashpot() / self.damping_unit() / self.size;
                each(&mut |i| lugre(v[i]) + dashpot * v[i] / top)
            }
            Cause::FrictionAndQuadratic => {
                each(&mut |i| lugre(v[i]) + (1.0 + r) * v[i] * v[i].abs() / top.powi(2))
            }
            Cause::FrictionAndHardening => {
                each(&mut |i| lugre(v[i]) + (1.0 + r) * (x[i] / big).powi(3))
            }
            Cause::PowerLaw => {
                let a = 0.5 + 0.4 * s;
                each(&mut |i| (v[i].abs() / top).powf(a).copysign(v[i]))
            }
            Cause::FluidDamper => {
                // k d = C |x' - d'|^a: a Maxwell element with a dashpot of power a.
                let (a, reach) = (0.6 + 0.4 * s, big * (0.1 + 0.4 * r));
                let mut z = 0.0_f64;
                each(&mut |i| {
                    let flow = top * z.abs().powf(1.0 / a).copysign(z);
                    z += DT / reach * (v[i] - flow);
                    z
                })
            }
            Cause::MrDamper => {
                // Yield force and viscosity in series with the oil's spring.
                let reach = big * (0.01 + 0.05 * s);
                let mut z = 0.0_f64;
                each(&mut |i| {
                    let over = (z.abs() - 1.0).max(0.0) * (0.1 + r).recip();
                    z += DT / reach * (v[i] - top * over.copysign(z));
                    z = z.clamp(-5.0, 5.0);
                    z
                })
            }
            Cause::Sliders => {
                let most = big * (0.1 + 0.4 * s);
                let mut sliders = [0.0_f64; 30];
                each(&mut |i| {
                    let mut sum = 0.0;
                    for (n, z) in sliders.iter_mut().enumerate() {
                        *z = (*z + step(i) * 30.0 / (most * (n + 1) as f64)).clamp(-1.0, 1.0);
                        sum += *z / 30.0;
                    }
                    sum
                })
            }
            Cause::RambergOsgood => {
                let (give, n) = (big * (0.1 + 0.2 * s), 2.0 + 6.0 * r);
                let mut z = 0.0_f64;
                each(&mut |i| {
                    let out = step(i) * z > 0.0;
                    z += step(i) / give * (1.0 - if out { z.abs().powf(n) } else { 0.0 });
                    z
                })
            }
            Cause::Degrading => {
                let give = big * (0.05 + 0.15 * s);
                let fades = (0.2 + 0.6 * r) / (20.0 * big);
                let (mut z, mut energy) = (0.0_f64, 0.0_f64);
                each(&mut |i| {
                    energy += (z * step(i)).max(0.0);
                    let (strength, stiffness) = (1.0 + fades * energy, 1.0 + q * fades * energy);
                    let out = if step(i) * z > 0.0 {
                        z.abs() * strength
                    } else {
                        0.0
                    };
                    z += step(i) / give * (1.0 - out) / stiffness;
                    z
                })
            }
            Cause::FadesWithPeak => {
                let mut peak = 0.0_f64;
                each(&mut |i| {
                    peak = peak.max(x[i].abs());
                    -LOST * x[i] * peak / big.powi(2)
                })
            }
            Cause::FadesWithTravel => {
                let (half, mut way) = (big * (10.0 + 50.0 * s), 0.0);
                each(&mut |i| {
                    way += step(i).abs();
                    -LOST * x[i] / big * way / (way + half)
                })
            }
            Cause::Pinching => {
                let (give, wide) = (big * (0.03 + 0.1 * s), big * (0.15 + 0.25 * r));
                let mut z = 0.0_f64;
                each(&mut |i| {
                    z = (z + step(i) / give).clamp(-1.0, 1.0);
                    z * (1.0 - (0.6 + 0.4 * q) * (-(x[i] / wide).powi(2)).exp())
                })
            }
            Cause::Flag => {
                // Yields going out at 1 and returns at `back`: no force is left at zero displacement.
                let (give, back) = (big * (0.1 + 0.2 * s), 0.2 + 0.5 * r);
                let mut z = 0.0_f64;
                each(&mut |i| {
                    let trial = z + step(i) / give;
                    let envelope = x[i] / give;
                    let (low, high) = if x[i] >= 0.0 {
                        (envelope.min(back), envelope.min(1.0))
                    } else {
                        (envelope.max(-1.0), envelope.max(-back))
                    };
                    z = trial.clamp(low, high);
                    z
                })
            }
            Cause::Contact => {
                let gap = big * (0.3 + 0.4 * s);
                let both = q < 0.5;
                let depth = |x: f64| ((x - gap).max(0.0) / (big - gap)).powf(1.5);
                each(&mut |i| 2.0 * (depth(x[i]) - if both { depth(-x[i]) } else { 0.0 }))
            }
            Cause::GasSpring => {
                let stroke = big * (1.3 + 1.5 * s);
                each(&mut |i| 1.0 - (1.0 - x[i] / stroke).max(0.05).powf(-1.3))
                    .into_iter()
                    .map(|f| -f)
                    .collect()
            }
            Cause::Play => {
                let half = big * (0.05 + 0.2 * s);
                let mut at = x[0];
                let k = self.linear[0];
                x.iter()
                    .map(|x| {
                        at = at.clamp(x - half, x + half);
                        k * (at - x)
                    })
                    .collect()
            }
            Cause::Cogging => {
                let pitch = big * (0.15 + 0.2 * s);
                each(&mut |i| 0.7 * (TAU * x[i] / pitch).sin())
            }
            Cause::SecondAxis => {
                let lines = self.lines.clone();
                let start: Vec<f64> = lines.iter().map(|_| rng.between(0.0, TAU)).collect();
                each(&mut |i| {
                    let t = i as f64 * DT;
                    let sum = lines.iter().zip(&start);
                    0.4 * sum
                        .map(|([f, p], s)| (TAU * f * t + p + s).sin())
                        .sum::<f64>()
                })
            }
            Cause::PumpLine => {
                let hz = self.lines[0][0] * 3.0;
                let (mut phase, mut off) = (rng.between(0.0, TAU), 0.0);
                each(&mut |_| {
                    // Wanders by a few percent within seconds.
                    off += DT * (-off / 2.0 + 0.05 * rng.normal() / DT.sqrt());
                    phase += TAU * DT * hz * (1.0 + off);
                    0.5 * phase.sin()
                })
            }
        }
    }

    /// The key.
    pub(super) fn truth(&self, plan: &Plan) -> Truth {
        let own: (&[&str], &[&str]) = match self.cause {
            Cause::Nothing | Cause::Cogging | Cause::SecondAxis | Cause::PumpLine => (&[], &[]),
            Cause::Friction => (&FRICTION, &[]),
            Cause::FrictionAndDashpot => (&FRICTION_AND_DASHPOT, &[]),
            Cause::FadesWithPeak => (&["degradation"], &[]),
            // The overall loss looks like a wrong stiffness, but that is not all of it.
            Cause::FadesWithTravel => (&["degradation", "gain_error"], &[]),
            Cause::FrictionAndQuadratic => (
                &["coulomb_friction", "stribeck_friction", "quadratic_damping"],
                &["viscous_damping"],
            ),
            Cause::FrictionAndHardening => {
                (&["coulomb_friction", "stribeck_friction", "hardening"], &[])
            }
            Cause::MoreDamping => (&["viscous_damping"], &[]),
            Cause::MoreMass => (&["inertia_force"], &[]),
            Cause::PowerLaw => (&["viscous_damping"], &["coulomb_friction"]),
            Cause::FluidDamper => (
                &["maxwell_damper", "viscous_damping"],
                &["coulomb_friction"],
            ),
            Cause::MrDamper => (
                &[
                    "coulomb_friction",
                    "stribeck_friction",
                    "bilinear_hysteresis",
                    "bouc_wen_hysteresis",
                ],
                &["viscous_damping", "quadratic_damping"],
            ),
            Cause::Sliders | Cause::RambergOsgood | Cause::Degrading => {
                (&HYSTERESIS, &["softening", "hardening"])
            }
            Cause::Pinching => (&HYSTERESIS, &["hardening", "backlash", "coulomb_friction"]),
            Cause::Flag => (
                &["bilinear_hysteresis", "bouc_wen_hysteresis", "softening"],
                &["coulomb_friction", "saturation"],
            ),
            Cause::Contact => (&["hardening", "asymmetric_stiffness"], &[]),
            Cause::GasSpring => (&["hardening", "asymmetric_stiffness"], &["softening"]),
            Cause::Play => (&["backlash"], &["bilinear_hysteresis"]),
        };
        // Two kinds of force have the same shape at one frequency or at one speed.
        let alike = match plan.kind {
            Move::OneFrequency => matches!(
                self.cause,
                Cause::MoreDamping | Cause::MoreMass | Cause::FluidDamper
            ),
            Move::OneSpeed => matches!(
                self.cause,
                Cause::Friction
                    | Cause::FrictionAndDashpot
                    | Cause::MoreDamping
                    | Cause::PowerLaw
                    | Cause::FluidDamper
            ),
            _ => false,
        };
        // A dashpot that fits within the declared damping's tolerance is no second cause.
        let both = self.cause == Cause::FrictionAndDashpot
            && self.dashpot() > WITHIN * DAMPING_KNOWN * self.linear[1];
        Truth {
            cause: self.cause.name(),
            steps: false,
            whole: if both {
                FRICTION_AND_DASHPOT.to_vec()
            } else if self.cause == Cause::FadesWithTravel {
                vec!["degradation"]
            } else {
                Vec::new()
            },
            right: own.0.to_vec(),
            beside: own.1.to_vec(),
            nameless: matches!(
                self.cause,
                Cause::Cogging | Cause::SecondAxis | Cause::PumpLine
            ),
            inseparable: alike,
        }
    }
}
