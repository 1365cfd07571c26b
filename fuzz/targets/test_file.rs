//! The test file.
#![no_main]

use experiment::files::test::TestFile;
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|text: &str| {
    if let Ok(test) = TestFile::parse(text, "test.toml", Path::new(""), &[]) {
        let _ = (
            test.compensation(),
            test.declared_model(),
            test.warning_of_true_delay(),
        );
    }
});
