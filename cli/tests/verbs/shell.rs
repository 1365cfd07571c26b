//! Completions and the man page of the command line.

use crate::common::outerloop;

#[test]
fn completions_and_the_man_page_know_every_verb() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let out = outerloop(&["completions", shell]);
        let text = String::from_utf8_lossy(&out.stdout);
        assert!(out.status.success());
        for word in ["serve", "diagnose", "scope"] {
            assert!(text.contains(word), "{shell}: {word}");
        }
    }
    let out = outerloop(&["man"]);
    let text = String::from_utf8_lossy(&out.stdout);
    assert!(
        out.status.success() && text.contains(".TH outerloop 1"),
        "{text}"
    );
    // References to separate pages do not occur.
    assert!(!text.contains("outerloop\\-"), "{text}");
    for verb in [
        "OUTERLOOP RUN",
        "OUTERLOOP SERVE",
        "OUTERLOOP BOARD IDENTIFY",
        "OUTERLOOP BENCHMARK RTHS",
    ] {
        assert!(text.contains(&format!(".SH \"{verb}\"")), "{verb}");
    }
    // Options of a verb below another verb.
    assert!(text.contains("\\-\\-deviate"), "{text}");
}
