//! Goals set for this program in a benchmark problem, its results, and by how much the goals are missed.
//!
//! Read from the JSON answer of `outerloop benchmark`, as a laboratory would read it.

mod goal;
mod marths;
mod rths;

pub use goal::{GOAL_HEAD, Goal};
use serde_json::Value;

/// All goals that apply to an answer of `benchmark rths` or `benchmark marths`.
///
/// # Errors
/// It is neither.
pub fn goals(answer: &Value) -> Result<Vec<Goal>, &'static str> {
    let rows = answer["rows"].as_array().map_or(&[][..], |rows| rows);
    match rows.first().and_then(|row| row.get("J2")) {
        Some(Value::Array(_)) => Ok(marths::goals(rows, answer)),
        Some(Value::Number(_) | Value::Null) => Ok(rths::goals(rows, answer)),
        _ => Err("no answer of `outerloop benchmark rths --json` or `benchmark marths --json`"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn an_answer_of_another_verb_is_refused() {
        for other in [
            json!({}),
            json!({ "rows": [] }),
            json!({ "rows": [{ "J2": "1" }] }),
        ] {
            assert!(goals(&other).is_err(), "{other}");
        }
    }
}
