//! Where each pose stands: its rotation, and how badly it fits.

use super::attitude::PackedAttitude;
use crate::kinematics::arm::{Arm, CableSet, nearest_attitude, rotation_of};
use crate::kinematics::{CableLengths, Octahedron, Pivot, RigPoints};
use crate::rig::Rig;
use crate::scalar::Real;
use nalgebra::{Matrix3, UnitQuaternion};

/// What the solver keeps of a pose.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement<T: Real> {
    attitude: PackedAttitude<T>,
    /// Squared length residuals over the noise's variance, the pose's rotation at its best: chi-square with three
    /// degrees of freedom when the pose is sound.
    pub misfit: T,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// No rotation found yet.
    Unplaced,
    /// Rotation known; took no part in the last pass.
    Placed,
    /// Took part in the last pass.
    Used,
    /// The triangle of this cable (from 1) and its neighbour is broken: never takes part.
    Broken(u8),
}

impl<T: Real> Placement<T> {
    pub fn at(rotation: &Matrix3<T>) -> Self {
        Self { attitude: PackedAttitude::of(&nearest_attitude(rotation)), misfit: T::zero(), state: State::Placed }
    }

    pub fn unplaced() -> Self {
        Self { attitude: PackedAttitude::identity(), misfit: T::zero(), state: State::Unplaced }
    }

    pub fn broken(cable: u8) -> Self {
        Self { state: State::Broken(cable), ..Self::unplaced() }
    }

    pub fn is_placed(&self) -> bool {
        matches!(self.state, State::Placed | State::Used)
    }

    pub fn is_used(&self) -> bool {
        self.state == State::Used
    }

    pub fn set_used(&mut self, used: bool) {
        if self.is_placed() {
            self.state = if used { State::Used } else { State::Placed };
        }
    }

    /// First cable (from 1) of a broken triangle.
    pub fn broken_cable(&self) -> Option<u8> {
        match self.state {
            State::Broken(cable) => Some(cable),
            _ => None,
        }
    }

    /// Both cables of a broken triangle are suspects until one is cleared.
    pub fn broken_cables(&self) -> u8 {
        self.broken_cable().map_or(0, |cable| 0b11 << (cable - 1))
    }

    pub fn rotation(&self) -> Matrix3<T> {
        rotation_of(&self.attitude())
    }

    pub fn attitude(&self) -> UnitQuaternion<T> {
        self.attitude.unpacked()
    }

    pub fn set_attitude(&mut self, attitude: &UnitQuaternion<T>) {
        self.attitude = PackedAttitude::of(attitude);
        if self.state == State::Unplaced {
            self.state = State::Placed;
        }
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
        if matches!(placement.state, State::Broken(_)) {
            return;
        }
        if let Some(fit) = self.arm(pivot).fit(lengths, CableSet::ALL) {
            placement.set_attitude(&fit.attitude);
        }
    }
}
