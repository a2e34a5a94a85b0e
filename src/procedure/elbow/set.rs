//! The poses of an elbow's set, and how far apart they are.

use crate::identification::hinge::{HingePose, MAX_CABLES};
use heapless::Vec;

/// Poses of one set, and the range of their lengths.
#[derive(Debug, Clone, PartialEq)]
pub struct Set<const N: usize> {
    poses: Vec<HingePose<f32>, N>,
}

impl<const N: usize> Set<N> {
    /// An empty set.
    pub const fn new() -> Self {
        Self { poses: Vec::new() }
    }

    /// Forgets all poses.
    pub fn clear(&mut self) {
        self.poses.clear();
    }

    /// The poses, in the order of their capture.
    pub fn poses(&self) -> &[HingePose<f32>] {
        &self.poses
    }

    /// The same, for the estimator to work on.
    pub fn poses_mut(&mut self) -> &mut [HingePose<f32>] {
        &mut self.poses
    }

    /// Number of poses. The capacity of every set fits a byte.
    pub fn count(&self) -> u8 {
        self.poses.len() as u8
    }

    /// No room for another pose.
    pub fn is_full(&self) -> bool {
        self.poses.is_full()
    }

    /// Appends a pose; false when there is no room, and then nothing has changed.
    pub fn push(&mut self, lengths_mm: [f32; MAX_CABLES]) -> bool {
        self.poses.push(HingePose::new(lengths_mm)).is_ok()
    }

    /// The largest difference of a length to the pose for which that is smallest, mm; infinite for an empty set.
    pub fn nearest_mm(&self, lengths_mm: &[f32; MAX_CABLES]) -> f32 {
        let farthest = |pose: &HingePose<f32>| {
            let pairs = pose.lengths_mm.iter().zip(lengths_mm);
            pairs.fold(0.0, |most: f32, (a, b)| most.max((a - b).abs()))
        };
        self.poses.iter().map(farthest).fold(f32::INFINITY, f32::min)
    }

    /// From the shortest to the longest length of the cable that changes most, mm.
    pub fn range_mm(&self) -> f32 {
        let of = |cable: usize| {
            let lengths = || self.poses.iter().filter_map(move |pose| pose.lengths_mm.get(cable));
            let (low, high) = lengths().fold((f32::INFINITY, 0.0_f32), |(low, high), x| (low.min(*x), high.max(*x)));
            (high - low).max(0.0)
        };
        (0..MAX_CABLES).map(of).fold(0.0, f32::max)
    }
}
