//! Symmetric 3x3 matrices: what is known of a point, and how well.
//!
//! Six numbers instead of nine, and closed forms instead of loops: the inverse by the adjugate, the largest eigenvalue
//! by squaring. Products that are wanted in several places are calls, not inlined: each is a hundred bytes of code.

use crate::calls::unit;
use crate::scalar::Real;
use crate::vector::dot;
use nalgebra::{Matrix3, Vector3};

/// A symmetric 3x3 matrix: xx, yx, yy, zx, zy, zz.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Symmetric<T>(pub [T; 6]);

impl<T: Real> Symmetric<T> {
    /// Nothing.
    pub fn zero() -> Self {
        Self([T::zero(); 6])
    }

    /// The identity times `value`.
    pub fn diagonal(value: T) -> Self {
        let zero = T::zero();
        Self([value, zero, value, zero, zero, value])
    }

    /// The matrix in full.
    #[inline(never)]
    pub fn to_matrix(&self) -> Matrix3<T> {
        let [xx, yx, yy, zx, zy, zz] = self.0;
        Matrix3::new(xx, yx, zx, yx, yy, zy, zx, zy, zz)
    }

    /// Adds `weight` a aᵀ.
    #[inline(always)]
    pub fn add_square(&mut self, a: &Vector3<T>) {
        let [xx, yx, yy, zx, zy, zz] = &mut self.0;
        *xx += a.x * a.x;
        *yx += a.y * a.x;
        *yy += a.y * a.y;
        *zx += a.z * a.x;
        *zy += a.z * a.y;
        *zz += a.z * a.z;
    }

    /// Adds another matrix times `weight`.
    #[inline(never)]
    pub fn add(&mut self, other: &Self, weight: T) {
        for (entry, other) in self.0.iter_mut().zip(&other.0) {
            *entry += *other * weight;
        }
    }

    /// The image of a vector.
    #[inline(never)]
    pub fn image(&self, a: &Vector3<T>) -> Vector3<T> {
        let [xx, yx, yy, zx, zy, zz] = self.0;
        Vector3::new(xx * a.x + yx * a.y + zx * a.z, yx * a.x + yy * a.y + zy * a.z, zx * a.x + zy * a.y + zz * a.z)
    }

    /// The product with `right`, column by column.
    #[inline(never)]
    pub fn times(&self, right: &Matrix3<T>) -> Matrix3<T> {
        let mut product = *right;
        for column in &mut product.data.0 {
            *column = self.image(&Vector3::from(*column)).into();
        }
        product
    }

    /// `left`ᵀ `right`, where that is symmetric.
    #[inline(never)]
    pub fn gram(left: &Matrix3<T>, right: &Matrix3<T>) -> Self {
        let mut gram = Self::zero();
        let mut entries = gram.0.iter_mut();
        for (i, a) in left.data.0.iter().enumerate() {
            for (b, entry) in right.data.0.iter().take(i + 1).zip(entries.by_ref()) {
                *entry = dot(&Vector3::from(*a), &Vector3::from(*b));
            }
        }
        gram
    }

    /// The adjugate: the inverse times the determinant, and also there when the determinant is zero.
    #[inline(never)]
    pub fn adjugate(&self) -> Self {
        let [xx, yx, yy, zx, zy, zz] = self.0;
        Self([
            yy * zz - zy * zy,
            zx * zy - yx * zz,
            xx * zz - zx * zx,
            yx * zy - zx * yy,
            yx * zx - xx * zy,
            xx * yy - yx * yx,
        ])
    }

    /// The inverse of a matrix that elimination has left of `of` (itself, if of none).
    ///
    /// `None` when a pivot is not larger than the part `smallest` of the diagonal entry that it came from, or is not a
    /// number.
    #[inline(never)]
    pub fn inverse(&self, of: &Self, smallest: T) -> Option<Self> {
        let adjugate = self.adjugate();
        let ([xx, yx, _, zx, ..], [first, _, second, .., third]) = (self.0, of.0);
        let [c11, c21, _, c31, _, minor] = adjugate.0;
        let determinant = xx * c11 + yx * c21 + zx * c31;
        // The pivots are the quotients of the leading minors. Written as products, and so that NaN is refused.
        let regular = xx > first * smallest && minor > second * smallest * xx && determinant > third * smallest * minor;
        regular.then(|| Self(adjugate.0.map(|cofactor| cofactor / determinant)))
    }

    /// The largest eigenvalue and its direction, a unit vector; no direction where there is none.
    ///
    /// The matrix is squared so many times: 2^n rounds of a power iteration in the time of n.
    #[inline(never)]
    pub fn largest(&self, squarings: usize) -> (T, Vector3<T>) {
        let zero = T::zero();
        let mut power = *self;
        for _ in 0..squarings {
            let [xx, _, yy, .., zz] = power.0;
            let scale = T::one() / (xx + yy + zz);
            // A zero, an infinity or a NaN: there is no direction.
            if !(scale > zero && scale.is_a_number()) {
                break;
            }
            power.0.iter_mut().for_each(|entry| *entry *= scale);
            let matrix = power.to_matrix();
            power = Self::gram(&matrix, &matrix);
        }
        // Every column is along that direction; the longest holds the most digits.
        let [x, y, z] = power.to_matrix().data.0.map(Vector3::from);
        let column = if x.x >= y.y && x.x >= z.z {
            x
        } else if y.y >= z.z {
            y
        } else {
            z
        };
        let direction = unit(&column);
        (dot(&self.image(&direction), &direction), direction)
    }
}
