//! The specimen as a shear frame: floors over storeys, from the ground up.

mod give_way;

use crate::kinematics::Kinematics;
use crate::specimen::Storey;

/// A floor, the storey below it and the mass on it.
#[derive(Clone, Debug)]
pub(crate) struct Floor {
    storey: Storey,
    drift: Kinematics,
    motion: Kinematics,
    mass_kg: f64,
    /// By what the floor falls short of where the actuator's dynamics would put it, m/N.
    gives_m_per_n: f64,
    shear_n: f64,
    restoring_n: f64,
}

impl Floor {
    /// At rest at zero, sampled `rate_hz` times a second.
    pub(crate) fn new(storey: Storey, mass_kg: f64, gives_m_per_n: f64, rate_hz: f64) -> Self {
        Self {
            storey,
            drift: Kinematics::new(rate_hz),
            motion: Kinematics::new(rate_hz),
            mass_kg,
            gives_m_per_n,
            shear_n: 0.0,
            restoring_n: 0.0,
        }
    }

    /// Displacement of the floor, m.
    #[inline]
    pub(crate) fn displacement_m(&self) -> f64 {
        self.motion.displacement_m()
    }

    /// Force on the actuator without inertia, N.
    #[inline]
    pub(crate) fn restoring_n(&self) -> f64 {
        self.restoring_n
    }

    /// Force on the load cell, N.
    #[inline]
    pub(crate) fn force_n(&self) -> f64 {
        self.restoring_n + self.mass_kg * self.motion.acceleration_m_s2()
    }
}

/// All floors.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    floors: Vec<Floor>,
    at_m: Vec<f64>,
    gives_way: bool,
}

impl Frame {
    pub(crate) fn new(floors: Vec<Floor>) -> Self {
        Self {
            at_m: vec![0.0; floors.len()],
            gives_way: floors.iter().any(|floor| floor.gives_m_per_n > 0.0),
            floors,
        }
    }

    #[inline]
    pub(crate) fn floors(&self) -> &[Floor] {
        &self.floors
    }

    /// Puts the floors where the actuators' dynamics would have them, less what gives way to the forces there.
    #[inline]
    pub(crate) fn step(&mut self, wanted_m: impl Iterator<Item = f64>) {
        if self.gives_way {
            for (at, wanted) in self.at_m.iter_mut().zip(wanted_m) {
                *at = wanted;
            }
            give_way::find_equilibrium(&self.floors, &mut self.at_m);
            Self::advance(&mut self.floors, self.at_m.iter().copied());
        } else {
            Self::advance(&mut self.floors, wanted_m);
        }
        let mut above_n = 0.0;
        for floor in self.floors.iter_mut().rev() {
            floor.restoring_n = floor.shear_n - above_n;
            above_n = floor.shear_n;
        }
    }
    /// Every floor goes to where it is, from the ground up; the storeys below answer with their shear.
    #[inline]
    fn advance(floors: &mut [Floor], at_m: impl Iterator<Item = f64>) {
        let mut below = 0.0;
        for (floor, at) in floors.iter_mut().zip(at_m) {
            floor.motion.advance(at);
            floor.drift.advance(at - below);
            floor.shear_n = floor.storey.step(&floor.drift);
            below = at;
        }
    }
}
