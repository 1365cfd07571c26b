//! Texts with a little markup: `**bold**`, and code between backticks.

/// The text as HTML for a page.
pub fn html(text: &str) -> String {
    let escaped = text.replace('&', "&amp;").replace('<', "&lt;");
    between(
        &between(&escaped, "**", ["<b>", "</b>"]),
        "`",
        ["<code>", "</code>"],
    )
}

/// The text for a terminal, without bold.
pub fn plain(text: &str) -> String {
    text.replace("**", "")
}

/// Replaces every pair of marks; a mark without a partner stays.
fn between(text: &str, mark: &str, [open, close]: [&str; 2]) -> String {
    let parts: Vec<&str> = text.split(mark).collect();
    let mut out = String::with_capacity(text.len());
    for (i, part) in parts.iter().enumerate() {
        out += match (i, i % 2 == 1) {
            (0, _) => "",
            (_, true) if i + 1 == parts.len() => mark,
            (_, true) => open,
            (_, false) => close,
        };
        out += part;
    }
    out
}

/// A template writes into memory, which cannot fail.
pub fn written(rendered: askama::Result<String>) -> String {
    rendered.unwrap_or_else(|e| format!("the page cannot be written: {e}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_come_in_pairs() {
        assert_eq!(
            html("**a** < `b` & 2 ** 3"),
            "<b>a</b> &lt; <code>b</code> &amp; 2 ** 3"
        );
        assert_eq!(plain("**a** `b`"), "a `b`");
    }
}
