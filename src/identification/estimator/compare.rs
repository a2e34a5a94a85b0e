//! Is it the machine? Cables that are not as stated change the lengths smoothly with the arm, and a centre that moves
//! can follow them. So before a moving centre is believed, a ball on a machine that nobody has measured is fitted to the same
//! poses: where that explains them, nobody can tell the two apart.
//!
//! Gauss-Newton with all the machine's constants, O and C, from where the moving centre's fit stands. The poses stay as that
//! fit has them: the rotation that the ball gives a pose is found anew in each pass.

use super::Next;
use super::fit::Fit;
use super::model::Model;
use super::refine::Plan;
use super::scratch::Scratch;
use crate::identification::joint::Joint;
use crate::identification::machine::{Machine, MachineEstimate};
use crate::identification::marginal_information::MarginalInformation;
use crate::identification::parameters::{CENTRE_UNKNOWNS, CentreSums, ParameterBlock, PoseAt};
use crate::identification::pose::Pose;
use crate::identification::refusal::Refusal;
use crate::kinematics::rotation::rotation_of;
use crate::kinematics::{AttitudeSolver, AttitudeTrack, CableSet, JointCentre, LengthJacobian};
use crate::scalar::Real;
use nalgebra::{UnitQuaternion, Vector3};

/// χ² over its degrees of freedom up to which a machine explains the poses. Balls in machines that are off leave 1.1 at the
/// most, shoulders with 0.35 mm of scatter 15 at least (chosen on `cargo study shoulder --seed 21`); noise that is somewhat
/// larger than stated lies between.
const EXPLAINED: f64 = 2.0;

/// Damping of a pass, as a share of the diagonal. All constants together are not determined (the machine's size is not), and
/// single precision factors no matrix with pivots below 3e-5.
const DAMPING: f64 = 1e-4;

/// Most passes; a shoulder takes two to six.
const MAX_PASSES: u8 = 20;
/// Passes go on while one leaves at most this share of the squares of the one before: with a shoulder they soon stay.
const GOES_ON: f64 = 0.95;

/// A ball on an unmeasured machine, and how far its fit is.
#[derive(Clone, Debug)]
pub(super) struct Compare<T: Real> {
    estimate: MachineEstimate<T>,
    centre: JointCentre<T>,
    step: Step<T>,
    passes: u8,
    /// After the pass before, mm².
    squares_mm2: T,
}

#[derive(Clone, Copy, Debug)]
enum Step<T> {
    /// The equations are to be empty.
    Begin,
    /// They are to hold the priors of an unmeasured machine.
    Priors,
    /// The poses are summed.
    Sum(Sum<T>),
    /// The normal equations are factored.
    Factor { used: usize },
    /// They are solved, then the step is taken.
    Solve { used: usize },
}

/// The sum over the poses under way.
#[derive(Clone, Copy, Debug)]
struct Sum<T> {
    /// The next pose, from 0.
    next: usize,
    /// The search for its rotation, from that about the moving centre; and the rotation, once it is found.
    track: Option<AttitudeTrack<T>>,
    attitude: Option<UnitQuaternion<T>>,
    used: usize,
    centre: CentreSums<T>,
}

impl<T: Real> Compare<T> {
    /// Begins. The moving centre's fit goes on when it is not the machine.
    pub fn new(fit: &Fit<T>, machine: &Machine<T>) -> Self {
        let estimate = MachineEstimate::unmeasured(machine);
        Self { estimate, centre: fit.centre, step: Step::Begin, passes: 0, squares_mm2: T::of(f64::INFINITY) }
    }

    /// The next slice of a pose, of the factor, or of the step.
    pub fn advance(&mut self, fit: &mut Fit<T>, machine: &Machine<T>, poses: &[Pose<T>]) -> Option<Next<T>> {
        match &mut self.step {
            Step::Begin => {
                fit.scratch = Scratch::Free;
                fit.equations.clear(self.estimate.count() + CENTRE_UNKNOWNS);
                self.step = Step::Priors;
                None
            }
            Step::Priors => {
                let variance = fit.variance_mm2();
                let model = Model { machine, estimate: &self.estimate, joint: &Joint::Ball };
                model.add_prior(&mut fit.equations, 0, variance);
                let centre = CentreSums::default();
                self.step = Step::Sum(Sum { next: 0, track: None, attitude: None, used: 0, centre });
                None
            }
            Step::Sum(sum) => {
                let ball = Model { machine, estimate: &self.estimate, joint: &Joint::Ball };
                if !sum.advance(fit, &ball, &self.centre, poses) {
                    sum.centre.move_to(&mut fit.equations);
                    fit.equations.damp(T::of(DAMPING));
                    self.step = Step::Factor { used: sum.used };
                }
                None
            }
            Step::Factor { used } => match fit.factor() {
                Ok(false) => None,
                Ok(true) => {
                    fit.begin_step();
                    self.step = Step::Solve { used: *used };
                    None
                }
                // Priors and damping determine all of it; rounding may not.
                Err(_) => Some(Self::go_on(fit)),
            },
            Step::Solve { .. } if !fit.solve() => None,
            Step::Solve { used } => {
                let used = *used;
                self.take_step(fit, machine, used)
            }
        }
    }

    /// Takes the step of a pass, and judges what it leaves.
    fn take_step(&mut self, fit: &mut Fit<T>, machine: &Machine<T>, used: usize) -> Option<Next<T>> {
        let step = fit.scratch.solution();
        let squares_mm2 = fit.equations.squares_after(&step);
        let freedom = T::of_integer((3 * used as i32 - CENTRE_UNKNOWNS as i32).max(1));
        if squares_mm2 <= fit.variance_mm2() * freedom * T::of(EXPLAINED) {
            return Some(Next::Done(Err(Refusal::MachineNotAsStated)));
        }
        self.passes += 1;
        let is_over = self.passes >= MAX_PASSES || !(squares_mm2 <= self.squares_mm2 * T::of(GOES_ON));
        self.squares_mm2 = squares_mm2;
        if is_over {
            return Some(Self::go_on(fit));
        }
        let (constants, centre) = step.split_at_checked(self.estimate.count()).unwrap_or_default();
        self.estimate.apply(machine, constants);
        if let [x, y, z, u, v, w, ..] = centre {
            self.centre.in_base_mm += Vector3::new(*x, *y, *z);
            self.centre.in_platform_mm += Vector3::new(*u, *v, *w);
        }
        self.step = Step::Begin;
        None
    }

    /// It is not the machine: the moving centre's fit goes on.
    fn go_on(fit: &mut Fit<T>) -> Next<T> {
        fit.is_compared = true;
        Next::Refine(Plan::select(fit))
    }
}

impl<T: Real> Sum<T> {
    /// The next pose's rotation, or the next columns or rows of its equations; false after the last pose.
    fn advance(&mut self, fit: &mut Fit<T>, ball: &Model<'_, T>, centre: &JointCentre<T>, poses: &[Pose<T>]) -> bool {
        if let Some(in_work) = fit.scratch.pose() {
            in_work.advance(ball, &mut fit.equations);
            return true;
        }
        let Some(pose) = poses.get(self.next) else { return false };
        match self.attitude.take() {
            None if pose.is_used() => self.attitude = self.turn(ball, centre, pose),
            None => self.next += 1,
            Some(attitude) => {
                self.add(fit, ball, centre, pose, &attitude);
                self.used += 1;
                self.next += 1;
            }
        }
        true
    }

    /// A few steps towards the rotation that fits a pose best about the ball; once it is found, that. Where none fits, the one
    /// that it has.
    fn turn(&mut self, ball: &Model<'_, T>, centre: &JointCentre<T>, pose: &Pose<T>) -> Option<UnitQuaternion<T>> {
        let track = self.track.get_or_insert(AttitudeTrack::new(*pose.attitude()));
        let lengths = ball.estimate.corrected(ball.machine, pose.lengths());
        let solver = AttitudeSolver { geometry: ball.estimate.geometry(), centre };
        let found = track.advance(&solver, &lengths, CableSet::ALL)?;
        self.track = None;
        Some(found.map_or(*pose.attitude(), |fit| fit.attitude))
    }

    /// Adds a pose with its rotation about the ball; its columns and rows follow.
    fn add(
        &mut self,
        fit: &mut Fit<T>,
        ball: &Model<'_, T>,
        centre: &JointCentre<T>,
        pose: &Pose<T>,
        attitude: &UnitQuaternion<T>,
    ) {
        let (rotation, lengths) = (rotation_of(attitude), ball.estimate.corrected(ball.machine, pose.lengths()));
        let jacobian = LengthJacobian::new(ball.estimate.geometry(), centre, &rotation, &lengths);
        let Ok(information) = MarginalInformation::new(&jacobian) else { return };
        let at = PoseAt { rotation: &rotation, lengths: &lengths, jacobian: &jacobian };
        let weight = T::one() / ball.machine.relative_variance(pose.samples);
        self.centre.add(&rotation, &information, weight);
        fit.equations.add_squares(information.squares_mm2() * weight);
        fit.scratch.put_pose(&at, &information, weight);
    }
}
