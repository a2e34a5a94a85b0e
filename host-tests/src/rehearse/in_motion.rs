//! Poses that the board captures by itself while the arm moves slowly and freely.

use super::client::PERIOD_MS;
use super::session::{SETTLE_MS, Session};
use super::transcript::{Captured, SessionError};
use crate::wearer::{Pose, Roaming};
use glenoid::can::report::PoseReport;
use glenoid::procedure::{PoseSet, Reason};
use glenoid::rig::CABLES;

/// A free movement that has not brought so many poses by then never will, seconds.
const LONGEST_S: f64 = 120.0;

/// The free movement so far.
pub(super) struct Motion {
    roaming: Roaming,
    /// Where the arm was at every sample.
    way: Vec<Pose>,
}

impl Motion {
    /// Seconds that the wearer has moved.
    pub(super) fn seconds(&self) -> f64 {
        self.way.len() as f64 * f64::from(PERIOD_MS) / 1000.0
    }

    /// Finds where the arm was when these lengths were read, mm: where the cables spanned them best.
    pub(super) fn locate(&self, captured: &mut [Captured]) {
        for captured in captured {
            let off = |pose: &Pose| -> f64 {
                (0..CABLES).map(|k| (pose.spans_mm[k] - f64::from(captured.lengths_mm[k])).powi(2)).sum()
            };
            let nearest = self.way.iter().min_by(|one, other| off(one).total_cmp(&off(other)));
            captured.pose = nearest.copied().unwrap_or(captured.pose);
        }
    }
}

impl Session<'_> {
    /// The arm goes to where it will begin to move freely.
    pub(super) fn begin_motion(&mut self) -> Result<Motion, SessionError> {
        let mut roaming = Roaming::new(self.wearer);
        let first = roaming.next(self.wearer, PERIOD_MS);
        self.move_to(first)?;
        Ok(Motion { roaming, way: Vec::new() })
    }

    /// Moves on until the board has captured at least `count` poses of a set, and comes to rest. Where the arm was in each
    /// is found when they are read out ([`Motion::locate`]).
    pub(super) fn collect_in_motion(
        &mut self,
        motion: &mut Motion,
        set: PoseSet,
        count: u8,
    ) -> Result<Vec<Captured>, SessionError> {
        let stage = self.display.counted("poses in motion", u64::from(count));
        let began_s = motion.seconds();
        let mut at = motion.roaming.next(self.wearer, PERIOD_MS);
        // a shoulder blade that was let go meanwhile does not leap
        self.move_to(at)?;
        let is_meant = |report: &&PoseReport| report.reason == Reason::Fine && report.set == set;
        while self.client.inbox.poses.iter().filter(is_meant).count() < usize::from(count) {
            if motion.seconds() - began_s > LONGEST_S {
                return Err(SessionError::Silence("pose in motion"));
            }
            at = motion.roaming.next(self.wearer, PERIOD_MS);
            motion.way.push(at);
            self.sample(at)?;
            let taken = self.client.inbox.poses.iter().filter(is_meant).count();
            stage.reached(taken as u64, "");
        }
        self.client.hold(SETTLE_MS)?;
        let reports = self.client.inbox.poses.iter().filter(is_meant);
        let captured: Vec<_> = reports
            .map(|report| Captured {
                pose: at,
                lengths_mm: [0.0; CABLES],
                samples: 1,
                predicted_sigma_mm: report.sigma_mm,
            })
            .collect();
        stage.done(&format!("{} captured in {:.0} s", captured.len(), motion.seconds() - began_s));
        Ok(captured)
    }
}
