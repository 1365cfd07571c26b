//! A release has the same version everywhere.

use std::path::Path;

/// The first line of `file` that begins with `key`, without it and without quotation marks.
fn said(file: &str, key: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(file);
    let text = std::fs::read_to_string(&path).unwrap();
    let line = text.lines().find_map(|line| line.strip_prefix(key));
    let value = line.unwrap_or_else(|| panic!("{file} has no {key}"));
    value.trim().trim_matches('"').to_owned()
}

#[test]
fn the_version_of_a_release_is_the_same_wherever_it_is_said() {
    let version = env!("CARGO_PKG_VERSION");
    for (file, key) in [
        ("Cargo.toml", "version ="),
        ("CITATION.cff", "version:"),
        ("python/Cargo.toml", "version ="),
        ("python/pyproject.toml", "version ="),
    ] {
        assert_eq!(said(file, key), version, "{file}");
    }
    // The newest heading; the date may follow.
    let newest = said("CHANGELOG.md", "## ");
    assert_eq!(newest.split(' ').next(), Some(version), "CHANGELOG.md");
}
