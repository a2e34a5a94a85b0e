//! A set of captured poses: their lengths, and their rotations to measure how far apart they are.

use crate::identification::PoseBuffer;
use crate::kinematics::CableLengths;
use heapless::Vec;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};

/// Poses of one set. The rotations are kept as quaternions: 16 bytes a pose on top of the 24 of the lengths.
#[derive(Debug, Clone, PartialEq)]
pub struct Captured<const N: usize> {
    lengths: PoseBuffer<f32, N>,
    rotations: Vec<UnitQuaternion<f32>, N>,
}

/// No room for another pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Full;

impl<const N: usize> Captured<N> {
    /// An empty set.
    pub const fn new() -> Self {
        Self { lengths: PoseBuffer::new(), rotations: Vec::new() }
    }

    /// Forgets all poses.
    pub fn clear(&mut self) {
        self.lengths.clear();
        self.rotations.clear();
    }

    /// The lengths of the poses, in the order of their capture.
    pub fn lengths(&self) -> &[CableLengths<f32>] {
        self.lengths.as_slice()
    }

    /// Number of poses. The capacity of every set fits a byte.
    pub fn count(&self) -> u8 {
        self.lengths.len() as u8
    }

    /// No room for another pose.
    pub fn is_full(&self) -> bool {
        self.lengths.is_full() || self.rotations.is_full()
    }

    /// Appends a pose with its rotation ({P} to {B}).
    ///
    /// # Errors
    /// [`Full`]; nothing has changed then.
    pub fn push(&mut self, lengths: CableLengths<f32>, rotation: &Matrix3<f32>) -> Result<(), Full> {
        if self.is_full() {
            return Err(Full);
        }
        self.lengths.push(lengths).map_err(|_| Full)?;
        self.rotations.push(quaternion(rotation)).map_err(|_| Full)
    }

    /// Angle to the nearest pose of the set, rad, 0 to π; None for an empty set.
    pub fn nearest_rad(&self, rotation: &Matrix3<f32>) -> Option<f32> {
        let asked = quaternion(rotation).into_inner();
        self.rotations
            .iter()
            .map(|captured| {
                let captured = captured.into_inner();
                // q and -q are the same rotation
                (asked - captured).norm().min((asked + captured).norm())
            })
            .reduce(f32::min)
            // |q1 - q2| = 2 sin(angle / 4)
            .map(|chord| 4.0 * libm::asinf((chord * 0.5).min(1.0)))
    }
}

impl<const N: usize> Default for Captured<N> {
    fn default() -> Self {
        Self::new()
    }
}

fn quaternion(rotation: &Matrix3<f32>) -> UnitQuaternion<f32> {
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    fn turned(degrees: f32) -> Matrix3<f32> {
        Rotation3::from_axis_angle(&Vector3::x_axis(), degrees.to_radians()).into_inner()
    }

    #[test]
    fn the_nearest_pose_counts_in_both_directions_and_round_the_circle() {
        let mut poses = Captured::<4>::new();
        assert_eq!(poses.nearest_rad(&turned(0.0)), None);
        for degrees in [0.0, 40.0, 170.0] {
            poses.push(CableLengths::new([280.0; 6]).unwrap(), &turned(degrees)).unwrap();
        }
        for (degrees, expected) in [(0.0, 0.0), (1.0, 1.0), (25.0, 15.0), (-3.0, 3.0), (-160.0, 30.0), (105.0, 65.0)] {
            let nearest = poses.nearest_rad(&turned(degrees)).unwrap().to_degrees();
            assert!((nearest - expected).abs() < 0.02, "{degrees}: {nearest}");
        }
    }

    #[test]
    fn a_full_set_stays_as_it_is() {
        let mut poses = Captured::<1>::new();
        let lengths = CableLengths::new([280.0; 6]).unwrap();
        poses.push(lengths, &turned(0.0)).unwrap();
        let before = poses.clone();
        assert_eq!(poses.push(lengths, &turned(9.0)), Err(Full));
        assert_eq!(poses, before);
    }
}
