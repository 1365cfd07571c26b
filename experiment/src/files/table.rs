//! A table of numbers under a header, from text, MAT or HDF5, with the location of every error in it.

use super::cell;
use super::dialect::{Dialect, without_end};
use super::header::{Header, unit_named};
use super::labview;
use crate::failure::Failure;
use std::collections::HashSet;

/// Columns of numbers. Lines that begin with `#` or `%` are comments.
#[derive(Clone, Debug)]
pub struct NumberTable {
    /// The file's name, for messages.
    pub file: String,
    /// Location of the header, for messages, such as `line 3`.
    pub header_place: String,
    /// The columns' names.
    pub headers: Vec<Header>,
    /// Line of each row; counted from 1 if the file has no lines.
    pub lines: Vec<u64>,
    /// Values, one vector per column; NaN in a bad cell.
    pub columns: Vec<Vec<f64>>,
    /// Cells that are not finite numbers, in file order; empty for a complete table.
    pub bad: Vec<BadCell>,
    /// What a row is called: `line`, or `value` if the file has no lines.
    pub row_name: &'static str,
}

/// A cell that is not a finite number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BadCell {
    /// Its row, from 0.
    pub row: usize,
    /// Its column, from 0.
    pub column: usize,
    /// Its contents.
    pub text: Box<str>,
}

/// A line of the file that is neither blank nor a comment.
#[derive(Clone, Copy)]
struct Line<'a> {
    number: u64,
    text: &'a str,
}

impl NumberTable {
    /// Reads `text`, which came from `file`, in any dialect.
    ///
    /// # Errors
    /// No header, a duplicate name, a row of a different length from the header, or a cell that is not a finite number.
    pub fn parse(file: &str, text: &str) -> Result<Self, Failure> {
        Self::parse_with_bad_cells(file, text, false)?.whole()
    }

    /// The same, with its bad cells: a caller must make sure not to use any of them. `by_number`: the columns of a file
    /// without a header are called 1, 2, ...
    ///
    /// # Errors
    /// As for [`NumberTable::parse`], except for the cells, and for the header with `by_number`.
    pub fn parse_with_bad_cells(file: &str, text: &str, by_number: bool) -> Result<Self, Failure> {
        let of_labview =
            labview::as_table(text).map_err(|why| Failure::input(format!("{file}, {why}")))?;
        let text = of_labview.as_deref().unwrap_or(text);
        let lines: Vec<Line<'_>> = text
            .lines()
            .zip(1..)
            .filter(|(text, _)| !is_comment(text))
            .map(|(text, number)| Line { number, text })
            .collect();
        if lines.is_empty() {
            return Err(Failure::input(format!("{file}: is empty")));
        }
        let dialect = Dialect::of(lines.iter().map(|l| l.text));
        let refuse =
            |line: u64, what: String| Failure::input(format!("{file}, line {line}: {what}"));
        if by_number && dialect.is_row(lines[0].text) {
            let width = without_end(&dialect.cells(lines[0].text)).len();
            let headers = (1..=width).map(|n| Header::of(&n.to_string(), None));
            return Self::of_rows(file, headers.collect(), &lines, lines[0].number, &dialect);
        }
        let head = Head::of(&lines, &dialect);
        let header = lines[head.header];
        let cells = dialect.cells(header.text);
        let cells = without_end(&cells);
        if let Some(number) = cells.iter().find(|c| dialect.any_number(c).is_some()) {
            return Err(refuse(
                header.number,
                format!(
                    "`{number}` stands where the header should be: accepted are names such as time_s or `Time (s)`; of \
                     a record without names, --column time=1:s and the like for its columns"
                ),
            ));
        }
        let units = head.units.map(|at| dialect.cells(lines[at].text));
        let beneath = |j: usize| units.as_ref().and_then(|u| u.get(j).copied());
        let headers: Vec<Header> = (0..cells.len())
            .map(|j| Header::of(cells[j], beneath(j)))
            .collect();
        let mut seen = HashSet::new();
        let mut names = headers.iter().map(|h| h.text.to_lowercase());
        if let Some(name) = names.find(|name| !seen.insert(name.clone())) {
            let twice = format!("the column `{name}` stands twice");
            return Err(refuse(header.number, twice));
        }
        // A segmented export repeats its header, with the units beneath, before each segment.
        let top = [Some(head.header), head.units].map(|at| at.map(|at| lines[at].text.trim_end()));
        let mut rows = lines[head.first_row..].to_vec();
        rows.retain(|line| !top.contains(&Some(line.text.trim_end())));
        Self::of_rows(file, headers, &rows, header.number, &dialect)
    }

    fn of_rows(
        file: &str,
        headers: Vec<Header>,
        rows: &[Line<'_>],
        header_line: u64,
        dialect: &Dialect,
    ) -> Result<Self, Failure> {
        let refuse =
            |line: u64, what: String| Failure::input(format!("{file}, line {line}: {what}"));
        let mut columns = vec![Vec::with_capacity(rows.len()); headers.len()];
        let mut bad = Vec::new();
        for (row, line) in rows.iter().enumerate() {
            let cells = dialect.cells(line.text);
            let cells = if cells.len() > headers.len() {
                without_end(&cells)
            } else {
                &cells
            };
            if cells.len() != headers.len() {
                return Err(refuse(
                    line.number,
                    miscounted(line.text, cells.len(), headers.len(), dialect),
                ));
            }
            for (at, (cell, column)) in cells.iter().zip(&mut columns).enumerate() {
                let number = dialect.number(cell);
                if number.is_none() {
                    bad.push(BadCell {
                        row,
                        column: at,
                        text: (*cell).into(),
                    });
                }
                column.push(number.unwrap_or(f64::NAN));
            }
        }
        Ok(Self {
            file: file.to_owned(),
            header_place: format!("line {header_line}"),
            headers,
            lines: rows.iter().map(|l| l.number).collect(),
            columns,
            bad,
            row_name: "line",
        })
    }

    /// From columns that have never been text, with their names; `place` is the location of those.
    ///
    /// # Errors
    /// Columns of different lengths, or a value that is not finite.
    pub fn of_columns(
        file: &str,
        place: &str,
        names: &[String],
        columns: Vec<Vec<f64>>,
    ) -> Result<Self, Failure> {
        let length = columns.first().map_or(0, Vec::len);
        for (name, values) in names.iter().zip(&columns) {
            if values.len() != length {
                return Err(Failure::input(format!(
                    "{file}: the columns are of different lengths, {name} of {} and {} of {length}: accepted are columns of \
                     one length",
                    values.len(),
                    names[0]
                )));
            }
            if let Some(at) = values.iter().position(|x| !x.is_finite()) {
                return Err(Failure::input(format!(
                    "{file}, value {}: {name} is {}: accepted is a finite number",
                    at + 1,
                    values[at]
                )));
            }
        }
        Ok(Self {
            file: file.to_owned(),
            header_place: place.to_owned(),
            headers: names.iter().map(|name| Header::of(name, None)).collect(),
            lines: (1..=length as u64).collect(),
            columns,
            bad: Vec::new(),
            row_name: "value",
        })
    }

    /// The table, if every cell is a number.
    ///
    /// # Errors
    /// The first one that is not.
    pub fn whole(self) -> Result<Self, Failure> {
        match self.bad.first() {
            Some(bad) => Err(self.refuse_cell(bad)),
            None => Ok(self),
        }
    }

    /// The refusal of a cell that is not a number.
    pub fn refuse_cell(&self, bad: &BadCell) -> Failure {
        let name = self.headers[bad.column].text.to_lowercase();
        self.refuse_row(
            bad.row,
            format!("{name} is `{}`: {}", bad.text, cell::wish(&bad.text)),
        )
    }

    /// A refusal at row `row`.
    pub fn refuse_row(&self, row: usize, what: impl std::fmt::Display) -> Failure {
        let line = self.lines.get(row).copied().unwrap_or(0);
        Failure::input(format!("{}, {} {line}: {what}", self.file, self.row_name))
    }

    /// The names of its columns as written in the file.
    pub fn names(&self) -> String {
        let names: Vec<&str> = self.headers.iter().map(|h| h.text.as_str()).collect();
        names.join(", ")
    }

    /// A refusal of the header.
    pub fn refuse_header(&self, what: impl std::fmt::Display) -> Failure {
        Failure::input(format!("{}, {}: {what}", self.file, self.header_place))
    }
}

/// The beginning of the table.
struct Head {
    header: usize,
    units: Option<usize>,
    first_row: usize,
}

impl Head {
    /// An instrument may write lines about itself before the table. The header is the last line before the first row of
    /// numbers that has as many cells as the row and no number; a row of units may follow it.
    fn of(lines: &[Line<'_>], dialect: &Dialect) -> Self {
        let cells = |at: usize| dialect.cells(lines[at].text);
        let is_row = |at: &usize| dialect.is_row(lines[*at].text);
        let plain = Self {
            header: 0,
            units: None,
            first_row: 1,
        };
        let has_numbers = |at: &usize| dialect.has_numbers(lines[*at].text);
        let all = || 0..lines.len();
        let Some(row) = all().find(is_row).or_else(|| all().find(has_numbers)) else {
            return plain;
        };
        let width = without_end(&cells(row)).len();
        let names = |at: &usize| {
            let cells = cells(*at);
            // An empty last cell may be a cell, as below a column without a unit, or the end of every line.
            let as_wide = [cells.len(), without_end(&cells).len()].contains(&width);
            as_wide && cells.iter().all(|c| dialect.any_number(c).is_none())
        };
        let Some(last) = (0..row).rev().find(names) else {
            return plain;
        };
        let is_units = cells(last)
            .iter()
            .all(|c| c.is_empty() || unit_named(c).is_some());
        let above = (0..last).rev().find(names).filter(|_| is_units);
        Self {
            header: above.unwrap_or(last),
            units: above.map(|_| last),
            first_row: last + 1,
        }
    }
}

fn is_comment(line: &str) -> bool {
    let line = line.trim_start();
    line.is_empty() || line.starts_with(['#', '%'])
}

/// A finite number, or none.
pub fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|x: &f64| x.is_finite())
}

/// The refusal of a line whose column count differs from the header's, and why, if known.
fn miscounted(line: &str, cells: usize, headers: usize, dialect: &Dialect) -> String {
    let why = if cells > headers && line.split([';', '\t', ' ']).any(has_thousands) {
        ": a separator of thousands, as in 1.234,56, is not read: accepted are numbers without one"
    } else if dialect.separator == Some(',') && cells == 2 * headers {
        // 0,5 next to 1,5: nothing tells the two commas apart.
        ": decimals with a comma are accepted with a semicolon or a tab between the columns"
    } else {
        ""
    };
    format!("has {cells} columns where the header has {headers}{why}")
}

/// True for `1.234,56` and `1,234.56`.
fn has_thousands(cell: &str) -> bool {
    let digits = |part: &str| !part.is_empty() && part.chars().all(|c| c.is_ascii_digit());
    [('.', ','), (',', '.')].iter().any(|(thousand, decimal)| {
        let Some((whole, fraction)) = cell.trim().rsplit_once(*decimal) else {
            return false;
        };
        let mut groups = whole.trim_start_matches(['+', '-']).split(*thousand);
        let first = groups.next().is_some_and(|g| digits(g) && g.len() <= 3);
        let others: Vec<&str> = groups.collect();
        let three = |g: &&str| digits(g) && g.len() == 3;
        first && digits(fraction) && !others.is_empty() && others.iter().all(three)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_blank_lines_do_not_shift_the_line_of_a_mistake() {
        let text = "# by hand\ntime_s,a\n0,1\n\n# pause\n1,oops\n";
        let e = NumberTable::parse("f.csv", text).unwrap_err().to_string();
        assert_eq!(e, "f.csv, line 6: a is `oops`: accepted is a finite number");
    }

    #[test]
    fn a_header_that_stands_before_each_segment_is_read_once() {
        let text = "time_s,a\ns,mm\n0,1\n1,2\ntime_s,a\ns,mm\n2,3\n";
        let table = NumberTable::parse("f.csv", text).unwrap();
        assert_eq!(table.columns, [[0.0, 1.0, 2.0], [1.0, 2.0, 3.0]]);
        assert_eq!(table.lines, [3, 4, 7]);
        // A different header, or a table of statistics at the end, is something else.
        for (more, said) in [
            ("time_s,b\n2,3\n", "line 5: time_s is `time_s`"),
            ("Max,2\n", "line 5: time_s is `Max`"),
        ] {
            let text = format!("time_s,a\ns,mm\n0,1\n1,2\n{more}");
            let e = NumberTable::parse("f.csv", &text).unwrap_err();
            assert!(e.to_string().contains(said), "{e}");
        }
    }

    #[test]
    fn each_mistake_is_refused_in_one_line() {
        for (text, said) in [
            ("", "is empty"),
            ("a,a\n1,2\n", "line 1: the column `a` stands twice"),
            ("a,A\n1,2\n", "stands twice"),
            ("0,1\n2,3\n", "line 1: `0` stands where the header"),
            ("a,b\n1\n", "line 2: has 1 columns where the header has 2"),
            (
                "time_s;b\n0,0;1.234,5\n0,1;1.235,5\n",
                "as in 1.234,56, is not read",
            ),
            (
                "time_s,b\n0,0,1,5\n0,1,1,6\n",
                "line 2: has 4 columns where the header has 2: decimals with a comma are accepted with a semicolon",
            ),
            ("a,b\n1,inf\n", "line 2: b is `inf`"),
            ("a,b\n1,\n2,3\n", "line 2: b is ``"),
            ("a,b\n1,oops\n2,3\n", "line 2: b is `oops`"),
            ("a;b\n1,5;oops\n2,5;3,1\n", "line 2: b is `oops`"),
        ] {
            let e = NumberTable::parse("f.csv", text).unwrap_err().to_string();
            assert!(e.contains(said) && !e.contains('\n'), "{e}");
        }
    }

    #[test]
    fn a_file_without_names_has_numbers_for_them() {
        let t = NumberTable::parse_with_bad_cells("f.csv", "0,1\n2,3\n", true).unwrap();
        let names: Vec<&str> = t.headers.iter().map(|h| h.text.as_str()).collect();
        assert_eq!(
            (names, t.columns),
            (vec!["1", "2"], vec![vec![0.0, 2.0], vec![1.0, 3.0]])
        );
        let named = NumberTable::parse_with_bad_cells("f.csv", "a,b\n2,3\n", true).unwrap();
        assert_eq!(named.headers[0].text, "a");
    }

    #[test]
    fn a_column_of_text_hides_no_other() {
        let text = "Rig B\nTime;Cmd;State\ns;mm;\n0,000;1,5;moves\n0,001;;moves\n";
        let t = NumberTable::parse_with_bad_cells("f.txt", text, false).unwrap();
        assert_eq!(t.header_place, "line 2");
        assert_eq!(t.columns[0], [0.0, 0.001]);
        let bad: Vec<(usize, usize, &str)> =
            t.bad.iter().map(|b| (b.row, b.column, &*b.text)).collect();
        assert_eq!(bad, [(0, 2, "moves"), (1, 1, ""), (1, 2, "moves")]);
        let e = t.whole().unwrap_err().to_string();
        assert_eq!(
            e,
            "f.txt, line 4: state is `moves`: accepted is a finite number"
        );
    }

    #[test]
    fn an_instrument_may_introduce_itself() {
        let text = "LabVIEW Measurement\nOperator;Smith\nRate;1000;Hz\n\nTime;Cmd;Disp;\ns;mm;mm;\n0,000;1,5;1,4;\n0,001;1,6;1,5;\n";
        let t = NumberTable::parse("f.txt", text).unwrap();
        let names: Vec<String> = t.headers.iter().map(|h| h.name(|_| false)).collect();
        assert_eq!(names, ["time_s", "command_mm", "displacement_mm"]);
        assert_eq!(t.columns[1], [1.5, 1.6]);
        assert_eq!((t.lines[0], t.header_place.as_str()), (7, "line 5"));
    }
}
