//! Standard output that may fail: a full disk or a closed pipe gives one sentence at the end, never a panic.
//!
//! A full disk under its log must not end a test that moves a rig. So what cannot be printed is dropped, and [`finish`]
//! returns the error when the verb has finished.

use super::bond::{bound, loosened};
use experiment::failure::Failure;
use experiment::files::plain;
use std::fmt::Arguments;
use std::io::{Write, stderr, stdout};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// The first error of standard output.
static BROKEN: OnceLock<String> = OnceLock::new();

/// Tables, sentences and progress are switched off.
static QUIET: AtomicBool = AtomicBool::new(false);

/// From now on prints only what was requested by name, and errors.
pub fn set_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

/// True if tables, sentences and progress are switched off.
pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Columns of the terminal on standard output; without a terminal, those in `COLUMNS`.
pub fn columns() -> Option<u16> {
    let terminal = terminal_size::terminal_size_of(stdout()).map(|(width, _)| width.0);
    let said = || std::env::var("COLUMNS").ok()?.parse().ok();
    terminal.or_else(said).filter(|columns| *columns > 0)
}

/// Columns of a page without a terminal.
const PAGE: u16 = 100;

/// Columns of text for reading, printed or piped: those of the terminal, else of a page.
pub fn page_columns() -> u16 {
    columns().unwrap_or(PAGE)
}

/// Text for reading, broken between words even without a terminal.
pub fn for_reading(text: &str) -> String {
    wrapped(text, page_columns().into())
}

/// Column at which the following lines of a text begin: after a label and a gap, else where the line begins.
fn hanging(line: &str, columns: usize) -> usize {
    let start = line.len() - line.trim_start_matches(' ').len();
    let gap = line[start..].find("  ").map(|at| start + at);
    let behind = gap.map(|at| at + line[at..].len() - line[at..].trim_start_matches(' ').len());
    let behind = behind.map(|at| textwrap::core::display_width(&line[..at]));
    behind.filter(|at| 2 * at <= columns).unwrap_or(start)
}

/// Breaks lines longer than the terminal between words; the rest of a sentence is aligned below its start.
fn wrapped(text: &str, columns: usize) -> String {
    let fits = |line: &str| textwrap::core::display_width(line) <= columns;
    let lines = text.split('\n').map(|line| {
        if fits(line) {
            return line.to_owned();
        }
        let sentence = line.trim_start_matches(' ');
        let indent = &line[..line.len() - sentence.len()];
        let sentence = bound(sentence);
        let below = " ".repeat(hanging(line, columns));
        // A path or a command longer than the line stays whole, so that it can be copied.
        let options = textwrap::Options::new(columns)
            .initial_indent(indent)
            .subsequent_indent(&below)
            .word_separator(textwrap::WordSeparator::AsciiSpace)
            .word_splitter(textwrap::WordSplitter::NoHyphenation)
            .break_words(false);
        loosened(&textwrap::fill(&sentence, options))
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// The `println!` of this crate.
pub fn print_line(text: Arguments<'_>) {
    if is_quiet() {
        return;
    }
    match columns() {
        Some(columns) => {
            print_answer(format_args!(
                "{}",
                wrapped(&text.to_string(), columns.into())
            ));
        }
        None => print_answer(text),
    }
}

/// A line on standard error; dropped if that cannot be written, since nobody could read it.
pub fn print_note(text: Arguments<'_>) {
    let mut out = stderr().lock();
    let text = match terminal_size::terminal_size_of(&out) {
        Some((width, _)) => wrapped(&text.to_string(), width.0.into()),
        None => text.to_string(),
    };
    let _ = out.write_all((text + "\n").as_bytes());
}

/// The `answer!` of this crate.
pub fn print_answer(text: Arguments<'_>) {
    if BROKEN.get().is_some() {
        return;
    }
    let mut out = stdout().lock();
    if let Err(e) = out.write_fmt(text).and_then(|()| out.write_all(b"\n")) {
        let _ = BROKEN.set(plain::reason(&e));
    }
}

/// Flushes standard output, and reports the first error in writing it.
///
/// # Errors
/// Standard output could not be written.
pub fn finish() -> Result<(), Failure> {
    if let Err(e) = stdout().flush() {
        let _ = BROKEN.set(plain::reason(&e));
    }
    match BROKEN.get() {
        None => Ok(()),
        Some(why) => Err(Failure::input(format!(
            "standard output cannot be written: {why}; what was printed is not complete"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::wrapped;

    #[test]
    fn a_sentence_breaks_between_words_and_keeps_its_indent_and_a_path_stays_whole() {
        let text = "short\n    the restoring force of the specimen in newtons\n  /a/very/long/path/that/goes/on.csv";
        assert_eq!(
            wrapped(text, 24),
            "short\n    the restoring force\n    of the specimen in\n    newtons\n  /a/very/long/path/that/goes/on.csv"
        );
        assert_eq!(
            wrapped("an error of 12.5 %, rms", 18),
            "an error of\n12.5 %, rms"
        );
        // A label keeps its own column.
        assert_eq!(
            wrapped("gain   of the valve, 1/s", 18),
            "gain   of the\n       valve, 1/s"
        );
        // A blank line, and a line that fits, stay as they are.
        assert_eq!(wrapped("a  b\n\n", 4), "a  b\n\n");
    }
}
