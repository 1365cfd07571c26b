//! Images, built by `scripts/cross` when a test asks for one: what is tested is never an old one.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// Set where a missing compiler or emulator is a failure.
const REQUIRED: &str = "OUTERLOOP_REQUIRE_QEMU";

/// Exit status of `scripts/cross` where there is no compiler for the target.
const NO_COMPILER: i32 = 3;

/// Builds the image `name` of the firmware with `features`; the output of the build where it fails.
///
/// `None` where it cannot be built or run on this machine, which has then been said.
///
/// # Panics
/// Where that is not allowed, or the script cannot be started.
pub fn build(name: &str, features: &str) -> Option<Result<PathBuf, String>> {
    cross("build", &["--bin", name], features)
}

/// Builds the test on the board itself, as [`build`].
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

/// The image `name` with `features`, as [`build`], where it must build.
///
/// # Panics
/// Where it does not.
pub fn image(name: &str, features: &str) -> Option<PathBuf> {
    build(name, features).map(must)
}

/// The same of an example of the firmware, which is evidence and no product.
///
/// # Panics
/// As [`image`].
pub fn example(name: &str, features: &str) -> Option<PathBuf> {
    cross("build", &["--example", name], features).map(must)
}

fn must(built: Result<PathBuf, String>) -> PathBuf {
    built.unwrap_or_else(|output| panic!("{output}"))
}

/// The executable that cargo reports in its messages, or what it has to say against it.
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
