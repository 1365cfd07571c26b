//! The page of a bare board with four wires: what can be sent to whoever asks what this firmware does on that board.

use super::page::{escape, page};
use crate::board::desk::{DeskRow, RowVerdict};
use link::reply::Identity;

/// The page.
pub fn of_desk(board: &Identity, emulated: bool, notes: &[String], rows: &[DeskRow]) -> String {
    let count = |verdict| rows.iter().filter(|row| row.verdict == verdict).count();
    let (good, bad) = (count(RowVerdict::Good), count(RowVerdict::Bad));
    let class = if bad > 0 { "bad" } else { "good" };
    let mut html = format!(
        "<p class=\"verdict {class}\">{good} rows as they have to be, {bad} not, {} not done.</p>",
        count(RowVerdict::NotDone)
    );
    html += "<table><tr><th>what</th><th>found</th><th>has to be</th><th></th></tr>";
    for row in rows {
        let verdict = match row.verdict {
            RowVerdict::Good => "good",
            RowVerdict::Bad => "<strong>not so</strong>",
            RowVerdict::NotDone => "not done",
        };
        html += &format!(
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{verdict}</td></tr>",
            escape(&row.what),
            escape(&row.found),
            escape(&row.limit)
        );
    }
    html += "</table>";
    if !notes.is_empty() {
        let items = notes
            .iter()
            .map(|note| format!("<li>{}</li>", escape(note)));
        html += &format!("<h2>Notes</h2><ul>{}</ul>", items.collect::<String>());
    }
    let world = if emulated {
        "An <b>emulated</b> board: cycles are counted instructions, and the four wires are the emulator's."
    } else {
        "A board on a desk, four wires, no rig."
    };
    let lead = format!(
        "{} with firmware {} ({}), {} MHz. {world}",
        escape(&board.board),
        escape(&board.version),
        escape(&board.commit),
        f64::from(board.clock_hz) / 1e6
    );
    page("What a bare board does", &lead, &html)
}
