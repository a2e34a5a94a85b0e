//! Least squares of six unknowns, streamed: each equation is added to the 6x6 normal equations and forgotten, so the
//! paper's 3m x 6 matrix D~ (Eq. 14) never exists.

use crate::scalar::Real;

/// Unknowns.
pub const UNKNOWNS: usize = 6;
/// Entries of a packed symmetric 6x6 matrix (lower triangle, row by row).
pub const PACKED: usize = UNKNOWNS * (UNKNOWNS + 1) / 2;

/// The smallest pivot that counts, as a share of the diagonal entry that it came from: below it the weakest
/// combination of the unknowns is seen a thousand times worse than the others.
///
/// Measured over random machines, at the end of the paper's iteration from ±10 mm starts: 4000 sets of 3 to 100 poses
/// about one axis left at most 6e-7 (their centre is wrong by up to 100 mm while δE looks perfect), three poses within
/// ±10 degrees at least 4e-6, within ±30 degrees at least 1.6e-4.
const SMALLEST_PIVOT: f64 = 1e-6;
/// The same in roundings, where those are coarser: in `f32` the rows' own rounding leaves more than the above.
const SMALLEST_PIVOT_ROUNDINGS: f64 = 256.0;

/// The smallest pivot that counts, as a share of the diagonal entry that it came from.
#[inline(always)]
pub(super) fn smallest_pivot<T: Real>() -> T {
    let (share, rounded) = (T::of(SMALLEST_PIVOT), T::default_epsilon() * T::of(SMALLEST_PIVOT_ROUNDINGS));
    if share > rounded { share } else { rounded }
}

/// DᵀD, DᵀY and YᵀY of the equations added so far (Eq. 15, 17).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalEquations<T> {
    pub(crate) matrix: [T; PACKED],
    pub(crate) gradient: [T; UNKNOWNS],
    pub(crate) squares: T,
}

/// The normal matrix has no inverse: some combination of the unknowns leaves every equation unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Singular;

/// L D Lᵀ of a symmetric positive definite 6x6 matrix: no square roots, and the only six divisions are kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factors<T> {
    /// Unit lower triangle below the diagonal; on the diagonal the inverse pivots. As a square, because there the
    /// compiler sees that no index leaves it.
    rows: [[T; UNKNOWNS]; UNKNOWNS],
    /// The largest share by which a diagonal entry exceeds the pivot that it became: how much worse the weakest
    /// combination of the unknowns is seen than the others. 1 or more.
    weakness: T,
}

/// Position of row `i`, column `j <= i` in a packed lower triangle.
#[inline(always)]
pub const fn at(i: usize, j: usize) -> usize {
    i * (i + 1) / 2 + j
}

impl<T: Real> Default for NormalEquations<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real> NormalEquations<T> {
    /// No equations yet.
    pub fn new() -> Self {
        Self { matrix: [T::zero(); PACKED], gradient: [T::zero(); UNKNOWNS], squares: T::zero() }
    }

    /// Adds the equation `row · X = value`.
    #[inline]
    pub fn add(&mut self, row: &[T; UNKNOWNS], value: T) {
        for i in 0..UNKNOWNS {
            for j in 0..=i {
                self.matrix[at(i, j)] += row[i] * row[j];
            }
            self.gradient[i] += row[i] * value;
        }
        self.squares += value * value;
    }

    /// YᵀY: the sum of the squared values.
    pub fn squares(&self) -> T {
        self.squares
    }

    /// YᵀY that is left after the step `x`, as far as the equations are linear.
    pub fn squares_after(&self, x: &[T; UNKNOWNS]) -> T {
        let gained = x.iter().zip(&self.gradient).fold(T::zero(), |sum, (x, g)| sum + *x * *g);
        (self.squares - gained).max(T::zero())
    }

    /// DᵀD, lower triangle row by row.
    pub fn matrix(&self) -> &[T; PACKED] {
        &self.matrix
    }

    /// DᵀY.
    pub fn gradient(&self) -> &[T; UNKNOWNS] {
        &self.gradient
    }

    /// Eq. 15: X = (DᵀD)⁻¹ DᵀY.
    ///
    /// # Errors
    /// [`Singular`] as for [`Factors::of`].
    pub fn solve(&self) -> Result<[T; UNKNOWNS], Singular> {
        match &Factors::of(&self.matrix) {
            Ok(factors) => Ok(factors.solve(&self.gradient)),
            Err(error) => Err(*error),
        }
    }
}

impl<T: Real> Factors<T> {
    /// Factors a packed symmetric matrix.
    ///
    /// # Errors
    /// [`Singular`] when a pivot is too small against the diagonal entry that it came from, or is not a number.
    // Not inlined, like `solve`: called from several places a few times a run.
    #[inline(never)]
    pub fn of(matrix: &[T; PACKED]) -> Result<Self, Singular> {
        let mut rows = [[T::zero(); UNKNOWNS]; UNKNOWNS];
        let mut weakness = T::one();
        let mut entries = matrix.iter();
        // Row by row (Golub and Van Loan, algorithm 4.1.2): `scaled[j]` is L_ij d_j before division.
        for i in 0..UNKNOWNS {
            let mut scaled = [T::zero(); UNKNOWNS];
            for j in 0..=i {
                let entry = *entries.next().ok_or(Singular)?;
                let mut rest = entry;
                for k in 0..j {
                    rest -= scaled[k] * rows[j][k];
                }
                if j < i {
                    scaled[j] = rest;
                    rows[i][j] = rest * rows[j][j];
                } else if rest > entry * smallest_pivot::<T>() && rest > T::zero() {
                    rows[i][i] = T::one() / rest;
                    weakness = weakness.max(entry * rows[i][i]);
                } else {
                    // NaN is refused too.
                    return Err(Singular);
                }
            }
        }
        Ok(Self { rows, weakness })
    }

    /// The largest share by which a diagonal entry exceeds the pivot that it became: how much worse the weakest
    /// combination of the unknowns is seen than the others. 1 or more.
    pub fn weakness(&self) -> T {
        self.weakness
    }

    /// The solution X of `matrix · X = right`.
    #[inline(never)]
    pub fn solve(&self, right: &[T; UNKNOWNS]) -> [T; UNKNOWNS] {
        let mut x = *right;
        for i in 0..UNKNOWNS {
            for j in 0..i {
                let known = x[j];
                x[i] -= self.rows[i][j] * known;
            }
        }
        for i in (0..UNKNOWNS).rev() {
            x[i] *= self.rows[i][i];
            for j in i + 1..UNKNOWNS {
                let known = x[j];
                x[i] -= self.rows[j][i] * known;
            }
        }
        x
    }

    /// The inverse of the matrix, lower triangle row by row.
    #[inline(never)]
    pub fn inverse(&self) -> [T; PACKED] {
        let mut inverse = [T::zero(); PACKED];
        let mut slots = inverse.iter_mut();
        for i in 0..UNKNOWNS {
            let mut unit = [T::zero(); UNKNOWNS];
            unit[i] = T::one();
            for (slot, entry) in slots.by_ref().take(i + 1).zip(self.solve(&unit)) {
                *slot = entry;
            }
        }
        inverse
    }
}
