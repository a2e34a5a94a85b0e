//! Predicted accuracy: the standard deviation that the poses captured so far will give, updated with every pose
//! (running covariance).
//!
//! The information of a pose depends on its geometry alone, so the covariance of a result can be predicted without
//! residuals: after each pose the device reports how good the centre would be, and which direction is worst. A ball
//! joint is assumed.
//!
//! [`add`](PredictedAccuracy::add) and [`predicted`](PredictedAccuracy::predicted) do it at once;
//! [`begin`](PredictedAccuracy::begin) and [`advance`](PredictedAccuracy::advance) a slice at a time, in the workspace of an
//! estimator that has nothing to do meanwhile.

use super::estimator::{Model, Scratch, Workspace};
use super::excitation::Excitation;
use super::joint::Joint;
use super::machine::{MAX_MACHINE, Machine, MachineEstimate};
use super::marginal_information::MarginalInformation;
use super::parameters::{CENTRE_UNKNOWNS, CentreSums, Equations, MAX_UNKNOWNS, PoseAt};
use super::pivot_calibration::PivotCalibration;
use super::pose::Pose;
use super::uncertainty::worst_direction_of_point;
use crate::kinematics::rotation::rotation_of;
use crate::kinematics::{JointCentre, LengthJacobian};
use crate::linear_algebra::packed_index;
use crate::rig::Parameters;
use crate::scalar::Real;
use nalgebra::{Matrix3, UnitQuaternion};

/// Multiplications of a slice of the factorization.
const PRODUCTS_A_SLICE: usize = 560;

/// Unknowns at the most: the machine's constants, O and C. The estimator's equations have room for more.
const UNKNOWNS: usize = MAX_MACHINE + CENTRE_UNKNOWNS;
const _: () = assert!(UNKNOWNS <= MAX_UNKNOWNS);

/// The information gathered so far.
#[derive(Clone, Debug)]
pub struct PredictedAccuracy<T: Real> {
    centre: JointCentre<T>,
    calibration: PivotCalibration<T>,
    /// The normal matrix of the poses alone, without priors: a packed lower triangle.
    information: [T; packed_index(UNKNOWNS, 0)],
    unknowns: usize,
    poses: usize,
    step: Step<T>,
}

/// Where the prediction under way stands.
#[derive(Clone, Copy, Debug)]
enum Step<T: Real> {
    /// There is none.
    Nothing,
    /// The centre is found anew, with the pose that is added: its rotation as it was captured.
    Centre(UnitQuaternion<T>),
    /// What the pose says of the centre.
    See(UnitQuaternion<T>),
    /// What it says of the machine.
    Machine,
    /// Its information is added to that of the others.
    Keep,
    /// The covariance with the poses so far.
    Now(Covariance<T>),
    /// With more of them.
    WithMore(Predicted<T>, Covariance<T>),
}

/// The covariance of the centre as it is computed.
#[derive(Clone, Copy, Debug)]
enum Covariance<T> {
    /// The information of the poses, so many times.
    Sum(T),
    Prior,
    Factor,
    Solve,
    /// Its worst direction.
    Direction(Matrix3<T>),
}

/// The accuracy of an identification from the poses so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Predicted<T> {
    /// 1σ of the centre in its worst direction, mm.
    pub sigma_mm: T,
    /// That direction in {B}, a unit vector.
    pub direction: [T; 3],
}

/// What the poses so far promise, and some more like them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction<T> {
    /// With the poses so far; `None` while they leave the centre undetermined.
    pub now: Option<Predicted<T>>,
    /// 1σ with more poses, mm.
    pub sigma_with_more_mm: Option<T>,
}

impl<T: Real> PredictedAccuracy<T> {
    /// No poses yet. The information of the first ones is computed at the nominal centre.
    pub fn new(machine: &Machine<T>, nominal: &Parameters<T>) -> Self {
        Self {
            centre: JointCentre::from_parameters(nominal, machine.geometry()),
            calibration: PivotCalibration::default(),
            information: [T::zero(); packed_index(UNKNOWNS, 0)],
            unknowns: machine.parameters() + CENTRE_UNKNOWNS,
            poses: 0,
            step: Step::Nothing,
        }
    }

    /// No poses any more. In place: its equations are too large to be built on a small stack a second time.
    pub fn restart(&mut self, machine: &Machine<T>, nominal: &Parameters<T>) {
        self.centre = JointCentre::from_parameters(nominal, machine.geometry());
        self.calibration = PivotCalibration::default();
        self.information.iter_mut().for_each(|entry| *entry = T::zero());
        self.unknowns = machine.parameters() + CENTRE_UNKNOWNS;
        (self.poses, self.step) = (0, Step::Nothing);
    }

    /// Adds a placed pose.
    pub fn add(&mut self, machine: &Machine<T>, pose: &Pose<T>) {
        let (mut equations, mut scratch) = (Equations::new(self.unknowns), Scratch::Free);
        self.begin(pose);
        while !matches!(self.step, Step::Now(_)) {
            let workspace = Workspace { equations: &mut equations, scratch: &mut scratch };
            let _ = self.advance(machine, pose, 0, workspace);
        }
        self.step = Step::Nothing;
    }

    /// Begins to add a placed pose. Its lengths are wanted again until that is done, its rotation is not.
    pub fn begin(&mut self, pose: &Pose<T>) {
        self.calibration.add(&pose.platform());
        self.step = Step::Centre(*pose.attitude());
    }

    /// What a pose says of the centre; what it says of the machine goes to work.
    fn see(
        &mut self,
        machine: &Machine<T>,
        pose: &Pose<T>,
        attitude: &UnitQuaternion<T>,
        Workspace { equations, scratch }: Workspace<'_, T>,
    ) -> Step<T> {
        let rotation = rotation_of(attitude);
        let jacobian = LengthJacobian::new(machine.geometry(), &self.centre, &rotation, pose.lengths());
        let Ok(information) = MarginalInformation::new(&jacobian) else {
            return Step::Now(Covariance::Sum(T::one()));
        };
        let at = PoseAt { rotation: &rotation, lengths: pose.lengths(), jacobian: &jacobian };
        let weight = T::one() / machine.relative_variance(pose.samples);
        equations.clear(self.unknowns);
        let mut sums = CentreSums::default();
        sums.add(&rotation, &information, weight);
        sums.move_to(equations);
        self.poses += 1;
        if machine.parameters() == 0 {
            return Step::Keep;
        }
        scratch.put_pose(&at, &information, weight);
        Step::Machine
    }

    /// The next slice of what the pose in work says of the machine as it is stated; true when all is said.
    fn add_in_work(machine: &Machine<T>, Workspace { equations, scratch }: Workspace<'_, T>) -> bool {
        // Made when it is wanted, for it takes 0.4 KB.
        let estimate = &MachineEstimate::new(machine);
        let model = Model { machine, estimate, joint: &Joint::Ball };
        scratch.pose().is_none_or(|in_work| in_work.advance(&model, equations))
    }

    /// The next slice of what was begun with this pose; what all of them promise, after the last. `more`: poses distributed
    /// like those so far.
    pub fn advance(
        &mut self,
        machine: &Machine<T>,
        pose: &Pose<T>,
        more: usize,
        workspace: Workspace<'_, T>,
    ) -> Option<Prediction<T>> {
        let nothing = Prediction { now: None, sigma_with_more_mm: None };
        let Workspace { equations, scratch } = workspace;
        match self.step {
            Step::Nothing => return Some(nothing),
            Step::Centre(attitude) => {
                // The nominal centre serves until the pivot calibration of the poses has a solution.
                if let Ok(centre) = self.calibration.solve() {
                    self.centre = centre;
                }
                if machine.parameters() > 0 && !scratch.has_room() {
                    scratch.make_room(pose.lengths());
                }
                self.step = Step::See(attitude);
            }
            Step::See(attitude) => self.step = self.see(machine, pose, &attitude, Workspace { equations, scratch }),
            Step::Machine => {
                if Self::add_in_work(machine, Workspace { equations, scratch }) {
                    self.step = Step::Keep;
                }
            }
            Step::Keep => {
                let used = packed_index(self.unknowns, 0);
                let entries = self.information.iter_mut().zip(equations.matrix()).take(used);
                entries.for_each(|(entry, of_pose)| *entry += *of_pose);
                self.step = Step::Now(Covariance::Sum(T::one()));
            }
            Step::Now(mut covariance) => {
                let Some(predicted) = self.next_of(&mut covariance, machine, equations) else {
                    self.step = Step::Now(covariance);
                    return None;
                };
                self.step = Step::Nothing;
                let Some(now) = predicted else { return Some(nothing) };
                if machine.parameters() == 0 {
                    // Without priors the covariance is in inverse proportion to the poses.
                    let (poses, all) = (T::of_integer(self.poses as i32), T::of_integer((self.poses + more) as i32));
                    let sigma_with_more_mm = Some(now.sigma_mm * (poses / all).root());
                    return Some(Prediction { now: predicted, sigma_with_more_mm });
                }
                self.step = Step::WithMore(now, Covariance::Sum(self.times_with(more)));
            }
            Step::WithMore(now, mut covariance) => {
                let Some(with_more) = self.next_of(&mut covariance, machine, equations) else {
                    self.step = Step::WithMore(now, covariance);
                    return None;
                };
                self.step = Step::Nothing;
                let sigma_with_more_mm = with_more.map(|predicted| predicted.sigma_mm);
                return Some(Prediction { now: Some(now), sigma_with_more_mm });
            }
        }
        None
    }

    /// How many times the information of the poses so far is that with `more`.
    fn times_with(&self, more: usize) -> T {
        T::of_integer((self.poses + more) as i32) / T::of_integer(self.poses.max(1) as i32)
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
        self.predicted_of(machine, self.times_with(more))
    }

    fn predicted_of(&self, machine: &Machine<T>, times: T) -> Option<Predicted<T>> {
        let mut equations = Equations::new(self.unknowns);
        let mut covariance = Covariance::Sum(times);
        loop {
            if let Some(predicted) = self.next_of(&mut covariance, machine, &mut equations) {
                return predicted;
            }
        }
    }

    /// The next slice of a covariance; after the last its worst direction, or that it has none.
    fn next_of(
        &self,
        covariance: &mut Covariance<T>,
        machine: &Machine<T>,
        equations: &mut Equations<T>,
    ) -> Option<Option<Predicted<T>>> {
        let noise_mm = machine.noise_mm();
        *covariance = match *covariance {
            Covariance::Sum(times) => {
                equations.clear(self.unknowns);
                equations.add_matrix(&self.information, times);
                Covariance::Prior
            }
            Covariance::Prior => {
                MachineEstimate::new(machine).add_prior(machine, equations, 0, noise_mm * noise_mm);
                Covariance::Factor
            }
            Covariance::Factor => match equations.factor_some(PRODUCTS_A_SLICE) {
                Ok(()) if equations.is_factored() => Covariance::Solve,
                Ok(()) => Covariance::Factor,
                Err(_) => return Some(None),
            },
            Covariance::Solve => Covariance::Direction(covariance_of_centre(equations)),
            Covariance::Direction(of_centre) => {
                let (sigma, direction) = worst_direction_of_point(&of_centre);
                return Some(Some(Predicted { sigma_mm: sigma * noise_mm, direction }));
            }
        };
        None
    }

    /// Rotational excitation of the poses so far.
    pub fn excitation(&self) -> Excitation<T> {
        self.calibration.rotations().excitation()
    }
}

/// Covariance of O from the factor of the equations, for a noise of 1 mm.
fn covariance_of_centre<T: Real>(equations: &Equations<T>) -> Matrix3<T> {
    let first = equations.unknowns() - CENTRE_UNKNOWNS;
    let mut centre = Matrix3::zeros();
    for j in 0..3 {
        let column = equations.covariance_column(first + j, first);
        for (i, entry) in column.iter().skip(first).take(3).enumerate() {
            centre[(i, j)] = *entry;
        }
    }
    centre
}
