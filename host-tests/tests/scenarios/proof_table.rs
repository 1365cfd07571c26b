//! The proof table: everything that the firmware promises has a test, and the page shows it.

use host_tests::proof::mutants::{misfits_of_images, without_mends};
use host_tests::proof::page::Proofs;
use host_tests::proof::top;

fn proofs() -> Proofs {
    Proofs::read().unwrap_or_else(|wrong| panic!("{}", wrong.join("\n")))
}

#[test]
fn nothing_is_without_a_test_and_without_what_shows_that_the_test_sees_it() {
    assert_eq!(proofs().gaps(), [""; 0]);
}

#[test]
fn the_page_is_what_the_code_and_the_tests_say() {
    let page = std::fs::read_to_string(top().join("docs/proof-table.md")).unwrap();
    assert!(
        page == proofs().page(),
        "docs/proof-table.md is not what `cargo run -p host-tests --bin proof-table -- --markdown` prints"
    );
}

#[test]
fn each_safeguard_can_be_taken_out_of_an_image_and_a_page_says_which_scenario_sees_it() {
    let mutants = without_mends(&top()).unwrap();
    assert_eq!(misfits_of_images(&top(), &mutants), [""; 0]);
    let page = std::fs::read_to_string(top().join("docs/firmware-validation.md")).unwrap();
    let rows: Vec<String> = mutants
        .iter()
        .map(|m| {
            let scenario = m.test.rsplit("::").next().unwrap_or(&m.test);
            format!("| {} | {} | `{scenario}` |", m.subject, m.name)
        })
        .collect();
    let there: Vec<&str> = page
        .lines()
        .filter(|line| rows.iter().any(|r| r == line))
        .collect();
    assert_eq!(
        there, rows,
        "docs/firmware-validation.md lists them in their order"
    );
    let sections = std::fs::read_to_string(top().join("docs/firmware-safeguards.md")).unwrap();
    for mutant in &mutants {
        let heading = format!("\n## {}", mutant.subject);
        let known = sections.to_lowercase().contains(&heading.to_lowercase());
        assert!(known, "docs/firmware-safeguards.md: {}", mutant.subject);
    }
    for subject in [
        "arming",
        "PERMIT",
        "period",
        "converters",
        "sensors",
        "motion",
        "memory",
    ] {
        let listed = mutants.iter().any(|m| m.subject == subject);
        assert!(listed, "emu/mutants.toml: {subject}");
    }
}
