//! A bare board with four wires: a page that shows what this firmware does on that board.

use crate::board::desk::{DeskRow, RowVerdict};
use crate::document::{Document, Grade, table};
use link::reply::Identity;

/// The page of the results.
pub fn of_desk(board: &Identity, emulated: bool, notes: &[String], rows: &[DeskRow]) -> Document {
    let world = if emulated {
        "An **emulated** board: cycles are counted instructions, and the four wires are the emulator's."
    } else {
        "A board on a desk, four wires, no rig."
    };
    let lead = format!(
        "{} with firmware {} ({}), {} MHz. {world}",
        board.board,
        board.version,
        board.commit,
        f64::from(board.clock_hz) / 1e6
    );
    let mut d = Document::new("What a bare board does", lead, true);
    let count = |verdict| rows.iter().filter(|row| row.verdict == verdict).count();
    let (good, bad) = (count(RowVerdict::Good), count(RowVerdict::Bad));
    let grade = if bad > 0 { Grade::Bad } else { Grade::Good };
    d.on_page(|d| {
        let not_done = count(RowVerdict::NotDone);
        let verdict = format!("{good} rows as they have to be, {bad} not, {not_done} not done.");
        d.verdict(grade, verdict);
        let mut t = table(&["what", "found", "has to be", ""]);
        for row in rows {
            let (verdict, grade) = match row.verdict {
                RowVerdict::Good => ("good", Some(Grade::Good)),
                RowVerdict::Bad => ("not so", Some(Grade::Bad)),
                RowVerdict::NotDone => ("not done", None),
            };
            t.add_row([row.what.as_str(), &row.found, &row.limit, verdict]);
            grade.into_iter().for_each(|grade| t.grade_last(grade));
        }
        d.table(t);
    });
    for row in rows {
        let verdict = match row.verdict {
            RowVerdict::Good => "good",
            RowVerdict::Bad => "BAD",
            RowVerdict::NotDone => "----",
        };
        d.tell(format!("{verdict:4}  {}: {}", row.what, row.found));
    }
    if !notes.is_empty() {
        d.heading("Notes");
        d.on_page(|d| d.items(notes.to_vec()));
    }
    d
}
