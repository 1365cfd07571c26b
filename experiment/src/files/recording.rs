//! Recorded data: columns with headers `quantity_unit`, for example `time_s,command_mm,displacement_mm,force_kn`, as
//! CSV in any dialect ([`super::table`]), MAT or HDF5 ([`super::binary`]). Headers as instruments write them are
//! understood ([`super::header`]), and missing information is given on the command line ([`super::columns`]).
//!
//! Several axes are distinguished by a number after the quantity: `force_n` belongs to axis 1, `force2_n` to axis 2.
//! [`crate::files::record_csv`] writes the same format.

use super::any_table;
use super::columns::{ColumnAssignment, Columns};
use super::header::Header;
use super::notes;
use super::quantities::{ANGLE, MOMENT, UnitOf, known, units_of};
use super::table::{BadCell, NumberTable};
use crate::failure::Failure;
use std::ops::Range;
use std::path::Path;

/// The quantities that are judged: one of their cells that is not a number is a gap.
const JUDGED: [&str; 4] = ["command", "target", "displacement", "force"];

/// A recording in SI units.
#[derive(Clone, Debug)]
pub struct SiRecording {
    /// The file, for messages.
    pub file: String,
    /// Time, s; increases.
    pub time_s: Vec<f64>,
    /// Everything else, in file order.
    pub columns: Vec<Column>,
    /// Line of each row.
    pub lines: Vec<u64>,
    /// Notes for the user on columns that were not understood.
    pub notes: Vec<String>,
    /// Rows in which a quantity has no number, in order, with their refusals: users of columns check
    /// [`SiRecording::gap_in`].
    gaps: Vec<(usize, Failure)>,
    /// What messages call a row.
    row_name: &'static str,
}

/// One measured quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// What was measured: `command`, `displacement`, `force`, ...; for a quantity unknown to this program its whole
    /// name.
    pub quantity: String,
    /// The axis, 1 being the lowest.
    pub axis: usize,
    /// The unit in the header.
    pub unit: String,
    /// Values in SI units, or in the file's own unit if that is `1` or unknown.
    pub values: Vec<f64>,
}

impl Column {
    /// True if it is an angle or a moment.
    pub fn is_of_rotation(&self) -> bool {
        [ANGLE, MOMENT].contains(&self.unit.as_str())
    }
}

/// Largest displacement of a test rig, m: above it the file's unit must be wrong.
const LONGEST_M: f64 = 20.0;

impl SiRecording {
    /// Reads `path`.
    ///
    /// # Errors
    /// A file that cannot be read, and all those of [`SiRecording::parse`].
    pub fn load(path: &Path) -> Result<Self, Failure> {
        Self::load_with_any_time(path, &Columns::default())?
            .without_gaps()?
            .with_rising_time()
    }

    /// The same, but time and gaps are left for the caller to judge: time written with few digits may repeat, and a
    /// part of a record may be sound even if the whole is not.
    ///
    /// # Errors
    /// As for [`SiRecording::load`], except for gaps and for time that does not increase.
    pub fn load_with_any_time(path: &Path, columns: &Columns) -> Result<Self, Failure> {
        let recording = Self::of(
            any_table::read(path, !columns.assigned.is_empty())?,
            columns,
        )?;
        recording.check_lengths()?;
        Ok(recording)
    }

    /// From columns with names such as `time_s` and `command_mm`; `name` is for messages.
    ///
    /// # Errors
    /// As for a file with such columns.
    pub fn of_columns(
        name: &str,
        names: &[String],
        columns: Vec<Vec<f64>>,
    ) -> Result<Self, Failure> {
        let table = NumberTable::of_columns(name, "its names", names, columns)?;
        let recording = Self::of(table, &Columns::default())?;
        recording.check_lengths()?;
        Ok(recording)
    }

    /// Checks that no displacement is longer than a rig.
    fn check_lengths(&self) -> Result<(), Failure> {
        let lengths = ["command", "displacement"];
        for column in self
            .columns
            .iter()
            .filter(|c| lengths.contains(&c.quantity.as_str()))
        {
            if let Some(row) = column.values.iter().position(|x| x.abs() > LONGEST_M) {
                return Err(Failure::input(format!(
                    "{}, {} {}: {} is {:.3e} m: accepted are up to {LONGEST_M} m; is the unit right?",
                    self.file, self.row_name, self.lines[row], column.quantity, column.values[row]
                )));
            }
        }
        Ok(())
    }

    /// Reads `text`, which came from `file`.
    ///
    /// # Errors
    /// With the line: an inadmissible unit for a quantity, a duplicate quantity, missing or non-increasing time, a row
    /// of a different length from the header, a cell that is not a finite number.
    pub fn parse(file: &str, text: &str) -> Result<Self, Failure> {
        Self::of(NumberTable::parse(file, text)?, &Columns::default())?.with_rising_time()
    }

    /// The recording, if every quantity has a number in every row.
    ///
    /// # Errors
    /// The first gap.
    pub(super) fn without_gaps(self) -> Result<Self, Failure> {
        match self.gaps.first() {
            Some((_, refusal)) => Err(refusal.clone()),
            None => Ok(self),
        }
    }

    /// The first gap in these rows: its time, s, and its refusal.
    pub fn gap_in(&self, rows: &Range<usize>) -> Option<(f64, &Failure)> {
        let (row, refusal) = self.gaps.iter().find(|(row, _)| rows.contains(row))?;
        Some((self.time_s[*row], refusal))
    }

    /// The rows around `rows` from the gap before them to the gap after them.
    pub fn between_gaps(&self, rows: &Range<usize>) -> Range<usize> {
        let gaps = || self.gaps.iter().map(|(row, _)| *row);
        let before = gaps().rfind(|row| *row < rows.start);
        let behind = gaps().find(|row| *row >= rows.end);
        before.map_or(0, |row| row + 1)..behind.unwrap_or(self.time_s.len())
    }

    fn with_rising_time(self) -> Result<Self, Failure> {
        match self.time_s.windows(2).position(|t| t[1] <= t[0]) {
            Some(row) => Err(self.refuse_time(row + 1)),
            None => Ok(self),
        }
    }

    /// The quantities in a table.
    pub(super) fn of(table: NumberTable, said: &Columns) -> Result<Self, Failure> {
        let assigned = assign(&table, &said.assigned)?;
        let mut notes = Vec::new();
        // A column with a cell that is not a number has a gap if it is a quantity, and is omitted otherwise.
        let bad_in = |j: usize| table.bad.iter().find(move |b| b.column == j);
        let mut used = Vec::new();
        let mut columns: Vec<Column> = Vec::with_capacity(table.headers.len());
        for (j, (header, values)) in table.headers.iter().zip(&table.columns).enumerate() {
            let (column, factor) = match assigned.iter().find(|(at, _)| *at == j) {
                Some((_, a)) => assigned_column(&table, header, a)?,
                None => {
                    let found = match meaning(&table, header, bad_in(j), said.rate)? {
                        Ok(found) => found,
                        Err(note) => {
                            notes.push(note);
                            continue;
                        }
                    };
                    // The command line takes precedence over what a name suggests.
                    let taken =
                        |(_, a): &(usize, &ColumnAssignment)| a.quantity == found.0.quantity;
                    if found.0.axis == 1 && assigned.iter().any(taken) {
                        (unknown(&header.text), 1.0)
                    } else {
                        found
                    }
                }
            };
            let twice = |c: &&Column| c.quantity == column.quantity && c.axis == column.axis;
            if columns.iter().any(|c| twice(&c)) {
                return Err(table.refuse_header(format!(
                    "{} of axis {} stands twice: accepted is one column of each quantity; --column says which",
                    column.quantity, column.axis
                )));
            }
            if let Some(bad) = bad_in(j) {
                let is_time = column.quantity == "time" && column.axis == 1;
                if is_time && said.rate.is_none() {
                    return Err(table.refuse_cell(bad));
                }
                if is_time || !JUDGED.contains(&column.quantity.as_str()) {
                    notes.push(left_out(&table, bad));
                    continue;
                }
                used.push(j);
            }
            let values: Vec<f64> = values.iter().map(|x| x * factor).collect();
            columns.push(Column { values, ..column });
        }
        let time_s = times(&table, &mut columns, said.rate)?;
        notes.extend(notes::of(&table, |quantity| {
            columns
                .iter()
                .any(|c| c.quantity == quantity && c.axis == 1)
        }));
        let gaps = table.bad.iter().filter(|b| used.contains(&b.column));
        Ok(Self {
            notes,
            gaps: gaps.map(|b| (b.row, table.refuse_cell(b))).collect(),
            file: table.file,
            time_s,
            columns,
            lines: table.lines,
            row_name: table.row_name,
        })
    }

    /// The refusal of a row's time.
    pub fn refuse_time(&self, row: usize) -> Failure {
        Failure::input(format!(
            "{}, {} {}: time {} s follows on {} s: accepted is time that increases, by equal intervals",
            self.file,
            self.row_name,
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

    /// u_c of axis 1, m; none for a rotation.
    pub fn command_m(&self) -> Option<&[f64]> {
        self.linear("command")
    }

    /// u_m of axis 1, m; none for a rotation.
    pub fn displacement_m(&self) -> Option<&[f64]> {
        self.linear("displacement")
    }

    fn linear(&self, quantity: &str) -> Option<&[f64]> {
        let column = self.column(quantity, 1)?;
        (!column.is_of_rotation()).then_some(&column.values[..])
    }

    /// R_m of axis 1: N, or the file's own unit if [`SiRecording::force_has_unit`] is false; none for a moment.
    pub fn force(&self) -> Option<&[f64]> {
        self.linear("force")
    }

    /// True if the force is in newtons.
    pub fn force_has_unit(&self) -> bool {
        self.column("force", 1).is_some_and(|c| c.unit != "1")
    }
}

/// The columns that the command line names, by their indices.
fn assign<'a>(
    table: &NumberTable,
    assigned: &'a [ColumnAssignment],
) -> Result<Vec<(usize, &'a ColumnAssignment)>, Failure> {
    let place = |a: &'a ColumnAssignment| {
        let wanted = a.column.to_lowercase();
        let named = table
            .headers
            .iter()
            .position(|h| h.text.to_lowercase() == wanted || h.base == wanted);
        let numbered = wanted
            .parse()
            .ok()
            .filter(|n| (1..=table.headers.len()).contains(n));
        named
            .or(numbered.map(|n: usize| n - 1))
            .map(|at| (at, a))
            .ok_or_else(|| {
                table.refuse_header(format!(
                    "has no column `{}`: accepted are {}",
                    a.column,
                    table.names()
                ))
            })
    };
    assigned.iter().map(place).collect()
}

/// A column that the command line names, with its unit from there, else from its header.
fn assigned_column(
    table: &NumberTable,
    header: &Header,
    a: &ColumnAssignment,
) -> Result<(Column, f64), Failure> {
    let units = units_of(&a.quantity);
    let unit = a.unit.unwrap_or(&header.unit);
    match units.iter().find(|(text, _)| *text == unit) {
        Some((_, factor)) => Ok((
            Column {
                unit: unit.to_owned(),
                ..unknown(&a.quantity)
            },
            *factor,
        )),
        None => {
            let accepted: Vec<_> = units.iter().map(|(text, _)| *text).collect();
            Err(table.refuse_header(format!(
                "the unit of `{}` is {}: accepted is --column {}={}:UNIT with one of {}",
                header.text,
                if unit.is_empty() { "not said" } else { unit },
                a.quantity,
                a.column,
                accepted.join(", ")
            )))
        }
    }
}

/// The meaning of a column's name, and its factor to SI; or why it is omitted, if --rate replaces its times.
fn meaning(
    table: &NumberTable,
    header: &Header,
    bad: Option<&BadCell>,
    rate_hz: Option<f64>,
) -> Result<Result<(Column, f64), String>, Failure> {
    let found = column(table, header);
    let clock = header.likely() == Some("time") || header.base.starts_with("time");
    Ok(match (bad.filter(|_| clock), rate_hz.filter(|_| clock)) {
        (None, None) => Ok(found?),
        // No unit turns times of day into seconds.
        (Some(bad), None) => Ok(found.map_err(|_| table.refuse_cell(bad))?),
        (Some(bad), Some(_)) => Err(left_out(table, bad)),
        (None, Some(_)) => found.map_err(|_| {
            format!(
                "{}: the column `{}` says no unit and is left out: --rate stands for it",
                table.file, header.text
            )
        }),
    })
}

/// The note that a column of another quantity is not used.
fn left_out(table: &NumberTable, bad: &BadCell) -> String {
    format!(
        "{}: the column `{}` is left out: `{}` in {} {} is no number",
        table.file, table.headers[bad.column].text, bad.text, table.row_name, table.lines[bad.row]
    )
}

/// A column under a name that is not interpreted.
fn unknown(name: &str) -> Column {
    Column {
        quantity: name.to_owned(),
        axis: 1,
        unit: String::new(),
        values: Vec::new(),
    }
}

/// The times of the rows, s, taken out of the columns if they are there; else from a rate.
fn times(
    table: &NumberTable,
    columns: &mut Vec<Column>,
    rate_hz: Option<f64>,
) -> Result<Vec<f64>, Failure> {
    let rows = table.lines.len();
    let is_time = |c: &Column| c.quantity == "time" && c.axis == 1;
    let time_s = match (columns.iter().position(is_time), rate_hz) {
        (Some(at), None) => columns.remove(at).values,
        (None, Some(hz)) if hz > 0.0 && hz <= 1e7 => (0..rows).map(|i| i as f64 / hz).collect(),
        (None, Some(hz)) => {
            return Err(Failure::input(format!(
                "--rate {hz} is refused: accepted are above 0 to 1e7 Hz"
            )));
        }
        (Some(_), Some(_)) => {
            return Err(Failure::input(format!(
                "{}: has times of its own: accepted is a file without, beside --rate",
                table.file
            )));
        }
        (None, None) => return Err(no_time(table)),
    };
    if time_s.len() < 2 {
        let rows = match time_s.len() {
            0 => "no row",
            _ => "one row",
        };
        return Err(Failure::input(format!(
            "{}: has {rows} of numbers: accepted are at least {}",
            table.file,
            diagnosis::FEWEST_SAMPLES
        )));
    }
    Ok(time_s)
}

/// The refusal of a table without time, with how to state its column.
fn no_time(table: &NumberTable) -> Failure {
    table.refuse_header(format!(
        "has no time: accepted are time_s, time_ms, `Time (s)`, --column time=COLUMN:s, or --rate HZ; its columns are {}",
        table.names()
    ))
}

/// The meaning of a name in the header, and its factor to SI.
fn column(table: &NumberTable, header: &Header) -> Result<(Column, f64), Failure> {
    let name = header.name(|name| matches!(known(name), Some((_, _, Some(_)))));
    match known(&name) {
        Some((quantity, units, Some((axis, unit)))) => {
            let factor = units
                .iter()
                .find(|(text, _)| *text == unit)
                .map_or(1.0, |(_, f)| *f);
            let column = Column {
                axis,
                unit: unit.to_owned(),
                ..unknown(quantity)
            };
            Ok((column, factor))
        }
        Some((quantity, units, None)) => Err(refuse_unit(table, header, quantity, units)),
        None => match header.likely() {
            Some(quantity) if header.unit.is_empty() && quantity != "acc" => {
                Err(refuse_unit(table, header, quantity, units_of(quantity)))
            }
            _ => Ok((unknown(&name), 1.0)),
        },
    }
}

/// Refuses a name of a quantity that states no unit, or one that it cannot have.
fn refuse_unit(table: &NumberTable, header: &Header, quantity: &str, units: &[UnitOf]) -> Failure {
    let accepted: Vec<_> = units
        .iter()
        .map(|(text, _)| format!("{quantity}_{text}"))
        .collect();
    table.refuse_header(format!(
        "the column `{}` is refused: accepted are {}, a unit in brackets or in a row beneath, or --column \
         '{quantity}={}:UNIT'",
        header.text,
        accepted.join(", "),
        header.text
    ))
}

#[cfg(test)]
mod tests;
