//! Where the instructions of a step go: every executed instruction, attributed by the image's own line tables.
//!
//! The step is inlined into one piece of code, so its parts cannot be timed from outside. The emulator traces each instruction,
//! and the debug information gives the function of core from which it was inlined.

use super::cycles::Course;
use addr2line::Loader;
use std::collections::HashMap;
use std::io::{Error, Result};
use std::path::Path;

/// The parts of a step, in their order.
pub const PARTS: [&str; 8] = [
    "estimator",
    "energy errors",
    "compensation",
    "integration",
    "signal, ground motion",
    "interlocks, supervisor",
    "record, history",
    "frame of the step",
];

/// Instructions of one step, by part.
pub type Counts = [u32; PARTS.len()];

/// The part that contains all others.
const FRAME: usize = PARTS.len() - 1;

/// The instructions of each step, by part.
///
/// # Errors
/// The image cannot be read.
pub fn parts(image: &Path, steps: &[Course]) -> Result<Vec<Counts>> {
    let symbols = Loader::new(image).map_err(|e| Error::other(e.to_string()))?;
    let mut known: HashMap<u32, Option<usize>> = HashMap::new();
    let counted = steps.iter().map(|step| {
        let (mut counts, mut part) = (Counts::default(), FRAME);
        for spent in &step.spent {
            let own = known.entry(spent.at);
            part = own
                .or_insert_with(|| part_at(&symbols, spent.at))
                .unwrap_or(part);
            counts[part] += 1;
        }
        counts
    });
    Ok(counted.collect())
}

/// The part to which the instruction at `at` belongs, inlined or not. `None` for a shared function that counts as its
/// caller's: libm, memory copies, 64-bit division.
fn part_at(symbols: &Loader, at: u32) -> Option<usize> {
    // From the innermost inlined function outwards.
    let mut frames = symbols.find_frames(u64::from(at)).ok()?;
    while let Ok(Some(frame)) = frames.next() {
        let file = frame.location.as_ref().and_then(|l| l.file).unwrap_or("");
        let function = frame.function.as_ref().and_then(|f| f.raw_name().ok());
        // Inlined functions are named without their path: `step<1>`.
        let name = function
            .as_deref()
            .and_then(|n| n.split('<').next())
            .unwrap_or("");
        // Not Rust's own library, which is also called core.
        if let Some((path, file)) = file.rsplit_once("core/src/")
            && !path.contains("library")
            && let Some(part) = part_of(file, name)
        {
            return Some(part);
        }
    }
    None
}

/// The part to which a function of core belongs; `None` for helpers and closures, which belong to their callers.
fn part_of(file: &str, function: &str) -> Option<usize> {
    let name = match file.split(['/', '.']).next()? {
        "estimate" => "estimator",
        "energy" => "energy errors",
        "force" | "predict" => "compensation",
        "newmark" => "integration",
        "signal" | "ground_motion" => "signal, ground motion",
        "supervise" => "interlocks, supervisor",
        "record" | "history" => "record, history",
        "outer_loop" => match function {
            "estimate" => "estimator",
            "may_send" | "trip_or_send" | "send" | "count_stale_steps" => "interlocks, supervisor",
            "record" => "record, history",
            "step"
            | "advance_command"
            | "solve"
            | "target_reached"
            | "command_without_integration" => "frame of the step",
            _ => return None,
        },
        _ => return None,
    };
    PARTS.iter().position(|&p| p == name)
}
