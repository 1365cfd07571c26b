//! The little linear algebra of a configuration (f64, at most 8 by 8). Never called in the step.

/// A square matrix, row by row.
pub type Matrix<const N: usize> = [[f64; N]; N];

/// The zero matrix.
pub const fn zeros<const N: usize>() -> Matrix<N> {
    [[0.0; N]; N]
}

/// A matrix with `diagonal` on its diagonal.
pub fn diagonal<const N: usize>(diagonal: &[f64; N]) -> Matrix<N> {
    let mut m = zeros();
    for i in 0..N {
        m[i][i] = diagonal[i];
    }
    m
}

/// `a b`.
pub fn product<const N: usize>(a: &Matrix<N>, b: &Matrix<N>) -> Matrix<N> {
    let mut m = zeros();
    for i in 0..N {
        for j in 0..N {
            m[i][j] = (0..N).map(|k| a[i][k] * b[k][j]).sum();
        }
    }
    m
}

/// The transpose.
pub fn transpose<const N: usize>(a: &Matrix<N>) -> Matrix<N> {
    let mut m = zeros();
    for i in 0..N {
        for j in 0..N {
            m[i][j] = a[j][i];
        }
    }
    m
}

/// `a + factor b`.
pub fn sum<const N: usize>(a: &Matrix<N>, factor: f64, b: &Matrix<N>) -> Matrix<N> {
    let mut m = zeros();
    for i in 0..N {
        for j in 0..N {
            m[i][j] = a[i][j] + factor * b[i][j];
        }
    }
    m
}

/// The lower Cholesky factor, or `None` if the matrix is not symmetric positive definite.
pub fn cholesky<const N: usize>(a: &Matrix<N>) -> Option<Matrix<N>> {
    let mut l = zeros::<N>();
    for i in 0..N {
        for j in 0..=i {
            if (a[i][j] - a[j][i]).abs() > 1e-9 * (a[i][i].abs() + a[j][j].abs()) {
                return None;
            }
            let rest = a[i][j] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
            if i == j {
                if !(rest.is_finite() && rest > 1e-12 * a[i][i]) {
                    return None;
                }
                l[i][i] = libm::sqrt(rest);
            } else {
                l[i][j] = rest / l[j][j];
            }
        }
    }
    Some(l)
}

/// The inverse of a lower triangular matrix with a non-zero diagonal.
fn lower_inverse<const N: usize>(l: &Matrix<N>) -> Matrix<N> {
    let mut m = zeros::<N>();
    for j in 0..N {
        m[j][j] = 1.0 / l[j][j];
        for i in j + 1..N {
            m[i][j] = -(j..i).map(|k| l[i][k] * m[k][j]).sum::<f64>() / l[i][i];
        }
    }
    m
}

/// The inverse of a symmetric positive definite matrix, or `None` if it is not one.
pub fn inverse<const N: usize>(a: &Matrix<N>) -> Option<Matrix<N>> {
    let l = lower_inverse(&cholesky(a)?);
    Some(product(&transpose(&l), &l))
}

/// Natural modes of `k x = omega^2 m x`: angular frequencies in rad/s, ascending, and mass-normalised
/// mode shapes as columns. `None` unless `m` is symmetric positive definite.
pub fn modes<const N: usize>(m: &Matrix<N>, k: &Matrix<N>) -> Option<([f64; N], Matrix<N>)> {
    let l = lower_inverse(&cholesky(m)?);
    let mut a = product(&product(&l, k), &transpose(&l));
    let mut vectors = diagonal(&[1.0; N]);
    // Cyclic Jacobi: 8 by 8 converges in some 6 sweeps, quadratically at the end.
    for _ in 0..60 {
        for p in 0..N {
            for q in p + 1..N {
                rotate(&mut a, &mut vectors, p, q);
            }
        }
    }
    let shapes = product(&transpose(&l), &vectors);
    let mut order = [0usize; N];
    for (i, slot) in order.iter_mut().enumerate() {
        *slot = i;
    }
    order.sort_unstable_by(|&i, &j| a[i][i].total_cmp(&a[j][j]));
    let mut omegas = [0.0; N];
    let mut sorted = zeros();
    for (to, &from) in order.iter().enumerate() {
        omegas[to] = libm::sqrt(a[from][from].max(0.0));
        for row in 0..N {
            sorted[row][to] = shapes[row][from];
        }
    }
    Some((omegas, sorted))
}

/// One Jacobi rotation that makes `a[p][q]` vanish.
fn rotate<const N: usize>(a: &mut Matrix<N>, vectors: &mut Matrix<N>, p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = libm::copysign(1.0, theta) / (theta.abs() + libm::sqrt(theta * theta + 1.0));
    let c = 1.0 / libm::sqrt(t * t + 1.0);
    let s = t * c;
    for row in a.iter_mut() {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
    for column in 0..N {
        (a[p][column], a[q][column]) = (
            c * a[p][column] - s * a[q][column],
            s * a[p][column] + c * a[q][column],
        );
    }
    for row in vectors.iter_mut() {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;

    #[test]
    fn a_uniform_shear_frame_has_its_textbook_modes() {
        // omega_r = 2 sqrt(k/m) sin((2 r - 1) pi / (2 (2 n + 1))), Chopra.
        let k = [[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]];
        let m = diagonal(&[1.0; 3]);
        let (omegas, shapes) = modes(&m, &k).unwrap();
        for (r, omega) in omegas.iter().enumerate() {
            let angle = (2.0 * r as f64 + 1.0) * core::f64::consts::PI / 14.0;
            assert!((omega - 2.0 * angle.sin()).abs() < 1e-12);
        }
        let unit = product(&transpose(&shapes), &product(&m, &shapes));
        assert!((unit[1][1] - 1.0).abs() < 1e-12 && unit[0][2].abs() < 1e-12);
    }

    #[test]
    fn an_inverse_undoes_and_an_indefinite_matrix_is_refused() {
        let a = [[4.0, 1.0], [1.0, 3.0]];
        let unit = product(&a, &inverse(&a).unwrap());
        assert!((unit[0][0] - 1.0).abs() < 1e-15 && unit[0][1].abs() < 1e-15);
        assert!(inverse(&[[1.0, 2.0], [2.0, 1.0]]).is_none());
    }
}
