//! One pass over the poses: the summed information on O and C.

use super::judgement;
use super::placement::{Placement, Placer};
use crate::identification::normal_equations::{NormalEquations, UNKNOWNS};
use crate::identification::outcome::Refusal;
use crate::identification::pose_information::PoseInformation;
use crate::kinematics::arm::turned;
use crate::kinematics::pivot::inverse_of_symmetric;
use crate::kinematics::{CableLengths, LengthEquations, Pivot};
use crate::scalar::Real;
use nalgebra::Matrix3;

/// Ridge on a pose's information when its own centre is asked for: keeps the direction that a pose near the fold does
/// not know from drowning the others.
const OWN_CENTRE_RIDGE: f64 = 0.02;

/// Sums of a pass.
#[derive(Clone, Debug)]
pub(super) struct PassSum<T> {
    /// Normal equations of (O, C); `squares` is the weighted sum of squares before the step, mm².
    pub equations: NormalEquations<T>,
    /// Poses with a weight above zero.
    pub poses: usize,
}

impl<T: Real> PassSum<T> {
    pub fn new() -> Self {
        Self { equations: NormalEquations::new(), poses: 0 }
    }

    /// Sum of squares that the step leaves, mm² (of the linear problem, exact at convergence).
    pub fn squares_after(&self, step: &[T; UNKNOWNS]) -> T {
        let gained = step.iter().zip(&self.equations.gradient).fold(T::zero(), |sum, (x, g)| sum + *x * *g);
        (self.equations.squares - gained).max(T::zero())
    }

    /// Adds one pose with the weight that `weight` gives to its misfit, and refines its rotation.
    pub fn add(
        &mut self,
        placement: &mut Placement<T>,
        placer: &Placer<T>,
        pivot: &Pivot<T>,
        lengths: &CableLengths<T>,
        variance_mm2: T,
        weight: impl Fn(T) -> T,
    ) {
        if !placement.is_placed() {
            return;
        }
        let rotation = placement.rotation();
        let equations = LengthEquations::new(&placer.points, pivot, &rotation, lengths);
        let Some(pose) = PoseInformation::of(&equations) else {
            placement.set_used(false);
            return;
        };
        placement.misfit = pose.squares_mm2 / variance_mm2;
        let weight = weight(placement.misfit);
        placement.set_used(weight > T::zero());
        placement.set_attitude(turned(placement.attitude(), &pose.turn));
        if weight > T::zero() {
            self.poses += 1;
            self.equations.squares += pose.squares_mm2 * weight;
            self.equations.add_information(&rotation, &(pose.information * weight), &(pose.gradient_mm * weight));
        }
    }

    /// Adds the centre that a pose would have by itself, all poses alike; its squared distance replaces the misfit.
    pub fn add_own_centre(
        &mut self,
        placement: &mut Placement<T>,
        placer: &Placer<T>,
        pivot: &Pivot<T>,
        lengths: &CableLengths<T>,
    ) {
        if !placement.is_placed() {
            return;
        }
        let rotation = placement.rotation();
        let equations = LengthEquations::new(&placer.points, pivot, &rotation, lengths);
        let ridge = Matrix3::identity() * T::of(OWN_CENTRE_RIDGE);
        let Some(pose) = PoseInformation::of(&equations) else { return };
        let Some(inverse) = inverse_of_symmetric(&(pose.information + ridge)) else { return };
        let own = inverse * pose.gradient_mm;
        placement.misfit = own.norm_squared();
        placement.set_attitude(turned(placement.attitude(), &pose.turn));
        self.poses += 1;
        self.equations.squares += own.norm_squared();
        self.equations.add_information(&rotation, &Matrix3::identity(), &own);
    }

    /// How far the centre wanders, or that a few poses alone are to blame.
    pub fn wander(
        &self,
        step: &[T; UNKNOWNS],
        placements: &mut [Placement<T>],
        rejected: u16,
        poses: usize,
    ) -> Refusal {
        let freedom = T::of_integer((3 * self.poses as i32 - UNKNOWNS as i32).max(1));
        let variance = self.squares_after(step) / freedom;
        let median = judgement::median_misfit(placements);
        // A normal scatter in space has a mean of its squares 1.27 times their median; a few poses far off, much more.
        let scattered = variance * T::of(3.0) <= median * T::of(judgement::SCATTER_RATIO);
        if scattered {
            Refusal::NotABall { wander_mm: variance.root().to_f32() }
        } else {
            Refusal::TooManyOutliers { rejected, poses: poses as u16 }
        }
    }
}
