//! A parameter that may differ between axes.

use schemars::JsonSchema;
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::error::{Accept, RigError};

/// One number for every axis, or a list with one number an axis, from the ground up.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum PerAxis {
    /// The same for every axis.
    All(f64),
    /// One an axis.
    Each(Vec<f64>),
}

impl PerAxis {
    /// One number per axis, each inside `accept`.
    pub(crate) fn resolve(
        &self,
        path: &str,
        axes: usize,
        accept: Accept,
    ) -> Result<Vec<f64>, RigError> {
        match self {
            Self::All(value) => Ok(vec![accept.check(path, *value)?; axes]),
            Self::Each(values) if values.len() == axes => values
                .iter()
                .enumerate()
                .map(|(axis, value)| accept.check(&format!("{path}[{axis}]"), *value))
                .collect(),
            Self::Each(values) => Err(RigError::new(
                path,
                format!("a list of {}", values.len()),
                format!("one number, or a list of {axes} (one an axis)"),
            )),
        }
    }

    /// The number for an axis, from 0; NaN if the list has none.
    pub fn at(&self, axis: usize) -> f64 {
        match self {
            Self::All(value) => *value,
            Self::Each(values) => values.get(axis).copied().unwrap_or(f64::NAN),
        }
    }

    /// Length of the list; `None` for one number for every axis.
    pub fn count(&self) -> Option<usize> {
        match self {
            Self::All(_) => None,
            Self::Each(values) => Some(values.len()),
        }
    }

    /// All numbers multiplied by `factor`.
    pub fn times(&self, factor: f64) -> Self {
        match self {
            Self::All(value) => Self::All(value * factor),
            Self::Each(values) => Self::Each(values.iter().map(|x| x * factor).collect()),
        }
    }

    /// True if every axis has exactly `value`.
    pub(crate) fn is(&self, value: f64) -> bool {
        match self {
            Self::All(one) => *one == value,
            Self::Each(each) => each.iter().all(|one| *one == value),
        }
    }
}

impl From<f64> for PerAxis {
    fn from(value: f64) -> Self {
        Self::All(value)
    }
}

impl<'de> Deserialize<'de> for PerAxis {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Numbers;
        impl<'de> Visitor<'de> for Numbers {
            type Value = PerAxis;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a number, or a list of numbers (one an axis)")
            }
            fn visit_f64<E: Error>(self, value: f64) -> Result<PerAxis, E> {
                Ok(PerAxis::All(value))
            }
            fn visit_i64<E: Error>(self, value: i64) -> Result<PerAxis, E> {
                Ok(PerAxis::All(value as f64))
            }
            fn visit_u64<E: Error>(self, value: u64) -> Result<PerAxis, E> {
                Ok(PerAxis::All(value as f64))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<PerAxis, A::Error> {
                let mut each = Vec::new();
                while let Some(value) = seq.next_element()? {
                    each.push(value);
                }
                Ok(PerAxis::Each(each))
            }
        }
        deserializer.deserialize_any(Numbers)
    }
}
