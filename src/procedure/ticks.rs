//! What the procedure does by itself as time passes: bounded work in every tick.

use super::calibration::State;
use super::outcome::{Candidate, PoseNotice, Verification};
use super::phase::Phase;
use super::reason::Reason;
use super::solve::{Detail, is_cured_by_more_poses};
use super::state::StateName;
use super::transition::Trigger;
use super::{Guidance, Procedure, Verifying};
use crate::identification::estimator::PoseVerification;
use crate::identification::verification::rms_limit_mm;
use crate::identification::{Identified, Progress};
use crate::scalar::Real;

impl Procedure {
    /// Time passes: times run out, a pose is captured, the solver works one slice. Returns the pose that was captured
    /// or refused, if any.
    pub fn tick(&mut self, now_ms: u32) -> Option<PoseNotice> {
        self.calibration.arm.tick(now_ms);
        if self.capturing.is_some() {
            return self.capture_further(now_ms);
        }
        // First: the next pose and the estimator want its place.
        if self.assessing.is_some() {
            let (notice, is_automatic) = self.assess()?;
            if is_automatic && self.state() == StateName::Collecting && self.is_enough() {
                self.identify(now_ms);
            }
            return Some(notice);
        }
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
        if self.capturing.is_some() {
            return None;
        }
        let overdue = self.calibration.is_overdue(now_ms, self.calibration.limits.settings().collecting_timeout_ms);
        let can_try =
            self.has_something_new() && (overdue && !self.calibration.run.by_command_only || self.poses.is_full());
        if can_try {
            self.identify(now_ms);
        } else if overdue {
            let detail = self.calibration.run.detail.unwrap_or(Detail::of(Reason::CollectingTimeout));
            self.calibration.end(now_ms, Trigger::Timeout, detail);
        }
        notice
    }

    /// There are poses that no solver run has seen, and enough of them in all for a solver run.
    fn has_something_new(&self) -> bool {
        let poses = self.poses.count();
        usize::from(poses) >= self.course.phase.min_poses() && poses > self.calibration.run.attempted_poses
    }

    /// The first set is good enough.
    fn is_enough(&self) -> bool {
        let settings = self.calibration.limits.settings();
        let is_sharp = |sigma| sigma <= settings.target_sigma_mm || self.more_poses_gain_little(sigma);
        // What is predicted is the accuracy of a ball.
        let is_good = self.course.phase == Phase::Held || self.predicted_sigma_mm().is_some_and(is_sharp);
        !self.calibration.run.by_command_only && self.poses.count() >= self.enough_poses() && is_good
    }

    /// Would ten more poses gain less than a tenth? Tolerances of the machine set a floor that no number of poses goes
    /// below.
    fn more_poses_gain_little(&self, sigma_mm: f32) -> bool {
        self.sigma_with_more_mm.is_some_and(|with_more_mm| with_more_mm > sigma_mm * 0.9)
    }

    fn tick_identifying(&mut self, now_ms: u32) {
        match self.work.advance(&self.machine, self.poses.poses_mut()) {
            Progress::Working => {}
            Progress::Identified(identified) => {
                if self.course.phase == Phase::Held {
                    self.found_held(now_ms);
                    return;
                }
                let identified = identified.clone();
                self.found(now_ms, identified);
            }
            Progress::Refused(refusal) => self.refused(now_ms, Detail::from(refusal)),
        }
    }

    fn found(&mut self, now_ms: u32, identified: Identified<f32>) {
        let numbers = identified.parameters.to_array();
        if !numbers.iter().chain(&identified.sigma_mm()).all(|number| number.is_finite()) {
            self.refused(now_ms, Detail::of(Reason::NotFinite));
        } else if let Err(detail) = self.check_plausible(&identified) {
            self.refused(now_ms, detail);
        } else {
            match self.work.motion() {
                Ok(motion) => {
                    let verifying = Verifying { identified, motion, judging: None };
                    self.calibration.go(now_ms, Trigger::Found, State::Verifying(verifying));
                }
                Err(reason) => self.refused(now_ms, Detail::of(reason)),
            }
        }
    }

    /// The first of two phases is done: its poses make room for the free ones.
    fn found_held(&mut self, now_ms: u32) {
        let Some(held) = self.work.estimator().held_centre() else {
            self.refused(now_ms, Detail::of(Reason::Singular));
            return;
        };
        if self.calibration.go(now_ms, Trigger::HeldFound, State::Collecting) {
            self.forget_poses();
            self.course.phase = Phase::Free(held);
            self.course.advice = Guidance::ReleaseBlade;
            (self.calibration.run.attempts, self.calibration.run.attempted_poses) = (0, 0);
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
        if self.capturing.is_some() {
            return None;
        }
        let wanted = self.calibration.limits.settings().verification_poses;
        let complete = self.held_out.count() >= wanted && !self.calibration.run.by_command_only;
        if complete || self.held_out.is_full() {
            self.judge();
        } else if self.calibration.is_overdue(now_ms, self.calibration.limits.settings().verifying_timeout_ms) {
            self.calibration.end(now_ms, Trigger::Timeout, Detail::of(Reason::VerifyingTimeout));
        }
        notice
    }

    /// Holds the next pose of the second set against the fit, a slice of it; after the last one, the verdict by χ².
    fn judge_one(&mut self, now_ms: u32) {
        let (run_id, boot, wearer) = (self.calibration.run.id, self.calibration.boot, self.calibration.wearer);
        let Some(Verifying { identified, motion, judging: Some(judging) }) = self.calibration.verifying_mut() else {
            return;
        };
        if let Some(pose) = self.held_out.poses().get(usize::from(judging.next)) {
            match self.work.estimator_mut().verify_slice(&mut judging.verification, &self.machine, pose) {
                None => {}
                Some(Some(residual)) => {
                    judging.squares_mm2 += residual.squares_mm2;
                    judging.chi_square += residual.chi_square;
                    judging.verification = PoseVerification::default();
                    judging.next += 1;
                }
                Some(None) => {
                    let pose = Some(judging.next);
                    let detail = Detail { pose, ..Detail::of(Reason::VerificationDoesNotClose) };
                    self.calibration.contradicted(now_ms, detail);
                }
            }
            return;
        }
        let poses = judging.next;
        let deviation_mm = (judging.squares_mm2 / f32::from(poses.max(1)) / 3.0).root();
        let joint = self.work.estimator().joint();
        let limit_mm = rms_limit_mm(deviation_mm, judging.chi_square, usize::from(poses), identified.noise_mm, joint);
        let verification = Verification { deviation_mm, limit_mm, poses };
        let (identified, motion) = (identified.clone(), *motion);
        let candidate = Candidate { run_id, boot, wearer, identified, motion, verification };
        // NaN must not pass
        if deviation_mm <= limit_mm {
            self.calibration.go(now_ms, Trigger::Verified, State::Review(candidate));
        } else {
            let size_mm = Some(deviation_mm);
            let detail = Detail { size_mm, ..Detail::of(Reason::VerificationFailed) };
            self.calibration.end(now_ms, Trigger::Contradicted, detail);
        }
    }
}
