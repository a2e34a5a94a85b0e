//! One pass over the poses: the summed information on O and C.

use super::judgement;
use super::placement::{Placement, Placer};
use crate::identification::blocks::BlockEquations;
use crate::identification::normal_equations::{Singular, UNKNOWNS};
use crate::identification::outcome::Refusal;
use crate::identification::pose_information::PoseInformation;
use crate::identification::zeros::ZeroEquations;
use crate::kinematics::arm::turned;
use crate::kinematics::{CableLengths, LengthEquations, Pivot};
use crate::rig::CABLES;
use crate::scalar::Real;
use crate::symmetric::Symmetric;
use crate::vector::square;

/// Ridge on a pose's information when its own centre is asked for: keeps the direction that a pose near the fold does
/// not know from drowning the others.
const OWN_CENTRE_RIDGE: f64 = 0.02;

/// Sums of a pass.
#[derive(Clone, Debug)]
pub(super) struct PassSum<T> {
    /// Normal equations of (O, C); `squares` is the weighted sum of squares before the step, mm².
    pub equations: BlockEquations<T>,
    /// The part of the zeros, when they are unknown.
    pub zeros: Option<ZeroEquations<T>>,
    /// Poses with a weight above zero.
    pub poses: usize,
}

/// A Gauss-Newton step of all unknowns.
pub(super) struct Step<T> {
    /// O and C, mm.
    pub pivot: [T; UNKNOWNS],
    /// The encoder zeros, mm.
    pub zeros: [T; CABLES],
    /// Sum of squares that the step leaves, mm² (of the linear problem, exact at convergence).
    pub squares_left: T,
}

impl<T: Real> Step<T> {
    /// The step of O and C alone.
    #[inline(never)]
    fn of(equations: &BlockEquations<T>) -> Result<Self, Singular> {
        let pivot = equations.solve()?;
        Ok(Self { pivot, zeros: [T::zero(); CABLES], squares_left: (equations.squares - equations.gained(&pivot)).max(T::zero()) })
    }

    /// Largest move of any unknown, mm.
    pub fn largest(&self) -> T {
        self.pivot.iter().chain(&self.zeros).fold(T::zero(), |largest, x| largest.max(x.abs()))
    }
}

impl<T: Real> PassSum<T> {
    /// An empty pass.
    pub fn new(zeros: Option<ZeroEquations<T>>) -> Self {
        Self { equations: BlockEquations::new(), zeros, poses: 0 }
    }

    /// The step of the pass.
    #[inline(never)]
    pub fn step(&self) -> Result<Step<T>, Singular> {
        // One or the other: with unknown zeros a step takes four times the stack.
        match &self.zeros {
            Some(zeros) => self.step_with(zeros),
            None => Step::of(&self.equations),
        }
    }

    #[inline(never)]
    fn step_with(&self, zeros: &ZeroEquations<T>) -> Result<Step<T>, Singular> {
        let Ok(reduced) = &zeros.reduce(&self.equations) else { return Err(Singular) };
        let step = Step::of(&reduced.equations)?;
        Ok(Step { zeros: reduced.zeros_step(&step.pivot), ..step })
    }

    /// Adds one pose with the weight that `weight` gives to its misfit, and refines its rotation.
    #[inline(never)]
    pub fn add(
        &mut self,
        placement: &mut Placement<T>,
        placer: &Placer<T>,
        pivot: &Pivot<T>,
        lengths: &CableLengths<T>,
        variance_mm2: T,
        weight: &dyn Fn(T) -> T,
    ) {
        if !placement.is_placed() {
            return;
        }
        let rotation = placement.rotation();
        let equations = LengthEquations::new(&placer.points, pivot, &rotation, lengths);
        // By reference, here and elsewhere: moved out of the option it would be copied.
        let Some(pose) = &PoseInformation::of(&equations) else {
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
            self.equations.add_pose(&rotation, &pose.eliminated.rest, &pose.gradient_mm, weight);
            if let Some(zeros) = &mut self.zeros {
                zeros.add(&rotation, &equations, pose, weight);
            }
        }
    }

    /// Adds the centre that a pose would have by itself, all poses alike; its squared distance replaces the misfit.
    #[inline(never)]
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
        let Some(pose) = &PoseInformation::of(&equations) else { return };
        let (one, mut ridged) = (Symmetric::diagonal(T::one()), pose.eliminated.rest);
        ridged.add(&one, T::of(OWN_CENTRE_RIDGE));
        let Some(inverse) = &ridged.inverse(&ridged, T::zero()) else { return };
        let own = inverse.image(&pose.gradient_mm);
        placement.misfit = square(&own);
        placement.set_attitude(turned(placement.attitude(), &pose.turn));
        self.poses += 1;
        self.equations.squares += square(&own);
        self.equations.add_pose(&rotation, &one, &own, T::one());
    }

    /// How far the centre wanders, or that a few poses alone are to blame.
    #[inline(never)]
    pub fn wander(&self, step: &Step<T>, placements: &mut [Placement<T>], rejected: u16, poses: usize) -> Refusal {
        let freedom = T::of_integer((3 * self.poses as i32 - UNKNOWNS as i32).max(1));
        let variance = step.squares_left / freedom;
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
