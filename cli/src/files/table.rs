//! CSV of numbers under a header, with the line of everything that is wrong in it.

use crate::failure::Failure;

/// Columns of finite numbers. Lines that begin with `#` are comments.
#[derive(Clone, Debug)]
pub struct NumberTable {
    /// The file's name, for messages.
    pub file: String,
    /// Line of the header.
    pub header_line: u64,
    /// Names in the header, trimmed, in lower case; no two alike.
    pub names: Vec<String>,
    /// Line of each row.
    pub lines: Vec<u64>,
    /// Values, one vector a column.
    pub columns: Vec<Vec<f64>>,
}

impl NumberTable {
    /// Reads `text`, which came from `file`.
    ///
    /// # Errors
    /// A name that stands twice, a row of another length than the header, or a cell that is no finite number.
    pub fn parse(file: &str, text: &str) -> Result<Self, Failure> {
        let refuse =
            |line: u64, what: String| Failure::input(format!("{file}, line {line}: {what}"));
        let mut rows = csv::ReaderBuilder::new()
            .has_headers(false)
            .comment(Some(b'#'))
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes())
            .into_records();
        let malformed = |e: csv::Error| {
            let line = e.position().map_or(0, csv::Position::line);
            refuse(line, "is not CSV".into())
        };
        // The reader counts a row from where the one before it ended: comments and blank lines are still to be skipped.
        let text_lines: Vec<&str> = text.lines().map(str::trim_start).collect();
        let line_of = |row: &csv::StringRecord| {
            let from = row.position().map_or(0, csv::Position::line);
            let skipped = text_lines
                .iter()
                .skip((from as usize).saturating_sub(1))
                .take_while(|l| l.is_empty() || l.starts_with('#'))
                .count();
            from + skipped as u64
        };
        let header = match rows.next() {
            Some(row) => row.map_err(malformed)?,
            None => return Err(Failure::input(format!("{file}: is empty"))),
        };
        let header_line = line_of(&header);
        let names: Vec<String> = header.iter().map(str::to_lowercase).collect();
        for (i, name) in names.iter().enumerate() {
            if names[..i].contains(name) {
                return Err(refuse(
                    header_line,
                    format!("the column `{name}` stands twice"),
                ));
            }
            if name.parse::<f64>().is_ok() {
                return Err(refuse(
                    header_line,
                    format!(
                        "`{name}` stands where the header should be: accepted are names such as time_s"
                    ),
                ));
            }
        }
        let mut columns = vec![Vec::new(); names.len()];
        let mut lines = Vec::new();
        for row in rows {
            let row = row.map_err(malformed)?;
            let line = line_of(&row);
            if row.len() != names.len() {
                return Err(refuse(
                    line,
                    format!(
                        "has {} columns where the header has {}",
                        row.len(),
                        names.len()
                    ),
                ));
            }
            for (j, cell) in row.iter().enumerate() {
                columns[j].push(number(cell).ok_or_else(|| {
                    refuse(
                        line,
                        format!("{} is `{cell}`: accepted is a finite number", names[j]),
                    )
                })?);
            }
            lines.push(line);
        }
        Ok(Self {
            file: file.to_owned(),
            header_line,
            names,
            lines,
            columns,
        })
    }

    /// A refusal at row `row`.
    pub fn refuse_row(&self, row: usize, what: impl std::fmt::Display) -> Failure {
        let line = self.lines.get(row).copied().unwrap_or(self.header_line);
        Failure::input(format!("{}, line {line}: {what}", self.file))
    }

    /// A refusal of the header.
    pub fn refuse_header(&self, what: impl std::fmt::Display) -> Failure {
        Failure::input(format!("{}, line {}: {what}", self.file, self.header_line))
    }
}

/// A finite number, or nothing.
pub fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|x: &f64| x.is_finite())
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
    fn each_mistake_is_refused_in_one_line() {
        for (text, said) in [
            ("", "is empty"),
            ("a,a\n1,2\n", "line 1: the column `a` stands twice"),
            ("a,A\n1,2\n", "stands twice"),
            ("0,1\n2,3\n", "line 1: `0` stands where the header"),
            ("a,b\n1\n", "line 2: has 1 columns where the header has 2"),
            ("a,b\n1,inf\n", "line 2: b is `inf`"),
            ("a,b\n1,\n", "line 2: b is ``"),
        ] {
            let e = NumberTable::parse("f.csv", text).unwrap_err().to_string();
            assert!(e.contains(said) && !e.contains('\n'), "{e}");
        }
    }
}
