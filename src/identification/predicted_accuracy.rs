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
use super::parameters::{CENTRE_UNKNOWNS, CentreSums, Equations, PoseAt};
use super::pivot_calibration::PivotCalibration;
use super::pose::Pose;
use super::pose_in_work::PoseInWork;
use super::uncertainty::worst_direction_of_point;
use crate::kinematics::{JointCentre, LengthJacobian};
use crate::rig::Parameters;
use crate::scalar::Real;
use nalgebra::Matrix3;

/// Multiplications of a slice of the factorization.
const PRODUCTS_A_SLICE: usize = 900;

const _: () = assert!(MAX_MACHINE + CENTRE_UNKNOWNS <= super::parameters::MAX_UNKNOWNS);

/// The information gathered so far.
#[derive(Clone, Debug)]
pub struct PredictedAccuracy<T: Real> {
    centre: JointCentre<T>,
    calibration: PivotCalibration<T>,
    /// Of the poses alone, without priors.
    information: Equations<T>,
    poses: usize,
    step: Step<T>,
}

/// Where the prediction under way stands.
#[derive(Clone, Copy, Debug)]
enum Step<T> {
    /// There is none.
    Nothing,
    /// The pose is added.
    Columns,
    Rows,
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
    // Inlined so that it is built where it stays: 3 KB of stack otherwise (`cargo stack --ways`).
    #[inline(always)]
    pub fn new(machine: &Machine<T>, nominal: &Parameters<T>) -> Self {
        Self {
            centre: JointCentre::from_parameters(nominal, machine.geometry()),
            calibration: PivotCalibration::default(),
            information: Equations::new(machine.parameters() + CENTRE_UNKNOWNS),
            poses: 0,
            step: Step::Nothing,
        }
    }

    /// No poses any more. In place: its equations are too large to be built on a small stack a second time.
    pub fn restart(&mut self, machine: &Machine<T>, nominal: &Parameters<T>) {
        self.centre = JointCentre::from_parameters(nominal, machine.geometry());
        self.calibration = PivotCalibration::default();
        self.information.clear(machine.parameters() + CENTRE_UNKNOWNS);
        (self.poses, self.step) = (0, Step::Nothing);
    }

    /// Adds a placed pose.
    pub fn add(&mut self, machine: &Machine<T>, pose: &Pose<T>) {
        let mut scratch = Scratch::Free;
        self.begin(machine, pose, &mut scratch);
        let Some(in_work) = scratch.pose() else { return };
        while !Self::add_columns(machine, in_work) {}
        while !in_work.add_rows(&mut self.information) {}
        self.step = Step::Nothing;
    }

    /// Begins to add a placed pose: what it says of the centre; what it says of the machine goes to work.
    pub fn begin(&mut self, machine: &Machine<T>, pose: &Pose<T>, scratch: &mut Scratch<T>) {
        self.step = Step::Now(Covariance::Sum(T::one()));
        self.calibration.add(&pose.platform());
        // The nominal centre serves until the pivot calibration of the poses has a solution.
        if let Ok(centre) = self.calibration.solve() {
            self.centre = centre;
        }
        let rotation = pose.rotation();
        let jacobian = LengthJacobian::new(machine.geometry(), &self.centre, &rotation, pose.lengths());
        let Ok(information) = MarginalInformation::new(&jacobian) else { return };
        let at = PoseAt { rotation: &rotation, lengths: pose.lengths(), jacobian: &jacobian };
        let weight = T::one() / machine.relative_variance(pose.samples);
        let mut sums = CentreSums::default();
        sums.add(&rotation, &information, weight);
        sums.move_to(&mut self.information);
        self.information.add_squares(information.squares_mm2() * weight);
        self.poses += 1;
        if machine.parameters() > 0 {
            *scratch = Scratch::Pose(PoseInWork::new(&at, &information, None, weight));
            self.step = Step::Columns;
        }
    }

    fn add_columns(machine: &Machine<T>, in_work: &mut PoseInWork<T>) -> bool {
        // As stated: made when it is wanted, for it takes 0.4 KB.
        let estimate = &MachineEstimate::new(machine);
        in_work.add_columns(&Model { machine, estimate, joint: &Joint::Ball, features: None })
    }

    /// The next slice of what was begun; what it promises, after the last. `more`: poses distributed like those so far.
    pub fn advance(
        &mut self,
        machine: &Machine<T>,
        more: usize,
        Workspace { equations, scratch }: Workspace<'_, T>,
    ) -> Option<Prediction<T>> {
        let nothing = Prediction { now: None, sigma_with_more_mm: None };
        match (self.step, scratch.pose()) {
            (Step::Nothing, _) => return Some(nothing),
            (Step::Columns, Some(in_work)) => {
                if Self::add_columns(machine, in_work) {
                    self.step = Step::Rows;
                }
            }
            (Step::Rows, Some(in_work)) => {
                if in_work.add_rows(&mut self.information) {
                    *scratch = Scratch::Free;
                    self.step = Step::Now(Covariance::Sum(T::one()));
                }
            }
            (Step::Columns | Step::Rows, None) => self.step = Step::Now(Covariance::Sum(T::one())),
            (Step::Now(mut covariance), _) => {
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
            (Step::WithMore(now, mut covariance), _) => {
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
        let mut equations = Equations::new(self.information.unknowns());
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
                equations.clear(self.information.unknowns());
                equations.add(&self.information, times);
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
