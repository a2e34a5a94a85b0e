//! Memory for one thing at a time: 1 KB more would be needed if each had its own.

use crate::identification::parameters::{MAX_UNKNOWNS, Rows};
use crate::identification::pose_in_work::PoseInWork;
use crate::scalar::Real;

/// What a stage works on between two slices.
// Both are large.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug)]
pub enum Scratch<T> {
    /// Nothing.
    Free,
    /// A pose on its way into the normal equations, when there are parameters beside the centre.
    Pose(PoseInWork<T>),
    /// Linear functions of the unknowns, whitened one after the other.
    Rows(Rows<T>),
}

impl<T: Real> Scratch<T> {
    /// A pose is on its way.
    pub fn has_pose(&self) -> bool {
        matches!(self, Self::Pose(_))
    }

    /// The pose, if there is one.
    pub fn pose(&mut self) -> Option<&mut PoseInWork<T>> {
        match self {
            Self::Pose(in_work) => Some(in_work),
            Self::Free | Self::Rows(_) => None,
        }
    }

    /// Takes this up in place of what was there.
    pub fn put_rows<const N: usize>(&mut self, rows: &[[T; MAX_UNKNOWNS]; N]) {
        *self = Self::Rows([[T::zero(); MAX_UNKNOWNS]; 3]);
        self.rows_mut().iter_mut().zip(rows).for_each(|(kept, row)| *kept = *row);
    }

    /// The rows; none when there is something else.
    pub fn rows(&self) -> &[[T; MAX_UNKNOWNS]] {
        match self {
            Self::Rows(rows) => rows,
            Self::Free | Self::Pose(_) => &[],
        }
    }

    /// The rows, to be changed.
    pub fn rows_mut(&mut self) -> &mut [[T; MAX_UNKNOWNS]] {
        match self {
            Self::Rows(rows) => rows,
            Self::Free | Self::Pose(_) => &mut [],
        }
    }
}
