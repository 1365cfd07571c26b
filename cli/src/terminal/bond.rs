//! Keeps a number and its unit on one line.

/// Joins the two while a text is broken into lines: a space at which no line breaks.
const BOND: char = '\u{a0}';
/// Longest unit, characters, such as `N/(m/s)^0.5`.
const LONGEST_UNIT: usize = 12;

/// Joins each short word after a number to that number.
pub fn bound(text: &str) -> String {
    let numeric = |word: &str| {
        word.trim_start_matches(['-', '+', '('])
            .starts_with(|c: char| c.is_ascii_digit())
    };
    let is_unit = |word: &str| {
        let short = (1..=LONGEST_UNIT).contains(&word.chars().count());
        short && word != "/" && !numeric(word)
    };
    let mut bound = String::with_capacity(text.len());
    let mut last = "";
    for (i, word) in text.split(' ').enumerate() {
        if i > 0 {
            let ends = last.ends_with([',', '.', ':', ';', ')']);
            bound.push(match numeric(last) && !ends && is_unit(word) {
                true => BOND,
                false => ' ',
            });
        }
        bound += word;
        last = word;
    }
    bound
}

/// Turns the joins back into spaces.
pub fn loosened(text: &str) -> String {
    text.replace(BOND, " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_bound_and_other_words_are_not() {
        let text = "  53.0 % / -32.5 %, on 3, all of 1.2 kN";
        let tied = bound(text);
        assert_eq!(
            tied.replace(BOND, "_"),
            "  53.0_% / -32.5_%, on 3, all of 1.2_kN"
        );
        assert_eq!(loosened(&tied), text);
    }
}
