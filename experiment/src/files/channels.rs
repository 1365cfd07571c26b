//! The channels of a test's record, with their names: `quantity_unit`, as recorded data have them
//! ([`super::recording`]), and several axes told apart by a number after the quantity.

use crate::trace::Trace;

/// A channel: its name and unit, a value a control step.
#[derive(Clone, Debug)]
pub struct Channel<'a> {
    /// `command_m`, `force2_n`, ...
    pub name: String,
    /// Its unit, written as an engineer would.
    pub unit: &'static str,
    /// Single precision, as the controller has it.
    pub values: &'a [f32],
}

/// A unit in a name, and as an engineer would write it.
type Unit = (&'static str, &'static str);

const M: Unit = ("m", "m");
const N: Unit = ("n", "N");
const ONE: Unit = ("1", "1");
/// Length, force, speed, acceleration, damping.
const MOTION: [&Unit; 5] = [
    &M,
    &N,
    &("m_per_s", "m/s"),
    &("m_per_s2", "m/s^2"),
    &("n_s_per_m", "N s/m"),
];
/// The same of a rotation.
const ROTATION: [&Unit; 5] = [
    &("rad", "rad"),
    &("n_m", "N m"),
    &("rad_per_s", "rad/s"),
    &("rad_per_s2", "rad/s^2"),
    &("n_m_s_per_rad", "N m s/rad"),
];

/// Everything of a trace but time, step and flags.
pub fn of(trace: &Trace) -> Vec<Channel<'_>> {
    let mut channels = Vec::new();
    for (j, floor) in trace.floors.iter().enumerate() {
        let axis = if j == 0 {
            String::new()
        } else {
            (j + 1).to_string()
        };
        // Of coupled actuators, what was read and sent is an actuator's, and only the first two have one.
        let coupled = trace.coordinates.as_ref().and_then(|names| names.get(j));
        let own = if coupled.is_some() { "actuator_" } else { "" };
        let rotates = coupled.is_some_and(|name| name.ends_with("_rad"));
        let read = [
            ("command", &M, &floor.sent_m),
            ("displacement", &M, &floor.displacement_m),
            ("force", &N, &floor.force_n),
        ];
        let read = read.into_iter().filter(|_| coupled.is_none() || j < 2);
        let [length, force, speed, acceleration, damping] = if rotates { ROTATION } else { MOTION };
        let of_structure = [
            ("target", length, &floor.command_m),
            (
                "estimated_displacement",
                length,
                &floor.estimated_displacement_m,
            ),
            ("estimated_force", force, &floor.estimated_force_n),
            ("velocity", speed, &floor.velocity_m_per_s),
            ("acceleration", acceleration, &floor.acceleration_m_per_s2),
            ("added_damping", damping, &floor.added_damping_n_s_per_m),
            ("gain", &ONE, &floor.gain),
        ];
        let read = read.map(|(quantity, unit, values)| (format!("{own}{quantity}"), unit, values));
        let others =
            of_structure.map(|(quantity, unit, values)| (quantity.to_owned(), unit, values));
        for (quantity, (suffix, unit), values) in read.chain(others) {
            channels.push(Channel {
                name: format!("{quantity}{axis}_{suffix}"),
                unit,
                values,
            });
        }
    }
    for (name, unit, values) in [
        (
            "ground_acceleration_m_per_s2",
            "m/s^2",
            &trace.ground_m_per_s2,
        ),
        ("energy_error_j", "J", &trace.energy_modified_j),
        ("energy_error_hsem_j", "J", &trace.energy_hsem_j),
        ("energy_error_stiffness_j", "J", &trace.energy_stiffness_j),
        ("energy_input_j", "J", &trace.energy_input_j),
        ("energy_ratio_1", "1", &trace.energy_ratio),
    ] {
        channels.push(Channel {
            name: name.into(),
            unit,
            values,
        });
    }
    channels
}
