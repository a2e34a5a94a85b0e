//! How far a run is, why it stands where it stands, and what the person at the arm should do: the heartbeat's content.

use super::calibration::State;
use super::guidance::Guidance;
use super::reason::Reason;
use super::state::PoseSet;
use super::{Procedure, Verifying};

impl Procedure {
    /// Progress in percent: a half for the first set, up to 80 for the solver, up to 99 for the second set. 100 only
    /// when the new centre is there and verified; 0 when there is no run or it failed.
    pub fn progress_percent(&self) -> u8 {
        let settings = self.calibration.limits.settings();
        match self.calibration.state() {
            State::Idle | State::Failed => 0,
            State::Collecting => {
                let counted = share(f32::from(self.poses.count()), f32::from(self.enough_poses()));
                let sharpened = self.predicted_sigma_mm().map_or(0.0, |sigma| share(settings.target_sigma_mm, sigma));
                // sharpness says nothing before there are poses enough to have any
                (25.0 * counted + 25.0 * counted.min(sharpened)) as u8
            }
            State::Identifying => 50 + (29.0 * self.work.share_done(self.poses.poses().len())) as u8,
            State::Verifying(Verifying { judging: None, .. }) => {
                let counted = share(f32::from(self.held_out.count()), f32::from(settings.verification_poses));
                80 + (15.0 * counted) as u8
            }
            State::Verifying(_) => 99,
            State::Review(_) => 100,
        }
    }

    /// Why the run stands where it stands, or what disturbs it now.
    pub fn reason(&self, now_ms: u32) -> Reason {
        self.calibration.reason(now_ms)
    }

    /// What the person at the arm should do now.
    pub fn guidance(&self, now_ms: u32) -> Guidance {
        self.calibration.guidance(now_ms, self.course.advice)
    }

    /// Poses in the set that is being captured, or was last.
    pub fn pose_count(&self) -> u8 {
        match self.calibration.current_set() {
            PoseSet::Identification => self.poses.count(),
            PoseSet::HeldOut => self.held_out.count(),
        }
    }
}

/// Part of the whole, 0 to 1; 0 when that is no number.
fn share(part: f32, whole: f32) -> f32 {
    let share = part / whole;
    if share > 0.0 { share.min(1.0) } else { 0.0 }
}
