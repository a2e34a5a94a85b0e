//! Capturing a pose, a step a tick: it is placed, then held against the others, then taken in or refused.

use super::arm::NotReady;
use super::outcome::PoseNotice;
use super::phase::Phase;
use super::reason::Reason;
use super::reply::Reply;
use super::state::PoseSet;
use super::{Guidance, Procedure};
use crate::identification::{Pose, PoseState};
use crate::kinematics::{CableLengths, PlatformSearch};

/// Between two poses in motion at least so much time passes, ms, six windows: whatever slides for a moment beside what the arm's
/// direction explains is then not counted twice, nor taken for a slip.
const PAUSE_IN_MOTION_MS: u32 = 540;

/// A pose on its way into a set.
#[derive(Debug, Clone, Copy)]
pub(super) struct Capturing {
    pose: Pose<f32>,
    search: PlatformSearch<f32>,
    asked: Asked,
}

/// What a capture began with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Asked {
    Command,
    /// The arm has come to rest.
    Rest,
    /// It has moved slowly.
    Motion,
}

impl Procedure {
    /// Begins to capture the pose in which the arm is held, or says why not.
    pub(super) fn capture_by_command(&mut self, now_ms: u32) -> Reply {
        // A pose on the way gives way: it was not asked for.
        let is_busy = self.capturing.is_some_and(|capturing| capturing.asked != Asked::Motion);
        if is_busy || self.assessing.is_some() {
            // The arm stands where it was captured a moment ago.
            return Reply::refused(Reason::PoseTooNear, 0);
        }
        match self.begin_at_rest(now_ms, Asked::Command) {
            None => Reply::LATER,
            Some(notice) => Reply { pose: Some(notice), ..Reply::refused(notice.reason, u16::from(notice.cable)) },
        }
    }

    /// A capture begins when the arm comes to rest, once a rest; or on its way, far enough from the others. A notice says why it
    /// does not.
    pub(super) fn capture_by_itself(&mut self, now_ms: u32) -> Option<PoseNotice> {
        if self.course.in_motion && self.calibration.arm.ready(now_ms).is_err() {
            self.begin_in_motion(now_ms);
            return None;
        }
        if self.calibration.has_come_to_rest(now_ms) { self.begin_at_rest(now_ms, Asked::Rest) } else { None }
    }

    fn begin_at_rest(&mut self, now_ms: u32, asked: Asked) -> Option<PoseNotice> {
        match self.calibration.arm.pose(now_ms, &self.rig) {
            Ok(taken) => {
                self.begin_capture(taken, asked);
                None
            }
            Err(not_ready) => Some(self.note_pose(now_ms, Err(not_ready), None)),
        }
    }

    /// Of the pose through which the arm has just moved slowly, if there is one.
    fn begin_in_motion(&mut self, now_ms: u32) {
        if let Some(taken) = self.calibration.arm.pose_in_motion(now_ms, &self.rig)
            && now_ms.wrapping_sub(self.calibration.run.since_ms) >= PAUSE_IN_MOTION_MS
        {
            self.begin_capture(taken, Asked::Motion);
        }
    }

    fn begin_capture(&mut self, (lengths, samples): (CableLengths<f32>, u16), asked: Asked) {
        let pose = Pose::new(lengths).averaged_over(samples);
        self.capturing = Some(Capturing { pose, search: PlatformSearch::default(), asked });
    }

    /// The next step of a capture. Returns the notice of the pose when it is over, unless the pose is to be assessed first.
    pub(super) fn capture_further(&mut self, now_ms: u32) -> Option<PoseNotice> {
        let capturing = self.capturing.as_mut()?;
        if capturing.pose.state == PoseState::Unplaced {
            capturing.pose.place_step(&mut capturing.search, self.machine.platform());
            return None;
        }
        let Capturing { pose, asked, .. } = *capturing;
        self.capturing = None;
        let mut distance_rad = None;
        let outcome = self.take_in(&pose, &mut distance_rad);
        // On the way from pose to pose most are too near: no notice is sent.
        if asked == Asked::Motion && outcome.is_err() {
            return None;
        }
        let notice = self.note_pose(now_ms, outcome, distance_rad);
        if asked == Asked::Command {
            let detail = if outcome.is_ok() { notice.index } else { notice.cable };
            self.answer = Some((notice.reason, u16::from(detail)));
        }
        self.assessed(notice, asked != Asked::Command)
    }

    /// Gives up the pose that is being captured: the state in which it was wanted is over.
    pub(super) fn give_up_capture(&mut self) {
        if self.capturing.take().is_some_and(|capturing| capturing.asked == Asked::Command) {
            self.answer = Some((Reason::WrongState, u16::from(self.state().code())));
        }
    }

    /// The answer to a capture by command, once it is there: as of [`Reply`].
    pub fn take_answer(&mut self) -> Option<(Reason, u16)> {
        self.answer.take()
    }

    fn note_pose(&mut self, now_ms: u32, outcome: Result<(), NotReady>, distance_rad: Option<f32>) -> PoseNotice {
        let notice = self.calibration.note_pose(now_ms, outcome, self.pose_count(), self.course.advice);
        PoseNotice { sigma_mm: self.predicted_sigma_mm(), distance_rad, ..notice }
    }

    /// What would help the first set most.
    fn advice(&self) -> Guidance {
        match self.course.phase {
            Phase::Held => match self.spread.advice() {
                Guidance::MoveOn | Guidance::TiltMore => Guidance::HoldBlade,
                advice => advice,
            },
            Phase::Free(_) => self.spread.advice_for_moving(),
            Phase::Only if self.moves() => self.spread.advice_for_moving(),
            Phase::Only => self.spread.advice(),
        }
    }

    /// Takes the pose into its set, if it is placed and far enough from all others.
    fn take_in(&mut self, pose: &Pose<f32>, distance_rad: &mut Option<f32>) -> Result<(), NotReady> {
        let refused = |reason| NotReady { reason, cable: 0 };
        match pose.state {
            PoseState::Broken => {
                let cable = pose.suspect_cables.trailing_zeros() as u8 + 1;
                return Err(NotReady { reason: Reason::LengthImpossible, cable });
            }
            PoseState::NotClosing => return Err(refused(Reason::PlatformDoesNotClose)),
            _ => {}
        }
        // A pose of the second set that repeats one of the first would verify nothing.
        let distances = [self.poses.nearest_rad(pose), self.held_out.nearest_rad(pose)];
        *distance_rad = distances.into_iter().flatten().reduce(f32::min);
        if distance_rad.is_some_and(|distance| distance < self.calibration.limits.settings().nearest_pose_rad) {
            return Err(refused(Reason::PoseTooNear));
        }
        match self.calibration.current_set() {
            PoseSet::Identification => {
                self.poses.push(*pose).map_err(|_| refused(Reason::PosesFull))?;
                self.spread.add(&pose.rotation());
                self.course.advice = self.advice();
            }
            PoseSet::HeldOut => {
                self.held_out.push(*pose).map_err(|_| refused(Reason::PosesFull))?;
                self.course.advice = Guidance::MoveOn;
            }
        }
        Ok(())
    }
}
