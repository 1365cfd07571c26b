//! What a board records in addition to displacement and force: the test does not depend on it, but it reveals faults.

use link::channel::ChannelCalibration;
use link::reply::Identity;
use link::telemetry::{Input, MAX_INPUTS, StepReport};
use link::{CodeRange, MAX_ACTUATORS};
use outerloop_core::Fault;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write as _;

/// Offset of an output and of its read-back that is no fault, as a fraction of the converter's range: the chip's own
/// DAC and ADC have 12 and 5 codes of 4095 by the data sheet; converters behind resistors or of 16 bits have less.
const OFFSET_SHARE: f64 = 0.005;
/// Allowed change of that offset since the test began: some codes of 12 bits.
const DRIFT_SHARE: f64 = 0.001;
/// Allowed gain error, as a fraction of the command.
const GAIN_SHARE: f64 = 0.01;

/// The further inputs of a running test.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct FurtherInputs {
    /// Largest difference between a command as read back at its converter and as sent, m, of any actuator.
    pub command_off_m: Option<f64>,
    /// The same for each actuator, from the first; null where nothing is read back.
    pub commands_off_m: Vec<Option<f64>>,
    /// Of each actuator the command read back less the command sent in its first step, m.
    #[serde(skip)]
    at_start_m: Vec<Option<f64>>,
    /// Of each actuator the step in which it was furthest beyond what two converters may be apart: by how much it was off,
    /// and what is allowed, m.
    #[serde(skip)]
    beyond: Vec<Option<(f64, f64)>>,
    #[serde(skip)]
    inputs: Vec<Input>,
    #[serde(skip)]
    codes: CodeRange,
    #[serde(skip)]
    span_v: [f32; 2],
    /// Each actuator's command from its codes.
    #[serde(skip)]
    lines: Vec<ChannelCalibration>,
    #[serde(skip)]
    rows: Vec<Row>,
}

/// A control step: its number, the active commands, m, NaN if unknown, and the input codes.
type Row = (u32, [f32; MAX_ACTUATORS], [u16; MAX_INPUTS]);

impl FurtherInputs {
    /// For a board; `None` if it has no such inputs.
    pub fn of(identity: &Identity) -> Option<Self> {
        let lines: Vec<ChannelCalibration> = identity.calibrations().map(|c| c.command).collect();
        (!identity.inputs.is_empty()).then(|| Self {
            command_off_m: None,
            commands_off_m: vec![None; lines.len()],
            at_start_m: vec![None; lines.len()],
            beyond: vec![None; lines.len()],
            inputs: identity.inputs.iter().copied().collect(),
            codes: identity.codes,
            span_v: identity.input_span_v,
            lines,
            rows: Vec::new(),
        })
    }

    /// Adds a control step of the running test. `command_m`: the active commands, for as many actuators as are known.
    pub fn add_step(&mut self, tick: u32, command_m: &[f32], step: &StepReport) {
        let known = |actuator: usize| command_m.get(actuator).copied().unwrap_or(f32::NAN);
        self.rows
            .push((tick, std::array::from_fn(known), step.inputs));
        for (input, &code) in self.inputs.iter().zip(&step.inputs) {
            let Input::CommandReadBack(actuator) = *input else {
                continue;
            };
            let actuator = usize::from(actuator);
            let (Some(line), Some(&sent_m)) = (self.lines.get(actuator), command_m.get(actuator))
            else {
                continue;
            };
            let apart_m = f64::from(line.quantity(code) - sent_m);
            let since_m = apart_m - *self.at_start_m[actuator].get_or_insert(apart_m);
            let off_m = apart_m.abs();
            let range_m = f64::from(line.per_code.abs()) * f64::from(self.codes.command_top);
            let gain_m = GAIN_SHARE * f64::from(sent_m.abs());
            for worst in [&mut self.commands_off_m[actuator], &mut self.command_off_m] {
                *worst = Some(worst.unwrap_or(0.0).max(off_m));
            }
            let beyond = &mut self.beyond[actuator];
            for (off_m, allowed_m) in [
                (off_m, OFFSET_SHARE * range_m + gain_m),
                (since_m.abs(), DRIFT_SHARE * range_m + gain_m),
            ] {
                let worst_m = beyond.map_or(0.0, |(off_m, allowed_m)| off_m - allowed_m);
                if off_m - allowed_m > worst_m {
                    *beyond = Some((off_m, allowed_m));
                }
            }
        }
    }

    /// Compares the commands that left the board with those sent, and explains the result for a test that tripped.
    pub fn sentence(&self, trip: Option<Fault>) -> Option<String> {
        let worst_m = self.command_off_m?;
        let several = self.lines.len() > 1;
        let dead = (1..).zip(&self.beyond).find_map(|(n, b)| b.map(|b| (n, b)));
        if let Some((number, (off_m, allowed_m))) = dead {
            let whose = if several {
                format!(" of actuator {number}")
            } else {
                String::new()
            };
            return Some(format!(
                "The command{whose}, read back at the output converter, was {:.3} mm off what was sent, where two converters may be {:.3} mm apart: it did not leave the board as it was sent, so look at the output converter and its wires before the valve.",
                off_m * 1e3,
                allowed_m * 1e3
            ));
        }
        let which = if several {
            "Each actuator's command"
        } else {
            "The command"
        };
        let off = format!(
            "{which}, read back at the output converter, was within {:.3} mm of what was sent",
            worst_m * 1e3
        );
        let follows = matches!(trip, Some(Fault::Tracking | Fault::StaleSample));
        Some(if follows {
            format!("{off}: look at the valve, the oil and the PERMIT chain.")
        } else {
            format!("{off}.")
        })
    }

    /// As a table: time since the first step, the commands as sent, and each input. From the second actuator on, its
    /// number follows the quantity.
    pub fn to_csv(&self, rate_hz: f64) -> String {
        let number = |actuator: usize| match actuator {
            0 => String::new(),
            other => (other + 1).to_string(),
        };
        let mut text = String::from("time_s");
        for actuator in 0..self.lines.len() {
            let _ = write!(text, ",command{}_m", number(actuator));
        }
        for input in &self.inputs {
            let _ = match input {
                Input::CommandReadBack(actuator) => {
                    write!(
                        text,
                        ",command_read_back{}_m",
                        number(usize::from(*actuator))
                    )
                }
                Input::SecondDisplacement => write!(text, ",displacement_2_v"),
                Input::HeadAcceleration => write!(text, ",head_acceleration_v"),
            };
        }
        text.push('\n');
        let first = self.rows.first().map_or(0, |row| row.0);
        for (tick, command_m, codes) in &self.rows {
            let time_s = f64::from(tick.wrapping_sub(first)) / rate_hz;
            let _ = write!(text, "{time_s}");
            for command_m in &command_m[..self.lines.len()] {
                let _ = match command_m.is_nan() {
                    true => write!(text, ","),
                    false => write!(text, ",{command_m}"),
                };
            }
            for (input, &code) in self.inputs.iter().zip(codes) {
                let shown = match input {
                    Input::CommandReadBack(actuator) => self
                        .lines
                        .get(usize::from(*actuator))
                        .map_or(f64::NAN, |line| f64::from(line.quantity(code))),
                    Input::SecondDisplacement | Input::HeadAcceleration => {
                        Input::volts(code, self.codes.sensor_top, self.span_v)
                    }
                };
                let _ = write!(text, ",{shown}");
            }
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(actuators: usize, inputs: Vec<Input>) -> FurtherInputs {
        FurtherInputs {
            command_off_m: None,
            commands_off_m: vec![None; actuators],
            at_start_m: vec![None; actuators],
            beyond: vec![None; actuators],
            inputs,
            codes: CodeRange {
                sensor_top: u16::MAX,
                sensor_rail: 65,
                sensor_spare: 1638,
                command_top: u16::MAX,
                command_spare: 1638,
            },
            span_v: [-10.0, 10.0],
            lines: vec![ChannelCalibration::over(0.05, u16::MAX); actuators],
            rows: Vec::new(),
        }
    }

    fn board() -> FurtherInputs {
        with(
            1,
            vec![Input::CommandReadBack(0), Input::SecondDisplacement],
        )
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
            inputs: [back, u16::MAX, 7, 0, 0],
        }
    }

    #[test]
    fn a_dead_converter_is_told_from_a_dead_valve() {
        let mut works = board();
        let mut dead = board();
        for (tick, command_m) in [(10, 0.0_f32), (11, 0.002), (12, 0.004)] {
            let line = works.lines[0];
            let exact = command_m / line.per_code + line.zero_code;
            works.add_step(tick, &[command_m], &step(command_m, (exact + 0.5) as u16));
            dead.add_step(tick, &[command_m], &step(command_m, 32_768));
        }
        assert!(works.command_off_m.unwrap() < 2e-6);
        assert!((dead.command_off_m.unwrap() - 0.004).abs() < 2e-6);
        let said = |f: &FurtherInputs| f.sentence(Some(Fault::Tracking)).unwrap();
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
    fn of_several_the_dead_one_is_named_and_a_command_that_is_not_known_says_nothing() {
        let all = [0, 1, 2].map(Input::CommandReadBack).to_vec();
        let mut three = with(3, all);
        let line = three.lines[0];
        let code = |m: f32| (m / line.per_code + line.zero_code + 0.5) as u16;
        let mut now = step(0.004, code(0.004));
        now.inputs = [code(0.004), code(0.003), 32_768, 0, 0];
        // For a step that was not recomputed only the first actuator's command is known.
        three.add_step(9, &[0.004], &now);
        assert_eq!(three.commands_off_m[1..], [None, None]);
        assert!(three.sentence(None).unwrap().starts_with("Each actuator"));
        three.add_step(10, &[0.004, 0.003, -0.005], &now);
        let said = three.sentence(Some(Fault::Tracking)).unwrap();
        assert!(said.starts_with("The command of actuator 3"), "{said}");
        assert!(said.contains("look at the output converter"), "{said}");
        let text = three.to_csv(2000.0);
        let lines: Vec<_> = text.lines().collect();
        assert!(
            lines[0].ends_with(
                "command3_m,command_read_back_m,command_read_back2_m,command_read_back3_m"
            )
        );
        assert!(lines[1].starts_with("0,0.004,,,"), "{text}");
    }

    #[test]
    fn the_table_has_a_column_an_input_and_a_row_a_step() {
        let mut all = board();
        all.add_step(10, &[0.0], &step(0.0, 32_768));
        all.add_step(12, &[0.001], &step(0.001, 33_000));
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
