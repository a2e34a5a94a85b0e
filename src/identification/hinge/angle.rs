//! The angle of an identified hinge, sample by sample: searched for at first, then followed.

use super::estimator::HingeEstimator;
use super::joint::Hinge;
use super::machine::{HingeMachine, MAX_CONSTANTS};
use super::pose::{AngleSearch, PoseAt};
use super::rig::MAX_CABLES;
use crate::linear_algebra::non_negative_root;
use crate::scalar::Real;

/// Angles of the search that a call adds.
const ANGLES_A_CALL: usize = 4;
/// Gauss-Newton rounds from the last angle.
const ROUNDS: usize = 2;

/// A hinge whose angle is followed.
#[derive(Clone, Debug)]
pub struct HingeAngles<T: Real> {
    hinge: Hinge<T>,
    machine: HingeMachine<T>,
    search: AngleSearch<T>,
    /// Angles of the search so far.
    searched: usize,
    /// The last one; none while it is searched for.
    angle_rad: Option<T>,
}

/// The angle of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FollowedAngle<T> {
    /// From where the platform has the smallest rotation that brings its axis onto that of the base, rad, within ±π or so.
    pub angle_rad: T,
    /// What the lengths leave, root mean square over the lengths to spare, mm.
    pub residual_mm: T,
}

impl<T: Real> HingeEstimator<T> {
    /// The angles of a hinge that this estimator has found, with the constants of the machine that it found with it.
    pub fn angles_of(&self, hinge: &Hinge<T>, constants: &[T; MAX_CONSTANTS]) -> HingeAngles<T> {
        let mut machine = self.work.fit.machine.clone();
        machine.set_values(*constants);
        // Its own zero is anywhere.
        let from_smallest = Hinge::through(
            hinge.axis(),
            &hinge.platform_foot_mm(),
            &hinge.axis_in_platform(),
            hinge.foot_in_platform_mm(),
        );
        let own_zero = hinge.zero_from(&from_smallest);
        let mut search = AngleSearch::nowhere();
        // Two cables may fit two angles; the joint's range says which.
        search.begin(self.work.fit.range_rad().map(|(first, last)| (first + own_zero, last + own_zero)));
        HingeAngles { hinge: from_smallest, machine, search, searched: 0, angle_rad: None }
    }
}

impl<T: Real> HingeAngles<T> {
    /// Takes in the lengths of a sample, mm. `None` while the first angle is searched for, a few of all in a call, and for
    /// lengths that are no numbers: then the search begins anew.
    pub fn follow(&mut self, lengths_mm: &[T; MAX_CABLES]) -> Option<FollowedAngle<T>> {
        if self.searched < AngleSearch::<T>::ANGLES {
            let until = self.searched + ANGLES_A_CALL;
            self.search.look(&self.hinge, &self.machine, self.searched..until);
            self.searched = until;
            return None;
        }
        let cables = self.machine.cables();
        let from = self.angle_rad.unwrap_or_else(|| self.search.nearest_rad(lengths_mm, cables));
        let (angle_rad, squares) = PoseAt::new(&self.hinge, &self.machine).best_angle(lengths_mm, from, ROUNDS);
        if !(angle_rad.is_a_number() && squares.is_a_number()) {
            self.angle_rad = None;
            return None;
        }
        // Within a turn, however often it was passed.
        let angle_rad =
            if angle_rad.abs() > T::two_pi() { self.search.nearest_rad(lengths_mm, cables) } else { angle_rad };
        self.angle_rad = Some(angle_rad);
        let spare = T::of_integer(cables.saturating_sub(1).max(1) as i32);
        Some(FollowedAngle { angle_rad, residual_mm: non_negative_root(squares / spare) })
    }

    /// The hinge.
    pub fn hinge(&self) -> &Hinge<T> {
        &self.hinge
    }

    /// The machine, as it was found with the hinge.
    pub(super) fn machine(&self) -> &HingeMachine<T> {
        &self.machine
    }
}
