//! A two-chamber ram under position control: orifice flow, compressible oil, leakage, seals and a second-order valve (Merritt,
//! Hydraulic Control Systems, 1967, chapters 3 and 6). Its declared values were fitted without a load.

use super::mark::Truth;
use crate::draws::Draws;
use crate::fine::{DT, delay, lag, rms};
use std::f64::consts::TAU;

/// The undeclared fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fault {
    Sound,
    Sag,
    SingleRod,
    SoftHoses,
    TightSeals,
    Overlap,
    SmallValve,
}

/// The name of a ram without a fault.
pub const SOUND_RAM: &str = "a sound ram";

/// Half of the rams are sound.
const TURNS: [Fault; 12] = [
    Fault::Sound,
    Fault::Sag,
    Fault::Sound,
    Fault::SingleRod,
    Fault::Sound,
    Fault::SoftHoses,
    Fault::Sound,
    Fault::TightSeals,
    Fault::Sound,
    Fault::Overlap,
    Fault::Sound,
    Fault::SmallValve,
];

impl Fault {
    pub(super) const fn of(seed: u64) -> Self {
        TURNS[(seed % TURNS.len() as u64) as usize]
    }

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Sound => SOUND_RAM,
            Self::Sag => "a supply that sags",
            Self::SingleRod => "a single rod",
            Self::SoftHoses => "soft hoses",
            Self::TightSeals => "tight seals",
            Self::Overlap => "an overlapped valve",
            Self::SmallValve => "a valve too small",
        }
    }

    pub(super) const ALL: [Self; 7] = [
        Self::Sound,
        Self::Sag,
        Self::SingleRod,
        Self::SoftHoses,
        Self::TightSeals,
        Self::Overlap,
        Self::SmallValve,
    ];
}

/// Supply pressure, Pa.
const SUPPLY: f64 = 21e6;
/// Piston area on the head side, m^2.
const AREA: f64 = 8e-3;
/// Moving mass, kg.
const MASS: f64 = 350.0;
/// Length of a chamber with the piston in the middle, m. `DEAD_LENGTH` adds the oil in the hoses as chamber length.
const HALF_STROKE: f64 = 0.125;
const DEAD_LENGTH: f64 = 0.03;
/// Simulation steps of the oil in one step of the fine grid.
const SUBSTEPS: usize = 4;

/// A ram, with lengths in m.
#[derive(Clone, Debug)]
pub(super) struct Ram {
    fault: Fault,
    delay_s: f64,
    lag_s: f64,
    valve_hz: f64,
    oil_hz: f64,
    /// Stiffness that it works against, N/m; `seals` is the friction of its seals, N.
    load: f64,
    seals: f64,
    /// Speed at full opening, m/s.
    speed: f64,
    overlap: f64,
    area_ratio: f64,
    sag: f64,
}

impl Ram {
    pub(super) fn draw(
        fault: Fault,
        amplitude_mm: f64,
        speed_mm_per_s: f64,
        rng: &mut Draws,
    ) -> Self {
        let of = |f: Fault, yes: f64, no: f64| if fault == f { yes } else { no };
        let top = 1e-3 * speed_mm_per_s;
        let large = rng.between(2.0, 4.0);
        Self {
            fault,
            delay_s: rng.between(5e-4, 2e-3),
            lag_s: rng.between(10e-3, 25e-3),
            valve_hz: rng.between(60.0, 120.0),
            oil_hz: of(
                Fault::SoftHoses,
                rng.between(14.0, 20.0),
                rng.between(70.0, 110.0),
            ),
            load: rng.between(0.0, 4e4) / (1e-3 * amplitude_mm),
            seals: of(
                Fault::TightSeals,
                rng.between(4e3, 7e3),
                rng.between(1e2, 4e2),
            ),
            speed: top * of(Fault::SmallValve, rng.between(0.75, 0.95), large),
            overlap: of(Fault::Overlap, rng.between(0.05, 0.08), 0.0),
            area_ratio: of(Fault::SingleRod, rng.between(0.5, 0.7), 1.0),
            sag: of(Fault::Sag, rng.between(0.3, 0.5), 0.0),
        }
    }

    /// The same ram with a sound one's values in place of the faulty ones.
    pub(super) fn sound(&self, speed_mm_per_s: f64, rng: &Draws) -> Self {
        let own = Self::draw(Fault::Sound, 1.0, speed_mm_per_s, &mut rng.clone());
        let is = |fault| self.fault == fault;
        Self {
            fault: Fault::Sound,
            oil_hz: if is(Fault::SoftHoses) {
                own.oil_hz
            } else {
                self.oil_hz
            },
            seals: if is(Fault::TightSeals) {
                own.seals
            } else {
                self.seals
            },
            speed: if is(Fault::SmallValve) {
                own.speed
            } else {
                self.speed
            },
            overlap: own.overlap,
            area_ratio: own.area_ratio,
            sag: own.sag,
            ..self.clone()
        }
    }

    /// Delay and lag in s, valve and oil frequency in Hz, load in N/m.
    pub(super) const fn numbers(&self) -> [f64; 5] {
        [
            self.delay_s,
            self.lag_s,
            self.valve_hz,
            self.oil_hz,
            self.load,
        ]
    }

    /// The same ram with these numbers.
    pub(super) fn with(&self, [delay_s, lag_s, valve_hz, oil_hz, load]: [f64; 5]) -> Self {
        Self {
            delay_s,
            lag_s,
            valve_hz,
            oil_hz,
            load,
            ..self.clone()
        }
    }

    /// Ranges of these numbers in sound rams.
    pub(super) fn sound_ranges(&self) -> [[f64; 2]; 5] {
        let load = (2.0 * self.load).max(1e5);
        [
            [0.0, 6e-3],
            [5e-3, 40e-3],
            [50.0, 150.0],
            [60.0, 130.0],
            [0.0, load],
        ]
    }

    /// The same ram without its load.
    fn calm(&self) -> Self {
        Self {
            load: 0.0,
            ..self.clone()
        }
    }

    /// Gain, delay in ms, lag in ms and offset in mm, as a laboratory fits them to another motion of half the size, without
    /// a load. Faults come later and do not affect the fit; only a valve that is too small was there already.
    pub(super) fn identified(&self, command_mm: &[f64], rng: &mut Draws) -> [f64; 4] {
        let mut sound = self.calm();
        if self.fault != Fault::SmallValve {
            let own = Self::draw(Fault::Sound, 1.0, 1.0, &mut rng.clone());
            (sound.oil_hz, sound.seals) = (own.oil_hz.max(70.0), own.seals);
            (sound.overlap, sound.area_ratio, sound.sag) = (0.0, 1.0, 0.0);
        }
        let half: Vec<f64> = command_mm.iter().map(|u| 0.5 * u).collect();
        let x = sound.displacement(&half);
        let left = |delay_s: f64, lag_s: f64| {
            let y = lag(&delay(&half, delay_s), lag_s);
            let (n, sy, sx) = (y.len() as f64, y.iter().sum::<f64>(), x.iter().sum::<f64>());
            let yy: f64 = y.iter().map(|y| y * y).sum();
            let xy: f64 = y.iter().zip(&x).map(|(y, x)| y * x).sum();
            let gain = (n * xy - sx * sy) / (n * yy - sy * sy);
            let zero = (sx - gain * sy) / n;
            let rest: Vec<f64> = y.iter().zip(&x).map(|(y, x)| x - gain * y - zero).collect();
            ([gain, 1e3 * delay_s, 1e3 * lag_s, zero], rms(&rest))
        };
        let (mut at, mut reach) = ([2e-3, self.lag_s], [2e-3, 0.5 * self.lag_s]);
        for _ in 0..9 {
            let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| [f64::from(i), f64::from(j)]));
            let tried = around.map(|[i, j]| {
                let place = [
                    (at[0] + i * reach[0]).max(0.0),
                    (at[1] + j * reach[1]).max(1e-3),
                ];
                (place, left(place[0], place[1]).1)
            });
            let best = tried.min_by(|a, b| a.1.total_cmp(&b.1));
            at = best.map_or(at, |b| b.0);
            reach = reach.map(|r| 0.6 * r);
        }
        left(at[0], at[1]).0
    }

    /// Displacement in response to a command, mm.
    pub(super) fn displacement(&self, command_mm: &[f64]) -> Vec<f64> {
        let late = delay(command_mm, self.delay_s);
        let h = DT / SUBSTEPS as f64;
        let areas = [AREA, AREA * self.area_ratio];
        let length = HALF_STROKE + DEAD_LENGTH;
        // The bulk modulus that gives the oil's frequency at mid-stroke.
        let bulk = MASS * (TAU * self.oil_hz).powi(2) * length / (areas[0] + areas[1]);
        let flow_gain = self.speed * AREA / (0.5 * SUPPLY).sqrt();
        let gain = 1.0 / (self.lag_s * self.speed);
        let valve = TAU * self.valve_hz;
        let leak = 0.02 * self.speed * AREA / SUPPLY;
        let mut x = 1e-3 * late[0];
        let hold = self.load * x;
        let mut p = [0.5 * SUPPLY + 0.5 * hold / areas[0], 0.0];
        p[1] = (p[0] * areas[0] - hold) / areas[1];
        let (mut v, mut spool, mut spool_v, mut bristle, mut pump) = (0.0, 0.0, 0.0, 0.0, SUPPLY);
        let mut out = Vec::with_capacity(late.len());
        for u in late {
            let wanted = (gain * (1e-3 * u - x)).clamp(-1.0, 1.0);
            for _ in 0..SUBSTEPS {
                spool_v += h * (valve * valve * (wanted - spool) - 1.4 * valve * spool_v);
                spool += h * spool_v;
                let open = spool - spool.clamp(-self.overlap, self.overlap);
                let into = |opening: f64, p: f64| {
                    let drop: f64 = if opening > 0.0 { pump - p } else { p };
                    flow_gain * opening * drop.abs().sqrt() * drop.signum()
                };
                let (q1, q2) = (into(open, p[0]), into(-open, p[1]));
                let across = leak * (p[0] - p[1]);
                let [l1, l2] = [length + x, length - x].map(|l| l.max(0.01));
                p[0] += h * bulk / (areas[0] * l1) * (q1 - areas[0] * v - across);
                p[1] += h * bulk / (areas[1] * l2) * (q2 + areas[1] * v + across);
                // The flow lowers the supply pressure until the accumulator has caught up.
                let drawn = (q1.max(0.0) + q2.max(0.0)) / (self.speed * AREA);
                pump += h / 0.3 * (SUPPLY * (1.0 - self.sag * drawn) - pump);
                bristle += h * (v - v.abs() * bristle / 2e-5);
                let friction = self.seals * bristle / 2e-5 + 1e3 * v;
                let oil_damping = 0.3 * MASS * TAU * self.oil_hz;
                let pull = p[0] * areas[0] - p[1] * areas[1] - self.load * x - friction;
                v += h * (pull - oil_damping * (v - open * self.speed)) / MASS;
                x += h * v;
            }
            out.push(1e3 * x);
        }
        out
    }

    /// The key.
    pub(super) fn truth(&self) -> Truth {
        // All rams have some friction, and a fault also changes the dynamics.
        let timing = &[
            "lag_error",
            "delay_error",
            "second_lag",
            "oil_column",
            "gain_error",
            "coulomb_friction",
        ][..];
        let (right, beside, nameless): (&[&str], &[&str], bool) = match self.fault {
            Fault::Sound => (&[], &[], false),
            Fault::Sag => (&[], &[], true),
            Fault::SingleRod => (&["asymmetric_actuator"], timing, false),
            Fault::SoftHoses => (&["oil_column", "second_lag"], timing, false),
            Fault::TightSeals => (&["coulomb_friction", "stribeck_friction"], timing, false),
            Fault::Overlap => (&["dead_band"], timing, false),
            Fault::SmallValve => (&["rate_limit", "saturation"], timing, false),
        };
        Truth {
            cause: self.fault.name(),
            right: right.to_vec(),
            beside: beside.to_vec(),
            nameless,
            ..Truth::default()
        }
    }
}
