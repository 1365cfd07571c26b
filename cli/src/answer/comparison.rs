//! The same test under several compensations.

use super::figures::Figures;
use super::section::{TestSection, rank};
use super::summaries::summaries;
use crate::document::Document;
use crate::document::plot::{Colour, FIFTH, FOURTH, TESTED, THIRD, WRONG};
use experiment::summary::Summary;

/// Colours of the curves besides the ideal; more would hide each other.
const BESIDE: [Colour; 5] = [TESTED, WRONG, THIRD, FOURTH, FIFTH];

/// A close-up for each ground motion, then a row per test. `sections`: the tests whose traces were kept for a page.
pub fn of_compare(rows: &[Summary], sections: &[TestSection<'_>]) -> Document {
    let lead = format!(
        "{} tests. A dot is good, a diamond fair, a triangle not the structure's response.",
        rows.len()
    );
    let title = "One test under several compensations";
    let mut d = Document::new(title, lead, !sections.is_empty());
    let mut records: Vec<&str> = sections.iter().map(|s| s.summary.record.as_str()).collect();
    records.dedup();
    for record in records {
        let own = sections.iter().filter(|s| s.summary.record == record);
        let mut ranked: Vec<&TestSection<'_>> = own.collect();
        rank(&mut ranked, |s| (s.summary.verdict, s.summary.eps_rms));
        d.heading(record);
        let Some(best) = ranked.first() else {
            continue;
        };
        d.on_page(|d| {
            d.verdict(
                best.summary.validity(),
                format!(
                    "**{}** comes nearest. {}",
                    best.summary.compensation,
                    best.summary.sentence()
                ),
            );
        });
        // The best ones, and the worst for comparison.
        let mut shown: Vec<&TestSection<'_>> =
            ranked.iter().take(BESIDE.len() - 1).copied().collect();
        shown.extend(ranked.iter().skip(shown.len()).last());
        Figures::of(best).overlay(&mut d, &shown, &BESIDE);
    }
    d.heading("Every test");
    summaries(&mut d, rows);
    if let Some(first) = sections.first() {
        d.test_file(&first.experiment.test.text);
    }
    d
}
