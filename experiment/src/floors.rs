//! The number of floors, from a number to a constant.

/// Evaluates an expression with the constant `$n` equal to the number of floors, 1 to 8.
#[macro_export]
macro_rules! with_floors {
    ($floors:expr, $n:ident => $body:expr) => {
        $crate::floors::with_floors!(@ $floors, $n, $body, 1 2 3 4 5 6 7 8)
    };
    (@ $floors:expr, $n:ident, $body:expr, $($count:literal)*) => {
        match $floors {
            $($count => {
                const $n: usize = $count;
                $body
            })*
            other => Err($crate::failure::Failure::input(format!(
                "structure.mass_kg has {other} values: accepted are 1 to 8"
            ))),
        }
    };
}
pub use with_floors;
