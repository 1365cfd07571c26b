//! Tables on the terminal: as wide as it is, and never broken inside a word or a number.

use super::bond;
use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use comfy_table::{
    Cell, CellAlignment, ColumnConstraint, ContentArrangement, Row, TableComponent, Width,
};
use experiment::coupled::figures::CoupledFigures;
use experiment::numbers::{joule, length, percent, three};
use experiment::summary::Summary;
use std::fmt;
use std::ops::{Deref, DerefMut};
use textwrap::core::display_width;

/// Columns of a terminal from which on tables are set with room around each cell.
const SPACIOUS: usize = 120;
/// A longer word, such as a path, may be broken.
const LONGEST_WORD: usize = 44;

/// A table for people. Where the terminal is too narrow for its longest words side by side, columns that matter least are left
/// out and named below it; where it is too narrow for the others, each row is a block of lines.
#[derive(Clone, Debug)]
pub struct Table {
    all: comfy_table::Table,
    /// Columns that may be left out, the first one first.
    least_important: &'static [usize],
}

impl Deref for Table {
    type Target = comfy_table::Table;

    fn deref(&self) -> &Self::Target {
        &self.all
    }
}

impl DerefMut for Table {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.all
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let table = self.bound();
        let Some(columns) = table.width().map(usize::from) else {
            return f.write_str(&loosened(&table));
        };
        let room: &[(u16, u16)] = match columns < SPACIOUS {
            true => &[(0, 1), (0, 0)],
            false => &[(1, 1), (0, 1), (0, 0)],
        };
        let mut widths = Widths::of(&table);
        for left_out in 0..=self.least_important.len() {
            for padding in room {
                if let Some(found) = widths.within(columns, *padding) {
                    f.write_str(&loosened(&set(table, &found, *padding)))?;
                    return self.name(&self.least_important[..left_out], f);
                }
            }
            if let Some(column) = self.least_important.get(left_out) {
                widths.leave_out(*column);
            }
        }
        self.as_blocks(f)
    }
}

/// The table with columns of these widths, blanks beside the cells included; those of no width are not shown.
fn set(mut table: comfy_table::Table, widths: &[usize], padding: (u16, u16)) -> comfy_table::Table {
    for (column, width) in table.column_iter_mut().zip(widths) {
        column.set_constraint(match width {
            0 => ColumnConstraint::Hidden,
            width => ColumnConstraint::Absolute(Width::Fixed(*width as u16)),
        });
        column.set_padding(padding);
    }
    table
}

impl Table {
    /// The same with words in the first `columns`, to the left.
    pub fn with_words(mut self, columns: usize) -> Self {
        for column in self.all.column_iter_mut().take(columns) {
            column.set_cell_alignment(CellAlignment::Left);
        }
        self
    }

    /// The same with columns that a narrow terminal may leave out, the first one first.
    pub fn least_important(mut self, columns: &'static [usize]) -> Self {
        self.least_important = columns;
        self
    }

    /// The same for reading: no wider than a page where there is no terminal.
    pub fn of_text(mut self) -> Self {
        self.all.set_width(super::output::page_columns());
        self
    }

    /// The same with each unit bound to its number.
    fn bound(&self) -> comfy_table::Table {
        let mut table = self.all.clone();
        for row in table.row_iter_mut() {
            let cells = contents(Some(row));
            *row = cells
                .iter()
                .map(|cell| bond::bound(cell))
                .collect::<Vec<_>>()
                .into();
        }
        table
    }

    /// What a wider terminal would show, too.
    fn name(&self, left_out: &[usize], f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if left_out.is_empty() {
            return Ok(());
        }
        let heads = contents(self.all.header());
        let names: Vec<&str> = left_out.iter().map(|c| heads[*c].as_str()).collect();
        write!(f, "\nOn a wider terminal also: {}.", names.join(", "))
    }

    /// Each row as lines: the head of a column, and its cell.
    fn as_blocks(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let heads = contents(self.all.header());
        let wide = heads.iter().map(|h| display_width(h)).max().unwrap_or(0);
        for (i, row) in self.all.row_iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            let lines = heads.iter().zip(contents(Some(row)));
            for (k, (head, cell)) in lines.filter(|(_, cell)| !cell.is_empty()).enumerate() {
                if i + k > 0 {
                    writeln!(f)?;
                }
                write!(f, "{head:<wide$}  {cell}")?;
            }
        }
        Ok(())
    }
}

/// The table as text, its bonds blanks again.
fn loosened(table: &comfy_table::Table) -> String {
    bond::loosened(&table.to_string())
}

fn contents(row: Option<&Row>) -> Vec<String> {
    row.into_iter()
        .flat_map(Row::cell_iter)
        .map(Cell::content)
        .collect()
}

/// How wide the text of each column may be; 0: the column is left out.
struct Widths {
    /// At least: its longest word.
    least: Vec<usize>,
    /// At most: its longest line.
    most: Vec<usize>,
}

impl Widths {
    fn of(table: &comfy_table::Table) -> Self {
        let (mut least, mut most) = (Vec::new(), Vec::new());
        for row in table.header().into_iter().chain(table.row_iter()) {
            for (i, cell) in row.cell_iter().enumerate() {
                least.resize(least.len().max(i + 1), 1);
                most.resize(least.len(), 1);
                for line in cell.content().lines() {
                    let words = line.split(' ').map(display_width);
                    let word = words.max().unwrap_or(0).min(LONGEST_WORD);
                    least[i] = word.max(least[i]);
                    most[i] = display_width(line).max(most[i]);
                }
            }
        }
        Self { least, most }
    }

    fn leave_out(&mut self, column: usize) {
        (self.least[column], self.most[column]) = (0, 0);
    }

    /// Widths that fit into so many columns, blanks beside each cell included: the widest give way first. `None`: none do.
    fn within(&self, columns: usize, (left, right): (u16, u16)) -> Option<Vec<usize>> {
        let padding = usize::from(left + right);
        let shown = self.most.iter().filter(|most| **most > 0).count();
        // And a blank where other tables have a line.
        let room = columns.checked_sub(shown * padding + shown.saturating_sub(1))?;
        let at_most = |cap: usize| -> Vec<usize> {
            let both = self.most.iter().zip(&self.least);
            both.map(|(most, least)| *most.min(&cap).max(least))
                .collect()
        };
        let cap = (0..=room)
            .rev()
            .find(|cap| at_most(*cap).iter().sum::<usize>() <= room)?;
        let with_padding = |width: usize| if width > 0 { width + padding } else { 0 };
        Some(at_most(cap).into_iter().map(with_padding).collect())
    }
}

/// A table with a head; numbers, from the second column on, to the right.
pub fn table(head: &[&str]) -> Table {
    let mut table = comfy_table::Table::new();
    table
        .load_preset(UTF8_HORIZONTAL_ONLY)
        // A rule after every row makes a table twice as long.
        .remove_style(TableComponent::HorizontalLines)
        .remove_style(TableComponent::MiddleIntersections)
        // As wide as the terminal; as wide as it needs where there is none.
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_header(head);
    if let Some(columns) = super::output::columns() {
        table.set_width(columns);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    Table {
        all: table,
        least_important: &[],
    }
}

/// A column of the figures of tests: its head, and the cell of a test.
pub type SummaryColumn = (&'static str, fn(&Summary) -> String);

const GROUND_MOTION: SummaryColumn = ("ground motion", |s| s.record.clone());
const HOW_IT_WENT: [SummaryColumn; 4] = [
    ("compensation", |s| s.compensation.to_owned()),
    ("verdict", verdict),
    ("eps_max", |s| percent(s.eps_max)),
    ("eps_rms", |s| percent(s.eps_rms)),
];
const ENERGY_ERROR: SummaryColumn = ("energy error", |s| joule(s.energy_error_j));
/// Of actuators that each move a floor of their own.
const OF_FLOORS: [SummaryColumn; 4] = [
    ("peak", |s| length(s.peak_displacement_m)),
    ("added damping", |s| percent(s.mean_added_damping_ratio)),
    ENERGY_ERROR,
    ("energy ratio", |s| percent(s.energy_ratio)),
];
/// Of two coupled actuators.
const OF_INTERFACE: [SummaryColumn; 5] = [
    ("by coordinate", |s| {
        let each = s.coupled.iter().flat_map(|c| &c.eps_rms_by_coordinate);
        each.map(|e| percent(*e)).collect::<Vec<_>>().join(" / ")
    }),
    ("x", |s| length(s.peak_displacement_m)),
    ("rotation", |s| {
        of_interface(s, |c| rotation(c.peak_rotation_rad))
    }),
    ("tracking 1 / 2", |s| of_interface(s, tracking)),
    ENERGY_ERROR,
];

fn verdict(s: &Summary) -> String {
    let Some(fault) = s.trip else {
        return s.verdict.name().to_owned();
    };
    match s.coupled.as_ref().and_then(|c| c.trip_axis) {
        None => format!("tripped: {fault}"),
        Some(axis) => format!("tripped: {fault} of {axis}"),
    }
}

fn of_interface(s: &Summary, cell: fn(&CoupledFigures) -> String) -> String {
    s.coupled.as_ref().map_or_else(String::new, cell)
}

/// A rotation.
pub fn rotation(rad: f64) -> String {
    format!("{} mrad", three(1e3 * rad))
}

/// How well each of two coupled actuators followed.
pub fn tracking(c: &CoupledFigures) -> String {
    c.tracking_rms_by_actuator.map(percent).join(" / ")
}

/// The columns of tests, and which of them a narrow terminal may leave out, the first one first. The ground motion is one where
/// there is more than one.
pub fn summary_columns(rows: &[Summary]) -> (Vec<SummaryColumn>, &'static [usize]) {
    let several = rows.windows(2).any(|w| w[0].record != w[1].record);
    let coupled = rows.iter().any(|s| s.coupled.is_some());
    let mut columns = HOW_IT_WENT.to_vec();
    columns.extend(if coupled {
        &OF_INTERFACE[..]
    } else {
        &OF_FLOORS
    });
    if several {
        columns.insert(0, GROUND_MOTION);
    }
    // The ratio, then the added damping; tracking, then the share of each coordinate.
    let least_important: &[usize] = match (coupled, several) {
        (false, false) => &[7, 5],
        (false, true) => &[8, 6],
        (true, false) => &[7, 4],
        (true, true) => &[8, 5],
    };
    (columns, least_important)
}

/// One row a test, and what its columns mean.
pub fn summaries(rows: &[Summary]) -> String {
    let (columns, least_important) = summary_columns(rows);
    let head: Vec<&str> = columns.iter().map(|(head, _)| *head).collect();
    let mut t = table(&head).least_important(least_important);
    for s in rows {
        t.add_row(columns.iter().map(|(_, cell)| cell(s)));
    }
    let coupled = rows.iter().any(|s| s.coupled.is_some());
    let meaning = if coupled { LEGEND_OF_INTERFACE } else { LEGEND };
    format!("{t}\n{meaning}")
}

/// What the columns of [`summaries`] mean.
const LEGEND: &str = "\
eps_max, eps_rms   largest and rms difference to the same test on an ideal actuator, of its largest displacement (Eqs 17, 18)
added damping      mean of what the compensation adds, of the critical damping of the first mode
energy error       what the actuator's error put into the structure (negative) or took out (positive), in all
energy ratio       what is left of it when the added damping has acted, of the energy in the test";

/// The same of two coupled actuators.
const LEGEND_OF_INTERFACE: &str = "\
eps_max, eps_rms   largest and rms difference to the same test on ideal actuators, of its largest motion, worst coordinate (Eqs 17, 18)
by coordinate      eps_rms of each coordinate
x, rotation        largest of the interface
tracking           true strokes less targets, rms, of the targets', actuator 1 / 2
energy error       what the actuators' errors put into the structure (negative) or took out (positive), in all (Eq 12)";

#[cfg(test)]
mod tests {
    use super::*;

    fn of(columns: u16) -> String {
        let mut t = table(&["channel", "verdict", "held out rms after", "noise rms"]);
        t.set_width(columns);
        t.add_row(["actuator", "partial", "0.06455 mm", "0.01009 mm"]);
        t.add_row(["specimen", "coulomb_friction", "", "44.8 N"]);
        t.to_string()
    }

    #[test]
    fn no_word_and_no_number_is_broken() {
        for columns in [200, 80, 60, 50, 40, 20] {
            let text = of(columns);
            for word in ["actuator", "0.06455", "0.01009", "coulomb_friction"] {
                assert!(text.contains(word), "{columns}:\n{text}");
            }
            let widest = text.lines().map(|l| l.chars().count()).max().unwrap();
            assert!(
                columns < 50 || widest <= usize::from(columns),
                "{columns}:\n{text}"
            );
        }
        // A unit stays beside its number.
        for columns in [80, 60, 50] {
            assert!(of(columns).contains("0.06455 mm"), "{}", of(columns));
        }
        assert!(of(40).contains("held out rms after  0.06455 mm"));
        assert!(
            !of(40).contains("held out rms after  \n"),
            "an empty cell needs no line"
        );
    }

    #[test]
    fn what_matters_least_is_left_out_and_named_before_a_row_becomes_a_block() {
        let text = |columns: u16| {
            let mut t = table(&["compensation", "eps_rms", "damping"]).least_important(&[2]);
            t.set_width(columns);
            t.add_row(["tangent", "0.00106 %", "3.47 %"]);
            t.to_string()
        };
        assert!(text(40).contains("3.47 %"));
        let narrow = text(28);
        assert!(!narrow.contains("3.47 %"), "{narrow}");
        assert!(
            narrow.ends_with("\nOn a wider terminal also: damping."),
            "{narrow}"
        );
        assert!(
            narrow.lines().take(4).all(|l| display_width(l) <= 28),
            "{narrow}"
        );
        assert!(text(18).contains("damping       3.47 %"), "{}", text(18));
    }
}
