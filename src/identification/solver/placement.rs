//! Where each pose stands: its rotation, and how badly it fits.

use super::attitude::PackedAttitude;
use crate::kinematics::arm::{Arm, CableSet, rotation_of};
use crate::kinematics::{CableLengths, Octahedron, Pivot, RigPoints};
use crate::rig::Rig;
use crate::scalar::Real;
use nalgebra::{Matrix3, UnitQuaternion};

/// What the solver keeps of a pose.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement<T: Real> {
    attitude: PackedAttitude<T>,
    /// Squared length residuals over the noise's variance, the pose's rotation at its best: chi-square with three
    /// degrees of freedom when the pose is sound. Infinite where it has no rotation.
    pub misfit: T,
    /// How far the pose has come.
    pub state: State,
    /// Bit k set: the triangle of cable k + 1 is broken. Both its cables are suspects until one is cleared.
    pub broken_cables: u8,
}

/// How far a pose has come, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd)]
pub(super) enum State {
    /// A triangle is broken: never takes part.
    Broken,
    /// No rotation found yet.
    Unplaced,
    /// Rotation known; took no part in the last pass.
    Placed,
    /// Took part in the last pass.
    Used,
}

impl<T: Real> Placement<T> {
    pub fn unplaced() -> Self {
        let misfit = T::of(f64::INFINITY);
        Self { attitude: PackedAttitude::identity(), misfit, state: State::Unplaced, broken_cables: 0 }
    }

    pub fn place(&mut self, attitude: &UnitQuaternion<T>) {
        self.set_attitude(attitude);
        (self.misfit, self.state) = (T::zero(), State::Placed);
    }

    /// The triangle of this cable (from 1) and the next is broken.
    pub fn set_broken(&mut self, cable: u8) {
        self.state = State::Broken;
        self.broken_cables = 0b11 << (cable - 1);
    }

    pub fn is_placed(&self) -> bool {
        self.state >= State::Placed
    }

    pub fn is_used(&self) -> bool {
        self.state == State::Used
    }

    pub fn rotation(&self) -> Matrix3<T> {
        rotation_of(&self.attitude())
    }

    pub fn attitude(&self) -> UnitQuaternion<T> {
        self.attitude.unpacked()
    }

    pub fn set_attitude(&mut self, attitude: &UnitQuaternion<T>) {
        self.attitude.set(attitude);
    }
}

/// The geometry that placing needs, computed once.
#[derive(Clone, Debug)]
pub(super) struct Placer<T: Real> {
    pub octahedron: Octahedron<T>,
    pub points: RigPoints<T>,
    pub rig_noise_mm: T,
}

impl<T: Real> Placer<T> {
    pub fn new(rig: &Rig<T>) -> Self {
        Self { octahedron: Octahedron::new(rig), points: RigPoints::new(rig), rig_noise_mm: rig.length_noise_mm() }
    }

    /// Fitting a rotation about the pivot.
    pub fn arm<'a>(&'a self, pivot: &'a Pivot<T>) -> Arm<'a, T> {
        Arm { points: &self.points, pivot }
    }

    /// Places a pose by the known pivot, on whichever side of the fold it fits best.
    pub fn replace(&self, placement: &mut Placement<T>, pivot: &Pivot<T>, lengths: &CableLengths<T>) {
        if placement.state > State::Broken
            && let Some(fit) = self.arm(pivot).fit(lengths, CableSet::ALL)
        {
            placement.place(&fit.attitude);
        }
    }
}
