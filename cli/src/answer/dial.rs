//! How the parameters of a diagnosis follow a dial.

use crate::document::{Document, table};
use crate::wording::digits;
use diagnosis::{DialNumber, Turned};
use experiment::numbers::percent;

/// Each name; nothing if there is no dial.
pub(super) fn section(d: &mut Document, dial: Option<&[Turned]>) {
    let Some(dial) = dial else { return };
    d.heading("The dial");
    if dial.is_empty() {
        d.tell("No law was named whose numbers can be read off every record of the dial.");
    }
    for t in dial {
        d.tell(sentence(t));
        let at: Vec<String> = t
            .doses
            .iter()
            .map(|at| format!("at {}", digits(*at)))
            .collect();
        let head: Vec<&str> = std::iter::once("number")
            .chain(at.iter().map(String::as_str))
            .chain(["halves differ", "follows"])
            .collect();
        let mut numbers = table(&head);
        for n in &t.numbers {
            let mut row = vec![n.name.clone()];
            row.extend(n.values.iter().map(|v| digits(*v)));
            row.push(digits(n.halves_differ));
            row.push(if n.follows { "yes" } else { "no" }.to_owned());
            numbers.add_row(row);
        }
        let mut names = vec!["name".to_owned()];
        names.extend(t.names.iter().map(|n| n.name().to_owned()));
        names.extend([String::new(), String::new()]);
        numbers.add_row(names);
        let mut left = vec!["left of the signal".to_owned()];
        left.extend(t.left.iter().map(|share| percent(*share)));
        left.extend([String::new(), String::new()]);
        numbers.add_row(left);
        d.table(numbers);
    }
}

fn sentence(t: &Turned) -> String {
    let named = |of_the_name: bool| -> Vec<&str> {
        let own = t
            .following()
            .filter(|n: &&DialNumber| n.of_the_name == of_the_name);
        own.map(|n| n.name.as_str()).collect()
    };
    let (own, others) = (named(true), named(false));
    let name = t.name.name();
    let follow = |n: usize| if n == 1 { "follows" } else { "follow" };
    match (&own[..], &others[..]) {
        ([], []) => {
            format!("No number of {name} follows the dial, nor does any that was declared.")
        }
        ([], others) => format!(
            "No number of {name} follows the dial, but {} {}: {name} is hardly what was turned.",
            others.join(" and "),
            follow(others.len())
        ),
        (own, []) => format!(
            "{} of {name} {} the dial, and no number that was declared does: that speaks for {name}.",
            own.join(" and "),
            follow(own.len())
        ),
        (own, others) => format!(
            "{} of {name} {} the dial, and {} too, which was declared: the name holds part of what was turned.",
            own.join(" and "),
            follow(own.len()),
            others.join(" and ")
        ),
    }
}
