//! The PC tool.
fn main() {}
