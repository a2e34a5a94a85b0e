//! One pass over the poses: the summed information on O and C.

use super::Weighing;
use super::judgement;
use super::placement::Placement;
use crate::calls::root;
use crate::identification::blocks::BlockEquations;
use crate::identification::normal_equations::UNKNOWNS;
use crate::identification::outcome::Refusal;
use crate::identification::pose_information::PoseInformation;
use crate::identification::zeros::Zeros;
use crate::kinematics::LengthEquations;
use crate::kinematics::arm::turn_by;
use crate::scalar::Real;
use nalgebra::Matrix3;

/// Ridge on a pose's information when its own centre is asked for: keeps the direction that a pose near the fold does
/// not know from drowning the others.
const OWN_CENTRE_RIDGE: f64 = 0.02;

/// Sums of a pass.
#[derive(Clone, Debug)]
pub(super) struct PassSum<T> {
    /// Normal equations of (O, C); `squares` is the weighted sum of squares before the step, mm².
    pub equations: BlockEquations<T>,
    /// Poses with a weight above zero.
    pub poses: usize,
}

impl<T: Real> PassSum<T> {
    /// An empty pass.
    pub fn new() -> Self {
        Self { equations: BlockEquations::new(), poses: 0 }
    }

    /// Adds a placed pose with the weight of its misfit, and refines its rotation.
    #[inline(never)]
    pub fn add(
        &mut self,
        placement: &mut Placement<T>,
        zeros: &mut impl Zeros<T>,
        rotation: &Matrix3<T>,
        lengths: &LengthEquations<T>,
        variance_mm2: T,
        weighing: Weighing<T>,
    ) {
        placement.set_used(false);
        // In place, here and elsewhere: as a result it would be copied.
        let mut pose = PoseInformation::empty();
        if pose.set(lengths).is_err() {
            return;
        }
        if let Weighing::Wander { .. } = weighing {
            pose.own_centre(T::of(OWN_CENTRE_RIDGE));
            placement.misfit = pose.squares_mm2;
        } else {
            placement.misfit = pose.squares_mm2 / variance_mm2;
        }
        let mut attitude = placement.attitude();
        turn_by(&mut attitude, &pose.turn);
        placement.set_attitude(&attitude);
        let weight = weighing.weight(placement.misfit);
        if weight > T::zero() {
            placement.set_used(true);
            self.poses += 1;
            self.equations.squares += pose.squares_mm2 * weight;
            self.equations.add_pose(rotation, &pose.information, &pose.gradient_mm, weight);
            zeros.add_pose(rotation, lengths, &pose, weight);
        }
    }

    /// How far the centre wanders, or that a few poses alone are to blame.
    #[inline(never)]
    pub fn wander(&self, squares_mm2: T, placements: &[Placement<T>], rejected: u16, poses: usize) -> Refusal {
        let freedom = T::of_integer((3 * self.poses as i32 - UNKNOWNS as i32).max(1));
        let variance = squares_mm2 / freedom;
        let median = judgement::misfits(placements).median;
        // A normal scatter in space has a mean of its squares 1.27 times their median; a few poses far off, much more.
        let scattered = variance * T::of(3.0) <= median * T::of(judgement::SCATTER_RATIO);
        if scattered {
            Refusal::NotABall { wander_mm: root(variance).to_f32() }
        } else {
            Refusal::TooManyOutliers { rejected, poses: poses as u16 }
        }
    }
}
