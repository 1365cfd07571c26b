//! What a board records beside displacement and force: no part of the test hangs on it, and it tells what is broken.

use link::reply::Identity;
use link::telemetry::{Input, MAX_INPUTS, StepReport};
use outerloop_core::Fault;
use serde::Serialize;
use std::fmt::Write as _;

/// A command that reads back further off than this share of the converter's range did not leave the board as it was sent.
/// Two converters of 16 bits with their offsets and gains stay below a third of it.
const OFF_SHARE: f64 = 0.01;

/// The further inputs of a running test.
#[derive(Clone, Debug, Serialize)]
pub struct Further {
    /// Largest distance of the command as read back at its converter from the command as sent, m.
    pub command_off_m: Option<f64>,
    #[serde(skip)]
    range_m: f64,
    #[serde(skip)]
    inputs: Vec<Input>,
    #[serde(skip)]
    sensor_top: u16,
    #[serde(skip)]
    command: link::channel::Line,
    #[serde(skip)]
    rows: Vec<(u32, f32, [u16; MAX_INPUTS])>,
}

impl Further {
    /// Of a board; `None` if it has none.
    pub fn of(identity: &Identity) -> Option<Self> {
        let command = identity.calibration.command;
        let range_m = f64::from(command.per_code.abs()) * f64::from(identity.codes.command_top);
        (!identity.inputs.is_empty()).then(|| Self {
            command_off_m: None,
            range_m,
            inputs: identity.inputs.iter().copied().collect(),
            sensor_top: identity.codes.sensor_top,
            command,
            rows: Vec::new(),
        })
    }

    /// A control step of the running test.
    pub fn see(&mut self, tick: u32, step: &StepReport) {
        self.rows.push((tick, step.command_m, step.inputs));
        let back = self
            .inputs
            .iter()
            .position(|i| *i == Input::CommandReadBack);
        if let Some(&code) = back.and_then(|i| step.inputs.get(i)) {
            let off_m = f64::from((self.command.quantity(code) - step.command_m).abs());
            self.command_off_m = Some(self.command_off_m.unwrap_or(0.0).max(off_m));
        }
    }

    /// Whether the command left the board as it was sent, and what that says of a test that tripped.
    pub fn sentence(&self, trip: Option<Fault>) -> Option<String> {
        let off_m = self.command_off_m?;
        let off = format!(
            "The command, read back at the output converter, was within {:.3} mm of what was sent",
            off_m * 1e3
        );
        let follows = matches!(trip, Some(Fault::Tracking | Fault::StaleSample));
        Some(if off_m > OFF_SHARE * self.range_m {
            format!(
                "{off}, more than {:.1} mm: it did not leave the board as it was sent, so look at the output converter and its wires before the valve.",
                OFF_SHARE * self.range_m * 1e3
            )
        } else if follows {
            format!("{off}: look at the valve, the oil and the PERMIT chain.")
        } else {
            format!("{off}.")
        })
    }

    /// As a table: time since the first step, the command as sent, and each input.
    pub fn to_csv(&self, rate_hz: f64) -> String {
        let mut text = String::from("time_s,command_m");
        for input in &self.inputs {
            text.push_str(match input {
                Input::CommandReadBack => ",command_read_back_m",
                Input::SecondDisplacement => ",displacement_2_v",
                Input::HeadAcceleration => ",head_acceleration_v",
            });
        }
        text.push('\n');
        let first = self.rows.first().map_or(0, |row| row.0);
        for (tick, command_m, codes) in &self.rows {
            let time_s = f64::from(tick.wrapping_sub(first)) / rate_hz;
            let _ = write!(text, "{time_s},{command_m}");
            for (input, &code) in self.inputs.iter().zip(codes) {
                let _ = match input {
                    Input::CommandReadBack => write!(text, ",{}", self.command.quantity(code)),
                    Input::SecondDisplacement | Input::HeadAcceleration => {
                        write!(text, ",{}", Input::volts(code, self.sensor_top))
                    }
                };
            }
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use link::channel::Line;

    fn board() -> Further {
        Further {
            command_off_m: None,
            range_m: 0.1,
            inputs: vec![Input::CommandReadBack, Input::SecondDisplacement],
            sensor_top: u16::MAX,
            command: Line::over(0.05, u16::MAX),
            rows: Vec::new(),
        }
    }

    fn step(command_m: f32, back: u16) -> StepReport {
        StepReport {
            flags: 0,
            displacement: 0,
            force: 0,
            others: Default::default(),
            command_m,
            added_damping_n_s_per_m: 0.0,
            energy_j: 0.0,
            digest: 0,
            inputs: [back, u16::MAX, 7],
        }
    }

    #[test]
    fn a_dead_converter_is_told_from_a_dead_valve() {
        let mut works = board();
        let mut dead = board();
        for (tick, command_m) in [(10, 0.0_f32), (11, 0.002), (12, 0.004)] {
            let exact = command_m / works.command.per_code + works.command.zero_code;
            works.see(tick, &step(command_m, (exact + 0.5) as u16));
            dead.see(tick, &step(command_m, 32_768));
        }
        assert!(works.command_off_m.unwrap() < 2e-6);
        assert!((dead.command_off_m.unwrap() - 0.004).abs() < 2e-6);
        let said = |f: &Further| f.sentence(Some(Fault::Tracking)).unwrap();
        assert!(
            said(&works).contains("look at the valve"),
            "{}",
            said(&works)
        );
        assert!(
            said(&dead).contains("look at the output converter"),
            "{}",
            said(&dead)
        );
    }

    #[test]
    fn the_table_has_a_column_an_input_and_a_row_a_step() {
        let mut all = board();
        all.see(10, &step(0.0, 32_768));
        all.see(12, &step(0.001, 33_000));
        let text = all.to_csv(2000.0);
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(
            lines[0],
            "time_s,command_m,command_read_back_m,displacement_2_v"
        );
        assert!(
            lines[2].starts_with("0.001,0.001,") && lines[2].ends_with(",10"),
            "{text}"
        );
        assert_eq!(lines.len(), 3);
    }
}
