//! Is it the machine? Cables that are not as stated change the lengths smoothly with the arm, and a centre that moves
//! can follow them. So before a moving centre is believed, a ball on a machine of which nothing is known exactly is held
//! against the same poses: where that explains them, nobody can tell the two apart.
//!
//! One linear step of all the machine's constants, O and C, from the poses as the moving centre has left them.

use super::Stage;
use super::fit::Fit;
use super::refine::{MEDIAN_PASSES, Refine};
use crate::identification::joint::Joint;
use crate::identification::machine::{Machine, MachineParameter, SCALE_UNIT};
use crate::identification::marginal_information::MarginalInformation;
use crate::identification::parameters::{CENTRE_UNKNOWNS, CentreSums, Column, Equations, ParameterBlock, PoseAt};
use crate::identification::pose::Pose;
use crate::identification::pose_in_work::PoseInWork;
use crate::identification::refusal::Refusal;
use crate::identification::weights::Weights;
use crate::kinematics::LengthJacobian;
use crate::scalar::Real;

/// How far a machine may be off that nobody has measured, 1σ: points, edges and encoder offsets, mm; drums, relative.
const UNMEASURED_MM: f64 = 5.0;
const UNMEASURED_DRUM: f64 = 0.02;

/// χ² over its degrees of freedom up to which a machine explains the poses. Balls in machines that are off leave 1.1 at the
/// most, shoulders with 0.35 mm of scatter 15 at least (`cargo study shoulder --seed 21`); noise that is somewhat larger than
/// stated lies between.
const EXPLAINED: f64 = 2.0;

/// All constants of the machine, none of them known exactly.
struct AllConstants<'a, T>(&'a Machine<T>);

impl<T: Real> ParameterBlock<T> for AllConstants<'_, T> {
    fn count(&self) -> usize {
        self.0.constants()
    }

    fn column(&self, index: usize, pose: &PoseAt<'_, T>) -> Column<T> {
        self.0.column(self.0.constant(index), pose)
    }

    fn add_prior(&self, equations: &mut Equations<T>, first: usize, variance_mm2: T) {
        for index in 0..self.count() {
            let sigma = match self.0.constant(index) {
                MachineParameter::Scale(_) => T::of(UNMEASURED_DRUM / SCALE_UNIT),
                _ => T::of(UNMEASURED_MM),
            };
            equations.add_to_entry(first + index, first + index, variance_mm2 / (sigma * sigma));
        }
    }
}

/// The poses are summed, then the equations are factored.
#[derive(Clone, Copy, Debug)]
pub(super) struct Compare<T> {
    next: usize,
    used: usize,
    /// The columns of the pose in work are known.
    has_columns: bool,
    /// The equations are factored, and half solved.
    is_half_solved: bool,
    centre: CentreSums<T>,
    /// Of the moving centre's fit, which goes on afterwards.
    weights: Weights<T>,
}

impl<T: Real> Compare<T> {
    /// Begins. With `weights` the moving centre's fit goes on when it is not the machine.
    pub fn new(fit: &mut Fit<T>, machine: &Machine<T>, weights: Weights<T>) -> Self {
        let all = AllConstants(machine);
        fit.equations.clear(all.count() + CENTRE_UNKNOWNS);
        fit.in_work = None;
        let variance = fit.variance_mm2();
        all.add_prior(&mut fit.equations, 0, variance);
        Self { next: 0, used: 0, has_columns: false, is_half_solved: false, centre: CentreSums::default(), weights }
    }

    /// The next slice of a pose, or of the solution.
    pub fn advance(&mut self, fit: &mut Fit<T>, machine: &Machine<T>, poses: &[Pose<T>]) -> Option<Stage<T>> {
        if let Some(in_work) = &mut fit.in_work {
            if !self.has_columns {
                self.has_columns = in_work.add_columns(&AllConstants(machine));
            } else if in_work.add_rows(&mut fit.equations) {
                fit.in_work = None;
            }
            return None;
        }
        if let Some(pose) = poses.get(self.next) {
            self.next += 1;
            if pose.is_used() {
                self.add(fit, machine, pose);
            }
            return None;
        }
        self.centre.move_to(&mut fit.equations);
        match fit.factor() {
            Ok(false) => None,
            Ok(true) if !self.is_half_solved => {
                fit.begin_step();
                self.is_half_solved = true;
                None
            }
            Ok(true) => Some(self.judge(fit, machine)),
            // Priors and poses determine all of it; rounding may not.
            Err(_) => Some(self.go_on(fit, machine)),
        }
    }

    fn add(&mut self, fit: &mut Fit<T>, machine: &Machine<T>, pose: &Pose<T>) {
        let Joint::Moving(moving) = &fit.joint else { return };
        let (rotation, lengths) = (pose.rotation(), fit.estimate.corrected(machine, pose.lengths()));
        let centre = fit.joint.centre_at(&fit.centre, &rotation);
        let jacobian = LengthJacobian::new(fit.estimate.geometry(), &centre, &rotation, &lengths);
        let Ok(mut information) = MarginalInformation::new(&jacobian) else { return };
        // Of a ball at O0: without the motion.
        information.residuals_mm += information.translation * moving.displacement_mm(&rotation);
        let at = PoseAt { rotation: &rotation, lengths: &lengths, jacobian: &jacobian };
        let weight = T::one() / pose.relative_variance;
        self.centre.add(&rotation, &information, weight);
        fit.equations.add_squares(information.squares_mm2() * weight);
        (fit.in_work, self.has_columns) = (Some(PoseInWork::new(&at, &information, None, weight)), false);
        self.used += 1;
    }

    fn judge(&self, fit: &mut Fit<T>, machine: &Machine<T>) -> Stage<T> {
        let squares_mm2 = fit.equations.squares_after(&fit.step());
        let freedom = T::of_integer((3 * self.used as i32 - CENTRE_UNKNOWNS as i32).max(1));
        if squares_mm2 <= fit.variance_mm2() * freedom * T::of(EXPLAINED) {
            return Stage::Done(Err(Refusal::MachineNotAsStated));
        }
        self.go_on(fit, machine)
    }

    fn go_on(&self, fit: &mut Fit<T>, machine: &Machine<T>) -> Stage<T> {
        fit.is_compared = true;
        Stage::Refine(Refine::new(fit, machine, self.weights, true).after(MEDIAN_PASSES))
    }
}
