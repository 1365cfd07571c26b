//! Equilibrium of floors whose supports give way to the force.
//!
//! Solved anew in every period, `x + g F(x) = wanted`: forces that depend on velocity or acceleration are far too stiff
//! to be carried over from one control period to the next. With a mass this is the mass on the spring `1 / g`,
//! integrated by Houbolt's method.

use super::floor::Floor;

/// Tolerance, m.
const TOLERANCE_M: f64 = 1e-13;
/// Sweeps over the floors, and steps within one: enough for contraction by a half each; stiff pairs take fewer.
const MOST: usize = 60;

/// Moves `at_m` from the force-free positions of the floors to the true ones.
pub(super) fn find_equilibrium(floors: &[Floor], at_m: &mut [f64]) {
    let wanted = at_m.to_vec();
    // Continuing the last period's motion gives a close start.
    for (at, floor) in at_m.iter_mut().zip(floors) {
        if floor.gives_m_per_n > 0.0 {
            *at = floor.displacement_m() + floor.motion.increment_m();
        }
    }
    for _ in 0..MOST {
        let mut moved: f64 = 0.0;
        for j in 0..floors.len() {
            let gives = floors[j].gives_m_per_n;
            if gives > 0.0 {
                let from = at_m[j];
                let found = root(from, |x| {
                    at_m[j] = x;
                    x - wanted[j] + gives * trial_force(floors, at_m, j)
                });
                at_m[j] = found;
                moved = moved.max((found - from).abs());
            }
        }
        if floors.len() == 1 || moved < TOLERANCE_M {
            return;
        }
    }
}

/// Force on the load cell of floor `j` if the floors were at `at_m`, N.
fn trial_force(floors: &[Floor], at_m: &[f64], j: usize) -> f64 {
    let shear = |j: usize| {
        let below = if j == 0 { 0.0 } else { at_m[j - 1] };
        let mut drift = floors[j].drift.clone();
        drift.advance(at_m[j] - below);
        floors[j].storey.clone().step(&drift)
    };
    let above = if j + 1 < floors.len() {
        shear(j + 1)
    } else {
        0.0
    };
    let mut motion = floors[j].motion.clone();
    motion.advance(at_m[j]);
    shear(j) - above + floors[j].mass_kg * motion.acceleration_m_s2()
}

/// A root of `f`, whose slope is at least 1 (a force that resists), so it lies between `x` and `x - f(x)`. False
/// position in Illinois' form; if a falling force makes the slope less, the best of [`MOST`] steps.
fn root(x: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    let (mut a, mut fa) = (x, f(x));
    if fa.abs() < TOLERANCE_M {
        return a;
    }
    let mut b = a - fa;
    let mut fb = f(b);
    for _ in 0..MOST {
        if fb.abs() < TOLERANCE_M || (a - b).abs() < TOLERANCE_M || fa == fb {
            break;
        }
        let c = b - fb * (b - a) / (fb - fa);
        let fc = f(c);
        if fc * fb < 0.0 {
            (a, fa) = (b, fb);
        } else {
            fa *= 0.5;
        }
        (b, fb) = (c, fc);
    }
    b
}
