//! How far an elbow's run is, why it stands where it stands, and what the person at the arm should do.

use super::{BENT, ENOUGH_POSES, ElbowProcedure, State, Verifying};
use crate::procedure::guidance::Guidance;
use crate::procedure::reason::Reason;
use crate::procedure::state::PoseSet;

/// Slices that a sound set takes for each of its poses.
const USUAL_SLICES_A_POSE: f32 = 1_500.0;

impl ElbowProcedure {
    /// Poses in the set that is being captured, or was last.
    pub fn pose_count(&self) -> u8 {
        match self.calibration.current_set() {
            PoseSet::Identification => self.poses.count(),
            PoseSet::HeldOut => self.held_out.count(),
        }
    }

    /// Progress in percent: a half for the first set, up to 80 for the solver, up to 99 for the second set. 100 only when the
    /// new hinge is there and verified; 0 when there is no run or it failed.
    pub fn progress_percent(&self) -> u8 {
        let share = |part: u8, whole: u8| (f32::from(part) / f32::from(whole.max(1))).min(1.0);
        match self.calibration.state() {
            State::Idle | State::Failed => 0,
            State::Collecting => (50.0 * share(self.poses.count(), ENOUGH_POSES)) as u8,
            State::Identifying => {
                // How many slices there will be is not known before the end: this grows more and more slowly.
                let (done, usual) = (self.slices as f32, USUAL_SLICES_A_POSE * f32::from(self.poses.count()));
                50 + (29.0 * done / (done + usual * 0.5)) as u8
            }
            State::Verifying(Verifying { judging: None, .. }) => {
                let wanted = self.calibration.limits.settings().verification_poses;
                80 + (15.0 * share(self.held_out.count(), wanted)) as u8
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
        self.calibration.guidance(now_ms, self.advice())
    }

    /// What would help the set most.
    pub(super) fn advice(&self) -> Guidance {
        let is_little = self.poses.count() > 1 && self.poses.range_mm() < BENT * self.rig.ring_mm();
        let asks_for_more = self.calibration.run.detail.is_some_and(|detail| detail.reason == Reason::TooAlike);
        match self.calibration.current_set() {
            PoseSet::Identification if is_little || asks_for_more => Guidance::BendFurther,
            _ => Guidance::MoveOn,
        }
    }
}
