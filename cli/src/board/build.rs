//! Builds the image and the emulator if they do not exist yet.

use super::image::Image;
use experiment::failure::Failure;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The image to flash: the one named by OUTERLOOP_IMAGE (OUTERLOOP_IMAGE_16, OUTERLOOP_IMAGE_3), else a release's, else
/// that of the current checkout.
///
/// # Errors
/// No checkout here, or a build that fails.
pub fn built_image(image: Image) -> Result<PathBuf, Failure> {
    if let Some(built) = std::env::var_os(image.variable()) {
        return Ok(built.into());
    }
    let name = image.name();
    if let Some(released) = bundled_file(&format!("outerloop-{name}.elf")) {
        return Ok(released);
    }
    let root = checkout()?;
    let target = target_folder(&root);
    let built = target
        .join("cross/thumbv7em-none-eabihf/release")
        .join(name);
    let mut build = Command::new(root.join("scripts/cross"));
    build.args(["build", "-p", "firmware", "--bin", name, "--release"]);
    build.args(image.features());
    announce(&built, "the board's image", "1 to 3 minutes");
    run(build.current_dir(&root).env("CARGO_TARGET_DIR", &target))?;
    Ok(built)
}

/// The emulator: the one named by OUTERLOOP_EMULATOR, else a release's, else that of the current checkout.
///
/// # Errors
/// No checkout here, or a build that fails.
pub fn built_emulator() -> Result<PathBuf, Failure> {
    if let Some(built) = std::env::var_os("OUTERLOOP_EMULATOR") {
        return Ok(built.into());
    }
    if let Some(released) = bundled_file(&format!(
        "outerloop-emulator{}",
        std::env::consts::EXE_SUFFIX
    )) {
        return Ok(released);
    }
    let root = checkout()?;
    let target = target_folder(&root);
    let built = target.join("release/emu");
    let mut build = Command::new("cargo");
    build.args(["build", "-p", "emu", "--features", "emulator", "--release"]);
    // The emulator's crate asks for a newer compiler than it needs.
    build.arg("--ignore-rust-version");
    announce(&built, "the emulator", "3 to 10 minutes and 1 GiB");
    run(build.current_dir(&root).env("CARGO_TARGET_DIR", &target))?;
    Ok(built)
}

/// A file that a release places next to this program.
fn bundled_file(name: &str) -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    Some(program.parent()?.join(name)).filter(|file| file.is_file())
}

/// Announces a long build: what is built, and how long it takes. Says nothing if the file exists and a build only checks
/// for changes.
fn announce(built: &Path, what: &str, takes: &str) {
    if !built.is_file() {
        eprintln!(
            "outerloop: --emulated: {what} has not been built yet: on two cores this takes {takes}, once"
        );
    }
}

/// The folder that contains `firmware` and `emu`: the current one or one above it. Nothing is built elsewhere.
fn checkout() -> Result<PathBuf, Failure> {
    let here = std::env::current_dir().unwrap_or_default();
    let is_root =
        |p: &&Path| p.join("emu/Cargo.toml").is_file() && p.join("scripts/cross").is_file();
    here.ancestors()
        .find(is_root)
        .map(Path::to_path_buf)
        .ok_or_else(|| {
            Failure::input(format!(
                "--emulated: {} is in no checkout of this project: accepted is one, with its folders firmware and emu, or OUTERLOOP_IMAGE and OUTERLOOP_EMULATOR with what was built of them",
                here.display()
            ))
        })
}

fn target_folder(root: &Path) -> PathBuf {
    let named = std::env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
    root.join(named.unwrap_or_else(|| "target".into()))
}

fn run(build: &mut Command) -> Result<(), Failure> {
    // Build messages go to standard error: standard output is for the result.
    let out = build
        .stdout(Stdio::null())
        .status()
        .map_err(|e| Failure::test(format!("--emulated: {}: {e}", command_line(build))))?;
    if out.success() {
        Ok(())
    } else {
        Err(Failure::test(format!(
            "--emulated: `{}` failed ({out}); scripts/setup installs what it needs",
            command_line(build)
        )))
    }
}

fn command_line(build: &Command) -> String {
    let words = std::iter::once(build.get_program()).chain(build.get_args());
    let words: Vec<_> = words.map(|w| w.to_string_lossy()).collect();
    words.join(" ")
}
