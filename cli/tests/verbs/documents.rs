//! The documents' commands: each of the README runs on a fresh clone without any data, or says in one sentence what is
//! missing and where to get it; every verb and option on a page exists.

use crate::common::root;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::Duration;

/// The fenced blocks of a page in a language, each as lines.
pub fn blocks<'a>(page: &'a str, language: &str) -> Vec<Vec<&'a str>> {
    let mut found = Vec::new();
    let mut open: Option<(bool, Vec<&str>)> = None;
    for line in page.lines() {
        match (&mut open, line.strip_prefix("```")) {
            (None, Some(name)) => open = Some((name == language, Vec::new())),
            (Some(_), Some(_)) => found.extend(open.take().filter(|b| b.0).map(|b| b.1)),
            (Some((_, lines)), None) => lines.push(line),
            (None, None) => {}
        }
    }
    found
}

/// The lines of a page indented by four spaces, outside its fenced blocks, as one block.
fn set_in(page: &str) -> Vec<&str> {
    let outside = page.split("```").step_by(2);
    outside
        .flat_map(str::lines)
        .filter_map(|line| line.strip_prefix("    "))
        .collect()
}

/// The commands in a page's shell blocks, one per line; continued lines are joined, comments removed.
fn commands(page: &str) -> Vec<String> {
    let plain = ["sh", ""]
        .iter()
        .flat_map(|language| blocks(page, language))
        .chain([set_in(page)])
        .map(|block| (block, ""));
    let console = blocks(page, "console")
        .into_iter()
        .map(|block| (block, "$ "));
    let mut all = Vec::new();
    for (block, prompt) in plain.chain(console) {
        let joined = block.join("\n").replace("\\\n", " ");
        let lines = joined.lines().filter_map(|line| line.strip_prefix(prompt));
        let lines =
            lines.map(|line| without_comment(line).replace("cargo outerloop ", "outerloop "));
        all.extend(lines.filter(|line| !line.is_empty()));
    }
    all
}

/// A comment follows a space or a tab, or begins the line.
fn without_comment(line: &str) -> String {
    let end = [" #", "\t#"]
        .iter()
        .filter_map(|mark| line.find(mark))
        .min();
    let line = if line.starts_with('#') { "" } else { line };
    line[..end.unwrap_or(line.len()).min(line.len())]
        .trim()
        .to_owned()
}

fn pages() -> Vec<PathBuf> {
    let mut all = vec![root().join("README.md")];
    all.extend(
        fs::read_dir(root().join("docs"))
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .filter(|path| path.extension().is_some_and(|e| e == "md")),
    );
    all.sort();
    all
}

/// A folder outside any checkout, with a copy of the examples.
fn stranger() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    copy(&root().join("examples"), &folder.path().join("examples"));
    folder
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let to = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &to);
        } else {
            fs::copy(entry.path(), to).unwrap();
        }
    }
}

/// A command as run by a shell, without third-party data, image or emulator.
fn shell(folder: &Path, line: &str) -> Command {
    let program = Path::new(env!("CARGO_BIN_EXE_outerloop"));
    let path = format!("{}:/usr/bin:/bin", program.parent().unwrap().display());
    let mut command = Command::new("sh");
    command
        .args(["-c", &format!("exec {line}")])
        .current_dir(folder)
        .env("PATH", path)
        .env("OUTERLOOP_DATA", folder.join("no-data"));
    for name in ["IMAGE", "IMAGE_16", "IMAGE_3", "EMULATOR"] {
        command.env_remove(format!("OUTERLOOP_{name}"));
    }
    command
}

/// What a command may lack on a fresh clone, and a word of the sentence that says where to get it.
fn lacks(line: &str) -> Option<&'static str> {
    let table = [
        ("--port", "--port"),
        ("--emulated", "OUTERLOOP_EMULATOR"),
        ("benchmark", "docs/data.md"),
        ("diagnose", "cannot be read"),
        ("--record", "docs/data.md"),
    ];
    table
        .iter()
        .find(|(word, _)| line.contains(word))
        .map(|(_, said)| *said)
}

#[track_caller]
fn runs_or_says_what_it_lacks(line: &str, output: &Output) {
    let said = String::from_utf8_lossy(&output.stderr);
    match (output.status.code(), lacks(line)) {
        (Some(0), _) => {}
        (Some(2), Some(word)) => {
            assert_eq!(said.trim().lines().count(), 1, "{line}: {said}");
            assert!(said.contains(word), "{line}: {said}");
        }
        (status, _) => panic!("{line}: exit status {status:?}: {said}"),
    }
}

/// A server waits for its client until it is stopped; here on a free port.
fn waits_and_stops(folder: &Path, line: &str) {
    let line = format!("{line} --listen 127.0.0.1:0");
    let mut server = shell(folder, &line).spawn().unwrap();
    std::thread::sleep(Duration::from_secs(2));
    assert!(
        server.try_wait().unwrap().is_none(),
        "{line}: it waits for a client"
    );
    crate::common::send_signal(&server, "-INT");
    assert!(server.wait().unwrap().success(), "{line}");
}

#[test]
fn every_command_of_the_readme_runs_on_a_fresh_clone_or_says_what_it_lacks() {
    let folder = stranger();
    let page = fs::read_to_string(root().join("README.md")).unwrap();
    let lines: Vec<String> = commands(&page)
        .into_iter()
        .filter(|line| line.starts_with("outerloop "))
        .collect();
    assert!(lines.len() >= 6, "{lines:?}");
    for line in &lines {
        if line.starts_with("outerloop serve") && lacks(line).is_none() {
            waits_and_stops(folder.path(), line);
        } else {
            runs_or_says_what_it_lacks(line, &shell(folder.path(), line).output().unwrap());
        }
    }
}

/// The options of a verb, from its help.
fn options(verb: &str) -> BTreeSet<String> {
    let words: Vec<&str> = verb.split(' ').chain(["--help"]).collect();
    let output = crate::common::outerloop(&words);
    assert!(output.status.success(), "`outerloop {verb}` is no verb");
    let help = String::from_utf8(output.stdout).unwrap();
    let words = help.split(|c: char| !c.is_ascii_alphanumeric() && c != '-');
    words
        .filter(|w| w.starts_with("--"))
        .map(str::to_owned)
        .collect()
}

/// The verb of a command and its options.
fn verb_and_options(line: &str) -> Option<(String, Vec<String>)> {
    let words: Vec<&str> = line
        .strip_prefix("outerloop ")?
        .split_whitespace()
        .collect();
    let verb = words.iter().find(|w| !w.starts_with('-'))?;
    let verb = match (*verb, words.iter().skip_while(|w| *w != verb).nth(1)) {
        ("board" | "benchmark", Some(second)) if second.starts_with(char::is_alphabetic) => {
            format!("{verb} {second}")
        }
        _ => (*verb).to_owned(),
    };
    let options = words
        .iter()
        .map(|w| w.trim_matches(['[', ']', '(', ')', ';']))
        .filter(|w| w.starts_with("--") && w.len() > 2)
        .map(|w| w.split('=').next().unwrap().to_owned())
        .collect();
    Some((verb, options))
}

#[test]
fn every_verb_and_option_that_a_page_shows_exists() {
    let mut help = BTreeMap::new();
    let mut seen = 0;
    for path in pages() {
        let page = fs::read_to_string(&path).unwrap();
        for line in commands(&page) {
            let Some((verb, given)) = verb_and_options(&line) else {
                continue;
            };
            let known = help.entry(verb.clone()).or_insert_with(|| options(&verb));
            for option in given {
                let at = path.display();
                assert!(
                    known.contains(&option),
                    "{at}: `{line}`: {verb} has no {option}"
                );
                seen += 1;
            }
        }
    }
    assert!(seen > 50, "{seen}");
}

#[test]
fn every_script_and_file_of_tests_that_a_page_names_exists() {
    let mut seen = 0;
    for path in pages() {
        let page = fs::read_to_string(&path).unwrap();
        for quoted in page
            .split('`')
            .skip(1)
            .step_by(2)
            .map(str::to_owned)
            .chain(commands(&page))
        {
            let words: Vec<&str> = quoted.split_whitespace().collect();
            for (i, word) in words.iter().enumerate() {
                let at = path.display();
                if word.starts_with("scripts/") {
                    let file = word.trim_end_matches(['.', ',', ';', ')']);
                    assert!(
                        root().join(file).exists(),
                        "{at}: `{quoted}`: there is no {file}"
                    );
                    seen += 1;
                }
                if words[0] == "cargo" && *word == "--test" {
                    let name = words.get(i + 1).expect("the name of a file of tests");
                    assert!(
                        is_test(name),
                        "{at}: `{quoted}`: there is no file of tests {name}"
                    );
                    seen += 1;
                }
            }
        }
    }
    assert!(seen > 30, "{seen}");
}

fn is_test(name: &str) -> bool {
    let crates = fs::read_dir(root())
        .unwrap()
        .map(|e| e.unwrap().path().join("tests"));
    crates.into_iter().any(|tests| {
        tests.join(format!("{name}.rs")).exists() || tests.join(name).join("main.rs").exists()
    })
}

/// The parts of a test command: packages, test files, and the words that select tests.
#[derive(Debug, Default)]
struct Chosen {
    packages: Vec<String>,
    files: Vec<String>,
    words: Vec<String>,
}

fn chosen(command: &str) -> Option<Chosen> {
    let mut words = command.split_whitespace().map(str::to_owned);
    if words.next()? != "cargo" || !["test", "tests"].contains(&&*words.next()?) {
        return None;
    }
    let mut chosen = Chosen::default();
    while let Some(word) = words.next() {
        match &*word {
            "-p" => chosen.packages.extend(words.next()),
            "--test" => chosen.files.extend(words.next()),
            "--features" | "--profile" | "--target" | "--test-threads" => drop(words.next()),
            "|" => break,
            option if option.starts_with('-') => {}
            _ => chosen.words.push(word),
        }
    }
    Some(chosen)
}

/// The functions in a Rust file or below a folder, with their modules, `scenarios::stability::a_test`.
fn functions(path: &Path, modules: &str, all: &mut Vec<String>) {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let modules = format!("{modules}{stem}::");
    if let Ok(entries) = fs::read_dir(path) {
        entries.for_each(|entry| functions(&entry.unwrap().path(), &modules, all));
    } else if let Some(text) = fs::read_to_string(path)
        .ok()
        .filter(|_| path.extension().is_some_and(|e| e == "rs"))
    {
        let lines = text
            .lines()
            .filter_map(|line| line.trim().strip_prefix("fn "));
        all.extend(lines.map(|name| format!("{modules}{name}")));
    }
}

#[test]
fn every_command_for_tests_that_a_page_shows_chooses_some() {
    let crates: Vec<PathBuf> = fs::read_dir(root())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.join("Cargo.toml").exists())
        .collect();
    let mut seen = 0;
    for path in pages() {
        let page = fs::read_to_string(&path).unwrap();
        let quoted = page.split('`').skip(1).step_by(2).map(str::to_owned);
        for command in quoted.chain(commands(&page)) {
            let Some(chosen) = chosen(&command) else {
                continue;
            };
            let mut found = Vec::new();
            for folder in &crates {
                let name = folder.file_name().unwrap().to_string_lossy().into_owned();
                if !chosen.packages.is_empty() && !chosen.packages.contains(&name) {
                    continue;
                }
                if chosen.files.is_empty() {
                    for part in ["src", "tests"] {
                        functions(&folder.join(part), "", &mut found);
                    }
                }
                for file in &chosen.files {
                    functions(&folder.join("tests").join(file), "", &mut found);
                    functions(&folder.join(format!("tests/{file}.rs")), "", &mut found);
                }
            }
            for word in &chosen.words {
                let known = found.iter().any(|name| name.contains(word));
                let at = path.display();
                assert!(known, "{at}: `{command}`: no test is called {word}");
                seen += 1;
            }
        }
    }
    assert!(seen > 20, "{seen}");
}

/// The rows of the first table on a page whose head begins so.
fn rows<'a>(page: &'a str, head: &str) -> Vec<Vec<&'a str>> {
    page.lines()
        .skip_while(|line| !line.starts_with(head))
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect()
}

/// The texts of a drawing's elements of one name, without the tags in them.
fn texts(drawing: &str, element: &str) -> Vec<String> {
    let end = format!("</{element}>");
    drawing
        .split(&format!("<{element}"))
        .skip(1)
        .filter_map(|part| Some(part.split_once(&end)?.0.split(['<', '>'])))
        .map(|parts| parts.skip(1).step_by(2).collect::<Vec<_>>().join(" "))
        .collect()
}

/// The words of a pin's label in any order: pin, number and name, without the connector's.
fn label(pin: &str) -> BTreeSet<&str> {
    pin.split(|c: char| !c.is_ascii_alphanumeric())
        .filter(|word| !word.is_empty() && !word.starts_with("CN"))
        .collect()
}

/// A drawn wire has a title with both ends, a pin of the board a label as in the tables.
#[test]
fn the_desk_with_external_converters_is_drawn_as_its_tables_say() {
    let read = |name| fs::read_to_string(root().join("docs").join(name)).unwrap();
    let (drawing, wiring, desk) = (read("desk-16.svg"), read("wiring-16.md"), read("desk.md"));
    let (titles, shown) = (texts(&drawing, "title"), texts(&drawing, "text"));
    let labels: Vec<BTreeSet<&str>> = shown.iter().map(|text| label(text)).collect();
    let drawn = |title: &str, ends: &[&str]| {
        let known = titles.iter().any(|t| t == title);
        assert!(known, "docs/desk-16.svg: there is no wire `{title}`");
        for end in ends {
            let known = labels.contains(&label(end));
            assert!(known, "docs/desk-16.svg: there is no label `{end}`");
        }
    };

    let lines = rows(&wiring, "| signal | pin |");
    assert_eq!(lines.len(), 11);
    for line in lines {
        let (pin, connector, chip, outside) = (line[1], line[2], line[3], line[4]);
        let title = format!("{pin}, {connector}: {chip}, {outside}");
        drawn(
            title.trim_end_matches([',', ' ']),
            &[&format!("{pin} {connector}")],
        );
    }

    let section = desk.split("## With external converters").nth(1).unwrap();
    let wires = rows(section, "| wire | from |");
    assert_eq!(wires.len(), 4);
    let mut from = "";
    for wire in wires {
        from = Some(wire[1]).filter(|f| *f != "the same").unwrap_or(from);
        drawn(&format!("{from} to {}", wire[2]), &[from, wire[2]]);
    }
    let inputs = rows(section, "| input | from |");
    assert_eq!(inputs.len(), 4);
    for input in inputs {
        let name = input[0].split(',').next().unwrap();
        drawn(&format!("{} to {name}", input[1]), &[name]);
    }
}
