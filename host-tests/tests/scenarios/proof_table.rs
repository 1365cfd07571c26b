//! The proof table: nothing that the firmware promises is without a test, and the page says so.

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
