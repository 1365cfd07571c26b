//! Values of the two actuators, and of the two coordinates.

/// A value for each of the two actuators, or for `x` and `theta`.
pub type Pair = [f32; 2];
