//! Converts the declarations of a test file to the settings of core's loop.

use super::table::{
    CoupledCompensation, CoupledLimits, CoupledStructure, CoupledTable, SpreadTable,
};
use crate::failure::Failure;
use crate::floors::with_floors;
use outerloop_core::coupled::{
    Bounds, CoupledRig, CoupledSettings, Coupler, EstimatorSettings, Parameter, Plant, Spreads,
    TrackerSettings, observed,
};
use outerloop_core::{Config, Design, Refusal, Structure, accept, modes};
use plant::coupled::ActuatorPairSpec;
use std::f64::consts::TAU;

/// Checks that the test can be run at all, whatever its compensation.
///
/// # Errors
/// The first refused value, with what would be accepted.
pub fn check(c: &CoupledTable, config: &Config) -> Result<(), String> {
    structure_shape(&c.structure)?;
    let physical = &c.specimen;
    for (name, m) in [
        ("stiffness", &physical.stiffness),
        ("damping", &physical.damping),
        ("mass", &physical.mass),
    ] {
        let crossed = name == "mass" && m[0][1] != 0.0;
        if m[0][1] != m[1][0] || crossed || !m.as_flattened().iter().all(|x| x.is_finite()) {
            return Err(format!(
                "coupled.specimen.{name} = {m:?} is refused: accepted is a symmetric matrix{}",
                if name == "mass" {
                    " without cross terms"
                } else {
                    ""
                }
            ));
        }
    }
    c.actuators
        .check("coupled.actuators")
        .map_err(|e| e.to_string())?;
    within_range(c).map_err(|e| e.to_string())?;
    let limits = &c.limits;
    let optional = [
        ("force_stands_m", limits.force_stands_m),
        ("disagree_m", limits.disagree_m),
    ];
    let optional = optional
        .into_iter()
        .filter_map(|(name, limit)| Some((name, limit?)));
    for (name, value) in limits.named().into_iter().chain(optional) {
        if !(value > 0.0 && value.is_finite()) {
            return Err(format!(
                "coupled.limits.{name} = {value} is refused: accepted are numbers above 0"
            ));
        }
    }
    for kind in CoupledCompensation::ALL {
        let settings = with_floors!(c.structure.coordinates.len(), N => {
            design::<N>(c, config, kind).map(drop)
        });
        settings.map_err(|e| e.to_string())?;
    }
    Ok(())
}

/// Checks the numbers that core does not have under their keys.
fn within_range(c: &CoupledTable) -> Result<(), Refusal> {
    let (spread, observer) = (c.spread, c.observer);
    for (key, ratio) in [
        ("coupled.spread.slow_pole_ratio", spread.slow_pole_ratio),
        ("coupled.spread.fast_pole_ratio", spread.fast_pole_ratio),
        ("coupled.spread.lead_ratio", spread.lead_ratio),
        ("coupled.spread.path_lead_ratio", spread.path_lead_ratio),
        ("coupled.spread.natural_ratio", spread.natural_ratio),
        ("coupled.spread.gain_ratio", spread.gain_ratio),
    ] {
        accept(key, ratio, (0.0..=0.5).contains(&ratio), "0 to 0.5")?;
    }
    let (noise_mm, ratio) = (c.noise_mm, observer.noise_ratio);
    let between = |x: f64, below: f64| x > 0.0 && x < below;
    let accepted = "numbers above 0, below 1000";
    accept(
        "coupled.noise_mm",
        noise_mm,
        between(noise_mm, 1e3),
        accepted,
    )?;
    let accepted = "numbers above 0, below 1";
    accept(
        "coupled.observer.noise_ratio",
        ratio,
        between(ratio, 1.0),
        accepted,
    )?;
    for p in observer.process {
        accept("coupled.observer.process", p, p > 0.0, "numbers above 0")?;
    }
    Ok(())
}

impl CoupledLimits {
    /// Every limit that is a magnitude, by its key.
    pub(super) fn named(&self) -> [(&'static str, f64); 13] {
        [
            ("stroke_m", self.stroke_m),
            ("velocity_m_per_s", self.velocity_m_per_s),
            ("force_n", self.force_n),
            ("tracking_m", self.tracking_m),
            ("x_m", self.x_m),
            ("x_velocity_m_per_s", self.x_velocity_m_per_s),
            ("x_force_n", self.x_force_n),
            ("x_tracking_m", self.x_tracking_m),
            ("rotation_rad", self.rotation_rad),
            (
                "rotation_velocity_rad_per_s",
                self.rotation_velocity_rad_per_s,
            ),
            ("moment_n_m", self.moment_n_m),
            ("rotation_tracking_rad", self.rotation_tracking_rad),
            ("frozen_m", self.frozen_m),
        ]
    }
}

/// Checks that every list has a value for every coordinate.
fn structure_shape(s: &CoupledStructure) -> Result<(), String> {
    let n = s.coordinates.len();
    if !(2..=8).contains(&n) {
        return Err(format!(
            "coupled.structure.coordinates has {n} names: accepted are 2 to 8"
        ));
    }
    for (i, name) in s.coordinates.iter().enumerate() {
        let wanted = match i {
            0 => name.ends_with("_m"),
            1 => name.ends_with("_rad"),
            _ => name.ends_with("_m") || name.ends_with("_rad"),
        };
        if !wanted || name.contains([',', ' ', '"']) {
            return Err(format!(
                "coupled.structure.coordinates has \"{name}\" at place {}: accepted are names that end with _m or _rad, first a \
                 displacement (_m), then a rotation (_rad)",
                i + 1
            ));
        }
    }
    for (name, m) in [("mass", &s.mass), ("stiffness", &s.stiffness)] {
        let square = m.len() == n && m.iter().all(|row| row.len() == n);
        let fine =
            square && (0..n).all(|i| (0..n).all(|j| m[i][j].is_finite() && m[i][j] == m[j][i]));
        if !fine {
            return Err(format!(
                "coupled.structure.{name} = {m:?} is refused: accepted is a symmetric matrix of {n} rows and {n} columns, as \
                 many as coordinates"
            ));
        }
    }
    for j in 0..n {
        let moved = s.influence.as_ref().map_or(0.0, |list| list.at(j));
        if moved.is_nan() || moved.abs() > 1e3 {
            return Err(format!(
                "coupled.structure.influence is {moved} for {}: accepted are numbers from -1000 to 1000: one, or {n}",
                s.coordinates[j]
            ));
        }
        let ratio = s.damping_ratio.at(j);
        if !(0.0..1.0).contains(&ratio) {
            return Err(format!(
                "coupled.structure.damping_ratio is {ratio} for mode {}: accepted are numbers from 0, below 1: one, or {n}",
                j + 1
            ));
        }
    }
    Ok(())
}

/// The settings of the loop with a compensation.
///
/// # Errors
/// The first value refused by core.
pub fn of<const N: usize>(
    c: &CoupledTable,
    config: &Config,
    kind: CoupledCompensation,
) -> Result<CoupledSettings<N>, Failure> {
    let refused = |e: Refusal| Failure::input(e);
    let limits = &c.limits;
    let whole = structure::<N>(c)?;
    let noise = |limit: f64| c.observer.noise_ratio * limit;
    let period_s = 1.0 / config.timing.rate_hz;
    let observer = |axis: usize, limit: f64| {
        observed(&whole, axis, noise(limit), c.observer.process[axis])
            // In single precision, like the tracker's period.
            .and_then(|o| o.steady(f64::from(period_s as f32)))
            .map_err(refused)
    };
    let target = [observer(0, limits.x_m)?, observer(1, limits.rotation_rad)?];
    let mut numerical = whole;
    for (row, k) in numerical
        .numerical_stiffness
        .iter_mut()
        .zip(&c.specimen.stiffness)
    {
        row.iter_mut().zip(k).for_each(|(all, part)| *all -= part);
    }
    for (row, k) in numerical.damping.iter_mut().zip(&c.specimen.damping) {
        row.iter_mut().zip(k).for_each(|(all, part)| *all -= part);
    }
    for j in 0..2 {
        numerical.physical_mass_kg[j] = c.specimen.mass[j][j];
    }
    let estimated = kind == CoupledCompensation::Coupled;
    Ok(CoupledSettings {
        structure: numerical,
        tracker: TrackerSettings {
            coupler: Coupler {
                pin_x_m: c.coupler.pin_x_m.map(|x| x as f32),
                pin_y_m: c.coupler.pin_y_m.map(|x| x as f32),
            },
            estimate: EstimatorSettings {
                plant: plant(&c.actuators, kind == CoupledCompensation::Uncoupled),
                spreads: if estimated {
                    spreads(&c.actuators, &c.spread)
                } else {
                    Spreads::new()
                },
                noise_m: (1e-3 * c.noise_mm) as f32,
                period_s: period_s as f32,
            },
            inverse: kind != CoupledCompensation::None,
            target,
            ahead_s: 0.0,
            trust_reading_hz: c.trust_reading_hz as f32,
        },
        interface: [
            Bounds {
                position: limits.x_m,
                speed_per_s: limits.x_velocity_m_per_s,
                force: limits.x_force_n,
                tracking: limits.x_tracking_m,
            },
            Bounds {
                position: limits.rotation_rad,
                speed_per_s: limits.rotation_velocity_rad_per_s,
                force: limits.moment_n_m,
                tracking: limits.rotation_tracking_rad,
            },
        ],
    })
}

/// The loop with a compensation.
///
/// # Errors
/// The first value refused by core.
pub fn design<const N: usize>(
    c: &CoupledTable,
    config: &Config,
    kind: CoupledCompensation,
) -> Result<Design<N, CoupledRig>, Failure> {
    Design::coupled(config, &of::<N>(c, config, kind)?).map_err(Failure::input)
}

/// The whole structure, physical and numerical parts.
fn structure<const N: usize>(c: &CoupledTable) -> Result<Structure<N>, Failure> {
    let s = &c.structure;
    let square = |m: &[Vec<f64>]| std::array::from_fn(|i| std::array::from_fn(|j| m[i][j]));
    let (mass, stiffness) = (square(&s.mass), square(&s.stiffness));
    let (omegas, shapes) = modes::<N>(&mass, &stiffness).ok_or_else(|| {
        Failure::input(
            "coupled.structure.mass is refused: accepted is a positive definite matrix, and one with which the stiffness has \
             frequencies",
        )
    })?;
    if let Some(mode) = omegas.iter().position(|w| w.is_nan() || *w <= 0.0) {
        return Err(Failure::input(format!(
            "coupled.structure.stiffness leaves mode {} without a frequency: accepted is a positive definite matrix",
            mode + 1
        )));
    }
    // C = sum of 2 zeta omega (M phi) (M phi)^T: Chopra, Dynamics of Structures, section 11.4.
    let mut damping = [[0.0; N]; N];
    for r in 0..N {
        let pushed: [f64; N] =
            std::array::from_fn(|i| (0..N).map(|j| mass[i][j] * shapes[j][r]).sum());
        let twice = 2.0 * s.damping_ratio.at(r) * omegas[r];
        for (row, left) in damping.iter_mut().zip(pushed) {
            row.iter_mut()
                .zip(pushed)
                .for_each(|(c, right)| *c += twice * left * right);
        }
    }
    let influence = std::array::from_fn(|i| match &s.influence {
        Some(list) => list.at(i),
        None => f64::from(u8::from(s.coordinates[i].ends_with("_m"))),
    });
    Ok(Structure {
        mass,
        damping,
        stiffness,
        numerical_stiffness: stiffness,
        influence,
        physical: 2,
        physical_mass_kg: [0.0; N],
    })
}

/// Natural frequencies of the whole structure, Hz, from the lowest.
///
/// # Errors
/// A refused structure.
pub fn natural_frequencies_hz(c: &CoupledTable) -> Result<Vec<f64>, Failure> {
    with_floors!(c.structure.coordinates.len(), N => {
        let whole = structure::<N>(c)?;
        let w = whole
            .natural_frequencies_rad_per_s()
            .map_err(Failure::input)?;
        Ok(w.iter().map(|w| w / TAU).collect())
    })
}

/// The actuators as in core; `alone`: without their interaction.
fn plant(a: &ActuatorPairSpec, alone: bool) -> Plant {
    let single = |m: &[[f64; 2]; 2], factor: f64| m.map(|row| row.map(|x| (factor * x) as f32));
    let (mut gain, mut path_lead_s) = (single(&a.gain, 1.0), single(&a.path_lead_ms, 1e-3));
    if alone {
        for m in [&mut gain, &mut path_lead_s] {
            (m[0][1], m[1][0]) = (0.0, 0.0);
        }
    }
    Plant {
        gain,
        slow_pole_rad_per_s: a.slow_pole_hz.map(|hz| (TAU * hz) as f32),
        fast_pole_rad_per_s: a.fast_pole_hz.map(|hz| (TAU * hz) as f32),
        lead_s: single(&a.lead_ms, 1e-3),
        path_lead_s,
        natural_rad_per_s: (TAU * a.natural_hz) as f32,
        damping_ratio: a.damping_ratio as f32,
        delay_s: a.delay_ms.map(|ms| (1e-3 * ms) as f32),
    }
}

/// What is estimated: every number that is present and has a spread.
fn spreads(a: &ActuatorPairSpec, s: &SpreadTable) -> Spreads {
    use Parameter::{FastPole, Gain, Lead, NaturalFrequency, PathLead, SlowPole};
    let pairs = [(0, 0), (0, 1), (1, 0), (1, 1)];
    let mut all: Vec<(Parameter, f64)> = Vec::new();
    for j in 0..2 {
        all.push((SlowPole(j), s.slow_pole_ratio));
        all.push((FastPole(j), s.fast_pole_ratio));
    }
    all.push((NaturalFrequency, s.natural_ratio));
    for (i, j) in pairs {
        if a.lead_ms[i][j] != 0.0 {
            all.push((Lead(i, j), s.lead_ratio));
        }
        if a.path_lead_ms[i][j] != 0.0 {
            all.push((PathLead(i, j), s.path_lead_ratio));
        }
        if a.gain[i][j] != 0.0 {
            all.push((Gain(i, j), s.gain_ratio));
        }
    }
    all.into_iter()
        .filter(|(_, spread)| *spread > 0.0)
        .map(|(p, spread)| (p, spread as f32))
        .collect()
}

/// A number of the actuators: its key, its unit, and its value in a plant of core.
type Named = (&'static str, &'static str, fn(&Plant) -> f32);

/// The numbers of the actuators that a test may estimate.
pub const NAMED: [Named; 17] = [
    ("slow_pole_hz.0", "Hz", |p| p.slow_pole_rad_per_s[0] / HZ),
    ("slow_pole_hz.1", "Hz", |p| p.slow_pole_rad_per_s[1] / HZ),
    ("fast_pole_hz.0", "Hz", |p| p.fast_pole_rad_per_s[0] / HZ),
    ("fast_pole_hz.1", "Hz", |p| p.fast_pole_rad_per_s[1] / HZ),
    ("natural_hz", "Hz", |p| p.natural_rad_per_s / HZ),
    ("lead_ms.0.0", "ms", |p| 1e3 * p.lead_s[0][0]),
    ("lead_ms.0.1", "ms", |p| 1e3 * p.lead_s[0][1]),
    ("lead_ms.1.0", "ms", |p| 1e3 * p.lead_s[1][0]),
    ("lead_ms.1.1", "ms", |p| 1e3 * p.lead_s[1][1]),
    ("path_lead_ms.0.0", "ms", |p| 1e3 * p.path_lead_s[0][0]),
    ("path_lead_ms.0.1", "ms", |p| 1e3 * p.path_lead_s[0][1]),
    ("path_lead_ms.1.0", "ms", |p| 1e3 * p.path_lead_s[1][0]),
    ("path_lead_ms.1.1", "ms", |p| 1e3 * p.path_lead_s[1][1]),
    ("gain.0.0", "1", |p| p.gain[0][0]),
    ("gain.0.1", "1", |p| p.gain[0][1]),
    ("gain.1.0", "1", |p| p.gain[1][0]),
    ("gain.1.1", "1", |p| p.gain[1][1]),
];

const HZ: f32 = std::f32::consts::TAU;

/// The actuators of the file, as in core.
pub fn plant_of(a: &ActuatorPairSpec) -> Plant {
    plant(a, false)
}
