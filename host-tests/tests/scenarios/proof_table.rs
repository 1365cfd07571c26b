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
fn each_mend_of_the_review_can_be_taken_out_of_an_image_and_the_findings_say_which_scenario_sees_it()
 {
    let mutants = without_mends(&top()).unwrap();
    assert_eq!(misfits_of_images(&top(), &mutants), [""; 0]);
    let page = std::fs::read_to_string(top().join("docs/firmware-findings.md")).unwrap();
    let rows: Vec<String> = mutants
        .iter()
        .map(|m| {
            let scenario = m.test.rsplit("::").next().unwrap_or(&m.test);
            format!("| {} | {} | `{scenario}` |", m.finding, m.name)
        })
        .collect();
    let there: Vec<&str> = page
        .lines()
        .filter(|line| rows.iter().any(|r| r == line))
        .collect();
    assert_eq!(
        there, rows,
        "docs/firmware-findings.md lists them in their order"
    );
    // D and E are answered on a page, F on a PC.
    for finding in ["A", "B", "C", "G", "H", "I", "J"] {
        assert!(mutants.iter().any(|m| m.finding == finding), "{finding}");
    }
}
