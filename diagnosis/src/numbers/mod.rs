//! Arithmetic on signals: sums and spectra, linear algebra, filters and operators, independent of records and models.

pub mod bounded;
pub mod coherence;
pub mod linear;
pub mod operators;
pub mod reflected;
pub mod signals;
