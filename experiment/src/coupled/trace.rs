//! What a test of two coupled actuators leaves: every quantity of every control step, in both systems of coordinates.

use super::part::CoupledPart;
use crate::trace::{AnyRecord, TestObserver};
use plant::coupled::CouplerSpec;
use std::fmt::Write as _;

/// A quantity of both actuators, or of x and rotation.
pub type Both = [Vec<f32>; 2];

/// Every control step of a running test, by column.
#[derive(Clone, Debug, Default)]
pub struct CoupledTrace {
    /// Control rate, Hz.
    pub rate_hz: f64,
    /// Names of the coordinates, with their units.
    pub coordinates: Vec<String>,
    /// Where each coordinate of the structure is to be now, m or rad.
    pub target: Vec<Vec<f32>>,
    /// Where x and rotation are, by the readings.
    pub displacement: Both,
    /// The same as the loop estimates it.
    pub estimated: Both,
    /// Where they truly are.
    pub truth: Both,
    /// Force along x and moment, as the loop has them of the readings.
    pub force: Both,
    /// What was sent to each actuator for this sample, m.
    pub command_m: Both,
    /// Strokes as read, m.
    pub stroke_m: Both,
    /// Strokes as they are, m.
    pub true_stroke_m: Both,
    /// Where each stroke is to be now, m.
    pub wanted_m: Both,
    /// Forces of the actuators as read, N.
    pub actuator_n: Both,
    /// Ground acceleration, m/s^2.
    pub ground_m_per_s2: Vec<f32>,
}

impl CoupledTrace {
    /// Number of control steps.
    pub fn len(&self) -> usize {
        self.ground_m_per_s2.len()
    }

    /// True if the test has not begun.
    pub fn is_empty(&self) -> bool {
        self.ground_m_per_s2.is_empty()
    }

    /// As recorded data have it: coordinate 1 is axis 1, and what is an actuator's own says so. `diagnose` reads targets,
    /// displacements and forces of x and rotation from it.
    pub fn to_csv(&self) -> String {
        let mut columns: Vec<(String, &[f32])> = Vec::new();
        for (i, (target, name)) in self.target.iter().zip(&self.coordinates).enumerate() {
            let (axis, rotates) = (number(i), name.ends_with("_rad"));
            let unit = if rotates { "rad" } else { "m" };
            columns.push((format!("target{axis}_{unit}"), target));
            if i < 2 {
                let force = if rotates { "n_m" } else { "n" };
                columns.push((format!("displacement{axis}_{unit}"), &self.displacement[i]));
                columns.push((format!("force{axis}_{force}"), &self.force[i]));
                columns.push((
                    format!("estimated_displacement{axis}_{unit}"),
                    &self.estimated[i],
                ));
                columns.push((format!("true_displacement{axis}_{unit}"), &self.truth[i]));
            }
        }
        for i in 0..2 {
            let axis = number(i);
            columns.extend([
                (
                    format!("actuator_target{axis}_m"),
                    self.wanted_m[i].as_slice(),
                ),
                (format!("actuator_command{axis}_m"), &self.command_m[i]),
                (format!("actuator_displacement{axis}_m"), &self.stroke_m[i]),
                (
                    format!("true_actuator_displacement{axis}_m"),
                    &self.true_stroke_m[i],
                ),
                (format!("actuator_force{axis}_n"), &self.actuator_n[i]),
            ]);
        }
        columns.push(("ground_acceleration_m_per_s2".into(), &self.ground_m_per_s2));
        let mut text = String::with_capacity(self.len() * 12 * (columns.len() + 1));
        text.push_str("time_s");
        for (name, _) in &columns {
            let _ = write!(text, ",{name}");
        }
        text.push('\n');
        for k in 0..self.len() {
            let _ = write!(text, "{}", k as f64 / self.rate_hz);
            for (_, values) in &columns {
                let _ = write!(text, ",{:?}", values[k]);
            }
            text.push('\n');
        }
        text
    }
}

/// Keeps a running test in both systems of coordinates.
#[derive(Debug)]
pub(super) struct InBothCoordinates<'a> {
    coupler: &'a CouplerSpec,
    pub(super) trace: CoupledTrace,
}

impl<'a> InBothCoordinates<'a> {
    /// No step yet.
    pub(super) fn of(part: &'a CoupledPart, rate_hz: f64) -> Self {
        let coordinates = part.declared.structure.coordinates.clone();
        Self {
            coupler: &part.declared.coupler,
            trace: CoupledTrace {
                rate_hz,
                target: vec![Vec::new(); coordinates.len()],
                coordinates,
                ..CoupledTrace::default()
            },
        }
    }
}

impl TestObserver for InBothCoordinates<'_> {
    fn on_step(&mut self, step: &AnyRecord<'_>) {
        let Some(reading) = step.coupled else {
            return;
        };
        let (trace, coupler) = (&mut self.trace, self.coupler);
        trace.ground_m_per_s2.push(step.ground_m_per_s2);
        for (column, u) in trace.target.iter_mut().zip(step.command_m) {
            column.push(*u);
        }
        let read = coupler.interface(reading.stroke_m);
        let wanted = coupler.strokes_m([0, 1].map(|i| f64::from(step.command_m[i])));
        for i in 0..2 {
            trace.displacement[i].push(read[i] as f32);
            trace.estimated[i].push(step.estimated_displacement_m[i]);
            trace.truth[i].push(reading.true_interface[i] as f32);
            trace.force[i].push(step.estimated_force_n[i]);
            trace.command_m[i].push(step.sent_m[i]);
            trace.stroke_m[i].push(reading.stroke_m[i] as f32);
            trace.true_stroke_m[i].push(reading.true_stroke_m[i] as f32);
            trace.wanted_m[i].push(wanted[i] as f32);
            trace.actuator_n[i].push(reading.force_n[i] as f32);
        }
    }
}

/// How axes are distinguished in a column's name.
fn number(i: usize) -> String {
    if i == 0 {
        String::new()
    } else {
        (i + 1).to_string()
    }
}
