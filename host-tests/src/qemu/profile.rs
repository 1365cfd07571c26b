//! Where the instructions of a step go: every executed instruction, attributed by the image's own line tables.
//!
//! The step is inlined into one piece of code, so parts cannot be timed from outside. The emulator writes down each
//! instruction that it runs, and the debug information tells from which function of core it was inlined.

use addr2line::Loader;
use std::collections::HashMap;
use std::io::{BufRead, BufReader, Error, Read, Result};
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

/// What an instruction belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// Inlined into the step: this part of it.
    Step(usize),
    /// A function of its own, of a known part or of none: libm, memory copies, 64-bit division.
    Callee(Option<usize>),
    /// The firmware around the step.
    Around,
    /// The exchange with the PC, which ends a control period.
    Exchange,
}

/// Reads a trace to its end; one entry for each control period.
///
/// # Errors
/// The trace or the image cannot be read.
pub fn steps(trace: impl Read, image: &Path) -> Result<Vec<Counts>> {
    let symbols = Loader::new(image).map_err(|e| Error::other(e.to_string()))?;
    let mut places: HashMap<u64, Place> = HashMap::new();
    let mut steps = Vec::new();
    let mut counts = Counts::default();
    let mut part: Option<usize> = None;
    let mut line = String::new();
    let mut trace = BufReader::with_capacity(1 << 20, trace);
    loop {
        line.clear();
        if trace.read_line(&mut line)? == 0 {
            return Ok(steps);
        }
        // Trace 0: 0x7f.. [cs/pc/flags/cflags] symbol
        let Some(pc) = line.strip_prefix("Trace").and_then(|t| t.split('/').nth(1)) else {
            continue;
        };
        let pc = u64::from_str_radix(pc, 16).map_err(Error::other)?;
        let place = *places.entry(pc).or_insert_with(|| place(&symbols, pc));
        part = match place {
            Place::Step(part) => Some(part),
            // Called from the step it belongs to it, called from elsewhere it does not.
            Place::Callee(own) => part.map(|caller| own.unwrap_or(caller)),
            Place::Around | Place::Exchange => None,
        };
        if let Some(part) = part {
            counts[part] += 1;
        }
        if place == Place::Exchange && counts != Counts::default() {
            steps.push(std::mem::take(&mut counts));
        }
    }
}

fn place(symbols: &Loader, pc: u64) -> Place {
    let Ok(mut frames) = symbols.find_frames(pc) else {
        return Place::Callee(None);
    };
    // From the innermost inlined function outwards.
    let (mut part, mut in_step, mut around) = (None, false, None);
    while let Ok(Some(frame)) = frames.next() {
        let file = frame.location.as_ref().and_then(|l| l.file).unwrap_or("");
        let function = frame.function.as_ref().and_then(|f| f.raw_name().ok());
        // Inlined functions are named without their path: `step<1>`.
        let name = function
            .as_deref()
            .and_then(|n| n.split('<').next())
            .unwrap_or("");
        if file.contains("firmware/src/") {
            let exchange = file.ends_with("semihosting.rs");
            around = around.or(Some(if exchange {
                Place::Exchange
            } else {
                Place::Around
            }));
        }
        // Not Rust's own library, which is called core, too.
        if let Some((path, file)) = file.rsplit_once("core/src/")
            && !path.contains("library")
        {
            part = part.or_else(|| part_of(file, name));
            in_step |= file == "outer_loop/step.rs" && name == "step";
        }
    }
    match (part, in_step, around) {
        (Some(part), true, _) => Place::Step(part),
        (_, _, Some(around)) => around,
        _ => Place::Callee(part),
    }
}

/// The part that a function of core belongs to; none for helpers and closures, which belong to their callers.
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
