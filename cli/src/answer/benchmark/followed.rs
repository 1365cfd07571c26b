//! An external controller, judged by its table of commands.

use crate::document::{Document, table};

/// The result of the table: the meaning and the figure of each criterion.
pub fn of_followed<'a>(
    lead: String,
    figures: impl Iterator<Item = (&'a str, String)>,
    with_page: bool,
) -> Document {
    let mut d = Document::new("A table of commands", "", with_page);
    d.say(lead);
    let rows = figures.map(|(meaning, figure)| vec![meaning.to_owned(), figure]);
    d.table(table(&["criterion", "figure"]).of_text().with_rows(rows));
    d
}
