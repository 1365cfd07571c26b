//! A compensation by its name.

use crate::failure::Failure;
use outerloop_core::{Accepted, Method};

/// A compensation by its name, as in `paper` or `tangent+ats`.
///
/// # Errors
/// A name that no compensation has.
pub fn method(name: &str) -> Result<Method, Failure> {
    Method::from_name(name).ok_or_else(|| {
        Failure::input(format!(
            "the compensation `{name}` is unknown: accepted are {Accepted}"
        ))
    })
}
