//! The channels of a test's record, with their names: `quantity_unit`, as in recorded data ([`super::recording`]), with
//! several axes distinguished by a number after the quantity.

use super::quantities::axis_number;
use crate::coupled::interface::InterfaceTrace;
use crate::trace::{FloorTrace, Trace};

/// A channel: its name, its unit, and one value per control step.
#[derive(Clone, Debug)]
pub struct Channel<'a> {
    /// `command_m`, `force2_n`, ...
    pub name: String,
    /// Its unit, as an engineer would write it.
    pub unit: &'static str,
    /// In single precision, as in the controller.
    pub values: &'a [f32],
}

/// A unit as in a name, and as an engineer would write it.
type Unit = (&'static str, &'static str);

const M: Unit = ("m", "m");
const N: Unit = ("n", "N");
const ONE: Unit = ("1", "1");
/// Length, force, velocity, acceleration, damping.
const MOTION: [&Unit; 5] = [
    &M,
    &N,
    &("m_per_s", "m/s"),
    &("m_per_s2", "m/s^2"),
    &("n_s_per_m", "N s/m"),
];
/// The same for a rotation.
const ROTATION: [&Unit; 5] = [
    &("rad", "rad"),
    &("n_m", "N m"),
    &("rad_per_s", "rad/s"),
    &("rad_per_s2", "rad/s^2"),
    &("n_m_s_per_rad", "N m s/rad"),
];

/// Name and unit of a column, and its values.
type Column<'a> = (&'static str, &'static Unit, &'a [f32]);

/// Everything in a trace except time, step and flags.
pub fn of(trace: &Trace) -> Vec<Channel<'_>> {
    let mut channels = Vec::new();
    for (j, floor) in trace.floors.iter().enumerate() {
        let axis = axis_number(j);
        let columns = match &trace.interface {
            None => of_floor(floor).into(),
            Some(interface) => of_coordinate(interface, floor, j),
        };
        for (quantity, (suffix, unit), values) in columns {
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

fn of_floor(floor: &FloorTrace) -> [Column<'_>; 10] {
    let [length, force, speed, acceleration, damping] = MOTION;
    [
        column("command", length, &floor.sent_m),
        column("displacement", length, &floor.displacement_m),
        column("force", force, &floor.force_n),
        column("target", length, &floor.command_m),
        column(
            "estimated_displacement",
            length,
            &floor.estimated_displacement_m,
        ),
        column("estimated_force", force, &floor.estimated_force_n),
        column("velocity", speed, &floor.velocity_m_per_s),
        column("acceleration", acceleration, &floor.acceleration_m_per_s2),
        column("added_damping", damping, &floor.added_damping_n_s_per_m),
        column("gain", &ONE, &floor.gain),
    ]
}

/// For two coupled actuators: coordinate `j` of the structure, and actuator `j` if there is one. The force of x and
/// rotation is the resultant of the measured forces.
fn of_coordinate<'a>(
    interface: &'a InterfaceTrace,
    floor: &'a FloorTrace,
    j: usize,
) -> Vec<Column<'a>> {
    let rotates = interface.coordinates[j].ends_with("_rad");
    let [length, force, speed, acceleration, _] = if rotates { ROTATION } else { MOTION };
    let mut columns = vec![
        column("target", length, &floor.command_m),
        column("velocity", speed, &floor.velocity_m_per_s),
        column("acceleration", acceleration, &floor.acceleration_m_per_s2),
    ];
    if j < 2 {
        columns.extend([
            column("displacement", length, &interface.displacement[j]),
            column("force", force, &floor.estimated_force_n),
            column(
                "estimated_displacement",
                length,
                &floor.estimated_displacement_m,
            ),
            column("true_displacement", length, &interface.truth[j]),
            column("actuator_target", &M, &interface.wanted_m[j]),
            column("actuator_command", &M, &floor.sent_m),
            column("actuator_displacement", &M, &floor.displacement_m),
            column(
                "true_actuator_displacement",
                &M,
                &interface.true_stroke_m[j],
            ),
            column("actuator_force", &N, &floor.force_n),
        ]);
    }
    columns
}

fn column<'a>(quantity: &'static str, unit: &'static Unit, values: &'a [f32]) -> Column<'a> {
    (quantity, unit, values)
}
