//! One calibration as a client and a wearer go through it: move, hold, capture, identify, verify, accept.

use super::bench::Bench;
use super::client::{ANSWER_LIMIT_MS, Client, PERIOD_MS};
use super::display::Display;
use super::transcript::{Captured, SessionError, Transcript};
use crate::wearer::{Pose, Wearer};
use glenoid::can::command::BY_COMMAND_ONLY;
use glenoid::can::message::PROTOCOL;
use glenoid::can::report::{OutcomeReport, PoseReport};
use glenoid::can::result::ZeroError;
use glenoid::can::status::Versions;
use glenoid::can::{BaseId, Opcode};
use glenoid::procedure::{PoseSet, Reason, StateName};
use glenoid::rig::CABLES;

/// The arm moves no faster than this share of what the drive can follow.
const SPEED_SHARE: f64 = 0.5;
/// Shortest movement between two poses, ms.
const SHORTEST_MOVE_MS: u32 = 150;
/// The arm is held still this long before a capture is tried, ms.
pub(super) const SETTLE_MS: u32 = 400;
/// Longest wait for the solver, ms. On the board it takes well under a second; an emulator on a busy host is slower.
pub(super) const SOLVER_LIMIT_MS: u32 = 60_000;
/// Poses that the board may refuse in a row as too near to others before the session gives up.
const REFUSALS_LIMIT: u32 = 20;

/// Whoever is in the machine: what a session must know to move the joint from pose to pose.
pub trait Person {
    /// The pose in which it begins.
    fn home(&self) -> Pose;

    /// The next random pose.
    fn next_pose(&mut self) -> Pose;

    /// Encoder counts on the way from one pose to another, one sample every `period_ms`, the last one in the new pose.
    fn motion(&self, from: &Pose, to: &Pose, duration_ms: u32, period_ms: u32) -> Vec<[i32; CABLES]>;

    /// Length of cable that one count stands for, mm.
    fn mm_per_count(&self) -> f64;

    /// How many of the six encoders have a cable.
    fn cables(&self) -> usize {
        CABLES
    }
}

impl Person for Wearer {
    fn home(&self) -> Pose {
        Self::home(self)
    }

    fn next_pose(&mut self) -> Pose {
        Self::next_pose(self)
    }

    fn motion(&self, from: &Pose, to: &Pose, duration_ms: u32, period_ms: u32) -> Vec<[i32; CABLES]> {
        Self::motion(self, from, to, duration_ms, period_ms)
    }

    fn mm_per_count(&self) -> f64 {
        self.encoder().mm_per_count()
    }
}

/// Somebody in a machine, a client on the bus.
pub struct Session<'a, P = Wearer> {
    pub(super) client: Client<'a>,
    pub(super) wearer: &'a mut P,
    pub(super) display: &'a Display,
    at: Pose,
    fastest_counts_per_ms: f64,
}

/// Both sets of a run that waits for its decision.
pub(super) struct Reviewed {
    pub(super) versions: Versions,
    pub(super) run_id: u16,
    pub(super) identification: Vec<Captured>,
    pub(super) verification: Vec<Captured>,
    pub(super) refused_poses: u32,
}

impl Session<'_> {
    /// Runs a whole calibration: `poses` to identify, `second` to verify, encoder zeros known to so many steps of
    /// [`ZERO_PRIOR_STEP_MM`](glenoid::can::command::ZERO_PRIOR_STEP_MM), 1σ.
    ///
    /// # Errors
    /// [`SessionError`]; the run is then left as the board ended it.
    pub fn calibrate(&mut self, poses: u8, second: u8, zero_prior_steps: u16) -> Result<Transcript, SessionError> {
        let reviewed = self.go_to_review(poses, second, zero_prior_steps)?;
        let Reviewed { versions, run_id, identification, verification, refused_poses } = reviewed;
        let inbox = self.client.wait_for("report", ANSWER_LIMIT_MS, |inbox| {
            let (quality, verified) = (inbox.quality?, inbox.verification?);
            Some((inbox.parameters(run_id)?, quality, verified))
        });
        let (parameters, quality, verified) = inbox?;
        // They come before the quality in a report.
        let zeros = all_zeros(&self.client.inbox.zeros);
        let live_centre_mm = self.accept(run_id)?;
        Ok(Transcript {
            versions,
            run_id,
            identification,
            verification,
            refused_poses,
            parameters,
            zeros,
            quality,
            verified,
            live_centre_mm,
        })
    }

    pub(super) fn accept(&mut self, run_id: u16) -> Result<[f32; 3], SessionError> {
        self.client.inbox.live_centre = [None; 3];
        self.accept_run(run_id)?;
        self.client.command(Opcode::Query, 0, 0)?;
        self.client.wait_for("live centre", ANSWER_LIMIT_MS, |inbox| match inbox.live_centre {
            [Some(x), Some(y), Some(z)] => Some([x, y, z].map(|parameter| parameter.value_mm)),
            _ => None,
        })
    }
}

impl<'a, P: Person> Session<'a, P> {
    /// A session that begins with the arm at home. `fastest_mm_per_s` is what the drive can follow.
    pub fn new(bench: &'a mut dyn Bench, wearer: &'a mut P, fastest_mm_per_s: f64, display: &'a Display) -> Self {
        let at = wearer.home();
        let fastest_counts_per_ms = SPEED_SHARE * fastest_mm_per_s / 1000.0 / wearer.mm_per_count();
        Self { client: Client::new(bench, at.counts), wearer, display, at, fastest_counts_per_ms }
    }

    /// The same with the board at these identifiers.
    #[must_use]
    pub fn at(mut self, base: BaseId) -> Self {
        self.client.base = base;
        self
    }

    /// The same with the arm in this pose already.
    #[must_use]
    pub fn standing_in(mut self, pose: Pose) -> Self {
        self.client.stand(pose.counts);
        self.at = pose;
        self
    }

    /// The pose in which the arm stands.
    pub fn pose(&self) -> &Pose {
        &self.at
    }

    /// Takes both sets and leads the run to the review: `poses` to identify, `second` to verify.
    pub(super) fn go_to_review(
        &mut self,
        poses: u8,
        second: u8,
        zero_prior_steps: u16,
    ) -> Result<Reviewed, SessionError> {
        let (versions, run_id) = self.begin(zero_prior_steps, BY_COMMAND_ONLY)?;
        let (mut identification, refused_first) = self.collect(PoseSet::Identification, poses)?;
        self.identify()?;
        let (mut verification, refused_second) = self.collect(PoseSet::HeldOut, second)?;
        self.client.command(Opcode::Verify, 0, 0)?;
        self.client.wait_for_state(StateName::Verifying, StateName::Review, SOLVER_LIMIT_MS)?;
        self.read_out(run_id, &mut identification, &mut verification)?;
        Ok(Reviewed { versions, run_id, identification, verification, refused_poses: refused_first + refused_second })
    }

    /// Meets the board and starts a run. `start`: the argument of the command.
    pub(super) fn begin(&mut self, zero_prior_steps: u16, start: u16) -> Result<(Versions, u16), SessionError> {
        let stage = self.display.stage("meeting the board");
        self.client.wait_for("heartbeat", ANSWER_LIMIT_MS, |inbox| inbox.heartbeat)?;
        self.client.command(Opcode::Query, 0, 0)?;
        let versions = self.client.wait_for("versions", ANSWER_LIMIT_MS, |inbox| inbox.versions)?;
        if versions.protocol != PROTOCOL {
            return Err(SessionError::Protocol(versions.protocol));
        }
        self.client.command(Opcode::SetZeroPrior, 0, zero_prior_steps)?;
        let answer = self.client.command_when_still(Opcode::Start, start)?;
        let [major, minor, patch] = versions.firmware;
        stage.done(&format!("firmware {major}.{minor}.{patch}, run {}", answer.run_id));
        Ok((versions, answer.run_id))
    }

    /// Moves from pose to pose until the board has taken `count` of them. Returns them and how many it refused.
    pub(super) fn collect(&mut self, set: PoseSet, count: u8) -> Result<(Vec<Captured>, u32), SessionError> {
        let title = if set == PoseSet::HeldOut { "verification poses" } else { "identification poses" };
        let stage = self.display.counted(title, u64::from(count));
        let (mut taken, mut refused, mut in_a_row) = (Vec::new(), 0, 0);
        while taken.len() < usize::from(count) {
            let pose = self.wearer.next_pose();
            self.move_to(pose)?;
            match self.client.command_when_still(Opcode::Capture, 0) {
                Ok(_) => in_a_row = 0,
                Err(SessionError::Refused(_, answer))
                    if answer.code == Reason::PoseTooNear && in_a_row < REFUSALS_LIMIT =>
                {
                    refused += 1;
                    in_a_row += 1;
                    continue;
                }
                Err(error) => return Err(error),
            }
            // The answer says that the pose was taken; its report is on the way.
            let taken_now = |report: &&PoseReport| {
                report.reason == Reason::Fine && report.set == set && usize::from(report.index) == taken.len()
            };
            let report = self
                .client
                .wait_for("pose report", ANSWER_LIMIT_MS, |inbox| inbox.poses.last().filter(taken_now).copied())?;
            let predicted_sigma_mm = report.sigma_mm;
            taken.push(Captured { pose, lengths_mm: [0.0; CABLES], samples: 1, predicted_sigma_mm });
            stage.reached(taken.len() as u64, &advice(&report));
        }
        stage.done(&match refused {
            0 => format!("{count} captured"),
            _ => format!("{count} captured, {refused} refused as too near to another"),
        });
        Ok((taken, refused))
    }

    pub(super) fn identify(&mut self) -> Result<(), SessionError> {
        let stage = self.display.stage("identifying");
        self.client.command(Opcode::Identify, 0, 0)?;
        self.client.wait_for_state(StateName::Identifying, StateName::Verifying, SOLVER_LIMIT_MS)?;
        stage.done("found");
        Ok(())
    }

    /// Reads the lengths that the board took for each pose of both sets.
    pub(super) fn read_out(
        &mut self,
        run_id: u16,
        first: &mut [Captured],
        second: &mut [Captured],
    ) -> Result<(), SessionError> {
        let cables = self.wearer.cables();
        let stage = self.display.counted("reading out", (first.len() + second.len()) as u64);
        let numbered = |set, captured| (0u8..).zip(captured).map(move |(index, captured)| (set, index, captured));
        let first = numbered(PoseSet::Identification, first);
        for (done, (set, index, captured)) in (1..).zip(first.chain(numbered(PoseSet::HeldOut, second))) {
            let held_out = if set == PoseSet::HeldOut { 0x100 } else { 0 };
            self.client.command_when_sent(Opcode::ReadPose, run_id, held_out | u16::from(index))?;
            captured.lengths_mm =
                self.client.wait_for("raw pose", ANSWER_LIMIT_MS, |inbox| inbox.pose_mm(set, index, cables))?;
            captured.samples = self.client.inbox.samples(set, index);
            stage.reached(done, "");
        }
        stage.done("the lengths that the board used");
        Ok(())
    }

    /// Accepts what a run has found.
    pub(super) fn accept_run(&mut self, run_id: u16) -> Result<(), SessionError> {
        let stage = self.display.stage("accepting");
        self.client.accept(run_id)?;
        // In the review the outcome says that nothing is decided yet; it may still be under way.
        let decided = |outcome: &OutcomeReport| outcome.run_id == run_id && outcome.reason != Reason::Fine;
        let outcome = self.client.wait_for("outcome", ANSWER_LIMIT_MS, |inbox| inbox.outcome.filter(decided))?;
        if outcome.reason != Reason::Accepted || !outcome.live {
            return Err(SessionError::Failed(outcome));
        }
        self.client.command(Opcode::Acknowledge, run_id, 0)?;
        stage.done("what was found is in use");
        Ok(())
    }

    /// The arm is there at the next sample.
    pub(super) fn sample(&mut self, pose: Pose) -> Result<(), SessionError> {
        self.at = pose;
        self.client.sample(pose.counts)
    }

    /// Moves the arm there, no faster than the drive can follow.
    pub(super) fn move_to(&mut self, pose: Pose) -> Result<(), SessionError> {
        let farthest = (0..CABLES).map(|k| (pose.counts[k] - self.at.counts[k]).unsigned_abs()).max().unwrap_or(0);
        // A minimum-jerk movement is 15/8 times as fast in its middle as on average.
        let needed_ms = 1.875 * f64::from(farthest) / self.fastest_counts_per_ms;
        let duration_ms = (needed_ms.ceil() as u32).max(SHORTEST_MOVE_MS).next_multiple_of(PERIOD_MS);
        for counts in self.wearer.motion(&self.at, &pose, duration_ms, PERIOD_MS) {
            self.client.sample(counts)?;
        }
        self.at = pose;
        self.client.hold(SETTLE_MS)
    }
}

/// All six zero errors, when all have come.
pub(super) fn all_zeros(zeros: &[Option<ZeroError>; CABLES]) -> Option<[ZeroError; CABLES]> {
    let [Some(z1), Some(z2), Some(z3), Some(z4), Some(z5), Some(z6)] = *zeros else { return None };
    Some([z1, z2, z3, z4, z5, z6])
}

/// What a pose report tells the person at the arm.
fn advice(report: &PoseReport) -> String {
    let guidance = report.guidance.text();
    match report.sigma_mm {
        Some(sigma) if report.set == PoseSet::Identification => {
            format!("expected σ of the centre {sigma:.3} mm; {guidance}")
        }
        _ => guidance.to_string(),
    }
}
