//! Every key of a test file: its unit, default, range and meaning, from the code that reads it; the schemas of files and answers.
//!
//! Names, types and meanings are those of the structures' JSON Schema, defaults are those that the structures have, and what is
//! accepted is what the refusal of a wrong value says. So this list cannot say anything else than the code.

mod answers;
mod declared_model;
mod key;
mod list;
mod probe;
mod render;
mod structures;
mod value;

pub use answers::SCHEMAS;
pub use declared_model::declared_model;
pub use key::Group;
pub use list::all;
pub use render::markdown;
