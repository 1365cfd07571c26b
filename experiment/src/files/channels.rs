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

/// Everything of a trace but time, step and flags.
pub fn of(trace: &Trace) -> Vec<Channel<'_>> {
    let mut channels = Vec::new();
    for (j, floor) in trace.floors.iter().enumerate() {
        let axis = if j == 0 {
            String::new()
        } else {
            (j + 1).to_string()
        };
        for (quantity, suffix, unit, values) in [
            ("command", "m", "m", &floor.sent_m),
            ("displacement", "m", "m", &floor.displacement_m),
            ("force", "n", "N", &floor.force_n),
            ("target", "m", "m", &floor.command_m),
            (
                "estimated_displacement",
                "m",
                "m",
                &floor.estimated_displacement_m,
            ),
            ("estimated_force", "n", "N", &floor.estimated_force_n),
            ("velocity", "m_per_s", "m/s", &floor.velocity_m_per_s),
            (
                "acceleration",
                "m_per_s2",
                "m/s^2",
                &floor.acceleration_m_per_s2,
            ),
            (
                "added_damping",
                "n_s_per_m",
                "N s/m",
                &floor.added_damping_n_s_per_m,
            ),
            ("gain", "1", "1", &floor.gain),
        ] {
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
