//! The board's image keeps its log's texts where a debugger finds them.

fn main() {
    if std::env::var_os("CARGO_FEATURE_BOARD").is_some() {
        println!("cargo:rustc-link-arg-bin=lab_board=-Tdefmt.x");
    }
}
