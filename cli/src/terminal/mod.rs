//! Tables and progress on the terminal.

pub mod coupled;
mod diagnosis;
pub mod interrupt;
pub mod misspelt;
mod next;
pub mod output;
pub mod plot;
mod standings;

pub use crate::numbers::{joule, percent};
pub use diagnosis::{diagnosis, stories};
pub use next::next;
pub use standings::{standings, standings_head, standings_row};

use crate::numbers::length;
use crate::summary::Summary;
use crate::trace::Witness;
use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use comfy_table::{
    CellAlignment, ColumnConstraint, ContentArrangement, Table, TableComponent, Width,
};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use outerloop_core::Record;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Columns of a terminal from which on tables are set with room around each cell.
const SPACIOUS: u16 = 120;

/// A table with a head; numbers, from the second column on, to the right.
pub fn table(head: &[&str]) -> Table {
    let mut table = Table::new();
    table
        .load_preset(UTF8_HORIZONTAL_ONLY)
        // A rule after every row makes a table twice as long.
        .remove_style(TableComponent::HorizontalLines)
        .remove_style(TableComponent::MiddleIntersections)
        // As wide as the terminal; as wide as it needs where there is none.
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_header(head);
    let narrow = table.width().is_some_and(|columns| columns < SPACIOUS);
    for (i, column) in table.column_iter_mut().enumerate() {
        if i > 0 {
            column.set_cell_alignment(CellAlignment::Right);
        }
        if narrow {
            column.set_padding((0, 1));
        }
        if narrow && i == 0 {
            // Names are read first: their head is not broken.
            let least = head[0].split(' ').map(str::len).max().unwrap_or(0) + 1;
            column.set_constraint(ColumnConstraint::LowerBoundary(Width::Fixed(least as u16)));
        }
    }
    table
}

/// One row a test; the ground motion where there is more than one.
pub fn summaries(rows: &[Summary]) -> Table {
    let several = rows.windows(2).any(|w| w[0].record != w[1].record);
    let mut head = vec![
        "ground motion",
        "compensation",
        "verdict",
        "eps_max",
        "eps_rms",
        "peak",
        "added damping",
        "energy error",
        "energy ratio",
    ];
    head.drain(..usize::from(!several));
    let mut t = table(&head);
    for s in rows {
        let cells = [
            s.record.clone(),
            s.compensation.to_owned(),
            s.trip
                .map_or_else(|| s.verdict.name().to_owned(), |f| format!("tripped: {f}")),
            percent(s.eps_max),
            percent(s.eps_rms),
            length(s.peak_displacement_m),
            percent(s.mean_added_damping_ratio),
            joule(s.energy_error_j),
            percent(s.energy_ratio),
        ];
        t.add_row(cells.into_iter().skip(usize::from(!several)));
    }
    t
}

/// What the columns of [`summaries`] mean.
pub const LEGEND: &str = "\
eps_max, eps_rms   largest and rms difference to the same test on an ideal actuator, of its largest displacement (Eqs 17, 18)
added damping      mean of what the compensation adds, of the critical damping of the first mode
energy error       what the actuator's error put into the structure (negative) or took out (positive), in all
energy ratio       what is left of it when the added damping has acted, of the energy in the test";

/// Steps between two looks at the clock.
const STEPS_A_TELL: u64 = 1 << 14;
/// Work that is over by then shows no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// A bar on standard error for work that takes longer than a second, where somebody looks at a terminal.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    began: Mutex<Option<Instant>>,
}

impl Progress {
    /// A bar over `steps` steps of work.
    pub fn over(what: &str, steps: u64) -> Self {
        let bar = ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {percent} %, {eta} left")
        {
            bar.set_style(style);
        }
        bar.set_message(what.to_owned());
        Self {
            bar,
            began: Mutex::new(Some(Instant::now())),
        }
    }

    /// Tells of `steps` more.
    pub fn add(&self, steps: u64) {
        self.bar.inc(steps);
        if let Ok(mut began) = self.began.lock()
            && began.is_some_and(|t| t.elapsed() > PATIENCE)
            && !output::is_quiet()
        {
            *began = None;
            // indicatif itself stays silent where standard error is no terminal.
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
    }

    /// What a test tells its steps to.
    pub fn witness(&self) -> Steps<'_> {
        Steps {
            progress: self,
            untold: 0,
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Does work of unknown length; beyond a second a spinner says what is being done, where somebody looks at a terminal.
pub fn while_waiting<T>(what: &str, work: impl FnOnce() -> T) -> T {
    if output::is_quiet() {
        return work();
    }
    let spinner = ProgressBar::new_spinner().with_message(what.to_owned());
    spinner.enable_steady_tick(PATIENCE);
    let done = work();
    spinner.finish_and_clear();
    done
}

/// Counts the steps of a test.
#[derive(Debug)]
pub struct Steps<'a> {
    progress: &'a Progress,
    untold: u64,
}

impl Witness for Steps<'_> {
    #[inline]
    fn see<const N: usize>(&mut self, _: &Record<N>) {
        self.untold += 1;
        if self.untold == STEPS_A_TELL {
            self.progress.add(self.untold);
            self.untold = 0;
        }
    }
}
