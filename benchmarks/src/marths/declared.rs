//! What the loop's own records say of the declared physical part.
//!
//! A tracker without any error still has a J7 of 10 % and 8 %: what is subtracted as physical is not the frame that answers.
//! A least squares of the recorded force on displacement, velocity and acceleration of the interface, all behind the same
//! zero-phase low-pass of 15 Hz, finds the frame; subtracting what was found in place of what was declared lowers the
//! floor.

use super::criteria::{Both, deviation};
use super::structure::{Matrices, Part};
use super::trial::{Trace, computed, without_error};
use super::{PERIOD_S, SIGN};
use crate::Refused;
use nalgebra::{DMatrix, Matrix2, Vector2};
use serde::Serialize;

/// The frame as a record shows it, in the structure's sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// kg, kg m^2: the diagonal.
    pub mass: Matrix2<f64>,
    /// N s/m and so on.
    pub damping: Matrix2<f64>,
    /// N/m and so on.
    pub stiffness: Matrix2<f64>,
}

/// Beyond this frequency readings are noise, Hz.
const CORNER_HZ: f64 = 15.0;

/// A low-pass that delays nothing: forwards and backwards through two poles, twice.
fn smooth(x: &[f64]) -> Vec<f64> {
    let share = 1.0 - (-std::f64::consts::TAU * CORNER_HZ * 2.0 * PERIOD_S).exp();
    let mut all = x.to_vec();
    for _ in 0..4 {
        let mut kept = 0.0;
        for y in &mut all {
            kept += share * (*y - kept);
            *y = kept;
        }
        all.reverse();
    }
    all
}

/// The frame that answered in a trial.
///
/// # Errors
/// A record in which nothing moved.
pub fn found(trace: &Trace) -> Result<Found, Refused> {
    let column = |pairs: &[Both], i: usize| -> Vec<f64> {
        let sign = if i == 1 { SIGN } else { 1.0 };
        smooth(&pairs.iter().map(|p| sign * p[i]).collect::<Vec<_>>())
    };
    let q = [0, 1].map(|i| column(&trace.interface, i));
    let force = [0, 1].map(|i| column(&trace.force, i));
    let n = q[0].len().saturating_sub(2);
    let value = |c: usize, k: usize| {
        let x = &q[c % 2];
        match c / 2 {
            0 => x[k],
            1 => (x[k + 1] - x[k - 1]) / (2.0 * PERIOD_S),
            _ => (x[k + 1] - 2.0 * x[k] + x[k - 1]) / (PERIOD_S * PERIOD_S),
        }
    };
    let scale: Vec<f64> = (0..6)
        .map(|c| (1..=n).map(|k| value(c, k).powi(2)).sum::<f64>().sqrt())
        .collect();
    let a = DMatrix::from_fn(n, 6, |k, c| value(c, k + 1) / scale[c]);
    let solver = (a.transpose() * &a)
        .cholesky()
        .ok_or_else(|| Refused::new("marths: in this record nothing moves"))?;
    let row = |i: usize| {
        let b = DMatrix::from_fn(n, 1, |k, _| force[i][k + 1]);
        let x = solver.solve(&(a.transpose() * b));
        let x: Vec<f64> = (0..6).map(|c| x[c] / scale[c]).collect();
        x
    };
    let rows = [row(0), row(1)];
    let matrix = |first: usize| Matrix2::from_fn(|i, j| rows[i][first + j]);
    let even = |m: Matrix2<f64>| 0.5 * (m + m.transpose());
    let mass = matrix(4);
    Ok(Found {
        mass: Matrix2::from_diagonal(&Vector2::new(mass[(0, 0)], mass[(1, 1)])),
        damping: even(matrix(2)),
        stiffness: even(matrix(0)),
    })
}

/// What is subtracted as physical, and what a tracker without any error then has for J7.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Floor {
    /// What is subtracted.
    pub subtracted: &'static str,
    /// J7 of x and rotation, per cent.
    #[serde(rename = "J7")]
    pub j7: Both,
}

/// J7 of a tracker without any error.
///
/// # Errors
/// A structure that cannot be integrated.
pub fn floor(reference: &Matrices, part: &Part, ground: &[f64]) -> Result<Both, Refused> {
    let exact = computed(reference, ground)?;
    let tracked = without_error(&reference.less(part), ground)?;
    let column = |t: &Trace, i: usize| t.numerical.iter().map(|p| p[i]).collect::<Vec<_>>();
    Ok([0, 1].map(|i| deviation(&column(&tracked, i), &column(&exact, i))))
}

/// The floor as declared, then with one part after the other as it was found.
///
/// # Errors
/// A structure that cannot be integrated.
pub fn floors(reference: &Matrices, found: &Found, ground: &[f64]) -> Result<Vec<Floor>, Refused> {
    let declared = Part::declared();
    let mut mass = declared.clone();
    mass.mass[(0, 0)] = found.mass[(0, 0)];
    // x and the controlled rotation of what was declared, without the other rotation.
    let two = |m: &nalgebra::Matrix3<f64>| Matrix2::new(m[(0, 0)], m[(0, 2)], m[(2, 0)], m[(2, 2)]);
    let (declared_mass, declared_damping) = (two(&declared.mass), two(&declared.damping));
    let steps = [
        ("as declared", declared),
        ("mass as found", mass),
        (
            "stiffness as found, none at the free rotation",
            Part::of_two(&declared_mass, &declared_damping, &found.stiffness),
        ),
        (
            "the same, and mass",
            Part::of_two(&found.mass, &declared_damping, &found.stiffness),
        ),
        (
            "the same, and damping",
            Part::of_two(&found.mass, &found.damping, &found.stiffness),
        ),
    ];
    steps
        .into_iter()
        .map(|(subtracted, part)| {
            Ok(Floor {
                subtracted,
                j7: floor(reference, &part, ground)?,
            })
        })
        .collect()
}
