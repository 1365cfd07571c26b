//! Proofs by the linker: nothing in a control period can panic, and nothing in it is computed in double precision.

use host_tests::qemu::image::{build, image};
use object::{Object, ObjectSymbol};

/// Names of the functions and data in an image.
fn symbols(path: &std::path::Path) -> Vec<String> {
    let bytes = std::fs::read(path).unwrap();
    let file = object::File::parse(&*bytes).unwrap();
    file.symbols()
        .filter_map(|s| s.name().ok().map(str::to_owned))
        .collect()
}

/// Functions that the compiler calls for f64 on a processor without it.
fn double_precision(symbols: &[String]) -> Vec<&String> {
    let is = |s: &&String| {
        s.starts_with("__aeabi_d") && *s != "__aeabi_d" || s.as_str() == "__aeabi_f2d"
    };
    symbols.iter().filter(is).collect()
}

#[test]
fn a_control_period_cannot_panic() {
    let Some(proof) = image("no_panic", "no-panic") else {
        return;
    };
    let symbols = symbols(&proof);
    assert!(
        symbols.iter().any(|s| s.contains("outer_loop")),
        "the step is in the image"
    );
    assert!(
        !symbols
            .iter()
            .any(|s| s.contains("panic_fmt") || s.contains("panicking"))
    );
    assert_eq!(double_precision(&symbols), Vec::<&String>::new());
}

#[test]
fn the_proof_fails_where_there_is_a_panic() {
    let Some(proof) = build("no_panic", "planted-panic") else {
        return;
    };
    let output = proof.expect_err("an image with a panic in it cannot be linked");
    assert!(output.contains("a_control_period_can_panic"), "{output}");
}

/// The image that designs a test on the target does use double precision: the search can find it.
#[test]
fn double_precision_would_be_seen() {
    let Some(image) = image("qemu", "qemu") else {
        return;
    };
    assert!(!double_precision(&symbols(&image)).is_empty());
}
