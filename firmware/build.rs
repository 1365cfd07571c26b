//! Gives the image its commit and the section of its log.

use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-check-cfg=cfg(coupled)");
    // The loop of two coupled actuators: always tested on this machine, in an image only on request.
    let image = std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none");
    if !image || std::env::var_os("CARGO_FEATURE_COUPLED").is_some() {
        println!("cargo:rustc-cfg=coupled");
    }
    // Only an image contains its commit; a build for this machine does not depend on it.
    if image {
        chip();
    }
}

fn chip() {
    println!("cargo:rustc-env=OUTERLOOP_COMMIT={}", commit());
    // Where memory.x is, for an image that another crate links.
    if let Some(top) = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).parent() {
        println!("cargo:rustc-link-search={}", top.display());
    }
    if std::env::var_os("CARGO_FEATURE_NUCLEO_F429ZI").is_some() {
        for image in ["nucleo_f429zi", "nucleo_f429zi_16", "nucleo_f429zi_3"] {
            println!("cargo:rustc-link-arg-bin={image}=-Tdefmt.x");
        }
    }
    if std::env::var_os("CARGO_FEATURE_ON_TARGET").is_some() {
        println!("cargo:rustc-link-arg-tests=-Tdefmt.x");
        println!("cargo:rustc-link-arg-tests=-Tembedded-test.x");
    }
    for folder in ["src", "../core/src", "../link/src"] {
        println!("cargo:rerun-if-changed={folder}");
    }
    for name in ["HEAD", "index"] {
        if let Some(path) = git(&["rev-parse", "--git-path", name]) {
            println!("cargo:rerun-if-changed={path}");
        }
    }
}

/// The commit, followed by `-dirty` if the sources differ from it.
fn commit() -> String {
    let Some(commit) = git(&["rev-parse", "--short=12", "HEAD"]) else {
        return "unknown".into();
    };
    // Otherwise git rewrites its index, which is watched, and each build would cause another one.
    let changed = git(&[
        "--no-optional-locks",
        "status",
        "--porcelain",
        "--untracked-files=no",
    ]);
    match changed.as_deref() {
        Some("") => commit,
        _ => commit + "-dirty",
    }
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    (output.status.success()).then(|| text.trim().to_owned())
}
