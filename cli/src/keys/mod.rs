//! Every key of a test file: its unit, default, range and meaning, from the code that reads it; the schemas of files and
//! results.
//!
//! Names, types and meanings come from the structures' JSON Schema, defaults from the structures themselves, and accepted
//! values from the refusal of a wrong value. So this list cannot contradict the code.

mod answers;
mod declared_model;
mod key;
mod list;
mod probe;
mod render;
mod structures;
mod unit;
mod value;

pub use answers::SCHEMAS;
pub use declared_model::declared_model;
pub use key::Group;
pub use list::all;
pub use render::markdown;
