//! Third-party records for tests, read where they are: `OUTERLOOP_DATA`, or `../shared/data` beside the repository.
//!
//! They are not part of the repository. A test that lacks them is not run, says so, and is counted: `scripts/test` names a
//! file in `OUTERLOOP_NOT_RUN` and shows at its end what was written there, so that a green run tells what it did not see.
//!
//! ```
//! let Some(file) = test_data::file("ground-motion/ELCENTRO_NS_1940_NGAW2.csv") else {
//!     return; // not run, and counted
//! };
//! assert!(file.is_file());
//! ```

use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};

/// The folder of the data, where there is one.
pub fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("OUTERLOOP_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"),
        PathBuf::from,
    );
    folder.is_dir().then_some(folder)
}

/// A file or folder of the data by its path in there. Where it is missing the calling test is counted as not run.
pub fn file(path: &str) -> Option<PathBuf> {
    let found = folder().map(|f| f.join(path)).filter(|f| f.exists());
    if found.is_none() {
        not_run(&format!(
            "{path} is missing (docs/data.md says where it is published, scripts/fetch-data brings what has an open address; OUTERLOOP_DATA \
             names the folder of the data)"
        ));
    }
    found
}

/// Says that the calling test is not run, and why; counted where `OUTERLOOP_NOT_RUN` names a file.
pub fn not_run(why: &str) {
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    println!("not run: {test}: {why}");
    let Some(list) = std::env::var_os("OUTERLOOP_NOT_RUN") else {
        return;
    };
    let file = OpenOptions::new().create(true).append(true).open(&list);
    if let Err(e) = file.and_then(|mut f| writeln!(f, "{test}: {why}")) {
        panic!(
            "{}: {e}; OUTERLOOP_NOT_RUN must name a file that can be written",
            list.display()
        );
    }
}
