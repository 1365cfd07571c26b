//! Links between the documents: each leads to an existing file, and to a heading in it.

use crate::common::root;
use std::fs;
use std::path::{Path, PathBuf};

/// All pages of the repository for readers.
fn pages() -> Vec<PathBuf> {
    let folders = ["", "docs", "python", "core", "firmware", "examples", "exam"];
    let pages = folders
        .iter()
        .filter_map(|folder| fs::read_dir(root().join(folder)).ok());
    pages
        .flatten()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "md"))
        .collect()
}

/// A page without its fenced blocks, which contain no links.
fn prose(page: &str) -> String {
    page.split("```").step_by(2).collect()
}

/// The targets of `[text](target)`.
fn links(page: &str) -> Vec<&str> {
    page.split("](")
        .skip(1)
        .filter_map(|rest| rest.split([')', ' ', '\n']).next())
        .collect()
}

/// The anchor of a heading: lower case, spaces as hyphens, no punctuation.
fn anchor(heading: &str) -> String {
    heading
        .trim_start_matches('#')
        .trim()
        .to_lowercase()
        .chars()
        .filter_map(|c| match c {
            ' ' => Some('-'),
            c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c),
            _ => None,
        })
        .collect()
}

fn has_heading(page: &Path, wanted: &str) -> bool {
    let text = fs::read_to_string(page).unwrap();
    let prose = prose(&text);
    let mut headings = prose.lines().filter(|line| line.starts_with('#'));
    headings.any(|line| anchor(line) == wanted)
}

#[test]
fn every_link_leads_to_a_file_and_a_heading_that_are_there() {
    let mut seen = 0;
    for path in pages() {
        let text = fs::read_to_string(&path).unwrap();
        for link in links(&prose(&text)).iter().filter(|l| !l.contains("://")) {
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = match file {
                "" => path.clone(),
                file => path.parent().unwrap().join(file),
            };
            let at = path.display();
            assert!(target.exists(), "{at}: `{link}`: there is no such file");
            let known = heading.is_empty() || has_heading(&target, heading);
            assert!(known, "{at}: `{link}`: there is no such heading");
            seen += 1;
        }
    }
    assert!(seen > 60, "{seen}");
}

/// A page of the book has no links out of the book, where they would lead nowhere.
#[test]
fn the_book_has_every_page_of_docs_and_no_link_out_of_it() {
    let summary = fs::read_to_string(root().join("docs/SUMMARY.md")).unwrap();
    let chapters = links(&summary);
    let docs = root().join("docs");
    for path in pages().iter().filter(|p| p.starts_with(&docs)) {
        let name = path.file_name().unwrap().to_str().unwrap();
        let listed = chapters.iter().filter(|c| **c == name).count();
        assert_eq!(
            listed,
            usize::from(name != "SUMMARY.md"),
            "docs/SUMMARY.md: {name}"
        );
        let text = fs::read_to_string(path).unwrap();
        let prose = prose(&text);
        let out = links(&prose)
            .into_iter()
            .find(|link| link.starts_with(".."));
        assert_eq!(out, None, "{name}");
    }
}

#[test]
fn a_heading_becomes_the_anchor_that_readers_link_to() {
    assert_eq!(anchor("## What `q` means, and why"), "what-q-means-and-why");
    assert_eq!(
        anchor("# Field rigs: is a name as sure as its `q` says"),
        "field-rigs-is-a-name-as-sure-as-its-q-says"
    );
}
