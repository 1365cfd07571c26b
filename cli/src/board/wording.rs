//! What a board reports, in words.

use link::status::{CrashCause, CrashReport, StartCause, Status};

/// Why the board last restarted, if nobody had requested it.
pub fn describe_words(started: StartCause, words: Option<&CrashReport>) -> Option<String> {
    let Some(words) = words else {
        return (started == StartCause::Watchdog)
            .then(|| "the watchdog reset the board, and no word is left of why".into());
    };
    let cause = match words.cause {
        CrashCause::Panic => "panicked",
        CrashCause::HardFault => "took a hard fault",
        CrashCause::StackOverflow => "ran out of stack",
        CrashCause::Starved => "was reset because a task starved",
        CrashCause::ClockStopped => "lost its clock",
        CrashCause::LowSupply => "lost its supply",
        CrashCause::PermitStays => "was reset because its PERMIT line did not follow",
        CrashCause::Silent => "was reset because its control interrupt had stopped",
    };
    Some(format!(
        "the board {cause} at control step {} while {}: {}",
        words.tick,
        words.mode.name(),
        words.text
    ))
}

/// Why the board last started.
pub fn describe_start(status: &Status) -> String {
    let words = describe_words(status.started, status.last_crash.as_ref());
    words.unwrap_or_else(|| {
        let why = match status.started {
            StartCause::Power => "its power had been away",
            StartCause::BrownOut => "its supply had been too low",
            StartCause::Pin => "its reset pin was pulled",
            StartCause::Software | StartCause::Watchdog => "its program asked for it",
        };
        why.into()
    })
}
