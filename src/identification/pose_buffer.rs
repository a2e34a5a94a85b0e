//! The poses of a calibration, in a buffer whose size is fixed when the program is compiled.

use super::pose::Pose;
use crate::scalar::Real;
use heapless::Vec;

/// Poses that the drive board holds by default.
pub const DEFAULT_CAPACITY: usize = 128;

/// The captured poses, in the order of their capture. 64 bytes a pose in single precision.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseBuffer<T: Real, const N: usize = DEFAULT_CAPACITY> {
    poses: Vec<Pose<T>, N>,
}

/// The buffer is full; the pose is handed back untouched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Full<T: Real>(pub Pose<T>);

impl<T: Real, const N: usize> Default for PoseBuffer<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real, const N: usize> PoseBuffer<T, N> {
    /// An empty buffer.
    pub const fn new() -> Self {
        Self { poses: Vec::new() }
    }

    /// Appends a pose and returns its index, from 0.
    ///
    /// # Errors
    /// [`Full`] with the pose when the buffer holds `N` poses already; they all stay.
    pub fn push(&mut self, pose: Pose<T>) -> Result<usize, Full<T>> {
        self.poses.push(pose).map_err(Full)?;
        Ok(self.poses.len() - 1)
    }

    /// The poses in the order of their capture.
    pub fn as_slice(&self) -> &[Pose<T>] {
        &self.poses
    }

    /// The same, for the estimator to work on.
    pub fn as_mut_slice(&mut self) -> &mut [Pose<T>] {
        &mut self.poses
    }

    /// Number of poses held.
    pub fn len(&self) -> usize {
        self.poses.len()
    }

    /// No pose yet.
    pub fn is_empty(&self) -> bool {
        self.poses.is_empty()
    }

    /// No room for another pose.
    pub fn is_full(&self) -> bool {
        self.poses.is_full()
    }

    /// Forgets all poses.
    pub fn clear(&mut self) {
        self.poses.clear();
    }
}
