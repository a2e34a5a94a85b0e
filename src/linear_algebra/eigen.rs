//! Eigenvalues of small symmetric matrices by the cyclic Jacobi method (Golub and Van Loan, section 8.5).

use super::non_negative_root;
use crate::scalar::Real;
use nalgebra::{SMatrix, SVector};

/// Sweeps over all off-diagonal entries. Convergence is quadratic: 6x6 matrices of full dynamic range take six.
const MAX_SWEEPS: usize = 10;

/// Eigenvalues, in no order, and unit eigenvectors as columns in the same order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eigen<T, const N: usize> {
    /// The eigenvalues.
    pub values: SVector<T, N>,
    /// The eigenvectors.
    pub vectors: SMatrix<T, N, N>,
}

/// All eigenvalues and eigenvectors of a symmetric matrix. Not finite where the matrix is not.
pub fn symmetric_eigen<T: Real, const N: usize>(matrix: &SMatrix<T, N, N>) -> Eigen<T, N> {
    let mut a = *matrix;
    let mut vectors = SMatrix::<T, N, N>::identity();
    for _ in 0..MAX_SWEEPS {
        let mut rotated = false;
        for p in 0..N {
            for q in p + 1..N {
                let (app, aqq, apq) = (a[(p, p)], a[(q, q)], a[(p, q)]);
                // Also false for NaN.
                if !(apq.abs() > T::default_epsilon() * non_negative_root((app * aqq).abs())) {
                    continue;
                }
                rotated = true;
                // The smaller of the two angles that make the entry vanish.
                let theta = (aqq - app) / (apq + apq);
                let sign = if theta < T::zero() { -T::one() } else { T::one() };
                let t = sign / (theta.abs() + (theta * theta + T::one()).root());
                let c = T::one() / (t * t + T::one()).root();
                let s = t * c;
                for k in 0..N {
                    let (x, y) = (a[(k, p)], a[(k, q)]);
                    a[(k, p)] = c * x - s * y;
                    a[(k, q)] = s * x + c * y;
                }
                for k in 0..N {
                    let (x, y) = (a[(p, k)], a[(q, k)]);
                    a[(p, k)] = c * x - s * y;
                    a[(q, k)] = s * x + c * y;
                    let (x, y) = (vectors[(k, p)], vectors[(k, q)]);
                    vectors[(k, p)] = c * x - s * y;
                    vectors[(k, q)] = s * x + c * y;
                }
            }
        }
        if !rotated {
            break;
        }
    }
    Eigen { values: a.diagonal(), vectors }
}

/// The largest eigenvalue and its unit eigenvector.
pub fn largest_eigenpair<T: Real, const N: usize>(matrix: &SMatrix<T, N, N>) -> (T, SVector<T, N>) {
    let eigen = symmetric_eigen(matrix);
    let mut largest = 0;
    for k in 1..N {
        if eigen.values[k] > eigen.values[largest] {
            largest = k;
        }
    }
    let direction = eigen.vectors.data.0.get(largest).map_or_else(SVector::zeros, |column| (*column).into());
    (eigen.values[largest], direction)
}
