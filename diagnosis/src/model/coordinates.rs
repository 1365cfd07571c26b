//! What is declared of a specimen of several coordinates.

use crate::model::declared::{Declared, LARGEST_TOLERANCE};
use crate::record::refusal::Refusal;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The matrices, in the order of the unknowns of a row: what a displacement, a velocity and an acceleration is multiplied by.
pub const MATRICES: [&str; 3] = ["stiffness", "damping", "mass"];

/// Coordinates that one specimen can have.
const MOST_COORDINATES: usize = 8;

/// Stiffness, damping and mass of a specimen of several coordinates. Entry `[i][j]` is the force on coordinate `i` by the
/// motion of coordinate `j`, in N, N m, m, rad and s.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CoupledSpecimen {
    /// Names, each with its unit at the end: `x_m`, `rotation_rad`. The first is axis 1 of a record.
    pub coordinates: Vec<String>,
    /// Force per displacement: N/m, N/rad, N m/rad.
    pub stiffness: Vec<Vec<Declared>>,
    /// Force per velocity: N s/m, N s/rad, N m s/rad; left out: none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub damping: Vec<Vec<Declared>>,
    /// Force per acceleration: kg, kg m, kg m^2; left out: none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub mass: Vec<Vec<Declared>>,
}

/// Whether a coordinate is an angle, by its name; `None` where the name says no unit.
fn turns(coordinate: &str) -> Option<bool> {
    let has = |unit: &str| {
        coordinate
            .strip_suffix(unit)
            .is_some_and(|name| !name.is_empty())
    };
    match (has("_m"), has("_rad")) {
        (true, _) => Some(false),
        (_, true) => Some(true),
        _ => None,
    }
}

impl CoupledSpecimen {
    /// How many coordinates there are.
    pub fn count(&self) -> usize {
        self.coordinates.len()
    }

    /// Whether coordinate `i` is an angle, with a moment where others have a force.
    pub fn is_rotation(&self, i: usize) -> bool {
        turns(&self.coordinates[i]) == Some(true)
    }

    /// The unit of what coordinate `i` is resisted with.
    pub fn force_unit(&self, i: usize) -> &'static str {
        if self.is_rotation(i) { "N m" } else { "N" }
    }

    /// The unit of an entry of matrix `which`, [`MATRICES`].
    pub fn unit(&self, which: usize, row: usize, column: usize) -> &'static str {
        match (which, self.is_rotation(row), self.is_rotation(column)) {
            (0, false, false) => "N/m",
            (0, false, true) => "N/rad",
            (0, true, false) => "N m/m",
            (0, true, true) => "N m/rad",
            (1, false, false) => "N s/m",
            (1, false, true) => "N s/rad",
            (1, true, false) => "N m s/m",
            (1, true, true) => "N m s/rad",
            (_, false, false) => "kg",
            (_, true, true) => "kg m^2",
            _ => "kg m",
        }
    }

    /// The unknowns of a row: its stiffnesses, dampings and masses.
    pub fn row(&self, i: usize) -> Vec<Declared> {
        let nothing = Declared {
            value: 0.0,
            tolerance: 0.0,
        };
        self.matrices()
            .into_iter()
            .flat_map(|matrix| match matrix.get(i) {
                Some(row) => row.clone(),
                None => vec![nothing; self.count()],
            })
            .collect()
    }

    fn matrices(&self) -> [&Vec<Vec<Declared>>; 3] {
        [&self.stiffness, &self.damping, &self.mass]
    }

    /// The same with other entries; `rows` as of [`CoupledSpecimen::row`].
    pub(crate) fn with_rows(&self, rows: &[Vec<Declared>]) -> Self {
        let n = self.count();
        let matrix = |which: usize| {
            let part = |row: &Vec<Declared>| row[which * n..(which + 1) * n].to_vec();
            rows.iter().map(part).collect()
        };
        Self {
            coordinates: self.coordinates.clone(),
            stiffness: matrix(0),
            damping: matrix(1),
            mass: matrix(2),
        }
    }

    /// Whether the matrices are whole and every number can be what it stands for.
    ///
    /// # Errors
    /// With the place of what is wrong.
    pub fn check(&self) -> Result<(), Refusal> {
        let n = self.count();
        if !(1..=MOST_COORDINATES).contains(&n) {
            return Err(Refusal::new(format!(
                "coupled.coordinates has {n} names: accepted are 1 to {MOST_COORDINATES}"
            )));
        }
        for (i, name) in self.coordinates.iter().enumerate() {
            if turns(name).is_none() {
                return Err(Refusal::new(format!(
                    "coupled.coordinates: `{name}` says no unit: accepted are names that end with _m or _rad, such as x_m"
                )));
            }
            if self.coordinates[..i].contains(name) {
                return Err(Refusal::new(format!(
                    "coupled.coordinates: `{name}` stands twice: accepted are different names"
                )));
            }
        }
        for (name, matrix) in MATRICES.into_iter().zip(self.matrices()) {
            if matrix.is_empty() && name != "stiffness" {
                continue;
            }
            if matrix.len() != n || matrix.iter().any(|row| row.len() != n) {
                let lengths: Vec<String> = matrix.iter().map(|r| r.len().to_string()).collect();
                return Err(Refusal::new(format!(
                    "coupled.{name} has rows of [{}] entries: accepted are {n} rows of {n}, one for each coordinate",
                    lengths.join(", ")
                )));
            }
            for (i, row) in matrix.iter().enumerate() {
                for (j, Declared { value, tolerance }) in row.iter().enumerate() {
                    if !value.is_finite() {
                        return Err(Refusal::new(format!(
                            "coupled.{name}, row {}, column {}: value = {value} is refused: accepted are finite numbers",
                            i + 1,
                            j + 1
                        )));
                    }
                    if !(0.0..=LARGEST_TOLERANCE).contains(tolerance) {
                        return Err(Refusal::new(format!(
                            "coupled.{name}, row {}, column {}: tolerance = {tolerance:e} is refused: accepted are 0 to 1e9",
                            i + 1,
                            j + 1
                        )));
                    }
                }
            }
        }
        Ok(())
    }
}
