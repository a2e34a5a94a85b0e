//! The least-squares step: `X = (DᵀD)⁻¹ Dᵀ Y` (Eq. 15), with the normal matrix inverted explicitly.

use super::Failure;
use nalgebra::{RealField, convert};

/// `X` of Eq. 15 for the stacked rows `d` and residues `y_mm` (Eq. 14), in mm.
///
/// # Errors
/// [`Failure::SingularNormalMatrix`] when `DᵀD` has no inverse in this precision.
pub fn least_squares<T: RealField + Copy>(d: &[[T; 6]], y_mm: &[T]) -> Result<[T; 6], Failure> {
    let mut normal = [[T::zero(); 6]; 6];
    let mut right = [T::zero(); 6];
    for (row, &y) in d.iter().zip(y_mm) {
        for i in 0..6 {
            for j in 0..6 {
                normal[i][j] += row[i] * row[j];
            }
            right[i] += row[i] * y;
        }
    }
    let inverse = invert_6x6(&normal).ok_or(Failure::SingularNormalMatrix)?;
    let mut x = [T::zero(); 6];
    for i in 0..6 {
        for j in 0..6 {
            x[i] += inverse[i][j] * right[j];
        }
    }
    Ok(x)
}

/// The inverse by Gauss-Jordan elimination with partial pivoting; `None` when singular.
///
/// Singular means that the best pivot left is below 1e-9 of the largest entry of the matrix, or below 32 roundings of it
/// where those are coarser (`f32`). All six unknowns are lengths, so `DᵀD` is dimensionless and its entries compare.
/// Measured at the truth over random machines: poses about one axis leave a last pivot below 1e-9, three poses within
/// ±10 degrees of home one above 1e-6. It is a test of rounding, not of whether the poses determine the centre well:
/// away from the truth, `D` of poses about one axis has full rank.
pub fn invert_6x6<T: RealField + Copy>(matrix: &[[T; 6]; 6]) -> Option<[[T; 6]; 6]> {
    let mut left = *matrix;
    let mut right = [[T::zero(); 6]; 6];
    let mut largest = T::zero();
    for i in 0..6 {
        right[i][i] = T::one();
        for entry in left[i] {
            largest = largest.max(entry.abs());
        }
    }
    let smallest_pivot = largest * convert::<f64, T>(1e-9).max(T::default_epsilon() * convert(32.0));

    for column in 0..6 {
        let mut pivot_row = column;
        for row in column + 1..6 {
            if left[row][column].abs() > left[pivot_row][column].abs() {
                pivot_row = row;
            }
        }
        left.swap(column, pivot_row);
        right.swap(column, pivot_row);
        let pivot = left[column][column];
        if pivot.abs() <= smallest_pivot || !pivot.is_finite() {
            return None;
        }
        for j in 0..6 {
            left[column][j] /= pivot;
            right[column][j] /= pivot;
        }
        for row in 0..6 {
            if row == column {
                continue;
            }
            let factor = left[row][column];
            for j in 0..6 {
                let (above, beside) = (left[column][j], right[column][j]);
                left[row][j] -= factor * above;
                right[row][j] -= factor * beside;
            }
        }
    }
    Some(right)
}
