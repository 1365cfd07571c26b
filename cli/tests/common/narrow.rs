//! On a terminal of 80 columns: no line is wider, and no unit is on a line of its own.
#![cfg(unix)]

use std::fs::File;
use std::io::Read;
use std::process::{Command, Stdio};

const COLUMNS: u16 = 80;

/// Units as they follow a number.
const UNITS: [&str; 17] = [
    "%", "m", "mm", "um", "mrad", "s", "ms", "us", "Hz", "N", "kN", "J", "mJ", "kJ", "MJ", "m/s",
    "N/m",
];

/// The output of a command on a terminal of 80 columns, both streams, and its exit status.
pub fn told(mut command: Command) -> (Option<i32>, String) {
    let size = nix::pty::Winsize {
        ws_row: 24,
        ws_col: COLUMNS,
        ws_xpixel: 0,
        ws_ypixel: 0,
    };
    let terminal = nix::pty::openpty(Some(&size), None).unwrap();
    let end = || Stdio::from(terminal.slave.try_clone().unwrap());
    command.stdin(end()).stdout(end()).stderr(end());
    let mut child = command.spawn().unwrap();
    // The terminal stays open as long as its other end is held here.
    drop((command, terminal.slave));
    let mut bytes = Vec::new();
    // Linux reports an error when nobody holds the terminal any more.
    let _ = File::from(terminal.master).read_to_end(&mut bytes);
    let status = child.wait().unwrap().code();
    (status, String::from_utf8(bytes).unwrap())
}

/// Lines as seen: without colours, and only the last state of a line that is overwritten.
pub fn seen(text: &str) -> Vec<String> {
    let mut plain = String::new();
    let mut rest = text;
    while let Some((before, behind)) = rest.split_once("\u{1b}[") {
        plain += before;
        let end = behind.find(|c: char| c.is_ascii_alphabetic());
        rest = &behind[end.map_or(behind.len(), |at| at + 1)..];
    }
    plain += rest;
    let lines = plain.split("\r\n");
    let last = |line: &str| line.rsplit('\r').next().unwrap_or_default().to_owned();
    lines.map(last).collect()
}

/// Checks that all output fits.
pub fn check(line: &str, text: &str) {
    for shown in seen(text) {
        let width = textwrap::core::display_width(&shown);
        // A path may be longer than any terminal, and stays whole; so does the usage of a verb.
        let whole = shown.starts_with("Usage: ")
            || shown.trim().contains('/') && !shown.trim().contains("  ");
        assert!(
            width <= usize::from(COLUMNS) || whole,
            "{line}: {width} columns: {shown}\n{text}"
        );
        let words: Vec<&str> = shown.split_whitespace().collect();
        assert!(
            words.is_empty() || !words.iter().all(|word| UNITS.contains(word)),
            "{line}: units without numbers: {shown}\n{text}"
        );
    }
}
