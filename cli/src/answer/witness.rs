//! What unused channels say of the names of a diagnosis.

use crate::document::plot::{Curve, HALF, IDEAL, TESTED, history, plot};
use crate::document::{Document, table};
use diagnosis::{Says, Testimony};
use schemars::JsonSchema;
use serde::Serialize;

/// Shares that differ by less than this count as equal.
const AS_MUCH: f64 = 0.05;

/// A witness, and what it says of each name.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Witness {
    /// The file.
    pub file: String,
    /// Its column in the file.
    pub column: String,
    /// What it says; empty where nothing was named.
    pub testimonies: Vec<Testimony>,
}

/// All witnesses; nothing if there are none.
pub(super) fn section(d: &mut Document, witnesses: &[Witness]) {
    if witnesses.is_empty() {
        return;
    }
    d.heading("Channels that took no part");
    for w in witnesses {
        if w.testimonies.is_empty() {
            d.tell(format!(
                "`{}` has nothing to speak of: no law was named.",
                w.column
            ));
        }
        for t in &w.testimonies {
            d.tell(sentence(&w.column, t));
            let mut shares = table(&["name", "what it takes of the witness"]);
            shares.add_row([t.name.name().to_owned(), share(t.share)]);
            for other in &t.others {
                shares.add_row([other.name.name().to_owned(), share(other.share)]);
            }
            d.table(shares);
            picture(d, &w.column, t);
        }
    }
}

fn share(share: f64) -> String {
    format!("{:.0} %", 100.0 * share.max(0.0))
}

fn sentence(column: &str, t: &Testimony) -> String {
    let (name, own) = (t.name.name(), share(t.share));
    let [low, high] = t.share_ci90.map(share);
    let best = t.others.iter().max_by(|a, b| a.share.total_cmp(&b.share));
    let best = best.map(|o| format!("{}, {}", o.name.name(), share(o.share)));
    let takes = format!(
        "of what the motion alone leaves of it on held-out data it takes {own} ({low} to {high})"
    );
    match t.says {
        Says::For => {
            let as_much = t.others.iter().filter(|o| o.share > t.share - AS_MUCH);
            let as_much: Vec<&str> = as_much.map(|o| o.name.name()).collect();
            let others = match (&as_much[..], best) {
                ([], None) => String::new(),
                ([], Some(best)) => format!("; the best of other families is {best}"),
                (names, _) => format!("; {} would take as much", names.join(" and ")),
            };
            format!("`{column}` shows {name}: {takes}{others}.")
        }
        Says::Against => {
            let best = best.unwrap_or_default();
            format!(
                "`{column}` speaks against {name}: {takes}, and another name takes more: {best}."
            )
        }
        Says::Nothing => format!(
            "`{column}` says nothing of {name}: {takes}. What only displaces, delays, damps or weighs, no other channel can tell \
             from the motion."
        ),
    }
}

fn picture(d: &mut Document, column: &str, t: &Testimony) {
    if t.says == Says::Nothing || !d.has_page() {
        return;
    }
    let heard = &t.heard;
    let over = |y: &[f64]| history(y.len(), |i| (heard.time_s[i], y[i]));
    let curves = [
        Curve::new(IDEAL, over(&heard.left_by_motion)).named("left by the motion"),
        Curve::new(TESTED, over(&heard.by_name)).named(t.name.name()),
    ];
    let caption = format!(
        "What the motion leaves of `{column}`, and what {} makes of it.",
        t.name.name()
    );
    d.figure(caption, || plot(HALF, "time [s]", column, &curves));
}
