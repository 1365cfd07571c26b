//! Changes of the code that a test has to see: `host-tests/mutants.toml`. `scripts/mutants` makes them, one after the other,
//! and runs the test that each names.

use super::claims::{Claim, Place};
use serde::Deserialize;
use std::path::Path;

/// One wrong line.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mutant {
    /// What it is, in some words.
    pub name: String,
    /// What the test proves by failing.
    pub ids: Vec<String>,
    /// The file, from the top of the repository.
    pub file: String,
    /// What stands in it, once.
    pub find: String,
    /// What stands there instead.
    pub replace: String,
    /// The crate of the test.
    pub package: String,
    /// The file of tests, or `lib`.
    pub target: String,
    /// The test, with its modules.
    pub test: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    mutant: Vec<Mutant>,
}

/// The list.
///
/// # Errors
/// Why it cannot be read, a sentence.
pub fn all(top: &Path) -> Result<Vec<Mutant>, String> {
    let path = top.join("host-tests/mutants.toml");
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let list: List = toml::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(list.mutant)
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
            if !claim.is_some_and(|c| c.ids.contains(id)) {
                wrong.push(format!("{name}: no test {last} of {folder} claims {id}"));
            }
        }
    }
    wrong
}
