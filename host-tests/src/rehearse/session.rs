//! One calibration as a client and a wearer go through it: move, hold, capture, identify, verify, accept.

use super::bench::{Bench, BenchError};
use super::display::Display;
use super::inbox::Inbox;
use crate::wearer::{Pose, Wearer};
use glenoid::can::message::PROTOCOL;
use glenoid::can::report::{OutcomeReport, PoseReport};
use glenoid::can::result::{Parameter, Quality, VerificationReport};
use glenoid::can::status::{Answer, Versions};
use glenoid::can::{BaseId, Opcode, Request};
use glenoid::procedure::{PoseSet, Reason, StateName};
use glenoid::rig::CABLES;
use std::fmt;

/// A sample of the encoders every so many milliseconds, as long as the session lasts: 100 Hz.
const PERIOD_MS: u32 = 10;
/// The arm moves no faster than this share of what the drive can follow.
const SPEED_SHARE: f64 = 0.5;
/// Shortest movement between two poses, ms.
const SHORTEST_MOVE_MS: u32 = 150;
/// The arm is held still this long before a capture is tried, ms, and this long before it is tried again.
const SETTLE_MS: u32 = 400;
const RETRY_MS: u32 = 50;
/// Longest wait for the answer to a command, ms.
const ANSWER_LIMIT_MS: u32 = 2_000;
/// Longest wait for the arm to count as still, ms.
const STILL_LIMIT_MS: u32 = 5_000;
/// Longest wait for the solver, ms. On the board it takes well under a second; an emulator on a busy host is slower.
const SOLVER_LIMIT_MS: u32 = 60_000;
/// Poses that the board may refuse in a row as too near to others before the session gives up.
const REFUSALS_LIMIT: u32 = 20;

/// Why a session ended without a result.
#[derive(Debug, Clone, PartialEq)]
pub enum SessionError {
    /// The board is gone.
    Bench(BenchError),
    /// Nothing was heard of what was waited for.
    Silence(&'static str),
    /// A command was not obeyed.
    Refused(Opcode, Answer),
    /// The run ended without a centre.
    Failed(OutcomeReport),
    /// The firmware speaks another vocabulary.
    Protocol(u8),
}

impl fmt::Display for SessionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bench(error) => write!(f, "{error}"),
            Self::Silence(what) => write!(f, "the board sent no {what} in time"),
            Self::Refused(opcode, answer) => write!(
                f,
                "the board did not obey {opcode:?}: {} (code {}, detail {}). What to do: {}",
                answer.code,
                answer.code.code(),
                answer.detail,
                answer.code.remedy()
            ),
            Self::Failed(outcome) => {
                write!(f, "the board gave up: {} (code {}", outcome.reason, outcome.reason.code())?;
                if let Some(pose) = outcome.pose {
                    write!(f, ", pose {pose}")?;
                }
                if outcome.cable != 0 {
                    write!(f, ", cable {}", outcome.cable)?;
                }
                if let Some(size) = outcome.size_mm {
                    write!(f, ", {size:.3} mm")?;
                }
                write!(f, "). What to do: {}", outcome.reason.remedy())
            }
            Self::Protocol(theirs) => {
                write!(f, "the firmware speaks vocabulary {theirs}, this program speaks {PROTOCOL}")
            }
        }
    }
}

impl std::error::Error for SessionError {}

impl From<BenchError> for SessionError {
    fn from(error: BenchError) -> Self {
        Self::Bench(error)
    }
}

/// A pose that the board took.
#[derive(Debug, Clone, PartialEq)]
pub struct Captured {
    /// The pose in which the wearer held the arm.
    pub pose: Pose,
    /// The lengths that the board took for it, as read out over CAN, mm.
    pub lengths_mm: [f32; CABLES],
    /// The centre's σ that the board predicted from the poses so far, mm.
    pub predicted_sigma_mm: Option<f32>,
}

/// Everything that a session brought to light.
#[derive(Debug, Clone, PartialEq)]
pub struct Transcript {
    /// The firmware.
    pub versions: Versions,
    /// The run.
    pub run_id: u16,
    /// The first set.
    pub identification: Vec<Captured>,
    /// The second set.
    pub verification: Vec<Captured>,
    /// Poses that the board refused because they were too near to others.
    pub refused_poses: u32,
    /// x, y, z, p1, p2, p3 with their standard deviations.
    pub parameters: [Parameter; 6],
    /// How well the first set fits.
    pub quality: Quality,
    /// How well the second set fits.
    pub verified: VerificationReport,
    /// The centre that is in use after the acceptance, mm.
    pub live_centre_mm: [f32; 3],
}

/// A wearer in a machine, a client on the bus.
pub struct Session<'a> {
    bench: &'a mut dyn Bench,
    wearer: &'a mut Wearer,
    display: &'a Display,
    at: Pose,
    counts: [i32; CABLES],
    inbox: Inbox,
    nonce: u16,
    fastest_counts_per_ms: f64,
}

impl<'a> Session<'a> {
    /// A session that begins with the arm at home. `fastest_mm_per_s` is what the drive can follow.
    pub fn new(bench: &'a mut dyn Bench, wearer: &'a mut Wearer, fastest_mm_per_s: f64, display: &'a Display) -> Self {
        let at = wearer.home();
        let fastest_counts_per_ms = SPEED_SHARE * fastest_mm_per_s / 1000.0 / wearer.encoder().mm_per_count();
        Self { bench, wearer, display, counts: at.counts, at, inbox: Inbox::default(), nonce: 0, fastest_counts_per_ms }
    }

    /// Runs a whole calibration: `poses` to identify, `second` to verify.
    ///
    /// # Errors
    /// [`SessionError`]; the run is then left as the board ended it.
    pub fn calibrate(mut self, poses: u8, second: u8) -> Result<Transcript, SessionError> {
        let (versions, run_id) = self.begin()?;
        let (mut identification, refused_first) = self.collect(PoseSet::Identification, poses)?;
        self.command(Opcode::Identify, 0, 0)?;
        self.identify()?;
        let (mut verification, refused_second) = self.collect(PoseSet::HeldOut, second)?;
        self.command(Opcode::Verify, 0, 0)?;
        self.wait_for_state(StateName::Review, SOLVER_LIMIT_MS)?;
        self.read_out(run_id, &mut identification, &mut verification)?;
        let inbox = self.wait_for("report", ANSWER_LIMIT_MS, |inbox| {
            let (quality, verified) = (inbox.quality?, inbox.verification?);
            Some((inbox.parameters(run_id)?, quality, verified))
        });
        let (parameters, quality, verified) = inbox?;
        let live_centre_mm = self.accept(run_id)?;
        let refused_poses = refused_first + refused_second;
        Ok(Transcript {
            versions,
            run_id,
            identification,
            verification,
            refused_poses,
            parameters,
            quality,
            verified,
            live_centre_mm,
        })
    }

    fn begin(&mut self) -> Result<(Versions, u16), SessionError> {
        let stage = self.display.stage("meeting the board");
        self.wait_for("heartbeat", ANSWER_LIMIT_MS, |inbox| inbox.heartbeat)?;
        self.command(Opcode::Query, 0, 0)?;
        let versions = self.wait_for("versions", ANSWER_LIMIT_MS, |inbox| inbox.versions)?;
        if versions.protocol != PROTOCOL {
            return Err(SessionError::Protocol(versions.protocol));
        }
        // Argument 1: poses are captured by command only.
        let answer = self.command_when_still(Opcode::Start, 1)?;
        let [major, minor, patch] = versions.firmware;
        stage.done(&format!("firmware {major}.{minor}.{patch}, run {}", answer.run_id));
        Ok((versions, answer.run_id))
    }

    /// Moves from pose to pose until the board has taken `count` of them. Returns them and how many it refused.
    fn collect(&mut self, set: PoseSet, count: u8) -> Result<(Vec<Captured>, u32), SessionError> {
        let title = if set == PoseSet::HeldOut { "verification poses" } else { "identification poses" };
        let stage = self.display.counted(title, u64::from(count));
        let (mut taken, mut refused, mut in_a_row) = (Vec::new(), 0, 0);
        while taken.len() < usize::from(count) {
            let pose = self.wearer.next_pose();
            self.move_to(pose)?;
            match self.command_when_still(Opcode::Capture, 0) {
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
            let report =
                self.wait_for("pose report", ANSWER_LIMIT_MS, |inbox| inbox.poses.last().filter(taken_now).copied())?;
            taken.push(Captured { pose, lengths_mm: [0.0; CABLES], predicted_sigma_mm: report.sigma_mm });
            stage.reached(taken.len() as u64, &advice(&report));
        }
        stage.done(&match refused {
            0 => format!("{count} captured"),
            _ => format!("{count} captured, {refused} refused as too near to another"),
        });
        Ok((taken, refused))
    }

    fn identify(&mut self) -> Result<(), SessionError> {
        let stage = self.display.stage("identifying");
        self.wait_for_state(StateName::Verifying, SOLVER_LIMIT_MS)?;
        stage.done("centre found");
        Ok(())
    }

    /// Reads the lengths that the board took for each pose of both sets.
    fn read_out(&mut self, run_id: u16, first: &mut [Captured], second: &mut [Captured]) -> Result<(), SessionError> {
        let stage = self.display.counted("reading out", (first.len() + second.len()) as u64);
        let numbered = |set, captured| (0u8..).zip(captured).map(move |(index, captured)| (set, index, captured));
        let first = numbered(PoseSet::Identification, first);
        for (done, (set, index, captured)) in (1..).zip(first.chain(numbered(PoseSet::HeldOut, second))) {
            let held_out = if set == PoseSet::HeldOut { 0x100 } else { 0 };
            self.command(Opcode::ReadPose, run_id, held_out | u16::from(index))?;
            captured.lengths_mm = self.wait_for("raw pose", ANSWER_LIMIT_MS, |inbox| inbox.pose_mm(set, index))?;
            stage.reached(done, "");
        }
        stage.done("the lengths that the board used");
        Ok(())
    }

    fn accept(&mut self, run_id: u16) -> Result<[f32; 3], SessionError> {
        let stage = self.display.stage("accepting");
        self.inbox.live_centre = [None; 3];
        self.command(Opcode::Accept, run_id, 0)?;
        // In the review the outcome says that nothing is decided yet; it may still be under way.
        let decided = |outcome: &OutcomeReport| outcome.run_id == run_id && outcome.reason != Reason::Fine;
        let outcome = self.wait_for("outcome", ANSWER_LIMIT_MS, |inbox| inbox.outcome.filter(decided))?;
        if outcome.reason != Reason::Accepted || !outcome.live {
            return Err(SessionError::Failed(outcome));
        }
        self.command(Opcode::Acknowledge, run_id, 0)?;
        self.command(Opcode::Query, 0, 0)?;
        let live = self.wait_for("live centre", ANSWER_LIMIT_MS, |inbox| match inbox.live_centre {
            [Some(x), Some(y), Some(z)] => Some([x, y, z].map(|parameter| parameter.value_mm)),
            _ => None,
        })?;
        stage.done("the new centre is in use");
        Ok(live)
    }

    /// Moves the arm there, no faster than the drive can follow.
    fn move_to(&mut self, pose: Pose) -> Result<(), SessionError> {
        let farthest = (0..CABLES).map(|k| (pose.counts[k] - self.at.counts[k]).unsigned_abs()).max().unwrap_or(0);
        // A minimum-jerk movement is 15/8 times as fast in its middle as on average.
        let needed_ms = 1.875 * f64::from(farthest) / self.fastest_counts_per_ms;
        let duration_ms = (needed_ms.ceil() as u32).max(SHORTEST_MOVE_MS).next_multiple_of(PERIOD_MS);
        for counts in self.wearer.motion(&self.at, &pose, duration_ms, PERIOD_MS) {
            self.counts = counts;
            self.step()?;
        }
        self.at = pose;
        self.hold(SETTLE_MS)
    }

    /// Holds the arm where it is.
    fn hold(&mut self, ms: u32) -> Result<(), SessionError> {
        for _ in 0..ms / PERIOD_MS {
            self.step()?;
        }
        Ok(())
    }

    /// One sample of the encoders; takes in what the board sends meanwhile.
    fn step(&mut self) -> Result<(), SessionError> {
        self.bench.set_counts(&self.counts)?;
        for frame in self.bench.pass(PERIOD_MS)? {
            self.inbox.take(&frame, BaseId::DEFAULT);
        }
        Ok(())
    }

    /// Holds still until `found` finds something in the inbox.
    fn wait_for<T>(
        &mut self,
        what: &'static str,
        limit_ms: u32,
        mut found: impl FnMut(&Inbox) -> Option<T>,
    ) -> Result<T, SessionError> {
        for _ in 0..=limit_ms / PERIOD_MS {
            if let Some(found) = found(&self.inbox) {
                return Ok(found);
            }
            self.step()?;
        }
        Err(SessionError::Silence(what))
    }

    /// Holds still until the board is in `state`, or has failed.
    fn wait_for_state(&mut self, state: StateName, limit_ms: u32) -> Result<(), SessionError> {
        let before = self.inbox.heartbeat.map(|heartbeat| heartbeat.sequence);
        let arrived = self.wait_for("change of state", limit_ms, |inbox| {
            let now = inbox.heartbeat.filter(|heartbeat| Some(heartbeat.sequence) != before)?.state;
            (now == state || now == StateName::Failed).then_some(now)
        })?;
        if arrived == state {
            return Ok(());
        }
        Err(SessionError::Failed(self.wait_for("outcome", ANSWER_LIMIT_MS, |inbox| inbox.outcome)?))
    }

    /// Sends a command and waits for its answer.
    fn command(&mut self, opcode: Opcode, run_id: u16, argument: u16) -> Result<Answer, SessionError> {
        self.nonce = self.nonce.checked_add(1).unwrap_or(1);
        let nonce = self.nonce;
        let request = Request { opcode: opcode as u8, nonce, run_id, argument };
        self.bench.send(&request.pack(BaseId::DEFAULT.command()))?;
        let answer = self.wait_for("answer", ANSWER_LIMIT_MS, |inbox| inbox.answers.get(&nonce).copied())?;
        if answer.code == Reason::Fine { Ok(answer) } else { Err(SessionError::Refused(opcode, answer)) }
    }

    /// Sends a command that needs a still arm, again and again until the board agrees that it is still.
    fn command_when_still(&mut self, opcode: Opcode, argument: u16) -> Result<Answer, SessionError> {
        for _ in 0..STILL_LIMIT_MS / RETRY_MS {
            match self.command(opcode, 0, argument) {
                // An arm that is coming to rest may for a moment move one cable only.
                Err(SessionError::Refused(_, Answer { code: Reason::ArmMoving | Reason::CableLoose, .. })) => {
                    self.hold(RETRY_MS)?;
                }
                result => return result,
            }
        }
        Err(SessionError::Silence("sign that the arm is still"))
    }
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
