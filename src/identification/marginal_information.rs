//! What one pose says about the joint centre, with the pose's own rotation eliminated.
//!
//! Of the six unknowns (O in {B}, C in {P}) a pose sees three combinations, δ = δO - R δC (see
//! [`length_jacobian`](crate::kinematics::length_jacobian)). With U and G the translation and rotation columns of the
//! Jacobian, the six lengths say U δ + G ω = e. Householder's reflections turn G into a triangle over zeros (QR
//! factorization; Golub and Van Loan, algorithm 5.2.1). Three of the six equations determine the small rotation ω then,
//! and the other three hold none of it:
//!
//! ```text
//! Ū δ = ē
//! ```
//!
//! Their squares are the Schur complement of the normal equations, S = ŪᵀŪ = UᵀU - (GᵀU)ᵀ (GᵀG)⁻¹ GᵀU, and S δ̂ = Ūᵀē:
//! all that the pose knows, with the exact maximum-likelihood weight.

use crate::kinematics::LengthJacobian;
use crate::linear_algebra::{Singular, rounding, solve_positive_definite};
use crate::rig::CABLES;
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// A number for each cable.
type Six<T> = [T; CABLES];

/// What one pose knows, for lengths with a variance of 1 mm² (multiply squares by 1/σ²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarginalInformation<T> {
    /// Ū: how the three equations change with δ, dimensionless.
    pub translation: Matrix3<T>,
    /// ē: their residuals with δ = 0, mm.
    pub residuals_mm: Vector3<T>,
    /// The best ω for δ = 0, rad.
    pub turn: Vector3<T>,
    /// The reflections 1 - v vᵀ, in the order in which they are applied.
    reflections: [Six<T>; 3],
    /// What the three equations were multiplied by afterwards.
    whitening: Option<Matrix3<T>>,
}

impl<T: Real> MarginalInformation<T> {
    /// The information of a pose on δ.
    ///
    /// # Errors
    /// [`Singular`] when the lengths do not determine the rotation; no pose of a regular rig is like that.
    #[cfg_attr(feature = "ccm", inline(never), unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn new(jacobian: &LengthJacobian<T>) -> Result<Self, Singular> {
        let rows = &jacobian.rows;
        // The columns of G and U, and e.
        let [g1, mut g2, mut g3] = core::array::from_fn(|j| core::array::from_fn(|k| rows[k].rotation_mm[j]));
        let [mut u1, mut u2, mut u3] = core::array::from_fn(|j| core::array::from_fn(|k| rows[k].translation[j]));
        let mut e: Six<T> = core::array::from_fn(|k| rows[k].residual_mm);
        let (first, d1) = reflection_of::<T, 0>(&g1)?;
        // Column by column, not in a loop: they stay in registers, 16 000 of 329 000 instructions of an identification less.
        reflect::<T, 0>(&mut g2, &first);
        reflect::<T, 0>(&mut g3, &first);
        reflect::<T, 0>(&mut u1, &first);
        reflect::<T, 0>(&mut u2, &first);
        reflect::<T, 0>(&mut u3, &first);
        reflect::<T, 0>(&mut e, &first);
        let (second, d2) = reflection_of::<T, 1>(&g2)?;
        reflect::<T, 1>(&mut g3, &second);
        reflect::<T, 1>(&mut u1, &second);
        reflect::<T, 1>(&mut u2, &second);
        reflect::<T, 1>(&mut u3, &second);
        reflect::<T, 1>(&mut e, &second);
        let (third, d3) = reflection_of::<T, 2>(&g3)?;
        reflect::<T, 2>(&mut u1, &third);
        reflect::<T, 2>(&mut u2, &third);
        reflect::<T, 2>(&mut u3, &third);
        reflect::<T, 2>(&mut e, &third);
        // The triangle, solved from its end.
        let z = e[2] / d3;
        let y = (e[1] - g3[1] * z) / d2;
        let x = (e[0] - g2[0] * y - g3[0] * z) / d1;
        let last = |column: &Six<T>| Vector3::new(column[3], column[4], column[5]);
        Ok(Self {
            translation: Matrix3::from_columns(&[last(&u1), last(&u2), last(&u3)]),
            residuals_mm: last(&e),
            turn: Vector3::new(x, y, z),
            reflections: [first, second, third],
            whitening: None,
        })
    }

    /// S: information on δ, dimensionless.
    pub fn information(&self) -> Matrix3<T> {
        self.translation.tr_mul(&self.translation)
    }

    /// S δ̂, mm.
    pub fn gradient_mm(&self) -> Vector3<T> {
        self.translation.tr_mul(&self.residuals_mm)
    }

    /// Sum of the squared length residuals with the best ω and δ = 0, mm².
    pub fn squares_mm2(&self) -> T {
        self.residuals_mm.norm_squared()
    }

    /// How the three equations change with each of the six lengths.
    #[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn projector(&self) -> [Vector3<T>; CABLES] {
        let [first, second, third] = &self.reflections;
        // The last three rows of the product of the reflections.
        let rows: [Six<T>; 3] = core::array::from_fn(|i| {
            let mut row = core::array::from_fn(|k| if k == 3 + i { T::one() } else { T::zero() });
            reflect::<T, 2>(&mut row, third);
            reflect::<T, 1>(&mut row, second);
            reflect::<T, 0>(&mut row, first);
            row
        });
        let [a, b, c] = &rows;
        let projector = core::array::from_fn(|k| Vector3::new(a[k], b[k], c[k]));
        match &self.whitening {
            Some(whitening) => projector.map(|column| whitening * column),
            None => projector,
        }
    }

    /// The same where the pose has a joint centre of its own, beside the common one by a scatter with this variance
    /// along each axis, in units of the noise's: the three equations are made as uncertain as they are then, and
    /// independent again. 0 = none.
    #[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn add_scatter(&mut self, scatter: T) {
        // Also false for NaN.
        if scatter > T::zero() {
            let covariance = Matrix3::identity() + self.translation * self.translation.transpose() * scatter;
            let whitening = inverse_of_factor(&covariance);
            self.translation = whitening * self.translation;
            self.residuals_mm = whitening * self.residuals_mm;
            self.whitening = Some(whitening);
        }
    }

    /// δ̂ for itself: the centre that the pose would have alone, exactly known, at a distance of √squares from the
    /// common one. `ridge` is added to the information, which may not know a direction.
    pub fn become_own_centre(&mut self, ridge: T) {
        let information = self.information() + Matrix3::from_diagonal_element(ridge);
        let gradient_mm = self.gradient_mm();
        self.residuals_mm = solve_positive_definite(&information, &gradient_mm, T::zero()).unwrap_or(gradient_mm);
        self.translation = Matrix3::identity();
    }
}

/// The v of the reflection 1 - v vᵀ that leaves of a column what stands before `FROM`, and one number at `FROM`: that number.
fn reflection_of<T: Real, const FROM: usize>(column: &Six<T>) -> Result<(Six<T>, T), Singular> {
    let squares = |values: &[T]| values.iter().fold(T::zero(), |sum, x| sum + *x * *x);
    let (done, rest) = column.split_at(FROM);
    let rest = squares(rest);
    // Reflections keep lengths, so the whole is still that of the first column. Also false for NaN.
    if !(rest > (squares(done) + rest) * rounding()) {
        return Err(Singular);
    }
    let norm = rest.root();
    let lead = column[FROM];
    let signed = if lead < T::zero() { -norm } else { norm };
    // The column with its length added to the leading number, on the side of its sign, scaled to |v|² = 2.
    let scale = T::one() / (norm * (norm + lead.abs())).root();
    let mut v = core::array::from_fn(|k| if k < FROM { T::zero() } else { column[k] * scale });
    v[FROM] = (lead + signed) * scale;
    Ok((v, -signed))
}

/// (1 - v vᵀ) times the column; v is zero before `FROM`.
// A call costs: 365 000 instructions an identification otherwise, 314 000 with it (`cargo cycles`).
#[inline]
fn reflect<T: Real, const FROM: usize>(column: &mut Six<T>, v: &Six<T>) {
    let (column, v) = (&mut column[FROM..], &v[FROM..]);
    let share = column.iter().zip(v).fold(T::zero(), |sum, (x, v)| sum + *x * *v);
    column.iter_mut().zip(v).for_each(|(x, v)| *x -= *v * share);
}

/// L⁻¹ for a matrix L Lᵀ that is nowhere below the identity (Cholesky).
fn inverse_of_factor<T: Real>(m: &Matrix3<T>) -> Matrix3<T> {
    let (one, zero) = (T::one(), T::zero());
    let a = one / m.m11.root();
    let (l21, l31) = (m.m21 * a, m.m31 * a);
    let c = one / (m.m22 - l21 * l21).root();
    let l32 = (m.m32 - l31 * l21) * c;
    let f = one / (m.m33 - l31 * l31 - l32 * l32).root();
    let b = -l21 * a * c;
    let d = -(l31 * a + l32 * b) * f;
    Matrix3::new(a, zero, zero, b, c, zero, d, -l32 * c * f, f)
}

/// δ̂ = S⁻¹ g of a pose, mm; a small ridge bounds a direction that the pose does not determine.
pub fn own_centre<T: Real>(information: &Matrix3<T>, gradient_mm: &Vector3<T>) -> Vector3<T> {
    let ridge = Matrix3::from_diagonal_element(T::of(1e-6));
    solve_positive_definite(&(information + ridge), gradient_mm, T::zero()).unwrap_or_else(Vector3::zeros)
}
