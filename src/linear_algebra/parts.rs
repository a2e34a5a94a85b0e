//! Columns and blocks of matrices by value, with no way to a panic: nalgebra's `into_owned` of a view has one.

use crate::scalar::Real;
use nalgebra::{Matrix3, Matrix6, Vector3};

/// Column `j` of a matrix, from 0; zero beside it.
pub fn column<T: Real>(matrix: &Matrix3<T>, j: usize) -> Vector3<T> {
    matrix.data.0.get(j).map_or_else(Vector3::zeros, |column| (*column).into())
}

/// The 3x3 block of a 6x6 matrix that begins at row `I`, column `J`.
pub fn block<T: Real, const I: usize, const J: usize>(matrix: &Matrix6<T>) -> Matrix3<T> {
    const { assert!(I <= 3 && J <= 3) };
    let of_column = |j: usize| {
        let [x, y, z] = core::array::from_fn(|i| matrix.data.0[J + j][I + i]);
        Vector3::new(x, y, z)
    };
    Matrix3::from_columns(&[of_column(0), of_column(1), of_column(2)])
}
