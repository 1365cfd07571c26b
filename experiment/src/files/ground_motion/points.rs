//! The common result of all formats: points in m/s^2, and notes on them.

use super::fortran;
use crate::failure::Failure;
use crate::files::header::unit_named;

/// Command-line information about a file that lacks it.
#[derive(Clone, Copy, Debug, Default)]
pub struct ColumnChoice {
    /// `--dt`, s.
    pub interval_s: Option<f64>,
    /// `--unit`.
    pub unit: Option<AccelerationUnit>,
}

/// Unit of an acceleration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "options", derive(clap::ValueEnum))]
#[non_exhaustive]
pub enum AccelerationUnit {
    /// Standard gravity, 9.80665 m/s^2.
    #[cfg_attr(feature = "options", value(name = "g"))]
    G,
    /// m/s^2.
    #[cfg_attr(feature = "options", value(name = "m/s2"))]
    MetrePerSecondSquared,
    /// cm/s^2.
    #[cfg_attr(feature = "options", value(name = "gal"))]
    Gal,
}

impl AccelerationUnit {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::G => "g",
            Self::MetrePerSecondSquared => "m/s2",
            Self::Gal => "gal",
        }
    }

    pub(super) fn in_si(self) -> f64 {
        match self {
            Self::G => 9.80665,
            Self::MetrePerSecondSquared => 1.0,
            Self::Gal => 0.01,
        }
    }

    /// The unit with this name, in lower case.
    pub(super) fn named(name: &str) -> Option<Self> {
        match unit_named(name)? {
            "g" => Some(Self::G),
            "m_per_s2" => Some(Self::MetrePerSecondSquared),
            "gal" => Some(Self::Gal),
            _ => None,
        }
    }
}

/// The contents of a file.
pub(super) struct Points {
    pub(super) interval_s: f64,
    pub(super) acc_m_per_s2: Vec<f64>,
    /// The unit stated in the file; `None` if it was given separately.
    pub(super) unit: Option<AccelerationUnit>,
}

/// Refuses a line, counted from 0, part of which is not what it should be.
pub(super) fn refuse_line(file: &str, line: usize, text: &str, accepted: &str) -> Failure {
    let shown: String = text.trim().chars().take(SHOWN).collect();
    let line = line + 1;
    Failure::input(format!(
        "{file}, line {line}: `{shown}` is refused: accepted is {accepted}"
    ))
}

/// Number of a line's characters shown in a message.
pub(super) const SHOWN: usize = 60;

/// All numbers from line `from`, counted from 0, to the end, in m/s^2.
pub(super) fn values(
    file: &str,
    text: &str,
    from: usize,
    width: Option<usize>,
    unit: AccelerationUnit,
) -> Result<Vec<f64>, Failure> {
    let mut acc = Vec::new();
    for (i, line) in text.lines().enumerate().skip(from) {
        for value in fortran::numbers(line, width) {
            let value = value.map_err(|word| refuse_line(file, i, word, "a finite number"))?;
            acc.push(value * unit.in_si());
        }
    }
    Ok(acc)
}
