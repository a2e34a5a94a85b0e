//! What the elbow's procedure does by itself as time passes: bounded work in every tick.

use super::refusal::is_cured_by_more_poses;
use super::{ENOUGH_POSES, ElbowCandidate, ElbowProcedure, FoundHinge, State, Verifying};
use crate::identification::hinge::{HingeProgress, MIN_POSES};
use crate::identification::statistics::{FALSE_ALARM, chi_square_quantile};
use crate::linear_algebra::non_negative_root;
use crate::procedure::guidance::Guidance;
use crate::procedure::outcome::{PoseNotice, Verification};
use crate::procedure::reason::Reason;
use crate::procedure::solve::Detail;
use crate::procedure::state::StateName;
use crate::procedure::transition::Trigger;

impl ElbowProcedure {
    /// Time passes: times run out, a pose is captured, the solver works one slice. Returns the pose that was captured
    /// or refused, if any.
    pub fn tick(&mut self, now_ms: u32) -> Option<PoseNotice> {
        self.calibration.arm.tick(now_ms);
        match self.state() {
            StateName::Idle | StateName::Failed => None,
            StateName::Collecting => self.tick_collecting(now_ms),
            StateName::Identifying => {
                self.tick_identifying(now_ms);
                None
            }
            StateName::Verifying => self.tick_verifying(now_ms),
            StateName::Review => {
                self.calibration.tick_review(now_ms);
                None
            }
        }
    }

    fn tick_collecting(&mut self, now_ms: u32) -> Option<PoseNotice> {
        if self.calibration.fails_by_lost_count(now_ms) {
            return None;
        }
        let notice = self.capture_by_itself(now_ms);
        let poses = self.poses.count();
        let has_something_new = usize::from(poses) >= MIN_POSES && poses > self.calibration.run.attempted_poses;
        let overdue = self.calibration.is_overdue(now_ms, self.calibration.limits.settings().collecting_timeout_ms);
        let is_enough = notice.is_some() && poses >= ENOUGH_POSES && self.advice() != Guidance::BendFurther;
        let can_try = !self.calibration.run.by_command_only && (is_enough || overdue) || self.poses.is_full();
        if has_something_new && can_try {
            self.identify(now_ms);
        } else if overdue {
            // Poses that were all too near each other say more than that no new one came.
            let is_alike =
                self.calibration.run.refused_pose.is_some_and(|refused| refused.reason == Reason::PoseTooNear);
            let reason = if is_alike { Reason::TooAlike } else { Reason::CollectingTimeout };
            let detail = self.calibration.run.detail.unwrap_or(Detail::of(reason));
            self.calibration.end(now_ms, Trigger::Timeout, detail);
        }
        notice
    }

    fn tick_identifying(&mut self, now_ms: u32) {
        self.slices = self.slices.saturating_add(1);
        let found = match self.estimator.advance(self.poses.poses_mut()) {
            HingeProgress::Working => return,
            HingeProgress::Refused(refusal) => Err(Detail::from(refusal)),
            HingeProgress::Identified(found) => {
                let found = FoundHinge::of(found);
                if found.is_finite() { Ok(found) } else { Err(Detail::of(Reason::NotFinite)) }
            }
        };
        match found {
            Ok(found) => {
                self.calibration.go(now_ms, Trigger::Found, State::Verifying(Verifying { found, judging: None }));
            }
            Err(detail) => self.refused(now_ms, detail),
        }
    }

    fn refused(&mut self, now_ms: u32, detail: Detail) {
        let again = !self.poses.is_full() && is_cured_by_more_poses(detail.reason);
        self.calibration.refused(now_ms, detail, again);
    }

    fn tick_verifying(&mut self, now_ms: u32) -> Option<PoseNotice> {
        if self.calibration.fails_by_lost_count(now_ms) {
            return None;
        }
        if let State::Verifying(Verifying { judging: Some(_), .. }) = self.calibration.state() {
            self.judge_one(now_ms);
            return None;
        }
        let notice = self.capture_by_itself(now_ms);
        let complete = self.held_out.count() >= self.calibration.limits.settings().verification_poses
            && !self.calibration.run.by_command_only;
        if complete || self.held_out.is_full() {
            self.judge();
        } else if self.calibration.is_overdue(now_ms, self.calibration.limits.settings().verifying_timeout_ms) {
            self.calibration.end(now_ms, Trigger::Timeout, Detail::of(Reason::VerifyingTimeout));
        }
        notice
    }

    /// Holds the next pose of the second set against the hinge; after the last one, the verdict by χ².
    fn judge_one(&mut self, now_ms: u32) {
        let (run_id, boot, wearer) = (self.calibration.run.id, self.calibration.boot, self.calibration.wearer);
        let Some(Verifying { found, judging: Some(judging) }) = self.calibration.verifying_mut() else { return };
        if let Some(pose) = self.held_out.poses().get(usize::from(judging.next)) {
            match self.estimator.verify(&pose.lengths_mm) {
                Some(verified) => {
                    judging.squares_mm2 += verified.squares_mm2;
                    judging.chi_square += verified.chi_square;
                    judging.next += 1;
                }
                None => {
                    let pose = Some(judging.next);
                    let detail = Detail { pose, ..Detail::of(Reason::VerificationDoesNotClose) };
                    self.calibration.contradicted(now_ms, detail);
                }
            }
            return;
        }
        let poses = judging.next;
        let freedom = f32::from(poses) * f32::from(self.rig.cables().saturating_sub(1));
        let deviation_mm = non_negative_root(judging.squares_mm2 / freedom);
        // χ² may be so large once in 10 000 sound sets.
        let most = chi_square_quantile(freedom, FALSE_ALARM as f32);
        let limit_mm = if judging.chi_square > 0.0 {
            deviation_mm * non_negative_root(most / judging.chi_square)
        } else {
            found.noise_mm * non_negative_root(most / freedom)
        };
        let verification = Verification { deviation_mm, limit_mm, poses };
        let found = found.clone();
        // NaN must not pass
        if deviation_mm <= limit_mm {
            let candidate = ElbowCandidate { run_id, boot, wearer, found, verification };
            self.calibration.go(now_ms, Trigger::Verified, State::Review(candidate));
        } else {
            let detail = Detail { size_mm: Some(deviation_mm), ..Detail::of(Reason::VerificationFailed) };
            self.calibration.end(now_ms, Trigger::Contradicted, detail);
        }
    }

    /// A pose is captured when the arm comes to rest, once a rest.
    fn capture_by_itself(&mut self, now_ms: u32) -> Option<PoseNotice> {
        if self.calibration.has_come_to_rest(now_ms) { Some(self.take_pose(now_ms)) } else { None }
    }
}
