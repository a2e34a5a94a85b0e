//! Fault isolation of the poses that were left out.

use super::Next;
use super::fit::Fit;
use crate::identification::fault_isolation::Isolation;
use crate::identification::machine::Machine;
use crate::identification::outcome::{MAX_REJECTED, Rejected};
use crate::identification::pose::Pose;
use crate::kinematics::AttitudeSolver;
use crate::scalar::Real;

/// Fault isolation of the poses left out, one after the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Isolate<T: Real> {
    /// The next pose, from 0.
    next: usize,
    /// How many of those left out are done.
    done: usize,
    isolation: Isolation<T>,
}

impl<T: Real> Default for Isolate<T> {
    fn default() -> Self {
        Self { next: 0, done: 0, isolation: Isolation::default() }
    }
}

impl<T: Real> Isolate<T> {
    /// One attempt at one hypothesis about the next pose left out.
    pub fn advance(&mut self, fit: &mut Fit<T>, machine: &Machine<T>, poses: &mut [Pose<T>]) -> Option<Next<T>> {
        let left_out = |(_, pose): &(usize, &mut Pose<T>)| !pose.is_used();
        let Some((index, pose)) = poses.iter_mut().enumerate().skip(self.next).find(left_out) else {
            return Some(Next::Done(Ok(())));
        };
        let noise = fit.result.noise_mm.max(machine.noise_mm());
        let variance_mm2 = noise * noise * machine.relative_variance(pose.samples) + fit.joint.scatter_mm2();
        let lengths = fit.estimate.corrected(machine, pose.lengths());
        let centre = fit.joint.centre_at(&fit.centre, &pose.rotation());
        let solver = AttitudeSolver { geometry: fit.estimate.geometry(), centre: &centre };
        let cables = self.isolation.advance(&solver, pose.attitude(), &lengths, variance_mm2)?;
        if cables != 0 {
            pose.suspect_cables = cables;
        }
        if let Some(rejected) = fit.result.rejected.get_mut(self.done).filter(|_| self.done < MAX_REJECTED) {
            *rejected = Rejected { pose: index as u32, cables: pose.suspect_cables };
        }
        *self = Self { next: index + 1, done: self.done + 1, isolation: Isolation::default() };
        None
    }
}
