//! Standard output that may fail: a full disk or a closed pipe is one sentence at the end, never a panic.
//!
//! A test that moves a rig must not be ended by a full disk under its log. So what cannot be printed is dropped, and
//! [`finish`] returns it when the verb has finished.

use super::bond::{bound, loosened};
use experiment::failure::Failure;
use experiment::files::plain;
use std::fmt::Arguments;
use std::io::{Write, stderr, stdout};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// Why standard output could not be written, the first time.
static BROKEN: OnceLock<String> = OnceLock::new();

/// Tables, sentences and progress are switched off.
static QUIET: AtomicBool = AtomicBool::new(false);

/// From now on prints only what was asked for by name, and errors.
pub fn set_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Tables, sentences and progress are switched off.
pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Columns of the terminal on standard output; those that `COLUMNS` says where it is none.
pub fn columns() -> Option<u16> {
    let terminal = terminal_size::terminal_size_of(stdout()).map(|(width, _)| width.0);
    let said = || std::env::var("COLUMNS").ok()?.parse().ok();
    terminal.or_else(said).filter(|columns| *columns > 0)
}

/// Columns of a page where there is no terminal.
const PAGE: u16 = 100;

/// Columns of text that is read where it is printed or piped to: those of the terminal, else of a page.
pub fn page_columns() -> u16 {
    columns().unwrap_or(PAGE)
}

/// Text that is read, broken between words also where there is no terminal.
pub fn for_reading(text: &str) -> String {
    wrapped(text, page_columns().into())
}

/// Where the text begins whose rest goes below it: behind a label and a gap, else where the line begins, columns.
fn hanging(line: &str, columns: usize) -> usize {
    let start = line.len() - line.trim_start_matches(' ').len();
    let gap = line[start..].find("  ").map(|at| start + at);
    let behind = gap.map(|at| at + line[at..].len() - line[at..].trim_start_matches(' ').len());
    let behind = behind.map(|at| textwrap::core::display_width(&line[..at]));
    behind.filter(|at| 2 * at <= columns).unwrap_or(start)
}

/// Lines that are longer than the terminal, broken between words; the rest of a sentence goes below its start.
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
        // A path or a command that is longer than the line stays whole, so that it can be copied.
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

/// What `println!` is in this crate.
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

/// A line on standard error; dropped where that cannot be written, since nobody is left to read it.
pub fn print_note(text: Arguments<'_>) {
    let mut out = stderr().lock();
    let text = match terminal_size::terminal_size_of(&out) {
        Some((width, _)) => wrapped(&text.to_string(), width.0.into()),
        None => text.to_string(),
    };
    let _ = out.write_all((text + "\n").as_bytes());
}

/// What `answer!` is in this crate.
pub fn print_answer(text: Arguments<'_>) {
    if BROKEN.get().is_some() {
        return;
    }
    let mut out = stdout().lock();
    if let Err(e) = out.write_fmt(text).and_then(|()| out.write_all(b"\n")) {
        let _ = BROKEN.set(plain::reason(&e));
    }
}

/// What standard output could not take, once everything is said.
///
/// # Errors
/// A standard output that cannot be written.
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
        // A label keeps its column to itself.
        assert_eq!(
            wrapped("gain   of the valve, 1/s", 18),
            "gain   of the\n       valve, 1/s"
        );
        // A blank line and what fits stay as they are.
        assert_eq!(wrapped("a  b\n\n", 4), "a  b\n\n");
    }
}
