//! Images, built by `scripts/cross` when a test asks for one, so that no old one is tested.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// Set if a missing compiler or emulator is a failure.
const REQUIRED: &str = "OUTERLOOP_REQUIRE_QEMU";

/// Exit status of `scripts/cross` if there is no compiler for the target.
const NO_COMPILER: i32 = 3;

/// Builds the image `name` of the firmware with `features`; the output of the build if it fails.
///
/// `None`, with a message, if it cannot be built or run on this machine.
///
/// # Panics
/// That is not allowed, or the script cannot be started.
pub fn build(name: &str, features: &str) -> Option<Result<PathBuf, String>> {
    cross("build", &["--bin", name], features)
}

/// Builds the test that runs on the board itself, as [`build`].
///
/// # Panics
/// As [`build`].
pub fn on_target() -> Option<Result<PathBuf, String>> {
    cross("test", &["--test", "on_target", "--no-run"], "on-target")
}

fn cross(verb: &str, what: &[&str], features: &str) -> Option<Result<PathBuf, String>> {
    let missing = |what: &str| {
        assert!(
            std::env::var_os(REQUIRED).is_none(),
            "{REQUIRED} is set, but {what}"
        );
        test_data::not_run(&format!("{what}; scripts/setup installs what is needed"));
        None
    };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts/cross");
    let output = Command::new(script)
        .args([
            verb,
            "-p",
            "firmware",
            "--release",
            "--message-format=json-render-diagnostics",
        ])
        .args(what)
        .args(["--no-default-features", "--features", features])
        .output()
        .expect("scripts/cross starts");
    if output.status.code() == Some(NO_COMPILER) {
        return missing("there is no compiler for the target");
    }
    let emulator = Command::new(super::machine::EMULATOR)
        .arg("--version")
        .stdout(Stdio::null())
        .status();
    if emulator.is_err() {
        return missing("there is no qemu-system-arm");
    }
    Some(executable(&output))
}

/// The image `name` with `features`, as [`build`], but it must build.
///
/// # Panics
/// It does not build.
pub fn image(name: &str, features: &str) -> Option<PathBuf> {
    build(name, features).map(must)
}

/// The same for an example of the firmware, which is evidence and not a product.
///
/// # Panics
/// As [`image`].
pub fn example(name: &str, features: &str) -> Option<PathBuf> {
    cross("build", &["--example", name], features).map(must)
}

fn must(built: Result<PathBuf, String>) -> PathBuf {
    built.unwrap_or_else(|output| panic!("{output}"))
}

/// The executable that cargo reports in its messages, or its errors.
fn executable(output: &Output) -> Result<PathBuf, String> {
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned());
    }
    String::from_utf8_lossy(&output.stdout)
        .lines()
        .filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok())
        .find_map(|message| message["executable"].as_str().map(PathBuf::from))
        .ok_or_else(|| "cargo reported no executable".to_owned())
}
