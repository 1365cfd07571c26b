//! What the tests of this repository claim to prove: the lines `// proves:` above them.
//!
//! A line is a list of ids; `by` names what the test makes fail for these, as written in the code. An id with an asterisk at
//! its end means all that begin so, for tests that iterate over the code's own list. What is named must appear in the test,
//! or in what it uses of its file.

use super::ids::Id;
use std::path::{Path, PathBuf};

/// Where a test runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// On this machine.
    Host,
    /// `core` and `link` as the image for QEMU.
    Qemu,
    /// The flashed image on the emulated board.
    Image,
}

impl Place {
    /// Every place.
    pub const ALL: [Self; 3] = [Self::Host, Self::Qemu, Self::Image];

    /// The letter before a test's number.
    pub const fn letter(self) -> char {
        match self {
            Self::Host => 'H',
            Self::Qemu => 'Q',
            Self::Image => 'I',
        }
    }

    fn of(file: &str) -> Self {
        if file.starts_with("emu/tests/") {
            Self::Image
        } else if file.starts_with("host-tests/tests/qemu/") {
            Self::Qemu
        } else {
            Self::Host
        }
    }
}

/// A test that claims something.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Claim {
    /// Its file, from the top of the repository.
    pub file: String,
    /// Its name.
    pub test: String,
    /// Where it runs.
    pub place: Place,
    /// It runs only in `scripts/nightly`.
    pub nightly: bool,
    /// The ids, each with what is made to fail to prove it.
    pub ids: Vec<(String, Vec<String>)>,
}

impl Claim {
    /// Whether it claims this.
    pub fn has(&self, id: &str) -> bool {
        self.ids.iter().any(|(claimed, _)| claimed == id)
    }
}

/// Start of the line.
const MARK: &str = "// proves: ";

/// The claims of all tests below `top`, by file and position in it.
///
/// # Errors
/// False claims, a sentence each.
pub fn all(top: &Path, ids: &[Id]) -> Result<Vec<Claim>, Vec<String>> {
    let (mut claims, mut wrong) = (Vec::new(), Vec::new());
    for path in rust_files(top) {
        let Ok(text) = std::fs::read_to_string(&path) else {
            continue;
        };
        let file = path.strip_prefix(top).unwrap_or(&path);
        let file = file.to_string_lossy().replace('\\', "/");
        // The examples in this module are not claims.
        if !file.starts_with("host-tests/src/proof/") {
            of_a_file(&file, &text, ids, &mut claims, &mut wrong);
        }
    }
    let skipped =
        skipped_in_a_push(&std::fs::read_to_string(top.join("scripts/tiers")).unwrap_or_default());
    for claim in claims.iter_mut().filter(|c| c.place == Place::Image) {
        let module = Path::new(&claim.file).file_stem().unwrap_or_default();
        let path = format!("{}::{}", module.to_string_lossy(), claim.test);
        claim.nightly |= skipped.iter().any(|name| path.contains(name));
    }
    if wrong.is_empty() {
        Ok(claims)
    } else {
        Err(wrong)
    }
}

/// Parts of the names of the tests on the emulated board that run only nightly, from `scripts/tiers`.
fn skipped_in_a_push(tiers: &str) -> Vec<String> {
    let list = tiers.split_once("\nnightly_emulated=(");
    let list = list.and_then(|(_, rest)| rest.split_once(')'));
    let names = list.map_or("", |(names, _)| names).split_whitespace();
    names.map(str::to_owned).collect()
}

fn of_a_file(file: &str, text: &str, ids: &[Id], claims: &mut Vec<Claim>, wrong: &mut Vec<String>) {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let items = items(text);
    for (at, line) in lines.iter().enumerate() {
        let Some(said) = line.strip_prefix(MARK) else {
            continue;
        };
        let mut fail = |what: String| wrong.push(format!("{file}:{}: {what}", at + 1));
        let below = lines[at + 1..].iter();
        let head: Vec<&&str> = below
            .take_while(|l| l.starts_with("#[") || l.starts_with("//"))
            .collect();
        let name = lines.get(at + 1 + head.len());
        let name = name.and_then(|l| l.strip_prefix("fn ")?.split('(').next());
        let (Some(name), true) = (name, head.iter().any(|l| **l == "#[test]")) else {
            fail("no test stands below what is claimed".into());
            continue;
        };
        let code = used_by(name, &items);
        let (said, by) = said.split_once(" by ").unwrap_or((said, ""));
        let by: Vec<String> = list(by).map(str::to_owned).collect();
        for named in by.iter().filter(|b| !code.contains(b.as_str())) {
            fail(format!("there is no {named} in this test"));
        }
        let mut claimed = Vec::new();
        for id in list(said) {
            match expand(id, &code, ids) {
                Ok(expanded) => claimed.extend(expanded.into_iter().map(|id| (id, by.clone()))),
                Err(what) => fail(what),
            }
        }
        let nightly = head.iter().any(|l| l.starts_with("#[ignore"));
        match claims.last_mut() {
            // Its claim takes several lines.
            Some(last) if last.file == file && last.test == name => {
                last.ids.extend(claimed);
            }
            _ => claims.push(Claim {
                file: file.to_owned(),
                test: name.to_owned(),
                place: Place::of(file),
                nightly,
                ids: claimed,
            }),
        }
    }
}

/// Functions and constants of a file by their names, as rustfmt formats them: up to the first line of the same indent that
/// ends in a brace or a semicolon.
fn items(text: &str) -> Vec<(&str, String)> {
    let lines: Vec<&str> = text.lines().collect();
    let mut items = Vec::new();
    for (at, line) in lines.iter().enumerate() {
        let bare = line.trim_start();
        let indent = &line[..line.len() - bare.len()];
        let mut rest = bare;
        for before in [
            "pub ",
            "pub(crate) ",
            "pub(super) ",
            "const fn ",
            "fn ",
            "const ",
            "static ",
        ] {
            rest = rest.strip_prefix(before).unwrap_or(rest);
        }
        let name = rest.split(|c: char| !is_of_a_name(c)).next();
        let (false, Some(name)) = (rest == bare || bare.starts_with("pub use"), name) else {
            continue;
        };
        let ends = |l: &&str| {
            let closes = l.strip_prefix(indent).is_some_and(|l| !l.starts_with(' '));
            closes && (l.ends_with('}') || l.ends_with(';'))
        };
        let last = lines[at..].iter().position(ends).unwrap_or(0);
        items.push((name, lines[at..=at + last].join("\n")));
    }
    items
}

/// A test with all items of its file that it names, directly or indirectly.
fn used_by(test: &str, items: &[(&str, String)]) -> String {
    let mut code = String::new();
    let mut names = vec![test];
    let mut at = 0;
    while let Some(&name) = names.get(at) {
        at += 1;
        for (_, text) in items.iter().filter(|(n, _)| *n == name) {
            code.push_str(text);
            code.push('\n');
            for word in text.split(|c| !is_of_a_name(c)) {
                if let Some((other, _)) = items.iter().find(|(n, _)| *n == word)
                    && !names.contains(other)
                {
                    names.push(other);
                }
            }
        }
    }
    code
}

fn is_of_a_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

fn list(text: &str) -> impl Iterator<Item = &str> {
    text.split(',').map(str::trim).filter(|w| !w.is_empty())
}

/// The ids that are meant; the test must contain their names in the code.
fn expand(claimed: &str, code: &str, ids: &[Id]) -> Result<Vec<String>, String> {
    let begin = claimed.strip_suffix('*');
    let meant: Vec<&Id> = ids.iter().filter(|id| id.is_meant_by(claimed)).collect();
    if meant.is_empty() {
        return Err(format!("{claimed} is no id of the code"));
    }
    if begin.is_some() && !code.contains("::ALL") {
        return Err(format!(
            "{claimed} is claimed, and no list ALL is gone over"
        ));
    }
    for id in &meant {
        let missing = id.words.iter().find(|w| !code.contains(w.as_str()));
        if let (Some(word), None) = (missing, begin) {
            return Err(format!("{claimed} is claimed, and {word} is not here"));
        }
    }
    Ok(meant.into_iter().map(|id| id.name.clone()).collect())
}

/// Sources and tests of the crates, sorted.
fn rust_files(top: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders: Vec<PathBuf> = entries(top)
        .into_iter()
        .filter(|path| path.join("Cargo.toml").is_file())
        .flat_map(|path| [path.join("src"), path.join("tests")])
        .collect();
    while let Some(folder) = folders.pop() {
        for path in entries(&folder) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

/// The readable entries of a folder; none if it does not exist.
fn entries(folder: &Path) -> Vec<PathBuf> {
    let read = folder.read_dir().into_iter().flatten();
    read.filter_map(|entry| Some(entry.ok()?.path())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::proof::ids;

    fn read(text: &str) -> (Vec<Claim>, Vec<String>) {
        let (mut claims, mut wrong) = (Vec::new(), Vec::new());
        let file = "emu/tests/rig/x.rs";
        of_a_file(file, text, &ids::all(), &mut claims, &mut wrong);
        (claims, wrong)
    }

    #[test]
    fn a_claim_is_of_the_test_below_it() {
        let text = "// proves: fault.force, limit.force_n by Burst\n#[test]\n#[ignore = \"long\"]\nfn one() {\n    \
            Fault::Force; limits.force_n; Burst\n}";
        let (claims, wrong) = read(text);
        assert_eq!(wrong, [""; 0]);
        assert_eq!(claims.len(), 1);
        assert_eq!((claims[0].place, claims[0].nightly), (Place::Image, true));
        let ids: Vec<&str> = claims[0].ids.iter().map(|(id, _)| id.as_str()).collect();
        assert_eq!(ids, ["fault.force", "limit.force_n"]);
        assert!(claims[0].ids.iter().all(|(_, by)| by[..] == ["Burst"]));
        assert_eq!(claims[0].test, "one");
    }

    #[test]
    fn what_a_push_leaves_out_is_read_off_the_tiers() {
        let tiers = "a=(b)\nnightly_emulated=(modes::every one\n    two)\nc=(d)";
        assert_eq!(skipped_in_a_push(tiers), ["modes::every", "one", "two"]);
        let here = std::fs::read_to_string(super::super::top().join("scripts/tiers")).unwrap();
        assert!(skipped_in_a_push(&here).len() > 5);
    }

    #[test]
    fn what_a_test_makes_to_fail_is_of_the_line_that_names_it() {
        let text = "// proves: fault.force by Burst\n// proves: limit.force_n\n#[test]\nfn one() {\n    helper();\n}\n\n\
            fn helper() {\n    Fault::Force; limits.force_n; Burst\n}";
        let (claims, wrong) = read(text);
        assert_eq!(wrong, [""; 0]);
        let by = |at: usize| claims[0].ids[at].1.len();
        assert_eq!((claims.len(), by(0), by(1)), (1, 1, 0));
    }

    #[test]
    fn a_claim_that_says_what_is_not_so_is_refused() {
        for (text, said) in [
            ("// proves: fault.force\nfn helper() {}", "no test"),
            (
                "// proves: fault.wind\n#[test]\nfn one() {}",
                "no id of the code",
            ),
            (
                "// proves: fault.force\n#[test]\nfn one() {}",
                "Fault::Force is not here",
            ),
            ("// proves: fault.*\n#[test]\nfn one() {}", "no list ALL"),
            (
                "// proves: fault.force by Burst\n#[test]\nfn one() { Fault::Force; }",
                "no Burst in this test",
            ),
            (
                "// proves: fault.force\n#[test]\nfn one() {}\n\n#[test]\nfn two() { Fault::Force; }",
                "Fault::Force is not here",
            ),
        ] {
            let (_, wrong) = read(text);
            assert!(wrong.iter().any(|w| w.contains(said)), "{text}: {wrong:?}");
        }
    }
}
