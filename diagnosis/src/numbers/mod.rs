//! Arithmetic on signals: sums and spectra of samples, linear algebra, filters and operators. It knows nothing of records or models.

pub mod coherence;
pub mod linear;
pub mod operators;
pub mod signals;
