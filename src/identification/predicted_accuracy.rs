//! Predicted accuracy: the standard deviation that the poses captured so far will give, updated with every pose
//! (running covariance).
//!
//! The information of a pose depends on its geometry alone, so the covariance of a result can be predicted without
//! residuals: after each pose the device reports how good the centre would be, and which direction is worst. A ball
//! joint is assumed.

use super::estimator::Model;
use super::excitation::Excitation;
use super::joint::Joint;
use super::machine::{MAX_MACHINE, Machine, MachineEstimate};
use super::marginal_information::MarginalInformation;
use super::parameters::{CENTRE_UNKNOWNS, Equations, ParameterBlock, PoseAt, add_pose};
use super::pivot_calibration::PivotCalibration;
use super::pose::Pose;
use super::uncertainty::worst_direction_of_point;
use crate::kinematics::{JointCentre, LengthJacobian};
use crate::rig::Parameters;
use crate::scalar::Real;
use nalgebra::Matrix3;

const _: () = assert!(MAX_MACHINE + CENTRE_UNKNOWNS <= super::parameters::MAX_UNKNOWNS);

/// The information gathered so far.
#[derive(Clone, Debug)]
pub struct PredictedAccuracy<T: Real> {
    centre: JointCentre<T>,
    estimate: MachineEstimate<T>,
    calibration: PivotCalibration<T>,
    /// Of the poses alone, without priors.
    information: Equations<T>,
    poses: usize,
}

/// The accuracy of an identification from the poses so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Predicted<T> {
    /// 1σ of the centre in its worst direction, mm.
    pub sigma_mm: T,
    /// That direction in {B}, a unit vector.
    pub direction: [T; 3],
}

impl<T: Real> PredictedAccuracy<T> {
    /// No poses yet. The information of the first ones is computed at the nominal centre.
    // Inlined so that it is built where it stays: 3 KB of stack otherwise (`cargo stack --ways`).
    #[inline(always)]
    pub fn new(machine: &Machine<T>, nominal: &Parameters<T>) -> Self {
        Self {
            centre: JointCentre::from_parameters(nominal, machine.geometry()),
            estimate: MachineEstimate::new(machine),
            calibration: PivotCalibration::default(),
            information: Equations::new(machine.parameters() + CENTRE_UNKNOWNS),
            poses: 0,
        }
    }

    /// No poses any more. In place: its equations are too large to be built on a small stack a second time.
    pub fn restart(&mut self, machine: &Machine<T>, nominal: &Parameters<T>) {
        self.centre = JointCentre::from_parameters(nominal, machine.geometry());
        self.estimate = MachineEstimate::new(machine);
        self.calibration = PivotCalibration::default();
        self.information.clear(machine.parameters() + CENTRE_UNKNOWNS);
        self.poses = 0;
    }

    /// Adds a placed pose.
    pub fn add(&mut self, machine: &Machine<T>, pose: &Pose<T>) {
        self.calibration.add(&pose.platform());
        // The nominal centre serves until the pivot calibration of the poses has a solution.
        if let Ok(centre) = self.calibration.solve() {
            self.centre = centre;
        }
        let rotation = pose.rotation();
        let jacobian = LengthJacobian::new(machine.geometry(), &self.centre, &rotation, pose.lengths());
        let Ok(information) = MarginalInformation::new(&jacobian) else { return };
        let at = PoseAt { rotation: &rotation, lengths: pose.lengths(), jacobian: &jacobian };
        let model = Model { machine, estimate: &self.estimate, joint: &Joint::Ball, features: None };
        add_pose(&mut self.information, &model, &at, &information, T::one() / machine.relative_variance(pose.samples));
        self.poses += 1;
    }

    /// Accuracy with the poses so far; `None` while they leave the centre undetermined.
    pub fn predicted(&self, machine: &Machine<T>) -> Option<Predicted<T>> {
        self.predicted_of(machine, T::one())
    }

    /// Accuracy with `more` further poses distributed like those so far; `None` as for [`predicted`](Self::predicted).
    pub fn predicted_with(&self, machine: &Machine<T>, more: usize) -> Option<Predicted<T>> {
        if self.poses == 0 {
            return None;
        }
        let all = T::of_integer((self.poses + more) as i32);
        self.predicted_of(machine, all / T::of_integer(self.poses as i32))
    }

    /// The standard deviation with `more` further poses distributed like those so far, given what is `predicted` now, mm.
    pub fn sigma_with(&self, machine: &Machine<T>, predicted: &Predicted<T>, more: usize) -> Option<T> {
        if machine.parameters() != 0 || self.poses == 0 {
            return self.predicted_with(machine, more).map(|predicted| predicted.sigma_mm);
        }
        // Without priors the covariance is in inverse proportion to the poses.
        let times = T::of_integer(self.poses as i32) / T::of_integer((self.poses + more) as i32);
        Some(predicted.sigma_mm * times.root())
    }

    fn predicted_of(&self, machine: &Machine<T>, times: T) -> Option<Predicted<T>> {
        let mut equations = Equations::new(self.information.unknowns());
        equations.add(&self.information, times);
        let noise_mm = machine.noise_mm();
        let model = Model { machine, estimate: &self.estimate, joint: &Joint::Ball, features: None };
        model.add_prior(&mut equations, 0, noise_mm * noise_mm);
        equations.factor().ok()?;
        let first = machine.parameters();
        let mut centre = Matrix3::zeros();
        for j in 0..3 {
            let column = equations.covariance_column(first + j, first);
            for (i, entry) in column.iter().skip(first).take(3).enumerate() {
                centre[(i, j)] = *entry;
            }
        }
        let (sigma, direction) = worst_direction_of_point(&centre);
        Some(Predicted { sigma_mm: sigma * noise_mm, direction })
    }

    /// Rotational excitation of the poses so far.
    pub fn excitation(&self) -> Excitation<T> {
        self.calibration.rotations().excitation()
    }
}
