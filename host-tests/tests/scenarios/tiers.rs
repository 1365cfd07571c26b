//! Every file of tests is in CONTRIBUTING's table of tiers, in the row of its tier, and the tiers' lists name existing files.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Names of the files of tests of all crates.
fn files_of_tests() -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for crates in top().read_dir().unwrap() {
        let Ok(tests) = crates.unwrap().path().join("tests").read_dir() else {
            continue;
        };
        for entry in tests {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|e| e == "rs") || path.join("main.rs").is_file() {
                names.insert(path.file_stem().unwrap().to_string_lossy().into_owned());
            }
        }
    }
    names
}

/// Files of which some tests run in another tier than the rest.
const IN_PARTS: [&str; 10] = [
    "field",
    "improve",
    "qemu",
    "records",
    "rig",
    "rig16",
    "rig3",
    "scenarios",
    "verbs",
    "watch",
];

#[test]
fn every_file_of_tests_stands_in_the_table_of_tiers() {
    let text = std::fs::read_to_string(top().join("CONTRIBUTING.md")).unwrap();
    let (_, table) = text.split_once("## Which tests hold what").unwrap();
    let (table, _) = table.split_once("\n## ").unwrap();
    let tiers = std::fs::read_to_string(top().join("scripts/tiers")).unwrap();
    let list = |head: &str| -> BTreeSet<&str> {
        let (_, list) = tiers.split_once(&format!("\n{head}=(")).unwrap();
        list.split_once(')').unwrap().0.split_whitespace().collect()
    };
    let [everyday, clocked, nightly] = ["everyday", "everyday_clocked", "nightly"].map(list);
    // Tier and files of each row.
    let rows: Vec<(&str, &str)> = table
        .lines()
        .filter_map(|line| line.strip_prefix("| "))
        .filter_map(|row| row.split_once(" | "))
        .map(|(tier, rest)| (tier.trim_matches('`'), rest.split(" | ").next().unwrap()))
        .collect();
    for name in files_of_tests() {
        let is_in = |list: &BTreeSet<&str>| list.contains(name.as_str());
        let tier = match name.as_str() {
            // It is flashed and run on a board by hand.
            "on_target" => continue,
            "verbs" => "everyday",
            _ if is_in(&everyday) || is_in(&clocked) => "everyday",
            _ if is_in(&nightly) => "nightly",
            _ => "--all",
        };
        let named = format!("`{name}`");
        let found = rows.iter().filter(|(_, files)| files.contains(&named));
        let found: BTreeSet<&str> = found.map(|(tier, _)| *tier).collect();
        assert!(found.contains(tier), "{name} is in no row of {tier}");
        let in_parts = IN_PARTS.contains(&name.as_str());
        assert!(in_parts || found.len() == 1, "{name}: {found:?}");
    }
}

#[test]
fn the_lists_of_the_tiers_name_files_of_tests() {
    let text = std::fs::read_to_string(top().join("scripts/tiers")).unwrap();
    let there = files_of_tests();
    let mut lists = 0;
    for line in text.lines() {
        let list = line.split_once("=(").and_then(|(_, l)| l.strip_suffix(')'));
        // The other lists are names within a file, or not at the top level of the script.
        let Some(list) = list.filter(|l| !l.contains("::") && !line.starts_with(' ')) else {
            continue;
        };
        lists += 1;
        for name in list.split_whitespace() {
            assert!(there.contains(name), "{name}: {line}");
        }
    }
    assert!(lists >= 5, "{lists}");
}

/// A name without a test would skip nothing, and run nothing at night.
#[test]
fn what_the_tiers_take_out_of_a_file_is_there() {
    let text = std::fs::read_to_string(top().join("scripts/tiers")).unwrap();
    let lists = [
        "everyday_others=(",
        "everyday_verbs=(",
        "nightly_tests=(",
        "nightly_emulated=(",
        "rig16_repeated=(",
    ];
    let modules = [
        "cli/tests/verbs",
        "host-tests/tests/records",
        "host-tests/tests/scenarios",
        "emu/tests/rig",
        "emu/tests/rig16",
        "emu/tests/rig3",
    ];
    let files = [
        "emu/tests/improve.rs",
        "emu/tests/watch.rs",
        "exam/tests/field.rs",
        "cli/tests/verbs/diagnose/beside.rs",
    ];
    let of_list = |head| {
        let (_, list) = text.split_once(&format!("\n{head}")).unwrap();
        let words = list.split_once(')').unwrap().0.split_whitespace();
        // Parts of names of tests are not looked for.
        words.filter(|w| !["--skip", "benchmark_", "h5py"].contains(w))
    };
    let mut names = 0;
    for name in lists.into_iter().flat_map(of_list) {
        let (paths, test): (Vec<_>, _) = match name.split_once("::") {
            Some((module, test)) => {
                let file = |folder| top().join(folder).join(module).with_extension("rs");
                (modules.map(file).to_vec(), test)
            }
            None => (files.map(|file| top().join(file)).to_vec(), name),
        };
        let there = paths.iter().any(|path| {
            let text = std::fs::read_to_string(path);
            text.is_ok_and(|t| t.contains(&format!("\nfn {test}")))
        });
        assert!(there, "{name}");
        names += 1;
    }
    assert!(names >= 25, "{names}");
}
