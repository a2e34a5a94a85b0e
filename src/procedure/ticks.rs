//! What the procedure does by itself as time passes: bounded work in every tick.

use super::outcome::{Candidate, PoseNotice, Verification};
use super::phase::Phase;
use super::reason::Reason;
use super::solve::{Detail, is_cured_by_more_poses};
use super::state::{PoseSet, StateName};
use super::transition::Trigger;
use super::{Guidance, Procedure, Run, State, Verifying};
use crate::identification::estimator::PoseVerification;
use crate::identification::verification::rms_limit_mm;
use crate::identification::{Identified, Progress};
use crate::scalar::Real;

impl Run {
    pub(super) const fn before_the_first() -> Self {
        Self {
            id: 0,
            by_command_only: false,
            in_motion: false,
            phase: Phase::Only,
            attempts: 0,
            attempted_poses: 0,
            moved: true,
            since_ms: 0,
            advice: Guidance::MoveOn,
            detail: None,
            refused_pose: None,
        }
    }

    /// The run after the run `last_id`. Ids wrap past zero, which means "no run".
    pub(super) const fn new(last_id: u16, by_command_only: bool, now_ms: u32) -> Self {
        let id = match last_id.wrapping_add(1) {
            0 => 1,
            id => id,
        };
        Self { id, by_command_only, since_ms: now_ms, ..Self::before_the_first() }
    }
}

impl Procedure {
    /// Time passes: times run out, a pose is captured, the solver works one slice. Returns the pose that was captured
    /// or refused, if any.
    pub fn tick(&mut self, now_ms: u32) -> Option<PoseNotice> {
        self.arm.tick(now_ms);
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
                if self.is_overdue(now_ms, self.limits.settings().review_timeout_ms) {
                    self.end(now_ms, Trigger::Timeout, Detail::of(Reason::ReviewTimeout));
                }
                None
            }
        }
    }

    fn is_overdue(&self, now_ms: u32, limit_ms: u32) -> bool {
        now_ms.wrapping_sub(self.run.since_ms) >= limit_ms
    }

    fn tick_collecting(&mut self, now_ms: u32) -> Option<PoseNotice> {
        if self.fails_by_lost_count(now_ms) {
            return None;
        }
        let notice = self.capture_by_itself(now_ms);
        if self.capturing.is_some() {
            return None;
        }
        let overdue = self.is_overdue(now_ms, self.limits.settings().collecting_timeout_ms);
        let can_try = self.has_something_new() && (overdue && !self.run.by_command_only || self.poses.is_full());
        if can_try {
            self.identify(now_ms);
        } else if overdue {
            let detail = self.run.detail.unwrap_or(Detail::of(Reason::CollectingTimeout));
            self.end(now_ms, Trigger::Timeout, detail);
        }
        notice
    }

    /// There are poses that no solver run has seen, and enough of them in all for a solver run.
    fn has_something_new(&self) -> bool {
        let poses = self.poses.count();
        usize::from(poses) >= self.run.phase.min_poses() && poses > self.run.attempted_poses
    }

    /// The first set is good enough.
    fn is_enough(&self) -> bool {
        let settings = self.limits.settings();
        let is_sharp = |sigma| sigma <= settings.target_sigma_mm || self.more_poses_gain_little(sigma);
        // What is predicted is the accuracy of a ball.
        let is_good = self.run.phase == Phase::Held || self.predicted_sigma_mm().is_some_and(is_sharp);
        !self.run.by_command_only && self.poses.count() >= self.enough_poses() && is_good
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
                if self.run.phase == Phase::Held {
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
                    self.go(now_ms, Trigger::Found, State::Verifying(verifying));
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
        if self.go(now_ms, Trigger::HeldFound, State::Collecting) {
            self.forget_poses();
            self.run.phase = Phase::Free(held);
            self.run.advice = Guidance::ReleaseBlade;
            (self.run.attempts, self.run.attempted_poses) = (0, 0);
        }
    }

    fn refused(&mut self, now_ms: u32, detail: Detail) {
        self.run.detail = Some(detail);
        let again = self.run.attempts < self.limits.settings().max_attempts && !self.poses.is_full();
        if again && is_cured_by_more_poses(detail.reason) {
            self.go(now_ms, Trigger::WantsMore, State::Collecting);
        } else {
            self.end(now_ms, Trigger::GaveUp, detail);
        }
    }

    fn tick_verifying(&mut self, now_ms: u32) -> Option<PoseNotice> {
        if self.fails_by_lost_count(now_ms) {
            return None;
        }
        if let State::Verifying(Verifying { judging: Some(_), .. }) = self.state {
            self.judge_one(now_ms);
            return None;
        }
        let notice = self.capture_by_itself(now_ms);
        if self.capturing.is_some() {
            return None;
        }
        let wanted = self.limits.settings().verification_poses;
        let complete = self.held_out.count() >= wanted && !self.run.by_command_only;
        if complete || self.held_out.is_full() {
            self.judge();
        } else if self.is_overdue(now_ms, self.limits.settings().verifying_timeout_ms) {
            self.end(now_ms, Trigger::Timeout, Detail::of(Reason::VerifyingTimeout));
        }
        notice
    }

    /// Holds the next pose of the second set against the fit, a slice of it; after the last one, the verdict by χ².
    fn judge_one(&mut self, now_ms: u32) {
        let State::Verifying(Verifying { identified, motion, judging: Some(judging) }) = &mut self.state else {
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
                    self.run.detail = Some(detail);
                    self.end(now_ms, Trigger::Contradicted, detail);
                }
            }
            return;
        }
        let poses = judging.next;
        let deviation_mm = (judging.squares_mm2 / f32::from(poses.max(1)) / 3.0).root();
        let joint = self.work.estimator().joint();
        let limit_mm = rms_limit_mm(deviation_mm, judging.chi_square, usize::from(poses), identified.noise_mm, joint);
        let verification = Verification { deviation_mm, limit_mm, poses };
        let (run_id, boot, wearer) = (self.run.id, self.boot, self.wearer);
        let (identified, motion) = (identified.clone(), *motion);
        let candidate = Candidate { run_id, boot, wearer, identified, motion, verification };
        // NaN must not pass
        if deviation_mm <= limit_mm {
            self.go(now_ms, Trigger::Verified, State::Review(candidate));
        } else {
            let size_mm = Some(deviation_mm);
            let detail = Detail { size_mm, ..Detail::of(Reason::VerificationFailed) };
            self.end(now_ms, Trigger::Contradicted, detail);
        }
    }

    fn fails_by_lost_count(&mut self, now_ms: u32) -> bool {
        let Some(cable) = self.arm.lost() else { return false };
        self.end(now_ms, Trigger::CountLost, Detail { cable, ..Detail::of(Reason::EncoderJumped) });
        true
    }

    /// The set in which poses are captured now, if any.
    pub(super) const fn current_set(&self) -> PoseSet {
        match self.state {
            State::Verifying(_) => PoseSet::HeldOut,
            _ => PoseSet::Identification,
        }
    }
}
