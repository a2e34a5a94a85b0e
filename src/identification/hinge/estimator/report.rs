//! The result with its covariance, from a finished fit.

use super::work::Work;
use crate::identification::hinge::fit::{Finish, Solve};
use crate::identification::hinge::joint::HINGE_UNKNOWNS;
use crate::identification::hinge::judge::{self, Flexion};
use crate::identification::hinge::pose::HingePose;
use crate::identification::hinge::refusal::{HingePart, HingeRefusal};
use crate::linear_algebra::{Singular, non_negative_root};
use crate::scalar::Real;

/// The result under way.
#[derive(Clone, Debug)]
pub enum Report<T: Real> {
    /// The last step and the factor.
    Finish(Finish<T>),
    /// The next column of the covariance.
    Column(usize, Solve<T>),
    /// How far does the joint bend?
    Bend(Flexion<T>),
}

impl<T: Real> Report<T> {
    /// At the beginning.
    pub const fn new() -> Self {
        Self::Finish(Finish::new())
    }

    /// One slice; the outcome at the end.
    pub fn advance(&mut self, work: &mut Work<T>, poses: &mut [HingePose<T>]) -> Option<Result<(), HingeRefusal>> {
        match self {
            Self::Finish(finish) => {
                if finish.advance(&mut work.fit, &mut work.scratch, poses)? == Err(Singular) {
                    return Some(Err(HingeRefusal::Weak { part: HingePart::Axis, sigma: f32::INFINITY }));
                }
                work.found.noise_mm =
                    judge::noise_of_result_mm(&work.fit, poses, work.settings.noise, work.rig.length_noise_mm());
                *self = Self::Column(0, Solve::column(0));
            }
            Self::Column(column, solve) => {
                let entries = solve.advance(&work.fit.equations)?;
                let noise_mm = work.found.noise_mm;
                for (row, value) in entries.iter().enumerate() {
                    if let Some(entry) = work.found.covariance.get_mut((row, *column)) {
                        *entry = *value * noise_mm * noise_mm;
                    }
                }
                let next = *column + 1;
                *self = match next < HINGE_UNKNOWNS {
                    true => Self::Column(next, Solve::column(next)),
                    false => Self::Bend(Flexion::new()),
                };
            }
            Self::Bend(flexion) => {
                let range = flexion.advance(poses)?;
                let (fit, found) = (&work.fit, &mut work.found);
                let freedom = judge::freedom(fit, poses);
                found.hinge = fit.hinge;
                found.machine.clone_from(&fit.machine);
                found.rms_residual_mm = non_negative_root(fit.squares_mm2 / freedom);
                found.flexion_rad = range;
                found.poses = poses.len() as u32;
                found.rejected = poses.iter().filter(|pose| !pose.is_used()).count() as u32;
                return Some(Ok(()));
            }
        }
        None
    }
}
