//! Command-line statements about the columns of a recorded file: `--column time="Time (ms)"`, `--rate 1000`.

use super::header::unit_named;

/// A quantity, and the column that contains it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ColumnAssignment {
    /// `time`, `command`, `displacement` or `force`.
    pub quantity: String,
    /// The column's name in the file, or its number, from 1.
    pub column: String,
    /// Its unit, if the file does not state it or states it wrongly.
    pub unit: Option<&'static str>,
}

impl std::str::FromStr for ColumnAssignment {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let refuse = |why: String| {
            format!(
                "`{text}`: {why}: accepted is QUANTITY=COLUMN or QUANTITY=COLUMN:UNIT, e.g. command=Cmd:mm, with time, \
                 command, displacement or force"
            )
        };
        let (quantity, column) = text
            .split_once('=')
            .ok_or_else(|| refuse("has no `=`".into()))?;
        if !["time", "command", "displacement", "force"].contains(&quantity) {
            return Err(refuse(format!("`{quantity}` is no quantity")));
        }
        let (column, unit) = match column.rsplit_once(':') {
            None => (column, None),
            Some((column, unit)) => match unit_named(unit) {
                Some(named) => (column, Some(named)),
                None => return Err(refuse(format!("`{unit}` is no unit"))),
            },
        };
        if column.trim().is_empty() {
            return Err(refuse("names no column".into()));
        }
        Ok(Self {
            quantity: quantity.to_owned(),
            column: column.trim().to_owned(),
            unit,
        })
    }
}

/// How the columns of recorded files are to be read.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "options", derive(clap::Args))]
pub struct Columns {
    /// Which column of the file is which quantity, where its header does not say it: time, command, displacement or
    /// force; the column by its name or number, the unit behind a colon, e.g. --column command=Cmd:mm
    #[cfg_attr(
        feature = "options",
        arg(long = "column", value_name = "QUANTITY=COLUMN[:UNIT]")
    )]
    pub assigned: Vec<ColumnAssignment>,
    /// Samples in a second, for a file without time, Hz
    #[cfg_attr(feature = "options", arg(long, value_name = "HZ"))]
    pub rate: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_assignment_names_quantity_column_and_unit() {
        let a: ColumnAssignment = "command=Cmd A (x):mm".parse().unwrap();
        assert_eq!(
            (a.quantity.as_str(), a.column.as_str(), a.unit),
            ("command", "Cmd A (x)", Some("mm"))
        );
        let a: ColumnAssignment = "time=1".parse().unwrap();
        assert_eq!((a.column.as_str(), a.unit), ("1", None));
        for (text, said) in [
            ("time", "has no `=`"),
            ("oil=Oil", "`oil` is no quantity"),
            ("time=Time:furlong", "`furlong` is no unit"),
            ("time=:s", "names no column"),
        ] {
            let e = text.parse::<ColumnAssignment>().unwrap_err();
            assert!(e.contains(said), "{e}");
        }
    }
}
