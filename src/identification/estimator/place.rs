//! Placing: the platform's pose in every captured pose, and the pivot calibration of them.

use super::excite::Purpose;
use super::fit::Fit;
use super::refine::Plan;
use super::{MIN_POSES, Next};
use crate::identification::gates::require_placed;
use crate::identification::joint::{Joint, Scatter};
use crate::identification::machine::Machine;
use crate::identification::pivot_calibration::PivotCalibration;
use crate::identification::pose::Pose;
use crate::identification::settings::JointChoice;
use crate::identification::weights::Weights;
use crate::kinematics::PlatformSearch;
use crate::linear_algebra::Singular;
use crate::scalar::Real;

/// The poses placed so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place<T: Real> {
    next: usize,
    /// Of the next pose's place.
    search: PlatformSearch<T>,
    calibration: PivotCalibration<T>,
}

impl<T: Real> Default for Place<T> {
    fn default() -> Self {
        Self { next: 0, search: PlatformSearch::default(), calibration: PivotCalibration::default() }
    }
}

impl<T: Real> Place<T> {
    /// The next step of placing the next pose, unless its capture has placed it; after the last, solves the calibration.
    pub fn advance(&mut self, fit: &mut Fit<T>, machine: &Machine<T>, poses: &mut [Pose<T>]) -> Option<Next<T>> {
        if let Some(pose) = poses.get_mut(self.next) {
            if pose.place_step(&mut self.search, machine.platform()) {
                if pose.is_placed() {
                    self.calibration.add(&pose.platform());
                }
                self.next += 1;
                self.search = PlatformSearch::default();
            }
            return None;
        }
        if self.calibration.rotations().poses() < T::of_integer(MIN_POSES as i32)
            && let Err(refusal) = require_placed(poses)
        {
            return Some(Next::Done(Err(refusal)));
        }
        Some(match self.calibration.solve() {
            Ok(centre) => {
                fit.centre = centre;
                match fit.settings.joint {
                    JointChoice::Held => fit.begin_scattered(machine, Joint::Held(Scatter::default())),
                    JointChoice::Moving => Next::Excite(Purpose::MovingCentre),
                    _ => Next::Refine(Plan::new(fit, Weights::Equal, false)),
                }
            }
            Err(Singular) => Next::Excite(Purpose::NameWhatIsSingular),
        })
    }
}
