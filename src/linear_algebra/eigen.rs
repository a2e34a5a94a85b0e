//! Eigenvalues of small symmetric matrices by the cyclic Jacobi method (Golub and Van Loan, section 8.5).

use super::non_negative_root;
use crate::scalar::Real;
use nalgebra::{SMatrix, SVector};

/// Sweeps over all off-diagonal entries. Convergence is quadratic: 6x6 matrices of full dynamic range take six.
const MAX_SWEEPS: u8 = 10;

/// Eigenvalues, in no order, and unit eigenvectors as columns in the same order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eigen<T, const N: usize> {
    /// The eigenvalues.
    pub values: SVector<T, N>,
    /// The eigenvectors.
    pub vectors: SMatrix<T, N, N>,
}

/// The eigenvalues of a symmetric matrix as they are found, a row of a sweep a call, for callers that must not do all of
/// it at once.
#[derive(Clone, Copy, Debug)]
pub struct EigenSearch<T, const N: usize> {
    a: SMatrix<T, N, N>,
    vectors: SMatrix<T, N, N>,
    sweeps: u8,
    row: u8,
    has_rotated: bool,
}

impl<T: Real, const N: usize> EigenSearch<T, N> {
    /// Begins.
    pub fn new(matrix: &SMatrix<T, N, N>) -> Self {
        Self { a: *matrix, vectors: SMatrix::identity(), sweeps: 0, row: 0, has_rotated: false }
    }

    /// The next row of a sweep; true when nothing is left to rotate.
    pub fn advance(&mut self) -> bool {
        let row = usize::from(self.row);
        for q in row + 1..N {
            self.has_rotated |= self.rotate(row, q);
        }
        self.row += 1;
        if row + 1 < N {
            return false;
        }
        self.sweeps += 1;
        let is_over = !self.has_rotated || self.sweeps >= MAX_SWEEPS;
        (self.row, self.has_rotated) = (0, false);
        is_over
    }

    /// What was found so far.
    pub fn eigen(&self) -> Eigen<T, N> {
        Eigen { values: self.a.diagonal(), vectors: self.vectors }
    }

    /// Makes an entry vanish; false where it has.
    fn rotate(&mut self, p: usize, q: usize) -> bool {
        let Self { a, vectors, .. } = self;
        let (app, aqq, apq) = (a[(p, p)], a[(q, q)], a[(p, q)]);
        // Also false for NaN.
        if !(apq.abs() > T::default_epsilon() * non_negative_root((app * aqq).abs())) {
            return false;
        }
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
        true
    }
}

/// All eigenvalues and eigenvectors of a symmetric matrix. Not finite where the matrix is not.
pub fn symmetric_eigen<T: Real, const N: usize>(matrix: &SMatrix<T, N, N>) -> Eigen<T, N> {
    let mut search = EigenSearch::new(matrix);
    while !search.advance() {}
    search.eigen()
}

impl<T: Real, const N: usize> Eigen<T, N> {
    /// The largest eigenvalue and its unit eigenvector.
    pub fn largest(&self) -> (T, SVector<T, N>) {
        let mut largest = 0;
        for k in 1..N {
            if self.values[k] > self.values[largest] {
                largest = k;
            }
        }
        let direction = self.vectors.data.0.get(largest).map_or_else(SVector::zeros, |column| (*column).into());
        (self.values[largest], direction)
    }
}

/// The largest eigenvalue and its unit eigenvector.
pub fn largest_eigenpair<T: Real, const N: usize>(matrix: &SMatrix<T, N, N>) -> (T, SVector<T, N>) {
    symmetric_eigen(matrix).largest()
}
