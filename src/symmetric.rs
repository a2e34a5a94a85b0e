//! Symmetric 3x3 matrices: what is known of a point, and how well.
//!
//! Six numbers instead of nine, the inverse by the adjugate, the largest eigenvalue by its own cubic equation. Products
//! that are wanted in several places are calls, not inlined: each is a hundred bytes of code.

use crate::calls::{root, unit};
use crate::scalar::Real;
use crate::vector::dot;
use nalgebra::{Matrix3, Vector3};

/// Rounds of Newton's method. Four to six reach the last digit; a double eigenvalue takes one for each bit.
const MOST_ROUNDS: usize = 24;

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

    /// Adds a aᵀ.
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
    pub fn add(&mut self, Self([a, b, c, d, e, f]): &Self, weight: T) {
        let [xx, yx, yy, zx, zy, zz] = &mut self.0;
        *xx += *a * weight;
        *yx += *b * weight;
        *yy += *c * weight;
        *zx += *d * weight;
        *zy += *e * weight;
        *zz += *f * weight;
    }

    /// The image of a vector.
    #[inline(never)]
    pub fn image(&self, a: &Vector3<T>) -> Vector3<T> {
        self.image_inline(a)
    }

    /// The same, inlined: where it is done for each of several vectors.
    #[inline(always)]
    pub(crate) fn image_inline(&self, a: &Vector3<T>) -> Vector3<T> {
        let [xx, yx, yy, zx, zy, zz] = self.0;
        Vector3::new(xx * a.x + yx * a.y + zx * a.z, yx * a.x + yy * a.y + zy * a.z, zx * a.x + zy * a.y + zz * a.z)
    }

    /// Every column becomes its image: the product with a matrix, in its place.
    #[inline(never)]
    pub fn apply_to(&self, columns: &mut Matrix3<T>) {
        for column in &mut columns.data.0 {
            *column = self.image_inline(&Vector3::from(*column)).into();
        }
    }

    /// Adds `left`ᵀ `right`, where that is symmetric, times `weight`.
    #[inline(never)]
    pub fn add_product(&mut self, left: &Matrix3<T>, right: &Matrix3<T>, weight: T) {
        let [a, b, c] = left.data.0.map(Vector3::from);
        let [u, v, w] = right.data.0.map(Vector3::from);
        let [xx, yx, yy, zx, zy, zz] = &mut self.0;
        *xx += dot(&a, &u) * weight;
        *yx += dot(&b, &u) * weight;
        *yy += dot(&b, &v) * weight;
        *zx += dot(&c, &u) * weight;
        *zy += dot(&c, &v) * weight;
        *zz += dot(&c, &w) * weight;
    }

    /// The adjugate: the inverse times the determinant, and also there when the determinant is zero.
    #[inline(never)]
    pub fn adjugate(&self) -> Self {
        self.adjugate_inline()
    }

    /// The same, inlined: the inverse is wanted three times a pose.
    #[inline(always)]
    fn adjugate_inline(&self) -> Self {
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

    /// Becomes its inverse; `of`: the matrix that elimination has left this one of (itself, if of none).
    ///
    /// False, and nothing is changed, when a pivot is not larger than the part `smallest` of the diagonal entry that it
    /// came from, or is not a number.
    #[inline(never)]
    #[must_use]
    pub fn invert(&mut self, of: &Self, smallest: T) -> bool {
        let adjugate = self.adjugate_inline();
        let ([xx, ..], [first, _, second, .., third]) = (self.0, of.0);
        let determinant = self.determinant(&adjugate);
        let [c11, c21, c22, c31, c32, minor] = adjugate.0;
        // The pivots are the quotients of the leading minors. Written as products, and so that NaN is refused.
        let regular = xx > first * smallest && minor > second * smallest * xx && determinant > third * smallest * minor;
        if regular {
            let scale = T::one() / determinant;
            self.0 = [c11 * scale, c21 * scale, c22 * scale, c31 * scale, c32 * scale, minor * scale];
        }
        regular
    }

    /// The determinant, given the adjugate.
    fn determinant(&self, adjugate: &Self) -> T {
        let ([xx, yx, _, zx, ..], [c11, c21, _, c31, ..]) = (self.0, adjugate.0);
        xx * c11 + yx * c21 + zx * c31
    }

    /// xx + yy + zz: the sum of the eigenvalues.
    pub fn trace(&self) -> T {
        let [xx, _, yy, .., zz] = self.0;
        xx + yy + zz
    }

    /// The largest eigenvalue of a matrix without negative ones, and its direction, a unit vector; not finite, or no
    /// direction, where there is none.
    ///
    /// Newton's method on the characteristic polynomial, from above. Where the next eigenvalue is as large, some
    /// direction between the two.
    #[inline(never)]
    pub fn largest(&self) -> (T, Vector3<T>) {
        let adjugate = self.adjugate();
        let (trace, minors, determinant) = (self.trace(), adjugate.trace(), self.determinant(&adjugate));
        // Exact when the two others are alike, and never too small: saves two or three rounds.
        let spread = root(trace * trace - minors * T::of(3.0));
        let mut value = (trace + spread + spread) * T::of(1.0 / 3.0);
        for _ in 0..MOST_ROUNDS {
            let polynomial = ((value - trace) * value + minors) * value - determinant;
            let slope = (T::of(3.0) * value - trace - trace) * value + minors;
            let step = polynomial / slope;
            // Also ends with NaN. What a last small step leaves is its square.
            if !(step > T::zero()) {
                break;
            }
            value -= step;
            if step < value * T::default_epsilon() * T::of(1024.0) {
                break;
            }
        }
        // Of M - λ every column of the adjugate is along the direction. A little of M decides where all vanish.
        let [xx, yx, yy, zx, zy, zz] = self.0;
        let mut columns = Self([xx - value, yx, yy - value, zx, zy, zz - value]).adjugate();
        columns.add(self, value * T::default_epsilon() * T::of(8.0));
        // The column with the largest diagonal entry is the longest. Where two eigenvalues are alike λ may have come out
        // too small, and they are negative.
        let [xx, yx, yy, zx, zy, zz] = columns.0;
        let (x, y, z) = (xx.abs(), yy.abs(), zz.abs());
        let longest = if x >= y && x >= z {
            [xx, yx, zx]
        } else if y >= z {
            [yx, yy, zy]
        } else {
            [zx, zy, zz]
        };
        (value, unit(&longest.into()))
    }
}

/// The smallest pivot that rounding has not made, as a part of the diagonal entry that it came from. The information on
/// the rotation in a pose of a sound rig is a hundred times above it.
pub fn rounding<T: Real>() -> T {
    T::default_epsilon() * T::of(64.0)
}
