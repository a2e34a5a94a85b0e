//! The poses of a calibration, in a buffer whose size is fixed when the program is compiled.

use crate::kinematics::CableLengths;
use heapless::Vec;

/// Poses that the drive board holds unless told otherwise.
pub const DEFAULT_CAPACITY: usize = 128;

/// Cable lengths of the captured poses, in the order of their capture. 24 bytes a pose in single precision.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseBuffer<T, const N: usize = DEFAULT_CAPACITY> {
    poses: Vec<CableLengths<T>, N>,
}

/// The buffer is full; the pose is handed back untouched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Full<T>(pub CableLengths<T>);

impl<T, const N: usize> Default for PoseBuffer<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T, const N: usize> PoseBuffer<T, N> {
    /// An empty buffer.
    pub const fn new() -> Self {
        Self { poses: Vec::new() }
    }

    /// Appends a pose and returns its index, from 0.
    ///
    /// # Errors
    /// [`Full`] with the pose when the buffer holds `N` poses already; they all stay.
    pub fn push(&mut self, lengths: CableLengths<T>) -> Result<usize, Full<T>> {
        self.poses.push(lengths).map_err(Full)?;
        Ok(self.poses.len() - 1)
    }

    /// The poses in the order of their capture.
    pub fn as_slice(&self) -> &[CableLengths<T>] {
        &self.poses
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
