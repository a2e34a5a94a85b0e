//! Memory for one thing at a time: 1 KB more would be needed if each had its own.

use super::seen_pose::SeenPose;
use crate::identification::marginal_information::MarginalInformation;
use crate::identification::parameters::{Equations, MAX_UNKNOWNS, PoseAt, Rows};
use crate::identification::pose_in_work::PoseInWork;
use crate::kinematics::{CableLengths, LengthJacobian};
use crate::linear_algebra::normal_equations::leading_zeros;
use crate::scalar::Real;
use nalgebra::Matrix3;

/// Multiplications of a slice with the factor: about 7 500 cycles of a Cortex-M4F.
pub(super) const PRODUCTS_A_SLICE: usize = 560;

/// A row takes the time of so many products beside its own.
const ROW_IN_PRODUCTS: usize = 10;

/// What a stage works on between two slices.
// Both are large.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug)]
pub enum Scratch<T> {
    /// Nothing.
    Free,
    /// What a pose says of the centre, before its equations go to work.
    Seen(SeenPose<T>),
    /// A pose on its way into the normal equations, when there are parameters beside the centre; or one that is in.
    Pose(PoseInWork<T>),
    /// Linear functions of the unknowns, which are whitened.
    Rows(RowsInWork<T>),
    /// The right side of the normal equations, which are solved.
    Right(RightInWork<T>),
}

/// Linear functions of the unknowns, whitened a few unknowns a call: then their products are covariances.
#[derive(Clone, Debug)]
pub struct RowsInWork<T> {
    rows: Rows<T>,
    /// The row under way, the first unknown that it depends on, and the next to be whitened.
    row: usize,
    from: usize,
    next: usize,
}

/// A right side of the normal equations on its way to their solution, a few unknowns a call.
#[derive(Clone, Debug)]
pub struct RightInWork<T> {
    values: [T; MAX_UNKNOWNS],
    /// The unknowns before this one are eliminated.
    from: usize,
    /// The next unknown.
    next: usize,
    is_half_solved: bool,
}

impl<T: Real> Scratch<T> {
    /// Takes up a pose in place of what was there, where it stays: 1 KB to be moved otherwise, a tenth of the time with unknown
    /// encoder offsets.
    pub fn put_pose(&mut self, at: &PoseAt<'_, T>, pose: &MarginalInformation<T>, weight: T) {
        if !self.has_room() {
            self.make_room(at.lengths);
        }
        if let Self::Pose(in_work) = self {
            in_work.begin(at, pose, weight);
        }
    }

    /// The Jacobian of a pose that is prepared, if there is one.
    pub fn prepared(&self) -> Option<&LengthJacobian<T>> {
        match self {
            Self::Pose(in_work) => in_work.prepared(),
            _ => None,
        }
    }

    /// Prepares a pose in the room that there is.
    pub fn prepare(&mut self, rotation: &Matrix3<T>, lengths: &CableLengths<T>, jacobian: LengthJacobian<T>) {
        if let Self::Pose(in_work) = self {
            in_work.prepare(rotation, lengths, jacobian);
        }
    }

    /// The pose that is prepared goes to work.
    #[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn begin_prepared(&mut self, pose: &MarginalInformation<T>, weight: T) {
        if let Self::Pose(in_work) = self {
            in_work.begin_prepared(pose, weight);
        }
    }

    /// A pose that is prepared and not begun is none any more.
    pub fn forget_prepared(&mut self) {
        if let Self::Pose(in_work) = self {
            in_work.forget_prepared();
        }
    }

    /// There is room for a pose.
    pub fn has_room(&self) -> bool {
        matches!(self, Self::Pose(_))
    }

    /// Makes room for a pose in place of what was there.
    pub fn make_room(&mut self, lengths: &CableLengths<T>) {
        *self = Self::Pose(PoseInWork::not_begun(lengths));
    }

    /// A pose is on its way.
    pub fn has_pose(&self) -> bool {
        matches!(self, Self::Pose(in_work) if in_work.is_under_way())
    }

    /// The pose that is on its way, if there is one.
    pub fn pose(&mut self) -> Option<&mut PoseInWork<T>> {
        match self {
            Self::Pose(in_work) if in_work.is_under_way() => Some(in_work),
            _ => None,
        }
    }

    /// Takes up rows in place of what was there.
    pub fn put_rows(&mut self, rows: &Rows<T>) {
        *self = Self::Rows(RowsInWork { rows: *rows, row: 0, from: 0, next: 0 });
    }

    /// The rows; none when there is something else.
    pub fn rows(&self) -> &[[T; MAX_UNKNOWNS]] {
        match self {
            Self::Rows(in_work) => &in_work.rows,
            _ => &[],
        }
    }

    /// Whitens what is next in the rows; true when they are white already.
    pub fn whiten(&mut self, equations: &Equations<T>) -> bool {
        let Self::Rows(RowsInWork { rows, row, from, next }) = self else { return true };
        let Some(values) = rows.get_mut(*row) else { return true };
        if *next == 0 {
            // The zeros that it begins with stay.
            *from = leading_zeros(values);
            *next = *from;
        }
        let last = rows_for(*next, *from, equations.unknowns());
        equations.solve_forwards(values, *from, *next..last);
        *next = last;
        if *next >= equations.unknowns() {
            (*row, *next) = (*row + 1, 0);
        }
        false
    }

    /// Takes up a right side in place of what was there, zero before unknown `from`: those before are eliminated.
    pub fn put_right(&mut self, values: &[T; MAX_UNKNOWNS], from: usize) {
        *self = Self::Right(RightInWork { values: *values, from, next: from, is_half_solved: false });
    }

    /// Solves what is next of the right side; true when it is solved already.
    pub fn solve(&mut self, equations: &Equations<T>) -> bool {
        let Self::Right(RightInWork { values, from, next, is_half_solved }) = self else { return true };
        if *is_half_solved && *next <= *from {
            return true;
        }
        if *is_half_solved {
            let first = first_row_for(*next, *from);
            equations.solve_backwards(values, *from, first..*next);
            *next = first;
            return false;
        }
        let last = rows_for(*next, *from, equations.unknowns());
        equations.solve_forwards(values, *from, *next..last);
        *next = last;
        *is_half_solved = last >= equations.unknowns();
        false
    }

    /// The solution; zero when there is something else.
    pub fn solution(&self) -> [T; MAX_UNKNOWNS] {
        match self {
            Self::Right(in_work) => in_work.values,
            _ => [T::zero(); MAX_UNKNOWNS],
        }
    }
}

/// The end of the rows from `next` on that a slice has the time for; a row has as many products as there are unknowns from `from` on
/// before it, and takes the time of some more.
fn rows_for(next: usize, from: usize, end: usize) -> usize {
    let (mut last, mut products) = (next, 0);
    while last < end && (last == next || products + last - from <= PRODUCTS_A_SLICE) {
        products += last - from + ROW_IN_PRODUCTS;
        last += 1;
    }
    last
}

/// The same backwards: the first of the rows before `next`.
fn first_row_for(next: usize, from: usize) -> usize {
    let (mut first, mut products) = (next, 0);
    while first > from && (first == next || products + first - 1 - from <= PRODUCTS_A_SLICE) {
        products += first - 1 - from + ROW_IN_PRODUCTS;
        first -= 1;
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Normal equations of all unknowns that there may be, factored, and numbers to go on with.
    fn factored() -> (Equations<f64>, impl FnMut() -> f64) {
        let mut random = 0x1234_5678_u32;
        let mut next = move || {
            random ^= random << 13;
            random ^= random >> 17;
            random ^= random << 5;
            f64::from(random.cast_signed()) / f64::from(i32::MAX)
        };
        let mut equations = Equations::new(MAX_UNKNOWNS);
        for _ in 0..2 * MAX_UNKNOWNS {
            let row: [f64; MAX_UNKNOWNS] = core::array::from_fn(|_| next());
            equations.add_row(&row, next());
        }
        equations.factor().unwrap();
        (equations, next)
    }

    #[test]
    fn rows_whitened_in_slices_are_those_whitened_at_once() {
        let (equations, mut next) = factored();
        let mut rows: Rows<f64> = core::array::from_fn(|_| core::array::from_fn(|_| next()));
        rows[1][..20].fill(0.0);
        let mut scratch = Scratch::Free;
        scratch.put_rows(&rows);
        let mut slices = 0;
        while !scratch.whiten(&equations) {
            slices += 1;
        }
        let mut whole = rows;
        whole.iter_mut().for_each(|row| equations.whiten(row));
        assert_eq!(scratch.rows(), whole);
        // Rows of 1 128 products and 48 entries, but for the second: of 378 and 28.
        assert_eq!(slices, 3 + 2 + 3);
    }

    #[test]
    fn a_right_side_solved_in_slices_is_the_one_solved_at_once() {
        let (equations, mut next) = factored();
        for from in [0, 7, MAX_UNKNOWNS - 1] {
            let right = core::array::from_fn(|unknown| if unknown < from { 0.0 } else { next() });
            let mut scratch = Scratch::Free;
            scratch.put_right(&right, from);
            while !scratch.solve(&equations) {}
            let mut whole = right;
            equations.solve_trailing(&mut whole, from);
            assert_eq!(scratch.solution(), whole, "from {from}");
        }
    }
}
