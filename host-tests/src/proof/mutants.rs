//! Changes of the code that a test must detect: `host-tests/mutants.toml`, and for the images, `emu/mutants.toml`.
//! `scripts/mutants` makes them, one after the other, and runs the test that each names.

use super::claims::{Claim, Place};
use super::ids::{Id, Kind};
use outerloop_core::Mode;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::Path;

/// One wrong line.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mutant {
    /// Its description.
    pub name: String,
    /// What the test proves by failing; an id with an asterisk at its end means all that begin so.
    pub ids: Vec<String>,
    /// Number of ways in which it is wrong, one after the other; the test fails in each. 0 if there is only one.
    #[serde(default)]
    pub ways: usize,
    /// The file, from the top of the repository.
    pub file: String,
    /// Text that occurs in it exactly once.
    pub find: String,
    /// Its replacement.
    pub replace: String,
    /// The crate of the test.
    pub package: String,
    /// The file of tests, or `lib`.
    pub target: String,
    /// The test, with its modules.
    pub test: String,
}

/// An image that lacks one safeguard, `emu/mutants.toml`, and the scenario of the emulated rig that fails on it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WithoutMend {
    /// What the safeguard is for, a section of `docs/firmware-safeguards.md`.
    pub subject: String,
    /// What is missing.
    pub name: String,
    /// The image that is built without it.
    pub image: String,
    /// The file of tests.
    pub target: String,
    /// The test, with its module.
    pub test: String,
    /// The edits that remove the safeguard.
    pub edits: Vec<Edit>,
}

/// A text in a file, and its replacement.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Edit {
    /// The file, from the top of the repository.
    pub file: String,
    /// Text that occurs in it exactly once.
    pub find: String,
    /// Its replacement.
    pub replace: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct List<T> {
    mutant: Vec<T>,
}

fn read<T: DeserializeOwned>(top: &Path, file: &str) -> Result<Vec<T>, String> {
    let path = top.join(file);
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let list: List<T> = toml::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(list.mutant)
}

/// The list of wrong lines, with the full names of all their `ids`.
///
/// # Errors
/// Why it cannot be read, a sentence.
pub fn all(top: &Path, ids: &[Id]) -> Result<Vec<Mutant>, String> {
    let mut mutants: Vec<Mutant> = read(top, "host-tests/mutants.toml")?;
    for mutant in &mut mutants {
        let (mut named, mut pairs) = (Vec::new(), 0);
        for listed in &mutant.ids {
            let meant = ids.iter().filter(|id| id.is_meant_by(listed));
            let before = named.len();
            for id in meant {
                named.push(id.name.clone());
                pairs += usize::from(id.kind == Kind::Mode);
            }
            if named.len() == before {
                return Err(format!("{}: {listed} is no id of the code", mutant.name));
            }
        }
        // For a pair, each outcome except the right one.
        let ways = pairs * Mode::ALL.len();
        if mutant.ways != ways {
            return Err(format!(
                "{}: {ways} ways and not {}",
                mutant.name, mutant.ways
            ));
        }
        mutant.ids = named;
    }
    Ok(mutants)
}

/// The list of images that lack a safeguard.
///
/// # Errors
/// Why it cannot be read, a sentence.
pub fn without_mends(top: &Path) -> Result<Vec<WithoutMend>, String> {
    read(top, "emu/mutants.toml")
}

/// Those that no longer fit the code or the scenarios, a sentence each.
pub fn misfits_of_images(top: &Path, mutants: &[WithoutMend]) -> Vec<String> {
    let read = |file: String| std::fs::read_to_string(top.join(file)).unwrap_or_default();
    let mut wrong = Vec::new();
    for mutant in mutants {
        let WithoutMend {
            name, target, test, ..
        } = mutant;
        for edit in &mutant.edits {
            let times = read(edit.file.clone()).matches(&edit.find).count();
            if times != 1 {
                let file = &edit.file;
                wrong.push(format!(
                    "{name}: what is to be changed stands {times} times in {file}"
                ));
            }
        }
        let (module, last) = test.split_once("::").unwrap_or(("main", test));
        // On the emulated rig, or of the disassembly.
        let found = ["emu", "host-tests"].iter().any(|owner| {
            let scenario = read(format!("{owner}/tests/{target}/{module}.rs"));
            scenario.contains(&format!("#[test]\nfn {last}()"))
        });
        if !found {
            wrong.push(format!("{name}: no test {test} of {target}"));
        }
    }
    wrong
}

/// Mutants that no longer fit the code or the tests, a sentence each.
pub fn misfits(top: &Path, mutants: &[Mutant], claims: &[Claim]) -> Vec<String> {
    let mut wrong = Vec::new();
    for mutant in mutants {
        let Mutant { name, test, .. } = mutant;
        let text = std::fs::read_to_string(top.join(&mutant.file)).unwrap_or_default();
        let times = text.matches(&mutant.find).count();
        if times != 1 {
            let file = &mutant.file;
            wrong.push(format!(
                "{name}: what is to be changed stands {times} times in {file}"
            ));
        }
        let last = test.rsplit("::").next().unwrap_or(test);
        let folder = format!("{}/", mutant.package);
        let claim = claims
            .iter()
            .find(|c| c.test == last && c.file.starts_with(&folder) && c.place == Place::Host);
        for id in &mutant.ids {
            if !claim.is_some_and(|c| c.has(id)) {
                wrong.push(format!("{name}: no test {last} of {folder} claims {id}"));
            }
        }
    }
    wrong
}
