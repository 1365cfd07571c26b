//! Where the cycles of a step go: by function and by line of the source, from the image's own line tables.

use super::cycles::Course;
use addr2line::Loader;
use std::collections::BTreeMap;
use std::io::{Error, Result};
use std::path::Path;

/// Cost of a place in the source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Share {
    /// Instructions.
    pub instructions: u64,
    /// Cycles, including those in which the core waited for the flash.
    pub cycles: u64,
    /// Those in which it waited.
    pub waited: u64,
}

/// Resolution of the places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grain {
    /// Functions, including inlined ones.
    Function,
    /// Lines.
    Line,
}

/// The places of a step in the source, the most expensive first.
///
/// # Errors
/// The image cannot be read.
pub fn places(image: &Path, course: &Course, grain: Grain) -> Result<Vec<(String, Share)>> {
    let symbols = Loader::new(image).map_err(|e| Error::other(e.to_string()))?;
    let mut shares = BTreeMap::<String, Share>::new();
    for spent in &course.spent {
        let share = shares.entry(place(&symbols, spent.at, grain)).or_default();
        share.instructions += 1;
        share.cycles += u64::from(spent.cycles);
        share.waited += u64::from(spent.waited);
    }
    let mut shares: Vec<_> = shares.into_iter().collect();
    shares.sort_by_key(|(_, share)| std::cmp::Reverse(share.cycles));
    Ok(shares)
}

/// The innermost function of core from which the instruction at `at` comes, or the function that contains it.
fn place(symbols: &Loader, at: u32, grain: Grain) -> String {
    let at = u64::from(at);
    if let Ok(mut frames) = symbols.find_frames(at) {
        while let Ok(Some(frame)) = frames.next() {
            let Some(location) = &frame.location else {
                continue;
            };
            let file = location.file.unwrap_or_default();
            // Rust's own library is also called core.
            let Some((path, file)) = file.rsplit_once("core/src/") else {
                continue;
            };
            if path.contains("library") {
                continue;
            }
            return match grain {
                Grain::Line => format!("{file}:{}", location.line.unwrap_or(0)),
                Grain::Function => {
                    let name = frame.function.as_ref().and_then(|f| f.demangle().ok());
                    format!("{file} {}", name.as_deref().unwrap_or("?"))
                }
            };
        }
    }
    symbols.find_symbol(at).unwrap_or("?").to_owned()
}
