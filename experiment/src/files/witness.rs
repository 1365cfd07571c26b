//! A channel of a recorded file that is not used in a diagnosis: `FILE:COLUMN`.

use super::columns::{ColumnAssignment, Columns};
use super::measured::{FilePart, RecordFiles};
use crate::failure::Failure;
use diagnosis::Recording;
use std::path::PathBuf;

/// A file, and its column that is the witness.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WitnessColumn {
    /// The file: one of those that are judged, or another with the same time.
    pub file: PathBuf,
    /// The column's name, or its number from 1.
    pub column: String,
}

impl std::str::FromStr for WitnessColumn {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.rsplit_once(':');
        let parts = parts.filter(|(file, column)| !file.is_empty() && !column.trim().is_empty());
        let (file, column) = parts.ok_or_else(|| {
            format!("`{text}` names no column: accepted is FILE:COLUMN, the column by its name or number")
        })?;
        Ok(Self {
            file: file.into(),
            column: column.trim().to_owned(),
        })
    }
}

impl std::fmt::Display for WitnessColumn {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "`{}` of {}", self.column, self.file.display())
    }
}

/// Its readings, in the column's own unit.
#[derive(Debug)]
pub struct WitnessRecord {
    pieces: Vec<Recording>,
}

impl WitnessColumn {
    /// Reads it; `columns` are the statements about the records' own columns.
    ///
    /// # Errors
    /// A file that cannot be used, or a column that it does not have.
    pub fn read(&self, columns: &Columns) -> Result<WitnessRecord, Failure> {
        let mut columns = columns.clone();
        columns.assigned.retain(|a| a.quantity != "force");
        // As a force without a unit, which is read as it is.
        columns.assigned.push(ColumnAssignment {
            quantity: "force".into(),
            column: self.column.clone(),
            unit: Some("1"),
        });
        let whole = FilePart {
            file: self.file.clone(),
            span_s: None,
        };
        let pieces = RecordFiles::with(&columns).parts(&[whole])?;
        Ok(WitnessRecord { pieces })
    }
}

impl WitnessRecord {
    /// Its readings at the times of a record, linear between its samples; `None` if it does not cover them.
    pub fn at(&self, time_s: &[f64]) -> Option<Vec<f64>> {
        let (first, last) = (*time_s.first()?, *time_s.last()?);
        let covers = |p: &&Recording| {
            let room = 0.5 * p.interval_s();
            p.time_s[0] - room <= first && last <= p.time_s[p.time_s.len() - 1] + room
        };
        let piece = self.pieces.iter().find(covers)?;
        let (times, read) = (&piece.time_s, piece.force_n.as_ref()?);
        let value = |t: &f64| {
            let next = times
                .partition_point(|own| own < t)
                .clamp(1, times.len() - 1);
            let (a, b) = (times[next - 1], times[next]);
            let share = ((t - a) / (b - a)).clamp(0.0, 1.0);
            read[next - 1] + share * (read[next] - read[next - 1])
        };
        Some(time_s.iter().map(value).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_witness_is_a_column_of_a_file_at_the_times_of_a_record() {
        let witness: WitnessColumn = "a:b/c.csv:p_bar".parse().unwrap();
        assert_eq!(
            (witness.file.to_str(), witness.column.as_str()),
            (Some("a:b/c.csv"), "p_bar")
        );
        for text in ["c.csv", "c.csv:", ":p"] {
            let e = text.parse::<WitnessColumn>().unwrap_err();
            assert!(e.contains("FILE:COLUMN"), "{e}");
        }
        let piece = Recording {
            time_s: (0..60).map(|i| f64::from(i) * 0.5).collect(),
            force_n: Some((0..60).map(|i| f64::from(i * i)).collect()),
            ..Recording::default()
        };
        let record = WitnessRecord {
            pieces: vec![piece],
        };
        assert_eq!(record.at(&[1.0, 1.25, 2.0]), Some(vec![4.0, 6.5, 16.0]));
        assert_eq!(record.at(&[29.0, 30.0]), None);
    }
}
