//! From deformation to restoring force: one element per storey.

pub(crate) mod added;
pub(crate) mod bilinear;
pub(crate) mod bouc_wen;
mod spec;
mod storey;

pub use bilinear::Bilinear;
pub use bouc_wen::BoucWen;
pub use spec::{SpecimenKind, SpecimenSpec};
pub use storey::Storey;
