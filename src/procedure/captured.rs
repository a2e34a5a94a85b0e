//! A set of captured poses, and how far apart they are.

use crate::identification::{Pose, PoseBuffer};
use crate::scalar::Real;

/// Poses of one set.
#[derive(Debug, Clone, PartialEq)]
pub struct Captured<const N: usize> {
    poses: PoseBuffer<f32, N>,
}

/// No room for another pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Full;

impl<const N: usize> Captured<N> {
    /// An empty set.
    pub const fn new() -> Self {
        Self { poses: PoseBuffer::new() }
    }

    /// Forgets all poses.
    pub fn clear(&mut self) {
        self.poses.clear();
    }

    /// The poses, in the order of their capture.
    pub fn poses(&self) -> &[Pose<f32>] {
        self.poses.as_slice()
    }

    /// The same, for the estimator to work on.
    pub fn poses_mut(&mut self) -> &mut [Pose<f32>] {
        self.poses.as_mut_slice()
    }

    /// Number of poses. The capacity of every set fits a byte.
    pub fn count(&self) -> u8 {
        self.poses.len() as u8
    }

    /// No room for another pose.
    pub fn is_full(&self) -> bool {
        self.poses.is_full()
    }

    /// Appends a pose.
    ///
    /// # Errors
    /// [`Full`]; nothing has changed then.
    pub fn push(&mut self, pose: Pose<f32>) -> Result<(), Full> {
        self.poses.push(pose).map(|_| ()).map_err(|_| Full)
    }

    /// Angle to the nearest pose of the set, rad, 0 to π; None for an empty set.
    pub fn nearest_rad(&self, pose: &Pose<f32>) -> Option<f32> {
        nearest_rad(self.poses(), pose)
    }
}

/// The same for a set of any capacity.
#[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
fn nearest_rad(poses: &[Pose<f32>], pose: &Pose<f32>) -> Option<f32> {
    // The cosine of half the angle between two rotations; q and -q are the same rotation.
    let cosine = |other: &Pose<f32>| other.attitude().coords.dot(&pose.attitude().coords).abs();
    // `f32::max` is a call, for the sake of NaN: 2 000 cycles with 95 poses.
    let nearest = poses.iter().map(cosine).reduce(|nearest, next| if next > nearest { next } else { nearest })?;
    // Of a small angle the cosine has lost the digits: sine and cosine of a quarter of the angle have not. An arc sine would
    // be one root less, but takes double precision in software, 3 KB of flash.
    let (sine, cosine) = ((0.5 - 0.5 * nearest).max(0.0).root(), (0.5 + 0.5 * nearest).root());
    Some(4.0 * libm::atan2f(sine, cosine))
}

impl<const N: usize> Default for Captured<N> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinematics::CableLengths;
    use nalgebra::{UnitQuaternion, Vector3};

    fn turned(degrees: f32) -> Pose<f32> {
        let mut pose = Pose::new(CableLengths::new([280.0; 6]).unwrap());
        pose.set_attitude(UnitQuaternion::from_axis_angle(&Vector3::x_axis(), degrees.to_radians()));
        pose
    }

    #[test]
    fn the_nearest_pose_counts_in_both_directions_and_round_the_circle() {
        let mut poses = Captured::<4>::new();
        assert_eq!(poses.nearest_rad(&turned(0.0)), None);
        for degrees in [0.0, 40.0, 170.0] {
            poses.push(turned(degrees)).unwrap();
        }
        for (degrees, expected) in [(0.0, 0.0), (1.0, 1.0), (25.0, 15.0), (-3.0, 3.0), (-160.0, 30.0), (105.0, 65.0)] {
            let nearest = poses.nearest_rad(&turned(degrees)).unwrap().to_degrees();
            assert!((nearest - expected).abs() < 0.06, "{degrees}: {nearest}");
        }
    }

    #[test]
    fn a_full_set_stays_as_it_is() {
        let mut poses = Captured::<1>::new();
        poses.push(turned(0.0)).unwrap();
        let before = poses.clone();
        assert_eq!(poses.push(turned(9.0)), Err(Full));
        assert_eq!(poses, before);
    }
}
