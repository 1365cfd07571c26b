//! A frame made up here for the multi-axial benchmark, so that a copy of this repository without the problem's files can check
//! a bound of its figures.
//!
//! Three storeys and three bays of Euler-Bernoulli beams and columns; columns are axially flexible, beams are not. In the first
//! storey of the middle bay, which is in the laboratory, the columns have the declared section and pinned feet. Sections are of
//! the published order of magnitude; no number comes from the problem's tables.

use benchmarks::marths::structure::{DOF, FREE_ROTATION, ROTATION, STOREYS, X};
use std::fmt::Write as _;

/// Columns of the frame, from the left.
const LINES: usize = 4;
/// Height of a storey and width of a bay, m.
const HEIGHT_M: f64 = 0.635;
const BAY_M: f64 = 0.762;
/// Bending stiffness of the columns, of those with pinned feet, and of the beams from the left (outer, middle, outer bay), N m^2.
const COLUMN_N_M2: f64 = 8e5;
const PINNED_N_M2: f64 = 2.1e5;
const BEAMS_N_M2: [f64; LINES - 1] = [2e4, 8e4, 2e4];
/// Axial stiffness of a column over its height, N/m.
const AXIAL_N_PER_M: f64 = 9e8;
/// Mass at a joint of the first floor, and at the joints of those above from the left, kg. It acts vertically at its joint and
/// horizontally on the floor.
const FIRST_KG: f64 = 2e3;
const ABOVE_KG: [f64; LINES] = [2e3, 4e3, 4e3, 2e3];

type Matrix = [[f64; DOF]; DOF];

/// Indices of the degrees of freedom: those that the loop uses are where the problem has them, the others take the rest.
struct Places {
    sway: [usize; 3],
    rotation: [[usize; LINES]; 3],
    vertical: [[usize; LINES]; 3],
    feet: [usize; 2],
}

impl Places {
    fn new() -> Self {
        let sway = [X, STOREYS[0], STOREYS[1]];
        let taken = [sway[0], sway[1], sway[2], ROTATION, FREE_ROTATION];
        let mut left = (0..DOF).filter(|i| !taken.contains(i));
        let mut next = || left.next().expect("29 degrees of freedom are as many");
        let mut rotation = [[0; LINES]; 3].map(|floor| floor.map(|_| next()));
        // The first floor's rotations at the middle bay are those that the loop uses: their two indices go to the feet instead.
        let feet = [rotation[0][1], rotation[0][2]];
        rotation[0][1] = FREE_ROTATION;
        rotation[0][2] = ROTATION;
        Self {
            sway,
            rotation,
            vertical: [[0; LINES]; 3].map(|floor| floor.map(|_| next())),
            feet,
        }
    }
}

/// Adds a bending element: deflection and rotation of one end, then of the other; `None`: fixed. `turned` is -1 if a positive
/// rotation is a negative slope.
fn bend(k: &mut Matrix, ends: [Option<usize>; 4], ei_n_m2: f64, l: f64, turned: f64) {
    let shape = [
        [12.0, 6.0 * l, -12.0, 6.0 * l],
        [6.0 * l, 4.0 * l * l, -6.0 * l, 2.0 * l * l],
        [-12.0, -6.0 * l, 12.0, -6.0 * l],
        [6.0 * l, 2.0 * l * l, -6.0 * l, 4.0 * l * l],
    ];
    let sign = [1.0, turned, 1.0, turned];
    for (i, row) in ends.iter().enumerate() {
        for (j, column) in ends.iter().enumerate() {
            if let (Some(row), Some(column)) = (row, column) {
                k[*row][*column] += sign[i] * sign[j] * shape[i][j] * ei_n_m2 / l.powi(3);
            }
        }
    }
}

/// Adds a column's axial stiffness.
fn press(k: &mut Matrix, lower: Option<usize>, upper: usize) {
    k[upper][upper] += AXIAL_N_PER_M;
    if let Some(lower) = lower {
        k[lower][lower] += AXIAL_N_PER_M;
        k[lower][upper] -= AXIAL_N_PER_M;
        k[upper][lower] -= AXIAL_N_PER_M;
    }
}

/// Stiffness and mass, N/m and kg.
fn matrices() -> [Matrix; 2] {
    let at = Places::new();
    let (mut k, mut m) = ([[0.0; DOF]; DOF], [[0.0; DOF]; DOF]);
    for floor in 0..3 {
        for line in 0..LINES {
            let (sway, turn) = (at.sway[floor], at.rotation[floor][line]);
            let upper = at.vertical[floor][line];
            let foot = (line == 1 || line == 2).then(|| at.feet[line - 1]);
            let below = floor.checked_sub(1);
            let lower = match below {
                Some(f) => [Some(at.sway[f]), Some(at.rotation[f][line])],
                None => [None, foot],
            };
            let pinned = below.is_none() && foot.is_some();
            let ei = if pinned { PINNED_N_M2 } else { COLUMN_N_M2 };
            let ends = [lower[0], lower[1], Some(sway), Some(turn)];
            bend(&mut k, ends, ei, HEIGHT_M, 1.0);
            press(&mut k, below.map(|f| at.vertical[f][line]), upper);
            let kg = if floor == 0 { FIRST_KG } else { ABOVE_KG[line] };
            m[upper][upper] += kg;
            m[sway][sway] += kg;
        }
        for (bay, ei) in BEAMS_N_M2.into_iter().enumerate() {
            let ends = [bay, bay + 1].map(|l| [at.vertical[floor][l], at.rotation[floor][l]]);
            let ends = [ends[0][0], ends[0][1], ends[1][0], ends[1][1]].map(Some);
            bend(&mut k, ends, ei, BAY_M, -1.0);
        }
    }
    [k, m]
}

/// The problem's files for this frame: stiffness, mass, and the start of a least squares without prior knowledge.
pub fn tables() -> [String; 3] {
    let [stiffness, mass] = matrices().map(|matrix| {
        let line = |row: &[f64; DOF]| row.map(|x| x.to_string()).join(",") + "\n";
        matrix.iter().map(line).collect()
    });
    let mut start = String::new();
    for actuator in [1, 2] {
        for tap in 0..4 {
            let row = |of: f64| [0, 1, 2, 3].map(|i| if i == tap { of } else { 0.0 });
            // It starts with the command equal to the target, and a large covariance; in mm.
            let _ = writeln!(start, "theta0_{actuator},{}", row(1.0)[0]);
            let covariance = row(1e5).map(|x| x.to_string()).join(",");
            let _ = writeln!(start, "P0_{actuator},{covariance}");
        }
    }
    [stiffness, mass, start]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_and_a_lift_of_the_whole_frame_strain_nothing_above_the_first_floor() {
        let ([k, _], at) = (matrices(), Places::new());
        let (mut turned, mut lifted) = ([0.0; DOF], [0.0; DOF]);
        for floor in 0..3 {
            turned[at.sway[floor]] = HEIGHT_M * (floor + 1) as f64;
            for line in 0..LINES {
                turned[at.rotation[floor][line]] = 1.0;
                turned[at.vertical[floor][line]] = -BAY_M * line as f64;
                lifted[at.vertical[floor][line]] = 1.0;
            }
        }
        let mut strained = 0;
        for (row, force) in k.iter().enumerate() {
            for motion in [&turned, &lifted] {
                let sum: f64 = force.iter().zip(motion).map(|(k, u)| k * u).sum();
                let above = (1..3).any(|f| {
                    at.sway[f] == row
                        || at.rotation[f].contains(&row)
                        || at.vertical[f].contains(&row)
                });
                assert!(!above || sum.abs() < 1e-3, "{row}: {sum} N");
                strained += usize::from(sum.abs() > 1e3);
            }
            assert!((0..DOF).all(|column| k[column][row] == force[column]));
        }
        // The columns of the first storey are strained: sway, rotating joints, lifted joints, and feet.
        assert!(strained >= 10, "{strained}");
    }
}
