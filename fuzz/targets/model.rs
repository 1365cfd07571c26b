//! The declared model: an accepted model is the same after writing and reading it again.
#![no_main]

use experiment::files::model::{parse, to_toml};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Ok(model) = parse("model.toml", text) {
        let written = to_toml(&model).expect("a model can be written");
        assert_eq!(parse("written.toml", &written).ok(), Some(model));
    }
});
