//! What readers of files say, in words for who has never seen the code: a number, not `f64`.

use serde::de::DeserializeOwned;
use toml::Value;

/// Rust's words and an engineer's.
const WORDS: [(&str, &str); 12] = [
    (
        "invalid mantissa, expected digits",
        "a number needs a digit before its point, as in 0.02",
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
    // The tables that are read apart from the rest.
    (
        "expected one of `structure`",
        "expected one of `plant`, `excitation`, `declared`, `board`, `serve`, `structure`",
    ),
];

/// The sentence of a deserialiser, in one line.
pub fn sentence(said: &str) -> String {
    let mut text = said.split_whitespace().collect::<Vec<_>>().join(" ");
    for (rust, plain) in WORDS {
        text = text.replace(rust, plain);
    }
    if let Some((before, _)) = text.split_once("expected struct ") {
        text = format!("{before}expected a table");
    }
    // A list is read until it is full: how long it was meant to be is not known.
    if text.starts_with("invalid length ") && text.ends_with("expected a sequence") {
        text = "has too many values: accepted are at most 8 values".into();
    }
    text
}

/// What went wrong with a file, without the number that the system gives it.
pub fn reason(e: &std::io::Error) -> String {
    let text = e.to_string();
    match text.split_once(" (os error") {
        Some((plain, _)) => plain.to_owned(),
        None => text,
    }
}

/// A table as what it should be, or where in it the mistake is.
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
