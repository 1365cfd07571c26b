//! The reference structure, its declared physical part, and the numerical rest.

use super::{GROUND_SCALE, PERIOD_S};
use crate::Refused;
use nalgebra::{DMatrix, Matrix2, Matrix3, SMatrix, SVector, SymmetricEigen};
use outerloop_core::coupled::VibrationMode;

/// Degrees of freedom.
pub const DOF: usize = 29;
/// x of the interface, counted from 0.
pub const X: usize = 26;
/// Rotation of the interface that the rig controls.
pub const ROTATION: usize = 20;
/// Rotation of the other end of the beam, which nothing controls.
pub const FREE_ROTATION: usize = 28;
/// x of the second and third storey.
pub const STOREYS: [usize; 2] = [25, 12];

/// Degrees of freedom of a [`PhysicalMatrices`], in its order.
const INTERFACE: [usize; 3] = [X, FREE_ROTATION, ROTATION];

/// A matrix of the whole structure.
pub type Whole = SMatrix<f64, DOF, DOF>;
type Vector = SVector<f64, DOF>;

/// Mass, damping and stiffness in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameMatrices {
    /// kg, kg m^2.
    pub mass: Whole,
    /// N s/m, and the matching units for rotation.
    pub damping: Whole,
    /// N/m, and the matching units for rotation.
    pub stiffness: Whole,
}

/// The matrix that turns a kind of motion into a force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatrixKind {
    /// For acceleration.
    Mass,
    /// For velocity.
    Damping,
    /// For displacement.
    Stiffness,
}

/// Mass, damping and stiffness in the laboratory, for x, the free rotation and the controlled one.
#[derive(Clone, Debug, PartialEq)]
pub struct PhysicalMatrices {
    /// kg, kg m^2.
    pub mass: Matrix3<f64>,
    /// N s/m, and the matching units for rotation.
    pub damping: Matrix3<f64>,
    /// N/m, and the matching units for rotation.
    pub stiffness: Matrix3<f64>,
}

/// Factors of mass and stiffness for Rayleigh damping with the given ratio at two angular frequencies.
fn rayleigh(ratio: f64, at_rad_per_s: [f64; 2]) -> [f64; 2] {
    let [a, b] = at_rad_per_s;
    [2.0 * ratio * a * b / (a + b), 2.0 * ratio / (a + b)]
}

impl FrameMatrices {
    /// The reference, from the problem's two CSV tables of 29 by 29 numbers.
    ///
    /// # Errors
    /// A table of another size, or a cell that is not a finite number.
    pub fn parse(stiffness_csv: &str, mass_csv: &str) -> Result<Self, Refused> {
        let (stiffness, mass) = (table("stiffness", stiffness_csv)?, table("mass", mass_csv)?);
        let [m, k] = rayleigh(0.05, [13.493, 165.125]);
        Ok(Self {
            damping: mass * m + stiffness * k,
            mass,
            stiffness,
        })
    }

    /// The numerical part that is left when `part` is in the laboratory.
    #[must_use]
    pub fn less(&self, part: &PhysicalMatrices) -> Self {
        let mut rest = self.clone();
        rest.add(-1.0, part);
        rest
    }

    /// `part` without masses at degrees of freedom where the structure has none: a negative mass cannot be integrated with
    /// a force that comes a sample late.
    #[must_use]
    pub fn held_by(&self, part: &PhysicalMatrices) -> PhysicalMatrices {
        let heavy = |i: usize| self.mass[(INTERFACE[i], INTERFACE[i])] > 0.0;
        let mut held = part.clone();
        held.mass = Matrix3::from_fn(|i, j| match heavy(i) && heavy(j) {
            true => part.mass[(i, j)],
            false => 0.0,
        });
        held
    }

    /// The structure with `part` added.
    #[must_use]
    pub fn plus(&self, part: &PhysicalMatrices) -> Self {
        let mut whole = self.clone();
        whole.add(1.0, part);
        whole
    }

    fn add(&mut self, sign: f64, part: &PhysicalMatrices) {
        for (i, &row) in INTERFACE.iter().enumerate() {
            for (j, &column) in INTERFACE.iter().enumerate() {
                self.mass[(row, column)] += sign * part.mass[(i, j)];
                self.damping[(row, column)] += sign * part.damping[(i, j)];
                self.stiffness[(row, column)] += sign * part.stiffness[(i, j)];
            }
        }
    }

    /// The `count` modes that are most visible in degree of freedom `at` when the ground shakes, by static condensation of
    /// the degrees of freedom without mass.
    pub fn modes(&self, at: usize, count: usize) -> Vec<VibrationMode> {
        let heavy: Vec<usize> = (0..DOF).filter(|&i| self.mass[(i, i)] > 0.0).collect();
        let light: Vec<usize> = (0..DOF).filter(|&i| self.mass[(i, i)] <= 0.0).collect();
        let pick = |rows: &[usize], columns: &[usize]| {
            DMatrix::from_fn(rows.len(), columns.len(), |i, j| {
                self.stiffness[(rows[i], columns[j])]
            })
        };
        // Light degrees of freedom follow the heavy ones: u_l = -K_ll^-1 K_lh u_h.
        let Some(solver) = pick(&light, &light).cholesky() else {
            return Vec::new();
        };
        let follow = -solver.solve(&pick(&light, &heavy));
        let condensed = pick(&heavy, &heavy) + pick(&heavy, &light) * &follow;
        let root = |i: usize| self.mass[(heavy[i], heavy[i])].sqrt();
        let scaled = DMatrix::from_fn(heavy.len(), heavy.len(), |i, j| {
            condensed[(i, j)] / (root(i) * root(j))
        });
        let eigen = SymmetricEigen::new(0.5 * (&scaled + scaled.transpose()));
        let shaken = shaken();
        let [m, k] = rayleigh(0.05, [13.493, 165.125]);
        let mut modes: Vec<VibrationMode> = (0..heavy.len())
            .map(|r| {
                let shape =
                    DMatrix::from_fn(heavy.len(), 1, |i, _| eigen.eigenvectors[(i, r)] / root(i));
                let load: f64 = (0..heavy.len())
                    .map(|i| shape[i] * self.mass[(heavy[i], heavy[i])] * shaken[heavy[i]])
                    .sum();
                let shown = match heavy.iter().position(|&h| h == at) {
                    Some(i) => shape[i],
                    None => light
                        .iter()
                        .position(|&l| l == at)
                        .map_or(0.0, |i| (follow.row(i) * &shape)[0]),
                };
                let omega = eigen.eigenvalues[r].max(0.0).sqrt();
                VibrationMode {
                    omega_rad_per_s: omega,
                    damping_ratio: 0.5 * (m / omega + k * omega),
                    participation: -load * shown,
                }
            })
            .collect();
        modes.sort_by(|a, b| b.participation.abs().total_cmp(&a.participation.abs()));
        modes.truncate(count);
        modes.sort_by(|a, b| a.omega_rad_per_s.total_cmp(&b.omega_rad_per_s));
        modes
    }
}

impl PhysicalMatrices {
    /// The part that the problem declares to be in the laboratory: one bay with pinned feet, without vertical motion. Its
    /// density is a hundred times that of steel, as published. Rotations keep their stiffness and damping but lose their mass.
    pub fn declared() -> Self {
        let inch4 = 0.0254_f64.powi(4);
        let inch2 = 0.0254_f64.powi(2);
        let (beam, column) = (0.762, 0.635);
        let (column_i, beam_i) = (2.520 * inch4, 0.6132 * inch4);
        let (young, density) = (200e9, 785e3);
        let beam_kg = density * 0.947 * inch2 * beam;
        let column_kg = density * 1.670 * inch2 * column;
        let mass = beam_kg + column_kg;
        let inertia = (beam_kg * beam * beam + column_kg * column * column) / 24.0;
        let sway = -3.0 * young * column_i / (column * column);
        let corner = 3.0 * young * column_i / column + 4.0 * young * beam_i / beam;
        let across = -2.0 * young * beam_i / beam;
        let stiffness = Matrix3::new(
            6.0 * young * column_i / column.powi(3),
            sway,
            sway,
            sway,
            corner,
            across,
            sway,
            across,
            corner,
        );
        let whole = Matrix3::from_diagonal(&[mass, inertia, inertia].into());
        let root = whole.map(|m| if m > 0.0 { 1.0 / m.sqrt() } else { 0.0 });
        let squares = SymmetricEigen::new(root * stiffness * root).eigenvalues;
        let [m, k] = rayleigh(0.05, [squares.min().sqrt(), squares.max().sqrt()]);
        Self {
            mass: Matrix3::from_diagonal(&[mass, 0.0, 0.0].into()),
            damping: whole * m + stiffness * k,
            stiffness,
        }
    }

    /// The three matrices from a function for their entries.
    pub fn from_fn(entry: impl Fn(MatrixKind, usize, usize) -> f64) -> Self {
        let matrix = |kind| Matrix3::from_fn(|i, j| entry(kind, i, j));
        Self {
            mass: matrix(MatrixKind::Mass),
            damping: matrix(MatrixKind::Damping),
            stiffness: matrix(MatrixKind::Stiffness),
        }
    }

    /// One of the three matrices.
    pub fn matrix(&self, kind: MatrixKind) -> &Matrix3<f64> {
        match kind {
            MatrixKind::Mass => &self.mass,
            MatrixKind::Damping => &self.damping,
            MatrixKind::Stiffness => &self.stiffness,
        }
    }

    /// A part without the free rotation, from matrices for x and the controlled rotation in the structure's sign.
    pub fn of_two([mass, damping, stiffness]: &[Matrix2<f64>; 3]) -> Self {
        // Index of x and of the controlled rotation in the small matrices.
        let two = |i: usize| [Some(0), None, Some(1)][i];
        Self::from_fn(|kind, i, j| {
            let matrix = match kind {
                MatrixKind::Mass => mass,
                MatrixKind::Damping => damping,
                MatrixKind::Stiffness => stiffness,
            };
            two(i).zip(two(j)).map_or(0.0, |at| matrix[at])
        })
    }
}

/// Degrees of freedom that the ground shakes: x of the three storeys.
fn shaken() -> Vector {
    let mut l = Vector::zeros();
    for at in [X, STOREYS[0], STOREYS[1]] {
        l[at] = 1.0;
    }
    l
}

fn table(name: &str, csv: &str) -> Result<Whole, Refused> {
    let mut all = Whole::zeros();
    let mut rows = 0;
    for (row, line) in csv.lines().filter(|l| !l.trim().is_empty()).enumerate() {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        if row >= DOF || cells.len() != DOF {
            return Err(Refused::new(format!(
                "the {name} table of the frame has {} numbers in line {}: accepted are {DOF} lines of {DOF}",
                cells.len(),
                row + 1
            )));
        }
        for (column, cell) in cells.iter().enumerate() {
            all[(row, column)] = cell
                .parse::<f64>()
                .ok()
                .filter(|x| x.is_finite())
                .ok_or_else(|| {
                    Refused::new(format!(
                        "the {name} table of the frame has `{cell}` in line {}: accepted is a finite number",
                        row + 1
                    ))
                })?;
        }
        rows = row + 1;
    }
    if rows != DOF {
        return Err(Refused::new(format!(
            "the {name} table of the frame has {rows} lines: accepted are {DOF}"
        )));
    }
    Ok(all)
}

/// Integration by constant average acceleration, as in the publication.
#[derive(Clone, Debug)]
pub struct Newmark {
    mass: Whole,
    /// Whether the mass is diagonal, as the published one is; then its diagonal is enough.
    lumped: bool,
    damping: Whole,
    flexible: Whole,
    load: Vector,
    displacement: Vector,
    velocity: Vector,
    acceleration: Vector,
}

impl Newmark {
    /// An integration from rest.
    ///
    /// # Errors
    /// A dynamic stiffness that cannot be inverted.
    pub fn new(matrices: &FrameMatrices) -> Result<Self, Refused> {
        let dynamic = matrices.stiffness
            + matrices.mass * (4.0 / (PERIOD_S * PERIOD_S))
            + matrices.damping * (2.0 / PERIOD_S);
        let flexible = dynamic
            .try_inverse()
            .ok_or_else(|| Refused::new("marths: the numerical part cannot be integrated"))?;
        Ok(Self {
            load: matrices.mass * shaken(),
            lumped: Whole::from_diagonal(&matrices.mass.diagonal()) == matrices.mass,
            mass: matrices.mass,
            damping: matrices.damping,
            flexible,
            displacement: Vector::zeros(),
            velocity: Vector::zeros(),
            acceleration: Vector::zeros(),
        })
    }

    /// Lets the ground shake the mass of `matrices` instead of its own.
    pub fn shake(&mut self, matrices: &FrameMatrices) {
        self.load = matrices.mass * shaken();
    }

    /// Advances by one sample. `ground_m_per_s2` is the ground's acceleration, used without a scale; `resisting` is the
    /// specimen's force on x (N) and moment on the controlled rotation (N m).
    pub fn step(&mut self, ground_m_per_s2: f64, resisting: [f64; 2]) {
        let (a, b) = (4.0 / (PERIOD_S * PERIOD_S), 2.0 / PERIOD_S);
        let (u, v, w) = (&self.displacement, &self.velocity, &self.acceleration);
        let moved = u * a + v * (2.0 * b) + w;
        let inertia = if self.lumped {
            moved.component_mul(&self.mass.diagonal())
        } else {
            self.mass * moved
        };
        let mut load = inertia + self.damping * (u * b + v) - self.load * ground_m_per_s2;
        load[X] -= resisting[0];
        load[ROTATION] -= resisting[1];
        let next = self.flexible * load;
        let acceleration = (next - u) * a - v * (2.0 * b) - w;
        self.velocity += (acceleration + w) * (0.5 * PERIOD_S);
        self.acceleration = acceleration;
        self.displacement = next;
    }

    /// Displacement of a degree of freedom, m or rad.
    pub fn at(&self, dof: usize) -> f64 {
        self.displacement[dof]
    }
}

/// A ground motion at the samples of the problem, with the problem's scale, m/s^2.
pub fn sampled(points_m_per_s2: &[f64], interval_s: f64) -> Vec<f64> {
    let end_s = points_m_per_s2.len().saturating_sub(1) as f64 * interval_s;
    let samples = (end_s / PERIOD_S).floor() as usize + 1;
    let at = |i: usize| points_m_per_s2.get(i).copied().unwrap_or(0.0);
    (0..samples)
        .map(|k| {
            let place = k as f64 * PERIOD_S / interval_s;
            let i = place.floor();
            let rise = at(i as usize + 1) - at(i as usize);
            GROUND_SCALE * (at(i as usize) + (place - i) * rise)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_declared_part_is_the_published_one() {
        let part = PhysicalMatrices::declared();
        assert!((part.mass[(0, 0)] - 902.527).abs() < 1e-2);
        assert!((part.stiffness[(0, 0)] - 4_915_814.0).abs() < 10.0);
        assert!((part.stiffness[(2, 1)] + 133_981.0).abs() < 1.0);
    }

    #[test]
    fn a_table_of_another_size_is_refused_by_its_line() {
        let error = FrameMatrices::parse("1,2\n", "").unwrap_err().to_string();
        assert!(error.contains("has 2 numbers in line 1"), "{error}");
        let row = vec!["x"; DOF].join(",");
        let error = FrameMatrices::parse(&row, "").unwrap_err().to_string();
        assert!(error.contains("`x` in line 1"), "{error}");
    }
}
