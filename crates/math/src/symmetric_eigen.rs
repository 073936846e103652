//! Eigenvalues of symmetric 3x3 matrices.

use glam::{DMat3, DVec3};

/// Eigenvalues and eigenvectors (columns of a rotation) of a symmetric matrix, in the order in
/// which the eigenvectors lie nearest to x, y and z: a diagonal matrix gives no rotation.
///
/// Cyclic Jacobi rotations [Golub & Van Loan, Matrix Computations, sec. 8.5] keep small eigenvalues
/// accurate beside large ones.
pub fn symmetric_eigen(matrix: &DMat3) -> (DVec3, DMat3) {
    // Maximum number of sweeps: convergence is quadratic, and a dozen sweeps always suffice.
    const MAX_SWEEPS: usize = 12;
    let mut tensor = matrix.to_cols_array_2d();
    let mut axes = DMat3::IDENTITY.to_cols_array_2d();
    for _ in 0..MAX_SWEEPS {
        let mut diagonal = true;
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            diagonal &= !rotate_away(&mut tensor, &mut axes, p, q);
        }
        if diagonal {
            break;
        }
    }
    (DVec3::new(tensor[0][0], tensor[1][1], tensor[2][2]), DMat3::from_cols_array_2d(&axes))
}

/// One Jacobi rotation in the plane of axes `p` and `q`, by at most 45 degrees, after which
/// `tensor[p][q]` vanishes. Columns of `axes` turn along. False if there was nothing to do.
fn rotate_away(tensor: &mut [[f64; 3]; 3], axes: &mut [[f64; 3]; 3], p: usize, q: usize) -> bool {
    let off = tensor[p][q];
    // Relative to both moments, so that a small one is resolved as well as a large one.
    let product = (tensor[p][p] * tensor[q][q]).abs();
    if off == 0.0 || off * off <= f64::EPSILON * f64::EPSILON * 1e-2 * product {
        return false;
    }
    let theta = (tensor[q][q] - tensor[p][p]) / (2.0 * off);
    let tangent =
        1.0 / (theta.abs() + (theta * theta + 1.0).sqrt()) * if theta < 0.0 { -1.0 } else { 1.0 };
    let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
    let sine = tangent * cosine;

    tensor[p][p] -= tangent * off;
    tensor[q][q] += tangent * off;
    tensor[p][q] = 0.0;
    tensor[q][p] = 0.0;
    let r = 3 - p - q;
    let (along_p, along_q) = (tensor[r][p], tensor[r][q]);
    tensor[r][p] = cosine * along_p - sine * along_q;
    tensor[r][q] = sine * along_p + cosine * along_q;
    tensor[p][r] = tensor[r][p];
    tensor[q][r] = tensor[r][q];
    for row in 0..3 {
        let (along_p, along_q) = (axes[p][row], axes[q][row]);
        axes[p][row] = cosine * along_p - sine * along_q;
        axes[q][row] = sine * along_p + cosine * along_q;
    }
    true
}
