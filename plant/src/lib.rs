//! The simulated rig (f64, host).
