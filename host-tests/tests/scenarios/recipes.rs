//! The recipes of CONTRIBUTING apply to this tree and are as small as they say; `scripts/recipe` builds and runs them.

use outerloop_core::Prediction;
use std::path::{Path, PathBuf};
use std::process::Command;

fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Number of lines that a recipe adds, by file, and whether the file is new; nothing is removed.
fn added(recipe: &str) -> Vec<(String, usize, bool)> {
    let patch = std::fs::read_to_string(top().join("docs/recipes").join(recipe)).unwrap();
    let mut files: Vec<(String, usize, bool)> = Vec::new();
    let mut new = false;
    for line in patch.lines() {
        if let Some(from) = line.strip_prefix("--- ") {
            new = from == "/dev/null";
        } else if let Some(to) = line.strip_prefix("+++ b/") {
            files.push((to.to_owned(), 0, new));
        } else if line.starts_with('+') {
            files.last_mut().unwrap().1 += 1;
        } else {
            assert!(
                !line.starts_with('-') || files.is_empty(),
                "{recipe}: {line}"
            );
        }
    }
    files
}

#[test]
fn recipes_apply_to_this_tree() {
    for recipe in std::fs::read_dir(top().join("docs/recipes")).unwrap() {
        let recipe = recipe.unwrap().path();
        if recipe.is_dir() {
            continue; // A separate crate: nothing is patched.
        }
        let applied = Command::new("git")
            .args(["apply", "--check"])
            .arg(recipe.canonicalize().unwrap())
            .current_dir(top())
            .output();
        let Ok(applied) = applied else {
            test_data::not_run("there is no git");
            return;
        };
        let said = String::from_utf8_lossy(&applied.stderr);
        assert!(applied.status.success(), "{}: {said}", recipe.display());
    }
}

#[test]
fn a_method_is_one_file_and_one_line_with_its_comment_and_a_number_that_is_pinned() {
    let files = added("add-a-method.patch");
    let new: Vec<_> = files.iter().filter(|f| f.2).collect();
    assert_eq!(new.len(), 1, "{files:?}");
    let old: Vec<_> = files.iter().filter(|f| !f.2).collect();
    let old: Vec<_> = old.iter().map(|f| (f.0.as_str(), f.1)).collect();
    assert_eq!(
        old,
        [("core/src/method.rs", 2), ("link/tests/golden.txt", 1)]
    );
    // The next free number, so that no other method gets a new one.
    let free = Prediction::ALL.iter().map(|p| p.code()).max().unwrap() + 1;
    let text = std::fs::read_to_string(top().join("docs/recipes/add-a-method.patch")).unwrap();
    assert!(text.contains(&format!("\n+                {free} Toy ")));
    assert!(text.contains(&format!("\n+method toy: 00{free:02x}\n")));
}

#[test]
fn an_effect_is_a_row_a_behaviour_and_a_candidate() {
    let files = added("add-an-effect.patch");
    assert!(files.iter().all(|f| !f.2), "no new file: {files:?}");
    let lines: usize = files.iter().map(|f| f.1).sum();
    assert!(files.len() <= 6 && lines <= 30, "{files:?}");
}

#[test]
fn converters_are_one_folder_one_binary_and_its_line_in_the_list() {
    let files = added("add-converters.patch");
    let old: Vec<_> = files.iter().filter(|f| !f.2).collect();
    assert_eq!(old.len(), 1, "{files:?}");
    assert_eq!(old[0].0, "firmware/src/board/mod.rs");
    let folders = ["firmware/src/board/toy/", "firmware/src/bin/toy/"];
    let new = files.iter().filter(|f| f.2);
    for (file, ..) in new {
        assert!(folders.iter().any(|f| file.starts_with(f)), "{file}");
    }
}

/// Who writes a second chip finds every file of the first one in the section.
#[test]
fn the_section_on_a_chip_names_every_file_of_the_one_there_is() {
    let text = std::fs::read_to_string(top().join("CONTRIBUTING.md")).unwrap();
    let (_, section) = text.split_once("## Add a chip").unwrap();
    let (section, _) = section.split_once("\n## ").unwrap();
    let mut files = 0;
    for file in top().join("firmware/src/chip/f429").read_dir().unwrap() {
        let name = file.unwrap().file_name().into_string().unwrap();
        // `mod.rs` lists the others.
        let named = name == "mod.rs" || section.contains(&format!("`{name}`"));
        assert!(named, "{name}");
        files += 1;
    }
    assert!(files >= 10, "{files}");
}
