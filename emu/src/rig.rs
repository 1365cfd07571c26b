//! The simulated rig behind the converters, of either kind.

use link::MAX_ACTUATORS;
use plant::Rig;
use plant::coupled::{CoupledReading, CoupledRig};

/// A rig.
#[derive(Debug)]
pub enum AnyRig {
    /// Each actuator moves a floor of its own.
    Direct(Rig),
    /// The first two actuators hold a coupler; the third has no load. While the valves are shut, their last reading holds.
    Coupled(CoupledRig, CoupledReading),
}

impl From<Rig> for AnyRig {
    fn from(rig: Rig) -> Self {
        Self::Direct(rig)
    }
}

impl From<CoupledRig> for AnyRig {
    fn from(rig: CoupledRig) -> Self {
        Self::Coupled(rig, CoupledReading::default())
    }
}

impl AnyRig {
    /// One period with held commands, m, of which the rig uses as many as it has actuators; returns displacement, m, and force,
    /// N, of each. `moves`: it has permission.
    pub fn step(&mut self, command_m: &[f64], moves: bool) -> [[f64; 2]; MAX_ACTUATORS] {
        let mut read = [[0.0; 2]; MAX_ACTUATORS];
        match self {
            Self::Direct(rig) => {
                let reading = rig.step(command_m);
                let each = reading.displacement_m.iter().zip(&reading.force_n);
                for (place, (m, n)) in read.iter_mut().zip(each) {
                    *place = [*m, *n];
                }
            }
            Self::Coupled(rig, last) => {
                if moves {
                    *last = rig.step([0, 1].map(|i| command_m.get(i).copied().unwrap_or(0.0)));
                }
                for (place, (m, n)) in read.iter_mut().zip(last.stroke_m.iter().zip(last.force_n)) {
                    *place = [*m, n];
                }
            }
        }
        read
    }

    /// Whether the rig's reading is where the valves sent the actuator; not so where the command of one also moves the other.
    pub fn goes_where_it_is_sent(&self) -> bool {
        matches!(self, Self::Direct(_))
    }
}
