//! `record.csv`: every quantity of every step, in the format of recorded data.

use crate::bench::Trace;
use std::fmt::Write as _;

/// The record as CSV. Numbers are written with as many digits as they need to read back to the same bits.
pub fn to_csv(trace: &Trace) -> String {
    let mut text = String::with_capacity(trace.time_s.len() * 200);
    let mut columns: Vec<(String, &[f32])> = Vec::new();
    for (j, floor) in trace.floors.iter().enumerate() {
        let at = if j == 0 {
            String::new()
        } else {
            format!("_{}", j + 1)
        };
        for (quantity, unit, values) in [
            ("command", "m", &floor.command_m),
            ("displacement", "m", &floor.displacement_m),
            ("force", "n", &floor.force_n),
            (
                "estimateddisplacement",
                "m",
                &floor.estimated_displacement_m,
            ),
            ("estimatedforce", "n", &floor.estimated_force_n),
            ("velocity", "mpers", &floor.velocity_m_per_s),
            ("acceleration", "mpers2", &floor.acceleration_m_per_s2),
            ("addeddamping", "nsperm", &floor.added_damping_n_s_per_m),
            ("gain", "1", &floor.gain),
        ] {
            columns.push((format!("{quantity}{at}_{unit}"), values));
        }
    }
    for (name, values) in [
        ("ground_mpers2", &trace.ground_m_per_s2),
        ("energystiffness_j", &trace.energy_stiffness_j),
        ("energyhsem_j", &trace.energy_hsem_j),
        ("energymodified_j", &trace.energy_modified_j),
        ("energyinput_j", &trace.energy_input_j),
        ("energyratio_1", &trace.energy_ratio),
    ] {
        columns.push((name.into(), values));
    }
    text.push_str("time_s");
    for (name, _) in &columns {
        let _ = write!(text, ",{name}");
    }
    text.push_str(",step_1,flags_1\n");
    for i in 0..trace.time_s.len() {
        let _ = write!(text, "{}", trace.time_s[i]);
        for (_, values) in &columns {
            let _ = write!(text, ",{}", values[i]);
        }
        let _ = writeln!(text, ",{},{}", trace.step[i], trace.flags[i]);
    }
    text
}
