//! One pass over the poses: the summed information on O and C.

use super::Weighing;
use super::placement::{Placement, State};
use crate::identification::blocks::BlockEquations;
use crate::identification::pose_information::PoseInformation;
use crate::identification::zeros::Zeros;
use crate::kinematics::CableLengths;
use crate::kinematics::arm::{rotation_of, turn_by};
use crate::kinematics::{LengthEquations, Pivot, RigPoints};
use crate::scalar::Real;

/// Ridge on a pose's information when its own centre is asked for: keeps the direction that a pose near the fold does
/// not know from drowning the others.
const OWN_CENTRE_RIDGE: f64 = 0.02;

/// Sums of a pass.
#[derive(Clone, Copy, Debug)]
pub(super) struct PassSum<T> {
    /// Normal equations of (O, C); `squares` is the weighted sum of squares before the step, mm².
    pub equations: BlockEquations<T>,
    /// What the step leaves of them, mm².
    pub squares_left_mm2: T,
    /// Poses with a weight above zero.
    pub poses: usize,
}

impl<T: Real> PassSum<T> {
    /// An empty pass.
    pub fn new() -> Self {
        Self { equations: BlockEquations::new(), squares_left_mm2: T::zero(), poses: 0 }
    }

    /// Adds a pose, if it is placed, with the weight of its misfit, and refines its rotation.
    #[cfg_attr(feature = "ccm", inline(never), unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn add(
        &mut self,
        placement: &mut Placement<T>,
        zeros: &mut impl Zeros<T>,
        (points, pivot): (&RigPoints<T>, &Pivot<T>),
        lengths: &CableLengths<T>,
        noise_mm: T,
        weighing: &Weighing<T>,
    ) {
        if !placement.is_placed() {
            return;
        }
        placement.state = State::Placed;
        let mut attitude = placement.attitude();
        let rotation = rotation_of(&attitude);
        // In place, here and elsewhere: as a result they would be copied.
        let equations = LengthEquations::new(points, pivot, &rotation, lengths);
        let mut pose = PoseInformation::empty();
        if pose.set(&equations).is_err() {
            return;
        }
        turn_by(&mut attitude, &pose.turn);
        placement.set_attitude(&attitude);
        if let Weighing::Wander { .. } = weighing {
            pose.own_centre(T::of(OWN_CENTRE_RIDGE));
            placement.misfit = pose.squares_mm2;
        } else {
            placement.misfit = pose.squares_mm2 / (noise_mm * noise_mm);
        }
        let weight = weighing.weight(placement.misfit);
        // Neither zero nor NaN.
        if weight.abs() > T::zero() {
            placement.state = State::Used;
            self.poses += 1;
            self.equations.squares += pose.squares_mm2 * weight;
            self.equations.add_pose(&rotation, &pose.information, &pose.gradient_mm, weight);
            zeros.add_pose(&rotation, &equations, &pose, weight);
        }
    }
}
