//! What the targets share: their beginnings, and a file to be read.

use std::path::PathBuf;

/// Writes files of this build into the folder that `OUTERLOOP_SEEDS` names, for the fuzzer to begin with. What changes
/// with every version of the link is not kept in the tree.
pub fn begin_with(seeds: impl IntoIterator<Item = Vec<u8>>) {
    let Some(folder) = std::env::var_os("OUTERLOOP_SEEDS").map(PathBuf::from) else {
        return;
    };
    for (number, bytes) in seeds.into_iter().enumerate() {
        let file = folder.join(format!("seed-{number}"));
        std::fs::write(&file, bytes).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    }
}

/// `bytes` as a file with this ending, which the next call replaces.
pub fn file_of(bytes: &[u8], ending: &str) -> PathBuf {
    let name = format!("outerloop-fuzz-{}.{ending}", std::process::id());
    let file = std::env::temp_dir().join(name);
    std::fs::write(&file, bytes).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    file
}
