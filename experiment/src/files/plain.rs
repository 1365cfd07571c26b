//! Error messages of the file readers in plain words: a number, not `f64`.

use serde::de::DeserializeOwned;
use toml::Value;

/// Lines longer than this are not quoted.
const LONGEST_LINE: usize = 80;

/// Rust's words and an engineer's.
const WORDS: [(&str, &str); 16] = [
    (
        "invalid mantissa, expected digits",
        "a number needs a digit before its point, as in 0.02",
    ),
    (
        "invalid fraction, expected digits",
        "a number needs a digit behind its point, as in 4.0",
    ),
    (
        "unexpected leading zero, expected nothing",
        "a number does not begin with a zero and another digit: write 4, or 0.4",
    ),
    (
        "unexpected key or value, expected newline, `#`",
        "something stands behind the value; a number has a point and no comma, as in 4.5",
    ),
    (
        "string values must be quoted, expected literal string",
        "a value is missing here, or a text without its quotes",
    ),
    (
        "floating-point number overflowed",
        "a number is beyond 1.8e308",
    ),
    ("expected f64", "expected a number"),
    ("expected f32", "expected a number"),
    ("expected u8", "expected a whole number to 255"),
    ("expected u16", "expected a whole number to 65535"),
    ("expected u32", "expected a whole number"),
    ("expected usize", "expected a whole number"),
    (
        "expected struct Declared",
        "expected { value = , tolerance = }",
    ),
    ("expected a borrowed string", "expected a text"),
    ("expected a string", "expected a text"),
    // The tables that are read separately.
    (
        "expected one of `structure`",
        "expected one of `plant`, `excitation`, `declared`, `board`, `serve`, `watch`, `coupled`, `structure`",
    ),
];

/// A deserialiser's message, in one line.
pub fn sentence(said: &str) -> String {
    let mut text = said.split_whitespace().collect::<Vec<_>>().join(" ");
    for (rust, plain) in WORDS {
        text = text.replace(rust, plain);
    }
    if let Some((before, _)) = text.split_once("expected struct ") {
        text = format!("{before}expected a table");
    }
    if let Some(kinds) = text.strip_prefix("invalid type: ")
        && let Some((found, wanted)) = kinds.rsplit_once(", expected ")
    {
        text = format!("{} stands there: accepted is {wanted}", plain_kind(found));
    }
    // A list is read until it is full: its intended length is unknown.
    if text.starts_with("invalid length ") && text.ends_with("expected a sequence") {
        text = "has too many values: accepted are at most 8 values".into();
    }
    text
}

/// A value of the wrong kind, as shown by the readers, in plain words.
fn plain_kind(found: &str) -> String {
    let quoted = |text: &str| text.trim_matches('`').to_owned();
    match found.split_once(' ') {
        Some(("string", text)) => format!("the text {text}"),
        Some(("integer" | "boolean", value)) => quoted(value),
        Some(("floating", rest)) => quoted(rest.trim_start_matches("point ")),
        _ => match found {
            "map" => "a table".into(),
            "sequence" => "a list".into(),
            other => other.to_owned(),
        },
    }
}

/// The line of a file with a TOML error, and the error.
pub fn in_line(text: &str, mistake: &toml::de::Error) -> String {
    let said = sentence(mistake.message());
    let Some(span) = mistake.span() else {
        return format!("line 1: {said}");
    };
    let before = &text[..span.start.min(text.len())];
    let number = 1 + before.matches('\n').count();
    let line = text.lines().nth(number - 1).unwrap_or_default().trim();
    if line.is_empty() || line.chars().count() > LONGEST_LINE {
        return format!("line {number}: {said}");
    }
    format!("line {number}, `{line}`: {said}")
}

/// The reason for a file error, without the system's error number.
pub fn reason(e: &std::io::Error) -> String {
    let text = e.to_string();
    match text.split_once(" (os error") {
        Some((plain, _)) => plain.to_owned(),
        None => text,
    }
}

/// Converts a table to its type, or reports the location of the error.
///
/// # Errors
/// A key or value that cannot be used, with its path.
pub fn typed<T: DeserializeOwned>(root: &str, value: Value) -> Result<T, String> {
    serde_path_to_error::deserialize(value).map_err(|e| {
        let path = match (root, e.path().to_string()) {
            (root, inner) if inner == "." => root.to_owned(),
            ("", inner) => inner,
            (root, inner) => format!("{root}.{inner}"),
        };
        let said = sentence(e.inner().message());
        if path.is_empty() {
            said
        } else {
            format!("{path}: {said}")
        }
    })
}

/// The table `name` of a test file; its defaults if it is omitted.
///
/// # Errors
/// A refused key or value.
pub fn part<T: DeserializeOwned + Default>(name: &str, value: Option<Value>) -> Result<T, String> {
    value.map_or_else(|| Ok(T::default()), |value| typed(name, value))
}

#[cfg(test)]
mod tests {
    use super::{in_line, sentence};

    #[test]
    fn a_value_of_another_kind_is_named_in_plain_words() {
        for (said, plain) in [
            (
                "invalid type: string \"a, b\", expected f64",
                "the text \"a, b\" stands there: accepted is a number",
            ),
            (
                "invalid type: floating point `4.5`, expected usize",
                "4.5 stands there: accepted is a whole number",
            ),
            (
                "invalid type: map, expected a string",
                "a table stands there: accepted is a text",
            ),
        ] {
            assert_eq!(sentence(said), plain);
        }
    }

    #[test]
    fn a_line_that_is_no_toml_is_quoted_and_says_how_a_number_is_written() {
        for (value, said) in [
            ("4,5", "a point and no comma, as in 4.5"),
            ("04", "write 4, or 0.4"),
            ("5.", "a digit behind its point"),
            (".5", "a digit before its point"),
            ("", "a value is missing here"),
        ] {
            let text = format!("[plant.actuator]\ndelay_ms = {value}\n");
            let mistake = text.parse::<toml::Table>().unwrap_err();
            let sentence = in_line(&text, &mistake);
            let line = format!("delay_ms = {value}");
            let place = format!("line 2, `{}`: ", line.trim());
            assert!(sentence.starts_with(&place), "{sentence}");
            assert!(sentence.contains(said), "{sentence}");
        }
    }
}
