//! Normal equations JᵀJ x = Jᵀe, summed equation by equation, so that the Jacobian of all poses (the paper's 3m x 6
//! matrix D~ of Eq. 14) is never stored; solved by Cholesky factorisation.
//!
//! The matrix is a packed lower triangle, row by row. How many of the `N` unknowns take part is decided at run time.
//! Its Cholesky factor takes its place, a few rows a call if wanted.

mod update;

use super::dot;
use crate::scalar::Real;
use core::ops::Range;
use nalgebra::SMatrix;

/// The smallest pivot that counts as regular, as a share of the diagonal entry that it came from: below it the weakest
/// combination of the unknowns has a standard deviation a thousand times larger than the others.
///
/// Measured over random machines, at the end of the paper's iteration from ±10 mm starts: 4000 sets of 3 to 100 poses
/// about one axis left at most 6e-7 (their centre is wrong by up to 100 mm while δE looks perfect), three poses within
/// ±10 degrees at least 4e-6, within ±30 degrees at least 1.6e-4.
const SMALLEST_PIVOT: f64 = 1e-6;
/// The same in roundings, where those are coarser: in `f32` the rows' own rounding leaves more than the above.
const SMALLEST_PIVOT_ROUNDINGS: f64 = 256.0;

/// An entry of the factor takes the time of so many products beside its own.
const ENTRY_IN_PRODUCTS: usize = 10;

/// The smallest pivot that counts, as a share of the diagonal entry that it came from.
pub fn smallest_pivot<T: Real>() -> T {
    T::of(SMALLEST_PIVOT).max(T::default_epsilon() * T::of(SMALLEST_PIVOT_ROUNDINGS))
}

/// Position of row `i`, column `j <= i` in a packed lower triangle.
pub const fn packed_index(i: usize, j: usize) -> usize {
    i * (i + 1) / 2 + j
}

/// The normal matrix has no inverse: some combination of the unknowns leaves every equation unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Singular;

/// JᵀJ, Jᵀe and eᵀe of the equations added so far; after [`factor`](Self::factor) the Cholesky factor of JᵀJ.
///
/// `N`: maximum number of unknowns; `P` = N (N + 1) / 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalEquations<T, const N: usize, const P: usize> {
    unknowns: usize,
    matrix: [T; P],
    gradient: [T; N],
    squares: T,
    /// Rows of the matrix that have become the factor's. The factor holds its diagonal inverted.
    factored: usize,
    /// Entries of the next row that have.
    in_row: usize,
    /// See [`pivot_ratio`](Self::pivot_ratio).
    pivot_ratio: T,
}

impl<T: Real, const N: usize, const P: usize> NormalEquations<T, N, P> {
    const PACKED: () = assert!(P == N * (N + 1) / 2);

    /// No equations yet in this many unknowns, at most `N`.
    pub fn new(unknowns: usize) -> Self {
        let () = Self::PACKED;
        Self {
            unknowns: if unknowns < N { unknowns } else { N },
            matrix: [T::zero(); P],
            gradient: [T::zero(); N],
            squares: T::zero(),
            factored: 0,
            in_row: 0,
            pivot_ratio: T::one(),
        }
    }

    /// Back to no equations, in this many unknowns, at most `N`. In place.
    pub fn clear(&mut self, unknowns: usize) {
        self.unknowns = if unknowns < N { unknowns } else { N };
        self.matrix.iter_mut().take(packed_index(self.unknowns, 0)).for_each(|entry| *entry = T::zero());
        self.gradient.iter_mut().take(self.unknowns).for_each(|entry| *entry = T::zero());
        self.squares = T::zero();
        (self.factored, self.in_row) = (0, 0);
        self.pivot_ratio = T::one();
    }

    /// Unknowns that take part.
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// eᵀe: the weighted sum of squares, mm².
    pub fn squares(&self) -> T {
        self.squares
    }

    /// Jᵀe.
    pub fn gradient(&self) -> &[T; N] {
        &self.gradient
    }

    /// JᵀJ, or its factor: lower triangle row by row.
    pub fn matrix(&self) -> &[T; P] {
        &self.matrix
    }

    /// Adds the equation `row · x = value`; `row` has as many entries as there are unknowns.
    pub fn add_row(&mut self, row: &[T], value: T) {
        let mut entries = self.matrix.as_mut_slice();
        for (i, (a, gradient)) in row.iter().zip(&mut self.gradient).enumerate().take(self.unknowns) {
            let Some((current, rest)) = entries.split_at_mut_checked(i + 1) else { break };
            entries = rest;
            current.iter_mut().zip(row).for_each(|(entry, b)| *entry += *a * *b);
            *gradient += *a * value;
        }
        self.squares += value * value;
    }

    /// Rows of JᵀJ from `first` on up to the diagonal, to be added to; empty outside the triangle.
    pub fn rows_mut<const R: usize>(&mut self, first: usize) -> [&mut [T]; R] {
        let mut rest = self.matrix.get_mut(packed_index(first, 0)..).unwrap_or_default();
        core::array::from_fn(|i| {
            let (row, below) = core::mem::take(&mut rest).split_at_mut_checked(first + i + 1).unwrap_or_default();
            rest = below;
            row
        })
    }

    /// The entry of JᵀJ in row `i`, column `j <= i`; 0 outside the triangle.
    pub fn entry(&self, i: usize, j: usize) -> T {
        self.matrix.get(packed_index(i, j)).copied().unwrap_or_else(T::zero)
    }

    /// Adds to one entry of JᵀJ, row `i`, column `j <= i`. Does nothing outside the triangle.
    pub fn add_to_entry(&mut self, i: usize, j: usize, value: T) {
        if let Some(entry) = self.matrix.get_mut(packed_index(i, j)) {
            *entry += value;
        }
    }

    /// Adds to Jᵀe of unknown `i`.
    pub fn add_to_gradient(&mut self, i: usize, value: T) {
        if let Some(gradient) = self.gradient.get_mut(i) {
            *gradient += value;
        }
    }

    /// Takes unknown `k` out before the matrix is factored: its step is zero.
    pub fn hold(&mut self, k: usize) {
        for other in 0..self.unknowns {
            if let Some(entry) = self.matrix.get_mut(packed_index(k.max(other), k.min(other))) {
                *entry = if other == k { T::one() } else { T::zero() };
            }
        }
        if let Some(gradient) = self.gradient.get_mut(k) {
            *gradient = T::zero();
        }
    }

    /// Adds to eᵀe.
    pub fn add_squares(&mut self, squares: T) {
        self.squares += squares;
    }

    /// Adds another normal matrix in the same unknowns, packed, `times` times. It says nothing of Jᵀe and eᵀe.
    pub fn add_matrix(&mut self, packed: &[T], times: T) {
        let used = packed_index(self.unknowns, 0);
        let entries = self.matrix.iter_mut().zip(packed).take(used);
        entries.for_each(|(entry, other)| *entry += *other * times);
    }

    /// Is the whole matrix factored?
    pub fn is_factored(&self) -> bool {
        self.factored >= self.unknowns
    }

    /// Is no row factored yet?
    pub fn is_unfactored(&self) -> bool {
        self.factored == 0 && self.in_row == 0
    }

    /// The block of JᵀJ of the last `M` unknowns, before it is factored.
    pub fn trailing_matrix<const M: usize>(&self) -> SMatrix<T, M, M> {
        let first = self.unknowns - if M < self.unknowns { M } else { self.unknowns };
        let entry = |i: usize, j: usize| self.matrix.get(packed_index(first + i.max(j), first + i.min(j))).copied();
        SMatrix::from_fn(|i, j| entry(i, j).unwrap_or_else(T::zero))
    }

    /// The factor L of JᵀJ = L Lᵀ takes the place of the matrix.
    ///
    /// # Errors
    /// As [`factor_some`](Self::factor_some).
    pub fn factor(&mut self) -> Result<(), Singular> {
        self.factor_some(usize::MAX)
    }

    /// The next entries of the factor, as many as take the time of about `products` multiplications; at least one (Golub and Van
    /// Loan, algorithm 4.2.1, row by row).
    ///
    /// # Errors
    /// [`Singular`] when a pivot is too small against the diagonal entry that it came from, or is not a number.
    #[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn factor_some(&mut self, products: usize) -> Result<(), Singular> {
        let mut left = products;
        while self.factored < self.unknowns && left > 0 {
            let row = self.factored;
            let mut last = self.in_row;
            while last < row && left > 0 {
                left = left.saturating_sub(last + ENTRY_IN_PRODUCTS);
                last += 1;
            }
            factor_entries(&mut self.matrix, row, self.in_row..last)?;
            self.in_row = last;
            if last == row && left > 0 {
                self.pivot_ratio = self.pivot_ratio.max(factor_diagonal(&mut self.matrix, row)?);
                left = left.saturating_sub(row + ENTRY_IN_PRODUCTS);
                (self.factored, self.in_row) = (row + 1, 0);
            }
        }
        Ok(())
    }

    /// Makes every diagonal entry larger by this share of itself, before the first row is factored (Marquardt 1963): the
    /// step becomes shorter in the directions that the equations hardly determine.
    pub fn damp(&mut self, share: T) {
        for i in 0..self.unknowns {
            if let Some(diagonal) = self.matrix.get_mut(packed_index(i, i)) {
                *diagonal += *diagonal * share;
            }
        }
    }

    /// The largest ratio of a diagonal entry to its pivot, 1 or more: an estimate of the condition number of the matrix
    /// with unit diagonal.
    pub fn pivot_ratio(&self) -> T {
        self.pivot_ratio
    }

    /// Solves JᵀJ x = `right` (Eq. 15), once factored; `right` becomes x.
    pub fn solve_for(&self, right: &mut [T; N]) {
        self.solve_trailing(right, 0);
    }

    /// The step x = (JᵀJ)⁻¹ Jᵀe, once factored.
    pub fn step(&self) -> [T; N] {
        let mut x = self.gradient;
        self.solve_for(&mut x);
        x
    }

    /// The sum of squares after a step by the linear model, mm².
    pub fn squares_after(&self, step: &[T; N]) -> T {
        let gained = dot(step.get(..self.unknowns).unwrap_or_default(), &self.gradient);
        (self.squares - gained).max(T::zero())
    }

    /// Solves with the part of the factor from unknown `from` on: the unknowns before it are eliminated. `right` is
    /// zero before `from`.
    pub fn solve_trailing(&self, right: &mut [T; N], from: usize) {
        self.solve_forwards(right, from, from..self.unknowns);
        self.solve_backwards(right, from, from..self.unknowns);
    }

    /// The first half of it, L y = `right`: `right` becomes y. Of these rows, for callers that solve a few at a time; those
    /// before must be solved.
    pub fn solve_forwards(&self, right: &mut [T; N], from: usize, rows: Range<usize>) {
        solve_forwards(&self.matrix, right, from, rows);
    }

    /// The second half, Lᵀ x = y: `y` becomes x. From the last of these rows to the first; those behind must be solved.
    pub fn solve_backwards(&self, y: &mut [T; N], from: usize, rows: Range<usize>) {
        solve_backwards(&self.matrix, y, from, rows);
    }

    /// `right` becomes L⁻¹ `right`, once factored. The squared norm of L⁻¹ k is kᵀ (JᵀJ)⁻¹ k, the variance of k·x.
    /// The zeros that it begins with stay.
    pub fn whiten(&self, right: &mut [T; N]) {
        let from = leading_zeros(right);
        self.solve_forwards(right, from, from..self.unknowns);
    }

    /// Column `column` of the covariance (the inverse of JᵀJ) of the unknowns from `from` on, the ones before
    /// eliminated.
    pub fn covariance_column(&self, column: usize, from: usize) -> [T; N] {
        let mut unit = [T::zero(); N];
        if let Some(entry) = unit.get_mut(column) {
            *entry = T::one();
        }
        self.solve_trailing(&mut unit, from);
        unit
    }
}

// The functions below are for any number of unknowns: one copy of each serves them all.

/// These entries of row `i` before its diagonal become the factor's, where those before them and all rows above are it already.
#[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
fn factor_entries<T: Real>(matrix: &mut [T], i: usize, entries: Range<usize>) -> Result<(), Singular> {
    let (above, row) = matrix.split_at_mut_checked(packed_index(i, 0)).ok_or(Singular)?;
    let mut above = above.get(packed_index(entries.start, 0)..).ok_or(Singular)?;
    for j in entries {
        let (other, rest) = above.split_at_checked(j + 1).ok_or(Singular)?;
        let (done, open) = row.split_at_mut_checked(j).ok_or(Singular)?;
        let ([entry, ..], [other @ .., inverse]) = (open, other) else { return Err(Singular) };
        *entry = (*entry - dot(done, other)) * *inverse;
        above = rest;
    }
    Ok(())
}

/// So does its diagonal, which is inverted. Gives the ratio of the diagonal entry to its pivot.
#[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
fn factor_diagonal<T: Real>(matrix: &mut [T], i: usize) -> Result<T, Singular> {
    let row = matrix.get_mut(packed_index(i, 0)..=packed_index(i, i)).ok_or(Singular)?;
    let (diagonal, row) = row.split_last_mut().ok_or(Singular)?;
    let pivot = row.iter().fold(*diagonal, |rest, a| rest - *a * *a);
    // Refuses NaN too.
    if !(pivot > *diagonal * smallest_pivot() && pivot > T::zero()) {
        return Err(Singular);
    }
    let ratio = *diagonal / pivot;
    *diagonal = T::one() / pivot.root();
    Ok(ratio)
}

/// L y = x, of these rows; y takes the place of x, which is zero before `from`.
fn solve_forwards<T: Real>(factor: &[T], x: &mut [T], from: usize, rows: Range<usize>) {
    for i in rows {
        let Some((row, inverse)) = row_of_factor(factor, i) else { return };
        let Some((solved, [x, ..])) = x.split_at_mut_checked(i) else { return };
        let (Some(row), Some(solved)) = (row.get(from..), solved.get(from..)) else { return };
        let known = dot(row, solved);
        *x = (*x - known) * inverse;
    }
}

/// Lᵀ x = y, of these rows from the last to the first; x takes the place of y.
fn solve_backwards<T: Real>(factor: &[T], x: &mut [T], from: usize, rows: Range<usize>) {
    for i in rows.rev() {
        let Some((row, inverse)) = row_of_factor(factor, i) else { return };
        let Some((open, [solved, ..])) = x.split_at_mut_checked(i) else { return };
        let (Some(row), Some(open)) = (row.get(from..), open.get_mut(from..)) else { return };
        *solved *= inverse;
        let solved = *solved;
        for (x, a) in open.iter_mut().zip(row) {
            *x -= *a * solved;
        }
    }
}

/// Row `i` of the factor without its diagonal, and the inverse of that.
fn row_of_factor<T: Real>(factor: &[T], i: usize) -> Option<(&[T], T)> {
    let (inverse, row) = factor.get(packed_index(i, 0)..=packed_index(i, i))?.split_last()?;
    Some((row, *inverse))
}

/// How many zeros these numbers begin with.
pub fn leading_zeros<T: Real>(numbers: &[T]) -> usize {
    numbers.iter().take_while(|number| **number == T::zero()).count()
}
