//! Checks the destinations of results before anything is read or runs: that they can be written, that none of them is
//! an input of the same command, and that no irreproducible record is replaced.
//!
//! A verb first declares what it will write. All file readers call [`refuse_output`], so that a file that is both input
//! and output is refused before a test begins, however its path is spelt.

use super::note::note;
use super::place::{Place, cannot, refuse_no_folder};
use crate::failure::Failure;
use std::fs;
use std::io::Error;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// Files that this process will write.
static OUTPUTS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// True if irreproducible records may be replaced.
static FORCED: AtomicBool = AtomicBool::new(false);

/// From now on irreproducible records may be replaced: `--force`.
pub fn set_force() {
    FORCED.store(true, Ordering::Relaxed);
}

/// True if irreproducible records may be replaced.
pub fn is_forced() -> bool {
    FORCED.load(Ordering::Relaxed)
}

/// The folder in which `names` will be written: `wanted`, or `wanted-2` and so on if it contains the record of a test
/// on a board, emulated or not, or of one that was stopped by hand; the change is reported.
///
/// # Errors
/// Not a folder, or one in which no file can be created. Nothing is left there.
pub fn folder<N: AsRef<str>>(
    wanted: Option<&Path>,
    names: &[N],
) -> Result<Option<PathBuf>, Failure> {
    let Some(wanted) = wanted else {
        return Ok(None);
    };
    refuse_no_folder(wanted)?;
    let free = free_folder(wanted, 1);
    make_and_drop_file(&free).map_err(|e| cannot(&free, &e))?;
    for name in names {
        will_write(&free.join(name.as_ref()))?;
    }
    Ok(Some(free))
}

/// The folder after `last`, which came from [`folder`] for `wanted`.
pub fn folder_behind(wanted: &Path, last: &Path) -> PathBuf {
    let before = (1..).take_while(|n| numbered(wanted, *n) != last).count();
    free_folder(wanted, before + 2)
}

/// The first of DIR-`number`, DIR-`number + 1` and so on whose record may be replaced, where DIR-1 is DIR itself.
fn free_folder(wanted: &Path, mut number: usize) -> PathBuf {
    loop {
        let candidate = numbered(wanted, number);
        let Some(why) = irreplaceable(&candidate).filter(|_| !is_forced()) else {
            return candidate;
        };
        number += 1;
        note(format_args!(
            "{} holds {why}, which cannot be made again and is kept: what comes now is in {}; --force replaces it",
            candidate.display(),
            numbered(wanted, number).display()
        ));
    }
}

fn numbered(wanted: &Path, number: usize) -> PathBuf {
    if number == 1 {
        return wanted.to_owned();
    }
    // `out/` and `out` are the same folder: the number is appended to its name.
    let plain: PathBuf = wanted.components().collect();
    let mut name = plain.into_os_string();
    name.push(format!("-{number}"));
    name.into()
}

/// The irreproducible contents of a folder, according to its summary.json.
fn irreplaceable(folder: &Path) -> Option<&'static str> {
    let text = fs::read_to_string(folder.join("summary.json")).ok()?;
    let summary: serde_json::Value = serde_json::from_str(&text).ok()?;
    if summary["verdict"] == "stopped" {
        return Some("the record of a test that was stopped by hand");
    }
    let of_board = summary["board"].is_object() || summary["place"] == "board";
    (of_board || summary["place"] == "emulated").then_some("the record of a test on a board")
}

/// Checks that a file can be written, and that it is not an input.
///
/// # Errors
/// As for [`folder`], and a path that is a folder.
pub fn file(file: Option<&Path>) -> Result<(), Failure> {
    let Some(path) = file else {
        return Ok(());
    };
    match Place::of(path).map_err(|e| cannot(path, &e))? {
        Place::Stream => Ok(()),
        Place::File(real) => {
            let folder = real.parent().unwrap_or(Path::new(""));
            make_and_drop_file(folder).map_err(|e| cannot(path, &e))?;
            will_write(path)
        }
    }
}

/// The same, but without `--force` only a file of this kind is replaced: any other may be a measurement. `own` says
/// whether a text is a `kind`.
///
/// # Errors
/// As for [`file`], and an existing file that is not a `kind`.
pub fn file_of_kind(
    wanted: Option<&Path>,
    kind: &str,
    own: impl Fn(&str) -> bool,
) -> Result<(), Failure> {
    file(wanted)?;
    let there = wanted.filter(|path| path.is_file() && !is_forced());
    let Some(path) = there else {
        return Ok(());
    };
    let found = fs::read(path).map_err(|e| cannot(path, &e))?;
    let replaceable = std::str::from_utf8(&found).is_ok_and(|text| text.is_empty() || own(text));
    if replaceable {
        return Ok(());
    }
    Err(Failure::input(format!(
        "{}: is there already and is no {kind}: accepted is the name of a new file, or --force",
        path.display()
    )))
}

/// The same for a record of a rig, which is not replaced without `--force`.
///
/// # Errors
/// As for [`file`], and an existing file.
pub fn new_record(path: &Path) -> Result<(), Failure> {
    file(Some(path))?;
    if path.is_file() && !is_forced() {
        return Err(Failure::input(format!(
            "{}: is there already, and a record of a rig cannot be made again: accepted is the name of a new file, or --force",
            path.display()
        )));
    }
    Ok(())
}

/// Creates a file in `folder`, or in its first existing parent, and deletes it.
fn make_and_drop_file(folder: &Path) -> Result<(), Error> {
    let mut above = folder.ancestors().filter(|f| !f.as_os_str().is_empty());
    let there = above.find(|f| f.exists()).unwrap_or(Path::new("."));
    tempfile::Builder::new().tempfile_in(there).map(drop)
}

fn will_write(path: &Path) -> Result<(), Failure> {
    let whole = std::path::absolute(path).map_err(|e| cannot(path, &e))?;
    let mut outputs = OUTPUTS.lock().unwrap_or_else(PoisonError::into_inner);
    let same = |other: &PathBuf| {
        in_its_folder(other) == in_its_folder(&whole) || is_one_file(other, &whole)
    };
    if outputs.iter().any(same) {
        return Err(Failure::input(format!(
            "{}: two results of this command would go there: accepted is a place of its own for each",
            path.display()
        )));
    }
    outputs.push(whole);
    Ok(())
}

/// A path with its folder resolved, if that exists.
fn in_its_folder(path: &Path) -> PathBuf {
    let folder = path.parent().and_then(|folder| folder.canonicalize().ok());
    match (folder, path.file_name()) {
        (Some(folder), Some(name)) => folder.join(name),
        _ => path.to_owned(),
    }
}

/// Checks that `input`, which is about to be read, will not be written by this command.
///
/// # Errors
/// The same file under both names.
pub fn refuse_output(input: &Path) -> Result<(), Failure> {
    let outputs = OUTPUTS.lock().unwrap_or_else(PoisonError::into_inner);
    match outputs.iter().find(|output| is_one_file(output, input)) {
        None => Ok(()),
        Some(output) => Err(Failure::input(format!(
            "{}: is read by this command and would be replaced by what it writes to {}: accepted is another place for the output",
            input.display(),
            output.display()
        ))),
    }
}

/// True if two paths lead to the same regular file.
fn is_one_file(a: &Path, b: &Path) -> bool {
    let (Ok(of_a), Ok(of_b)) = (fs::metadata(a), fs::metadata(b)) else {
        return false;
    };
    if !of_a.is_file() || !of_b.is_file() {
        return false;
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        // Hard links, too.
        (of_a.dev(), of_a.ino()) == (of_b.dev(), of_b.ino())
    }
    #[cfg(not(unix))]
    {
        matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    const NONE: [&str; 0] = [];

    fn said<T>(failed: Result<T, Failure>) -> String {
        failed.err().unwrap().to_string()
    }

    #[test]
    fn what_cannot_be_written_is_known_before() {
        let home = tempfile::tempdir().unwrap();
        let at = |name: &str| home.path().join(name);
        fs::write(at("file"), "").unwrap();
        for good in [home.path().to_owned(), at("new/deeper")] {
            assert_eq!(folder(Some(&good), &NONE).unwrap().unwrap(), good);
            file(Some(&good.join("a.csv"))).unwrap();
        }
        file(Some(Path::new("/dev/null"))).unwrap();
        file(Some(Path::new("/dev/null"))).unwrap();
        assert_eq!(
            fs::read_dir(home.path()).unwrap().count(),
            1,
            "nothing is left"
        );
        // Nobody can create a file there, whoever runs this.
        for bad in ["/proc", "/proc/new/deeper"] {
            let e = said(folder(Some(Path::new(bad)), &NONE));
            assert!(e.starts_with(&format!("{bad}: cannot be written: ")), "{e}");
        }
        let e = said(file(Some(Path::new("/proc/new.csv"))));
        assert!(e.starts_with("/proc/new.csv: cannot be written"), "{e}");
        assert!(said(folder(Some(&at("file")), &NONE)).contains("is no folder"));
        assert!(said(file(Some(home.path()))).contains("it is a folder"));
        assert!(said(new_record(&at("file"))).contains("is there already"));
        new_record(&at("new.csv")).unwrap();
    }

    #[test]
    fn two_results_do_not_go_to_one_place() {
        let home = tempfile::tempdir().unwrap();
        let at = |name: &str| home.path().join(name);
        fs::create_dir(at("deep")).unwrap();
        file(Some(&at("result"))).unwrap();
        for same in ["result", "deep/../result", "./result"] {
            let e = said(file(Some(&at(same))));
            assert!(e.contains("two results of this command"), "{e}");
        }
        let e = said(folder(Some(home.path()), &["other", "result"]));
        assert!(e.contains("two results of this command"), "{e}");
    }

    #[test]
    fn an_input_is_no_output_however_its_path_is_spelt() {
        let home = tempfile::tempdir().unwrap();
        let at = |name: &str| home.path().join(name);
        for name in ["record.csv", "other.csv"] {
            fs::write(at(name), "").unwrap();
        }
        fs::create_dir(at("deep")).unwrap();
        std::os::unix::fs::symlink(at("record.csv"), at("link.csv")).unwrap();
        fs::hard_link(at("record.csv"), at("hard.csv")).unwrap();
        folder(Some(&at("deep/..")), &["record.csv"]).unwrap();
        for same in ["record.csv", "deep/../record.csv", "link.csv", "hard.csv"] {
            let e = said(refuse_output(&at(same)));
            assert!(e.contains("would be replaced by what it writes to"), "{e}");
        }
        refuse_output(&at("other.csv")).unwrap();
    }

    #[test]
    fn a_record_that_cannot_be_made_again_keeps_its_folder() {
        let home = tempfile::tempdir().unwrap();
        let at = |name: &str| home.path().join(name);
        for (name, summary) in [
            ("a", r#"{"verdict": "completed", "board": {}}"#),
            ("a-2", r#"{"verdict": "stopped"}"#),
            ("a-3", r#"{"verdict": "completed", "place": "emulated"}"#),
            (
                "b",
                r#"{"verdict": "completed", "board": null, "place": "simulated"}"#,
            ),
        ] {
            fs::create_dir(at(name)).unwrap();
            fs::write(at(name).join("summary.json"), summary).unwrap();
        }
        let free = |name: &str| folder(Some(&at(name)), &NONE).unwrap().unwrap();
        assert_eq!(free("a"), at("a-4"));
        assert_eq!(free("a/"), at("a-4"));
        assert_eq!(free("b"), at("b"));
        assert_eq!(folder_behind(&at("b"), &at("b")), at("b-2"));
        assert_eq!(folder_behind(&at("a"), &at("a")), at("a-4"));
    }
}
