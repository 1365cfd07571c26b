//! Shared by the targets: writing seeds, and making a file from bytes.

use std::path::PathBuf;

/// Writes seeds made by this build into the folder named by `OUTERLOOP_SEEDS`, for the fuzzer to start from. Seeds that change
/// with every version of the link are not kept in the repository.
pub fn begin_with(seeds: impl IntoIterator<Item = Vec<u8>>) {
    let Some(folder) = std::env::var_os("OUTERLOOP_SEEDS").map(PathBuf::from) else {
        return;
    };
    for (number, bytes) in seeds.into_iter().enumerate() {
        let file = folder.join(format!("seed-{number}"));
        std::fs::write(&file, bytes).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    }
}

/// Writes `bytes` to a file with this extension, which the next call overwrites.
pub fn file_of(bytes: &[u8], ending: &str) -> PathBuf {
    let name = format!("outerloop-fuzz-{}.{ending}", std::process::id());
    let file = std::env::temp_dir().join(name);
    std::fs::write(&file, bytes).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    file
}
