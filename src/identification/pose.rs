//! A captured pose: its lengths, the platform's pose by them, and its χ².

use crate::kinematics::rotation::{nearest_attitude, rotation_of};
use crate::kinematics::{CableLengths, LengthError, PlatformError, PlatformPose, PlatformSearch, PlatformSolver};
use crate::scalar::Real;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// State of a pose, in the order in which it advances.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd)]
pub enum PoseState {
    /// The two cables of an end-point and their base edge make no triangle: never takes part.
    Broken,
    /// Forward kinematics not done yet.
    Unplaced,
    /// The forward kinematics found no platform pose.
    NotClosing,
    /// Rotation known; took no part in the last pass.
    Placed,
    /// Took part in the last pass.
    Used,
}

/// A pose. One value serves capture and estimator, so that none is placed twice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose<T: Real> {
    lengths: CableLengths<T>,
    attitude: UnitQuaternion<T>,
    origin_mm: Vector3<T>,
    /// Samples of the encoders that its lengths are the mean of; 1 by default.
    pub samples: u16,
    /// χ² of its lengths at the present estimate, the pose's rotation at its best: three degrees of freedom when the
    /// pose is sound. Infinite where it has no rotation.
    pub chi_square: T,
    /// Its state.
    pub state: PoseState,
    /// Bit k set: cable k + 1 is suspect. For a broken triangle both cables of the end-point.
    pub suspect_cables: u8,
}

impl<T: Real> Pose<T> {
    /// A pose with these lengths, not placed yet.
    pub fn new(lengths: CableLengths<T>) -> Self {
        Self {
            lengths,
            attitude: UnitQuaternion::identity(),
            origin_mm: Vector3::zeros(),
            samples: 1,
            chi_square: T::of(f64::INFINITY),
            state: PoseState::Unplaced,
            suspect_cables: 0,
        }
    }

    /// A pose with these lengths, placed.
    ///
    /// # Errors
    /// [`PlatformError`] when the lengths give no platform pose.
    pub fn placed(platform: &PlatformSolver<T>, lengths: CableLengths<T>) -> Result<Self, PlatformError> {
        let mut pose = Self::new(lengths);
        pose.set_platform(&platform.solve(&lengths)?);
        Ok(pose)
    }

    /// Places the pose, unless it is placed already. A pose that cannot be placed keeps the reason in its state.
    pub fn place(&mut self, platform: &PlatformSolver<T>) {
        let mut search = PlatformSearch::default();
        while !self.place_step(&mut search, platform) {}
    }

    /// The next step of that, with a search that begins with the first; true when the pose is placed or cannot be.
    pub fn place_step(&mut self, search: &mut PlatformSearch<T>, platform: &PlatformSolver<T>) -> bool {
        if self.state != PoseState::Unplaced {
            return true;
        }
        match search.advance(platform, &self.lengths) {
            None => return false,
            Some(Ok(pose)) => self.set_platform(&pose),
            Some(Err(PlatformError::DoesNotClose)) => self.state = PoseState::NotClosing,
            Some(Err(PlatformError::Length(LengthError { cable, .. }))) => {
                self.state = PoseState::Broken;
                self.suspect_cables = 0b11 << (cable - 1);
            }
        }
        true
    }

    /// The same pose, its lengths the mean of so many samples.
    #[must_use]
    pub fn averaged_over(self, samples: u16) -> Self {
        Self { samples, ..self }
    }

    /// Back to the state before placing; lengths and samples stay.
    pub fn reset(&mut self) {
        let Self { attitude, origin_mm, chi_square, state, suspect_cables, .. } = Self::new(self.lengths);
        (self.attitude, self.origin_mm) = (attitude, origin_mm);
        (self.chi_square, self.state, self.suspect_cables) = (chi_square, state, suspect_cables);
    }

    fn set_platform(&mut self, pose: &PlatformPose<T>) {
        self.origin_mm = pose.origin_mm;
        self.set_attitude(nearest_attitude(&pose.rotation));
    }

    /// Sets the rotation ({P} to {B}) and marks the pose as placed, with χ² 0 until the next pass.
    pub fn set_attitude(&mut self, attitude: UnitQuaternion<T>) {
        self.attitude = attitude;
        (self.chi_square, self.state) = (T::zero(), PoseState::Placed);
    }

    /// Replaces the rotation of a placed pose; its state stays.
    pub fn refine_attitude(&mut self, attitude: UnitQuaternion<T>) {
        self.attitude = attitude;
    }

    /// The six lengths.
    pub fn lengths(&self) -> &CableLengths<T> {
        &self.lengths
    }

    /// Rotation from {P} to {B}.
    pub fn attitude(&self) -> &UnitQuaternion<T> {
        &self.attitude
    }

    /// Rotation from {P} to {B} as a matrix.
    pub fn rotation(&self) -> Matrix3<T> {
        rotation_of(&self.attitude)
    }

    /// The platform's pose: origin by the forward kinematics, present rotation.
    pub fn platform(&self) -> PlatformPose<T> {
        PlatformPose { origin_mm: self.origin_mm, rotation: self.rotation() }
    }

    /// A rotation is known.
    pub fn is_placed(&self) -> bool {
        self.state >= PoseState::Placed
    }

    /// Took part in the last pass.
    pub fn is_used(&self) -> bool {
        self.state == PoseState::Used
    }
}
