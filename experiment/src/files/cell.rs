//! A cell that is not a number: what it probably is, and what would be accepted.

/// Words that instruments and spreadsheets write for missing values.
const ABSENT: [&str; 9] = [
    "nan", "na", "n/a", "null", "none", "-", "--", "inf", "missing",
];

/// The end of a refusal: what is accepted, and what this cell seems to be.
pub fn wish(cell: &str) -> String {
    let seems = seems(cell).map_or_else(String::new, |what| format!("; {what}"));
    format!("accepted is a finite number{seems}")
}

fn seems(cell: &str) -> Option<&'static str> {
    let low = cell.to_lowercase();
    let bare = low.trim_start_matches(['+', '-']);
    if cell.is_empty() {
        return Some("the cell is blank: nothing was recorded there");
    }
    if cell.starts_with('#') {
        return Some("a spreadsheet writes that where it has no value or the column is too narrow");
    }
    if ABSENT.contains(&low.as_str()) || ABSENT.contains(&bare) || bare == "infinity" {
        return Some("it stands where nothing was recorded");
    }
    if is_clock(cell) {
        return Some(
            "a date or a time of day is not read: accepted are seconds from the start, or --rate HZ instead of the times",
        );
    }
    if is_grouped(cell) {
        return Some("digits in groups are not read: write 1002.56, without a thousands separator");
    }
    None
}

/// `12:00:01.2`, `2024-01-31T12:00:01`, `31.01.2024 12:00`.
fn is_clock(cell: &str) -> bool {
    let digit = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit());
    let mut parts = cell.split(':');
    let ends_in_digit = |part: &str| digit(part.trim().chars().next_back());
    match (parts.next(), parts.next()) {
        (Some(hours), Some(minutes)) => ends_in_digit(hours) && digit(minutes.chars().next()),
        _ => false,
    }
}

/// `1,002.56`, `1.002,56`, `1'002`, `1 002`: groups of three digits after the first.
fn is_grouped(cell: &str) -> bool {
    let cell = cell.trim_start_matches(['+', '-']);
    let groups: Vec<&str> = cell
        .split([',', '.', '\'', ' ', '\u{a0}', '\u{202f}', '\u{2019}'])
        .collect();
    let digits = |part: &str| part.chars().all(|c| c.is_ascii_digit());
    let first = groups.first().is_some_and(|g| (1..=3).contains(&g.len()));
    groups.len() > 1 && first && groups.iter().all(|g| digits(g)) && groups[1].len() == 3
}

#[cfg(test)]
mod tests {
    use super::wish;

    #[test]
    fn a_cell_that_is_no_number_says_what_it_seems_to_be() {
        for (cell, said) in [
            ("", "the cell is blank"),
            ("NaN", "nothing was recorded"),
            ("-Inf", "nothing was recorded"),
            ("n/a", "nothing was recorded"),
            ("#N/A", "a spreadsheet writes that"),
            ("######", "a spreadsheet writes that"),
            ("12:00:01.2", "a time of day"),
            ("2024-01-31T12:00:01.25", "a time of day"),
            ("1,002.56", "without a thousands separator"),
            ("-1.002,56", "without a thousands separator"),
            ("12\u{202f}002", "without a thousands separator"),
        ] {
            let sentence = wish(cell);
            assert!(
                sentence.starts_with("accepted is a finite number; "),
                "{cell}"
            );
            assert!(sentence.contains(said), "{cell}: {sentence}");
        }
        for cell in ["oops", "1,5", "1.2.3", "12 mm", "x:y"] {
            assert_eq!(wish(cell), "accepted is a finite number", "{cell}");
        }
    }
}
