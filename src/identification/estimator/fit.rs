//! The fit under way: the unknowns, the normal equations of a pass, and the residuals that it leaves.

use super::model::Model;
use super::scratch::{PRODUCTS_A_SLICE, Scratch};
use crate::identification::joint::{HeldCentre, Joint};
use crate::identification::machine::{Machine, MachineEstimate};
use crate::identification::marginal_information::MarginalInformation;
use crate::identification::noise::Residuals;
use crate::identification::outcome::{Identified, rms_residual};
use crate::identification::parameters::{CENTRE_UNKNOWNS, CentreSums, Equations, ParameterBlock};
use crate::identification::pose::{Pose, PoseState};
use crate::identification::refusal::Refusal;
use crate::identification::settings::{EstimatorSettings, Noise};
use crate::identification::uncertainty::{RESULT_PACKED, packed};
use crate::identification::weights::Weights;
use crate::kinematics::rotation::turned;
use crate::kinematics::{AttitudeSearch, AttitudeSolver, CableLengths, CableSet, JointCentre, LengthJacobian};
use crate::linear_algebra::{Singular, block};
use crate::rig::Parameters;
use crate::scalar::Real;
use nalgebra::{Matrix3, Matrix6, Vector3};

/// Ridge on a pose's information when its own centre is computed: bounds the direction that a pose near a singularity
/// does not determine.
const OWN_CENTRE_RIDGE: f64 = 0.02;

/// Everything that the stages work on.
#[derive(Clone, Debug)]
pub(super) struct Fit<T: Real> {
    pub settings: EstimatorSettings<T>,
    /// O and C of the last step, mm.
    pub centre: JointCentre<T>,
    /// The machine's constants of the last step.
    pub estimate: MachineEstimate<T>,
    /// The model of the joint, with its unknowns of the last step.
    pub joint: Joint<T>,
    /// Of the pass under way; factored at its end.
    pub equations: Equations<T>,
    /// What is worked on between two slices.
    pub scratch: Scratch<T>,
    /// Information on O and C of the last pass with all other unknowns taken as known, for a noise of 1 mm.
    pub centre_information: [T; RESULT_PACKED],
    /// It is not the machine that looks like a moving centre.
    pub is_compared: bool,
    /// Why the ball was refused, once it was.
    pub ball_refusal: Option<Refusal>,
    /// The joint centre in the platform from a held phase: a prior.
    pub held: Option<HeldCentre<T>>,
    /// 1σ of a moving centre's path over the poses, across the arm and in all, mm.
    pub path_sigmas_mm: [T; 2],
    /// Residuals of the last pass.
    pub residuals: Residuals<T>,
    /// The result, filled in as the stages find it.
    pub result: Identified<T>,
}

/// A pass over the poses under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pass<T> {
    /// The next pose, from 0.
    pub next: usize,
    /// Poses with a weight above zero.
    pub used: usize,
    /// The priors are in.
    has_priors: bool,
    /// The search for the rotation of the next pose, or that it is over.
    search: Search<T>,
    /// Of O and C alone.
    centre: CentreSums<T>,
    /// Σ |S' δ̂|², mm²: the rate at which the squares fall with the scatter's variance.
    pub squared_gradients: T,
}

/// Where the next pose of a pass stands.
#[derive(Clone, Copy, Debug)]
enum Search<T> {
    /// Its rotation is the one of the pass before, or not looked at yet.
    No,
    /// It is searched for, one assembly mode a slice.
    Going(AttitudeSearch<T>),
    /// It has been searched for.
    Over,
}

impl<T: Real> Default for Pass<T> {
    fn default() -> Self {
        Self {
            next: 0,
            used: 0,
            has_priors: false,
            search: Search::No,
            centre: CentreSums::default(),
            squared_gradients: T::zero(),
        }
    }
}

impl<T: Real> Fit<T> {
    /// The fit before its first pass: the nominal centre, the machine as stated.
    // Inlined so that it is built where it stays: 10 KB more of the stack otherwise (`cargo stack`).
    #[inline(always)]
    pub fn new(machine: &Machine<T>, nominal: &Parameters<T>, settings: EstimatorSettings<T>) -> Self {
        let noise_mm = match settings.noise {
            Noise::Known(noise) => noise,
            Noise::EstimatedUpTo(_) => machine.noise_mm(),
        };
        let centre = JointCentre::from_parameters(nominal, machine.geometry());
        Self {
            settings,
            centre,
            estimate: MachineEstimate::new(machine),
            joint: Joint::Ball,
            equations: Equations::new(0),
            scratch: Scratch::Free,
            centre_information: [T::zero(); RESULT_PACKED],
            is_compared: false,
            ball_refusal: None,
            held: None,
            path_sigmas_mm: [T::zero(); 2],
            residuals: Residuals::none(noise_mm, machine.noise_mm()),
            result: Identified::empty(*nominal),
        }
    }

    /// Nothing known any more.
    pub fn restart(&mut self, machine: &Machine<T>) {
        self.estimate = MachineEstimate::new(machine);
        self.joint = Joint::Ball;
        self.is_compared = false;
        self.ball_refusal = None;
        self.held = None;
        let noise_mm = match self.settings.noise {
            Noise::Known(noise) => noise,
            Noise::EstimatedUpTo(_) => machine.noise_mm(),
        };
        self.residuals = Residuals::none(noise_mm, machine.noise_mm());
        self.result.rms_residuals_mm.clear();
    }

    /// Parameters beside O and C.
    pub fn parameters(&self) -> usize {
        self.estimate.count() + self.joint.count()
    }

    /// Variance of the noise, mm².
    pub fn variance_mm2(&self) -> T {
        self.residuals.noise_mm * self.residuals.noise_mm
    }

    /// Before a pass: the equations are empty.
    pub fn begin_pass(&mut self) {
        self.scratch = Scratch::Free;
        self.equations.clear(self.parameters() + CENTRE_UNKNOWNS);
    }

    fn add_priors(&mut self, machine: &Machine<T>) {
        let model = Model { machine, estimate: &self.estimate, joint: &self.joint };
        model.add_prior(&mut self.equations, 0, self.residuals.noise_mm * self.residuals.noise_mm);
        // The held phase is a prior for a moving centre only; a ball is judged by its own poses.
        if let (Some(held), Joint::Moving(_)) = (&self.held, &self.joint) {
            let first = self.equations.unknowns() - 3;
            let variance = self.residuals.noise_mm * self.residuals.noise_mm;
            held.add_prior(&mut self.equations, first, &self.centre.in_platform_mm, variance);
        }
    }

    /// Adds the priors, then the next pose of the pass with its weight, and refines its rotation; false after the last. Poses whose χ² is
    /// above `reinitialise_above` are re-initialised from the known centre first, in the assembly mode that fits best: that
    /// takes a call for each mode. With parameters beside the centre a pose takes some calls more.
    pub fn add_next_pose(
        &mut self,
        pass: &mut Pass<T>,
        machine: &Machine<T>,
        poses: &mut [Pose<T>],
        weights: &Weights<T>,
        reinitialise_above: T,
    ) -> bool {
        if let Some(in_work) = self.scratch.pose() {
            let model = Model { machine, estimate: &self.estimate, joint: &self.joint };
            in_work.advance(&model, &mut self.equations);
            return true;
        }
        if !core::mem::replace(&mut pass.has_priors, true) {
            self.add_priors(machine);
            return true;
        }
        let index = pass.next;
        let Some(pose) = poses.get_mut(index) else {
            pass.centre.move_to(&mut self.equations);
            return false;
        };
        if self.parameters() > 0 && !self.scratch.has_room() {
            self.scratch.make_room(pose.lengths());
            return true;
        }
        if let Search::No = pass.search
            && pose.chi_square > reinitialise_above
            && pose.state > PoseState::Broken
        {
            pass.search = Search::Going(AttitudeSearch::new());
        }
        if let Search::Going(search) = &mut pass.search {
            if self.search(search, machine, pose) {
                pass.search = Search::Over;
            }
            return true;
        }
        if self.parameters() > 0 && pose.is_placed() && self.scratch.prepared().is_none() {
            // It has been searched for, if it had to be.
            pass.search = Search::Over;
            let lengths = self.estimate.corrected(machine, pose.lengths());
            let rotation = pose.rotation();
            let jacobian = self.jacobian(&rotation, &lengths);
            self.scratch.prepare(&rotation, &lengths, jacobian);
            return true;
        }
        pass.search = Search::No;
        pass.next += 1;
        if pose.is_placed() {
            self.add_placed(pass, index, machine, pose, weights);
            // Without weight it does not go to work.
            self.scratch.forget_prepared();
        }
        true
    }

    /// The next columns of the pose in work by the fit's own model, which is to go no further; true when all are known.
    pub fn add_columns(&mut self, machine: &Machine<T>) -> bool {
        let model = Model { machine, estimate: &self.estimate, joint: &self.joint };
        self.scratch.pose().is_none_or(|in_work| in_work.add_columns(&model))
    }

    /// Whitens what is next in the rows at work; true when they are white.
    pub fn whiten(&mut self) -> bool {
        self.scratch.whiten(&self.equations)
    }

    /// Solves what is next of the right side at work; true when it is solved.
    pub fn solve(&mut self) -> bool {
        self.scratch.solve(&self.equations)
    }

    /// Goes on searching for a pose's rotation; true when that is over.
    fn search(&self, search: &mut AttitudeSearch<T>, machine: &Machine<T>, pose: &mut Pose<T>) -> bool {
        let lengths = self.estimate.corrected(machine, pose.lengths());
        let centre = self.joint.centre_at(&self.centre, &pose.rotation());
        let solver = AttitudeSolver { geometry: self.estimate.geometry(), centre: &centre };
        let is_over = search.advance(&solver, &lengths, CableSet::ALL);
        if let (true, Some(fit)) = (is_over, search.best()) {
            pose.set_attitude(fit.attitude);
        }
        is_over
    }

    #[cfg_attr(feature = "ccm", inline(never), unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    fn add_placed(
        &mut self,
        pass: &mut Pass<T>,
        index: usize,
        machine: &Machine<T>,
        pose: &mut Pose<T>,
        weights: &Weights<T>,
    ) {
        let was_used = pose.is_used();
        let rotation = pose.rotation();
        if !matches!(weights, Weights::Without { .. }) {
            pose.state = PoseState::Placed;
        }
        let mut information = match self.scratch.prepared() {
            Some(jacobian) => MarginalInformation::new(jacobian),
            None => {
                let lengths = self.estimate.corrected(machine, pose.lengths());
                MarginalInformation::new(&self.jacobian(&rotation, &lengths))
            }
        };
        let Ok(information) = &mut information else { return };
        pose.refine_attitude(turned(pose.attitude(), &information.turn));
        let relative_variance = machine.relative_variance(pose.samples);
        let variance = self.variance_mm2() * relative_variance;
        if let Weights::OwnCentres { .. } = weights {
            information.become_own_centre(T::of(OWN_CENTRE_RIDGE));
            pose.chi_square = information.squares_mm2();
        } else {
            information.add_scatter(self.joint.scatter_mm2() / variance);
            pose.chi_square = information.squares_mm2() / variance;
        }
        let weight = weights.weight(index, pose.chi_square, was_used) / relative_variance;
        // Neither zero nor NaN.
        if weight > T::zero() {
            if !matches!(weights, Weights::Without { .. }) {
                pose.state = PoseState::Used;
            }
            pass.used += 1;
            pass.squared_gradients += information.gradient_mm().norm_squared() * weight;
            pass.centre.add(&rotation, information, weight);
            self.equations.add_squares(information.squares_mm2() * weight);
            if self.parameters() > 0 {
                self.scratch.begin_prepared(information, weight);
            }
        }
    }

    /// The Jacobian of a pose at the present estimate. For a moving centre its motion with the rotation is included.
    pub fn jacobian(&self, rotation: &Matrix3<T>, lengths: &CableLengths<T>) -> LengthJacobian<T> {
        self.joint.jacobian(self.estimate.geometry(), &self.centre, rotation, lengths)
    }

    /// A copy of a pose with the rotation that fits best about the present centre; `None` when no rotation fits.
    pub fn place_about_centre(&self, machine: &Machine<T>, pose: &Pose<T>) -> Option<Pose<T>> {
        let lengths = self.estimate.corrected(machine, pose.lengths());
        let mut placed = *pose;
        if !pose.is_placed() {
            placed.place(machine.platform());
        }
        let geometry = self.estimate.geometry();
        let track = |start| self.joint.track(geometry, &self.centre, start, &lengths);
        let attitude = track(*placed.attitude()).or_else(|| {
            let centre = self.joint.centre_at(&self.centre, &placed.rotation());
            track(AttitudeSolver { geometry, centre: &centre }.solve(&lengths, CableSet::ALL)?.attitude)
        });
        placed.set_attitude(attitude?);
        Some(placed)
    }

    /// Factors the next rows of the normal equations; true when all are.
    ///
    /// # Errors
    /// [`Singular`] when the poses leave some combination of the unknowns undetermined.
    pub fn factor(&mut self) -> Result<bool, Singular> {
        if self.equations.is_unfactored() {
            self.centre_information = packed(&self.equations.trailing_matrix());
        }
        self.equations.factor_some(PRODUCTS_A_SLICE)?;
        Ok(self.equations.is_factored())
    }

    /// The step of a pass goes to work, once factored.
    pub fn begin_step(&mut self) {
        self.scratch.put_right(self.equations.gradient(), 0);
    }

    /// Takes the step, once solved, and keeps its residuals. Returns the largest change of any unknown, mm.
    pub fn take_step(&mut self, machine: &Machine<T>, pass: &Pass<T>) -> T {
        let step = self.scratch.solution();
        let squares_mm2 = self.equations.squares_after(&step);
        let parameters = self.parameters();
        let in_machine = self.estimate.count();
        let unknowns = step.iter().take(parameters + CENTRE_UNKNOWNS);
        let largest_mm = unknowns.fold(T::zero(), |largest, x| if x.abs() > largest { x.abs() } else { largest });
        let (of_parameters, of_centre) = step.split_at_checked(parameters).unwrap_or_default();
        self.joint.apply(of_parameters.get(in_machine..).unwrap_or_default());
        self.estimate.apply(machine, of_parameters);
        if let [x, y, z, u, v, w, ..] = of_centre {
            self.centre.in_base_mm += Vector3::new(*x, *y, *z);
            self.centre.in_platform_mm += Vector3::new(*u, *v, *w);
        }
        self.residuals.squares_mm2 = squares_mm2;
        self.residuals.used = pass.used;
        self.residuals.freedom = self.freedom(pass.used);
        self.result.rms_residual_mm = rms_residual(squares_mm2, pass.used);
        largest_mm
    }

    /// Degrees of freedom of the residuals of a pass: three a pose, less the unknowns that the poses determine.
    fn freedom(&self, used: usize) -> T {
        let unknown = CENTRE_UNKNOWNS as i32 + self.joint.free_parameters();
        T::of_integer((3 * used as i32 - unknown).max(1))
    }

    /// C and its covariance, once factored.
    pub fn centre_in_platform(&self) -> HeldCentre<T> {
        let covariance = self.centre_covariance() * self.variance_mm2();
        HeldCentre { in_platform_mm: self.centre.in_platform_mm, covariance_mm2: block::<T, 3, 3>(&covariance) }
    }

    /// Covariance of O and C, for a noise of 1 mm, once factored.
    pub fn centre_covariance(&self) -> Matrix6<T> {
        let mut covariance = Matrix6::zeros();
        (0..CENTRE_UNKNOWNS).for_each(|column| self.put_centre_covariance_column(&mut covariance, column));
        covariance
    }

    /// Puts one column of it, from 0.
    pub fn put_centre_covariance_column(&self, covariance: &mut Matrix6<T>, column: usize) {
        let first = self.equations.unknowns() - CENTRE_UNKNOWNS;
        let of_all = self.equations.covariance_column(first + column, first);
        let entries = of_all.iter().skip(first).copied();
        if column < CENTRE_UNKNOWNS {
            covariance.column_mut(column).iter_mut().zip(entries).for_each(|(entry, of_all)| *entry = of_all);
        }
    }
}
