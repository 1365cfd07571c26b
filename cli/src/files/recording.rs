//! Recorded data: CSV whose header names `quantity_unit`, for example `time_s,command_mm,displacement_mm,force_kn`.
//!
//! Several axes are told apart by a number after the quantity: `force_n` is that of axis 1, `force2_n` that of axis 2.
//! [`crate::files::record_csv`] writes the same format.

use super::read;
use super::table::NumberTable;
use crate::failure::Failure;
use std::path::Path;

/// A unit, what it is in SI, and whether the SI value is the number as it stands.
type UnitOf = (&'static str, f64);

const LENGTH: &[UnitOf] = &[("m", 1.0), ("mm", 1e-3)];
const FORCE: &[UnitOf] = &[("n", 1.0), ("kn", 1e3), ("1", 1.0)];
const ENERGY: &[UnitOf] = &[("j", 1.0)];
const PLAIN: &[UnitOf] = &[("1", 1.0)];

/// The quantities that are known, and the units that each can have; the first is the one that is written.
const QUANTITIES: &[(&str, &[UnitOf])] = &[
    ("time", &[("s", 1.0), ("ms", 1e-3)]),
    ("command", LENGTH),
    ("target", LENGTH),
    ("displacement", LENGTH),
    ("force", FORCE),
    ("estimated_displacement", LENGTH),
    ("estimated_force", FORCE),
    ("velocity", &[("m_per_s", 1.0), ("mm_per_s", 1e-3)]),
    ("acceleration", &[("m_per_s2", 1.0), ("g", 9.80665)]),
    ("ground_acceleration", &[("m_per_s2", 1.0), ("g", 9.80665)]),
    ("added_damping", &[("n_s_per_m", 1.0)]),
    ("gain", PLAIN),
    ("energy_error", ENERGY),
    ("energy_error_hsem", ENERGY),
    ("energy_error_stiffness", ENERGY),
    ("energy_input", ENERGY),
    ("energy_ratio", PLAIN),
    ("step", PLAIN),
    ("flags", PLAIN),
];

/// A recording in SI units.
#[derive(Clone, Debug)]
pub struct Recording {
    /// The file, for messages.
    pub file: String,
    /// Time, s; increases.
    pub time_s: Vec<f64>,
    /// Everything else, in the order of the file.
    pub columns: Vec<Column>,
    /// Line of each row.
    pub lines: Vec<u64>,
}

/// One measured quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// What was measured: `command`, `displacement`, `force`, ...; a quantity that this program does not know has its
    /// whole name here.
    pub quantity: String,
    /// The axis, 1 being the lowest.
    pub axis: usize,
    /// The unit in the header.
    pub unit: String,
    /// Values in SI units, or in the file's own unit where that is `1` or not known.
    pub values: Vec<f64>,
}

impl Recording {
    /// Reads `path`.
    ///
    /// # Errors
    /// A file that cannot be read, and all of [`Recording::parse`].
    pub fn load(path: &Path) -> Result<Self, Failure> {
        Self::parse(&path.display().to_string(), &read(path)?)
    }

    /// Reads `text`, which came from `file`.
    ///
    /// # Errors
    /// With the line: a unit that the quantity cannot have, a quantity twice, time that is missing or does not
    /// increase, a row of another length than the header, a cell that is no finite number.
    pub fn parse(file: &str, text: &str) -> Result<Self, Failure> {
        let recording = Self::parse_with_any_time(file, text)?;
        let late = recording.time_s.windows(2).position(|t| t[1] <= t[0]);
        match late {
            Some(row) => Err(recording.refuse_time(row + 1)),
            None => Ok(recording),
        }
    }

    /// The same, but time is left to be judged by [`Recording::refuse_time`]'s caller: where it is written with few
    /// digits it may repeat itself, and a part of a record may be sound where the whole is not.
    ///
    /// # Errors
    /// As [`Recording::parse`], but for time that does not increase.
    pub fn parse_with_any_time(file: &str, text: &str) -> Result<Self, Failure> {
        let table = NumberTable::parse(file, text)?;
        let mut columns: Vec<Column> = Vec::with_capacity(table.names.len());
        for (name, values) in table.names.iter().zip(&table.columns) {
            let (column, factor) = column(&table, name)?;
            let twice = |c: &&Column| c.quantity == column.quantity && c.axis == column.axis;
            if columns.iter().any(|c| twice(&c)) {
                return Err(table.refuse_header(format!(
                    "{} of axis {} stands twice: accepted is one column of each quantity",
                    column.quantity, column.axis
                )));
            }
            let values = values.iter().map(|x| x * factor).collect();
            columns.push(Column { values, ..column });
        }
        let at = columns
            .iter()
            .position(|c| c.quantity == "time" && c.axis == 1)
            .ok_or_else(|| table.refuse_header("has no time: accepted are time_s and time_ms"))?;
        let time_s = columns.remove(at).values;
        if time_s.len() < 2 {
            return Err(Failure::input(format!(
                "{file}: has {} rows: accepted are at least 2",
                time_s.len()
            )));
        }
        Ok(Self {
            file: file.to_owned(),
            time_s,
            columns,
            lines: table.lines,
        })
    }

    /// That time is wrong at a row.
    pub fn refuse_time(&self, row: usize) -> Failure {
        Failure::input(format!(
            "{}, line {}: time {} s follows on {} s: accepted is time that increases, by equal intervals",
            self.file,
            self.lines[row],
            self.time_s[row],
            self.time_s[row - 1]
        ))
    }

    /// A quantity of an axis (1 is the lowest).
    pub fn column(&self, quantity: &str, axis: usize) -> Option<&Column> {
        self.columns
            .iter()
            .find(|c| c.quantity == quantity && c.axis == axis)
    }

    /// u_c of axis 1, m.
    pub fn command_m(&self) -> Option<&[f64]> {
        Some(&self.column("command", 1)?.values)
    }

    /// u_m of axis 1, m.
    pub fn displacement_m(&self) -> Option<&[f64]> {
        Some(&self.column("displacement", 1)?.values)
    }

    /// R_m of axis 1: N, or the file's own unit where [`Recording::force_has_unit`] says no.
    pub fn force(&self) -> Option<&[f64]> {
        Some(&self.column("force", 1)?.values)
    }

    /// Whether the force is in newtons.
    pub fn force_has_unit(&self) -> bool {
        self.column("force", 1).is_some_and(|c| c.unit != "1")
    }
}

/// What a name in the header means, and the factor to SI.
fn column(table: &NumberTable, name: &str) -> Result<(Column, f64), Failure> {
    // The longest quantity that the name begins with: `energy_error_hsem_j` is not `energy_error` in `hsem_j`.
    let known = QUANTITIES
        .iter()
        .filter_map(|(quantity, units)| Some((*quantity, *units, name.strip_prefix(quantity)?)))
        .max_by_key(|(quantity, ..)| quantity.len());
    let empty = |quantity: &str, axis, unit: &str| Column {
        quantity: quantity.to_owned(),
        axis,
        unit: unit.to_owned(),
        values: Vec::new(),
    };
    let Some((quantity, units, rest)) = known else {
        return Ok((empty(name, 1, ""), 1.0));
    };
    let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let axis = match &rest[..digits] {
        "" => Some(1),
        number => number.parse().ok().filter(|n| *n >= 1),
    };
    let unit = rest[digits..].strip_prefix('_').unwrap_or(&rest[digits..]);
    let found = units.iter().find(|(text, _)| *text == unit);
    match (axis, found) {
        (Some(axis), Some((_, factor))) if rest[digits..].starts_with('_') => {
            Ok((empty(quantity, axis, unit), *factor))
        }
        _ => {
            let accepted: Vec<_> = units
                .iter()
                .map(|(text, _)| format!("{quantity}_{text}"))
                .collect();
            Err(table.refuse_header(format!(
                "the column `{name}` is refused: accepted are {}",
                accepted.join(", ")
            )))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Recording, String> {
        Recording::parse("r.csv", text).map_err(|e| e.to_string())
    }

    #[test]
    fn units_become_si_and_unknown_quantities_stay_as_they_are() {
        let r = parse(
            "# rig A\ntime_ms,command_mm,displacement_m,force_kn,force2_n,oil_c\n0,1,0.002,3,4,40\n1,2,0.003,4,5,41\n",
        )
        .unwrap();
        assert_eq!(r.time_s, [0.0, 0.001]);
        assert_eq!(r.command_m().unwrap(), [0.001, 0.002]);
        assert_eq!(r.displacement_m().unwrap(), [0.002, 0.003]);
        assert_eq!(r.force().unwrap(), [3000.0, 4000.0]);
        assert!(r.force_has_unit());
        assert_eq!(r.column("force", 2).unwrap().values, [4.0, 5.0]);
        assert_eq!(r.column("oil_c", 1).unwrap().values, [40.0, 41.0]);
    }

    #[test]
    fn a_force_without_a_unit_says_so_and_missing_channels_are_missing() {
        let r = parse("time_s,displacement_mm,force_1\n0,1,2\n1,2,3\n").unwrap();
        assert!(!r.force_has_unit());
        assert_eq!(r.force().unwrap(), [2.0, 3.0]);
        assert!(r.command_m().is_none());
    }

    #[test]
    fn each_mistake_is_refused_with_its_line() {
        for (text, said) in [
            (
                "time_s,force_mm\n0,1\n1,1\n",
                "line 1: the column `force_mm` is refused",
            ),
            ("time_s,displacement_kn\n0,1\n1,1\n", "displacement_m"),
            ("time_s,command\n0,1\n1,1\n", "`command` is refused"),
            ("time_s,command0_mm\n0,1\n1,1\n", "`command0_mm` is refused"),
            ("time_s,commandm\n0,1\n1,1\n", "`commandm` is refused"),
            ("time_min,command_mm\n0,1\n1,1\n", "time_s"),
            ("command_mm,force_n\n0,1\n1,1\n", "has no time"),
            (
                "time_s,command_mm,command_m\n0,1,1\n1,1,1\n",
                "command of axis 1 stands twice",
            ),
            ("time_s,force_n\n0,1\n1,1\n1,2\n", "line 4: time 1 s"),
            ("time_s,force_n\n0,1\n1,nan\n", "line 3: force_n is `nan`"),
            ("time_s,force_n\n0,1\n1,high\n", "line 3: force_n is `high`"),
            ("time_s,force_n\n0,1\n1\n", "line 3: has 1 columns"),
            ("time_s,force_n\n0,1\n", "has 1 rows"),
        ] {
            let e = parse(text).unwrap_err();
            assert!(e.contains(said) && !e.contains('\n'), "{e}");
        }
    }
}
