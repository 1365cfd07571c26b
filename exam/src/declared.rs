//! What the lab believes: the declared model.

use std::fmt::Write;

/// A declared value and its standard tolerance, in the unit of the parameter's name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// The declared value.
    pub value: f64,
    /// One standard tolerance.
    pub tolerance: f64,
}

impl Parameter {
    /// A value and a tolerance.
    pub const fn new(value: f64, tolerance: f64) -> Self {
        Self { value, tolerance }
    }
}

/// Command to displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeclaredActuator {
    /// Dimensionless.
    pub gain: Parameter,
    /// Transport delay, ms.
    pub delay_ms: Parameter,
    /// First-order time constant, ms.
    pub lag_ms: Parameter,
    /// mm; none if the model has no offset.
    pub offset_mm: Option<Parameter>,
}

/// Displacement to force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeclaredSpecimen {
    /// N/mm.
    pub stiffness_n_per_mm: Parameter,
    /// N s/mm; none if the model has no damping.
    pub damping_n_s_per_mm: Option<Parameter>,
    /// kg; none if the model has no mass.
    pub mass_kg: Option<Parameter>,
    /// N; none if the model has no offset.
    pub offset_n: Option<Parameter>,
}

/// The model file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Declared {
    /// `[actuator]`
    pub actuator: DeclaredActuator,
    /// `[specimen]`
    pub specimen: DeclaredSpecimen,
}

/// A line of the model file: a name, and its parameter if it is declared.
type Line = (&'static str, Option<Parameter>);

impl Declared {
    /// The model file's text.
    pub fn to_toml(&self) -> String {
        let (a, s) = (&self.actuator, &self.specimen);
        let tables: [(&str, &[Line]); 2] = [
            (
                "actuator",
                &[
                    ("gain", Some(a.gain)),
                    ("delay_ms", Some(a.delay_ms)),
                    ("lag_ms", Some(a.lag_ms)),
                    ("offset_mm", a.offset_mm),
                ],
            ),
            (
                "specimen",
                &[
                    ("stiffness_n_per_mm", Some(s.stiffness_n_per_mm)),
                    ("damping_n_s_per_mm", s.damping_n_s_per_mm),
                    ("mass_kg", s.mass_kg),
                    ("offset_n", s.offset_n),
                ],
            ),
        ];
        let mut text = String::new();
        for (table, parameters) in tables {
            let _ = writeln!(text, "[{table}]");
            for (name, parameter) in parameters {
                if let Some(Parameter { value, tolerance }) = parameter {
                    let _ = writeln!(
                        text,
                        "{name} = {{ value = {value:?}, tolerance = {tolerance:?} }}"
                    );
                }
            }
        }
        text
    }
}
