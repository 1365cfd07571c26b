//! How a text file separates its columns, writes its decimals, and where its table begins.

/// Column separator and decimal sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dialect {
    /// Between two cells; `None`: any run of blanks.
    pub separator: Option<char>,
    /// True if the decimal sign is a comma.
    pub decimal_comma: bool,
}

/// Every dialect, the likeliest first.
const DIALECTS: [Dialect; 8] = [
    Dialect::new(Some(','), false),
    Dialect::new(Some('\t'), false),
    Dialect::new(Some(';'), false),
    Dialect::new(Some(';'), true),
    Dialect::new(Some('\t'), true),
    Dialect::new(None, false),
    Dialect::new(None, true),
    // With every cell in quotes.
    Dialect::new(Some(','), true),
];

/// Number of lines examined to detect the dialect.
const LOOKED_AT: usize = 200;

impl Dialect {
    const fn new(separator: Option<char>, decimal_comma: bool) -> Self {
        Self {
            separator,
            decimal_comma,
        }
    }

    /// The one in which most lines are numbers; if there is none, because of a column of text, the one in which most
    /// lines have numbers; else the one whose separator occurs in the first line.
    pub fn of<'a>(lines: impl Iterator<Item = &'a str> + Clone) -> Self {
        let looked_at = || lines.clone().take(LOOKED_AT);
        let first = looked_at().next().unwrap_or("");
        let most = |is_row: fn(&Self, &str) -> bool| {
            let rows = |d: &Self| looked_at().filter(|l| is_row(d, l)).count();
            let best = DIALECTS.into_iter().rev().max_by_key(rows);
            best.filter(|d| rows(d) > 0)
        };
        most(Self::is_row)
            .or_else(|| most(Self::has_numbers))
            .or_else(|| {
                let stands = |d: &Self| d.separator.is_some_and(|s| first.contains(s));
                DIALECTS.into_iter().find(stands)
            })
            .unwrap_or(DIALECTS[0])
    }

    /// The cells of a line, without the blanks and quotes around them.
    pub fn cells<'a>(&self, line: &'a str) -> Vec<&'a str> {
        let bare = |cell: &'a str| cell.trim().trim_matches('"').trim();
        match self.separator {
            None => line.split_whitespace().map(bare).collect(),
            Some(separator) => {
                let mut quoted = false;
                line.split(|c| {
                    quoted ^= c == '"';
                    c == separator && !quoted
                })
                .map(bare)
                .collect()
            }
        }
    }

    /// A cell as a number, finite or not.
    pub fn any_number(&self, cell: &str) -> Option<f64> {
        // Some locales write the typographic minus sign, which is unambiguous.
        let proper = cell.strip_prefix('\u{2212}').map(|rest| format!("-{rest}"));
        let cell = proper.as_deref().unwrap_or(cell);
        if self.decimal_comma && cell.contains(',') {
            // With a decimal comma a point would be a thousands separator: which one is meant is unknown.
            return (!cell.contains('.'))
                .then(|| cell.replace(',', ".").parse().ok())
                .flatten();
        }
        cell.parse().ok().or_else(|| fortran(cell))
    }

    /// A cell as a finite number.
    pub fn number(&self, cell: &str) -> Option<f64> {
        self.any_number(cell).filter(|x| x.is_finite())
    }

    /// True if a line has at least two cells, all numbers. A line that ends with its separator has one cell less.
    pub fn is_row(&self, line: &str) -> bool {
        let cells = self.cells(line);
        let cells = without_end(&cells);
        cells.len() > 1 && cells.iter().all(|c| self.number(c).is_some())
    }

    /// True if a line has at least two numbers, whatever else it contains.
    pub fn has_numbers(&self, line: &str) -> bool {
        let cells = self.cells(line);
        cells.iter().filter(|c| self.number(c).is_some()).count() > 1
    }
}

/// A number of Fortran's double precision, `1.5D-03`.
fn fortran(cell: &str) -> Option<f64> {
    let begins = cell.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    begins.then(|| cell.replace(['D', 'd'], "e").parse().ok())?
}

/// The cells of a row without the empty one after a trailing separator.
pub fn without_end<'a, 'b>(cells: &'b [&'a str]) -> &'b [&'a str] {
    match cells {
        [all @ .., ""] if all.len() > 1 => all,
        all => all,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dialect_is_told_from_the_rows() {
        for (text, separator, decimal_comma) in [
            ("t,x\n0,1\n1,2", Some(','), false),
            ("t,x\n0, 1\n1, 2", Some(','), false),
            ("t\tx\n0.0\t1.5\n", Some('\t'), false),
            ("t\tx\n0,0\t1,5\n", Some('\t'), true),
            ("t;x\n0,0;1,5\n", Some(';'), true),
            ("t;x\n0.0;1.5;\n", Some(';'), false),
            ("t x\n 0.0  1.5\n", None, false),
            ("t x\n 0,0  1,5\n", None, true),
            ("t;x\noops;no\n", Some(';'), false),
            ("t;x;state\n0,0;1,5;up\n0,1;1,6;up\n", Some(';'), true),
            ("t\tx\tstate\n0.0\t1.5\tup\n", Some('\t'), false),
            ("\"t\",\"x\"\n\"0\",\"1\"\n", Some(','), false),
            ("t,x\n\"0,0\",\"1,5\"\n", Some(','), true),
        ] {
            let d = Dialect::of(text.lines());
            assert_eq!(
                (d.separator, d.decimal_comma),
                (separator, decimal_comma),
                "{text}"
            );
        }
    }

    #[test]
    fn cells_are_bare() {
        let d = DIALECTS[0];
        assert_eq!(d.cells(" a , \"b, c\",1 "), ["a", "b, c", "1"]);
        let comma = Dialect::new(Some(';'), true);
        assert_eq!(comma.number("-1,5e-3"), Some(-1.5e-3));
        assert_eq!(comma.number("1.234,5"), None);
        assert_eq!(d.number("-1.5D-03"), Some(-1.5e-3));
        assert_eq!(d.number("\u{2212}1.25"), Some(-1.25));
        assert_eq!(comma.number("\u{2212}1,25"), Some(-1.25));
        assert_eq!(d.number("Disp"), None);
    }
}
