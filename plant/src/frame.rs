//! The specimen as a shear frame: floors over storeys, from the ground up.

mod floor;
mod give_way;

use crate::effect::Additions;
pub(crate) use floor::Floor;

/// All floors.
#[derive(Clone, Debug)]
pub(crate) struct Floors {
    floors: Vec<Floor>,
    at_m: Vec<f64>,
    gives_way: bool,
}

impl Floors {
    pub(crate) fn new(floors: Vec<Floor>) -> Self {
        Self {
            at_m: vec![0.0; floors.len()],
            gives_way: floors.iter().any(|floor| floor.gives_m_per_n > 0.0),
            floors,
        }
    }

    /// Takes the effects that begin on floor `j` in the next period.
    pub(crate) fn begin(&mut self, j: usize, added: Additions) {
        self.floors[j].begin(added);
        self.gives_way = self.floors.iter().any(|floor| floor.gives_m_per_n > 0.0);
    }

    #[inline]
    pub(crate) fn floors(&self) -> &[Floor] {
        &self.floors
    }

    /// Moves the floors to the positions of the actuators' dynamics, minus the give under the forces there.
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
    /// Moves every floor to its position, from the ground up; the storeys below respond with their shear.
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
