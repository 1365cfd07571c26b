//! What the image has to know from outside: the commit that it is built from, and the log's section.

use std::process::Command;

fn main() {
    println!("cargo:rustc-env=OUTERLOOP_COMMIT={}", commit());
    let board = std::env::var_os("CARGO_FEATURE_NUCLEO_F429ZI").is_some();
    let target = std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none");
    if board && target {
        for image in ["nucleo_f429zi", "nucleo_f429zi_16", "nucleo_f429zi_3"] {
            println!("cargo:rustc-link-arg-bin={image}=-Tdefmt.x");
        }
    }
    if std::env::var_os("CARGO_FEATURE_ON_TARGET").is_some() && target {
        println!("cargo:rustc-link-arg-tests=-Tdefmt.x");
        println!("cargo:rustc-link-arg-tests=-Tembedded-test.x");
    }
    println!("cargo:rerun-if-changed=build.rs");
    for folder in ["src", "../core/src", "../link/src"] {
        println!("cargo:rerun-if-changed={folder}");
    }
    for name in ["HEAD", "index"] {
        if let Some(path) = git(&["rev-parse", "--git-path", name]) {
            println!("cargo:rerun-if-changed={path}");
        }
    }
}

/// The commit, `-dirty` behind it if the sources are not those of the commit.
fn commit() -> String {
    git(&[
        "describe",
        "--always",
        "--dirty",
        "--abbrev=12",
        "--exclude=*",
    ])
    .unwrap_or_else(|| "unknown".into())
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    (output.status.success()).then(|| text.trim().to_owned())
}
