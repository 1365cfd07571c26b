//! The description of a key.

use super::value::ValueKind;

/// A key of the test file.
#[derive(Clone, Debug, serde::Serialize, schemars::JsonSchema)]
pub struct Key {
    /// Its path, `loop.rate_hz`.
    pub path: String,
    /// Its unit; `1` for a plain number, several for a list of different numbers, `varies` where `meaning` says it, empty for a
    /// text, a name, true or false and tables.
    pub unit: &'static str,
    /// The value if it is left out, as written in a file; null where there is none: see `meaning`, of the key or of its table.
    pub default: Option<String>,
    /// What is accepted.
    pub accepted: String,
    /// What it means.
    pub meaning: String,
    /// What it holds.
    #[serde(skip)]
    pub(super) kind: ValueKind,
}

impl Key {
    /// The last part of its path.
    pub fn name(&self) -> &str {
        self.path.rsplit('.').next().unwrap_or(&self.path)
    }
}

/// A table of the test file with its keys.
#[derive(Clone, Debug, serde::Serialize, schemars::JsonSchema)]
pub struct Group {
    /// Its path.
    pub path: String,
    /// What it is.
    pub meaning: String,
    /// Its keys.
    pub keys: Vec<Key>,
}
