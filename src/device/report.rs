//! Sends what there is to say about the run, a frame or two a tick, so that no queue has to be long.

use super::left_out::{left_out, quality};
use super::seal::seal;
use super::shown::{self, Kind, NamingInWork};
use crate::can::Message;
use crate::can::health::{BusHealth, LastStop, StopText};
use crate::can::hinge::Module;
use crate::can::identity::Naming;
use crate::can::report::{LeftOut, OutcomeReport, PoseSamples, RawLength};
use crate::can::result::{Axis, VerificationReport, WeakDirection};
use crate::can::status::{Counters, Versions};
use crate::identification::uncertainty::{RESULT_UNKNOWNS, unpacked};
use crate::linear_algebra::EigenSearch;
use crate::procedure::module::{FoundJoint, JointValue};
use crate::procedure::{ModuleProcedure, PoseSet, Reason, StateName};
use crate::restart::CrashRecord;

/// An unacknowledged report is sent again after this time, ms.
const REPEAT_MS: u32 = 1_000;

/// What a report consists of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Parts {
    /// Versions, counters, how the firmware stopped the last time.
    pub device: bool,
    /// The centre in use.
    pub live: bool,
    /// What the run has found, and how it ended.
    pub run: bool,
}

/// What does not belong to the run but is reported.
pub(super) struct About<'a> {
    pub versions: &'a Versions,
    pub module: Module,
    pub counters: &'a Counters,
    pub bus: &'a BusHealth,
    pub crash_record: Option<&'a CrashRecord>,
}

/// Positions of the parts in a report.
const VERSIONS: u8 = 0;
const MODULE: u8 = 1;
const COUNTERS: u8 = 2;
const BUS: u8 = 3;
const LAST_STOP: u8 = 4;
const STOP_TEXT: u8 = 5;
const LIVE: u8 = STOP_TEXT + StopText::MAX_PARTS;
const LIVE_NAMING: u8 = LIVE + shown::FRAMES;
const CANDIDATE: u8 = LIVE_NAMING + 1;
const CANDIDATE_NAMING: u8 = CANDIDATE + shown::FRAMES;
const QUALITY: u8 = CANDIDATE_NAMING + 1;
const VERIFICATION: u8 = QUALITY + 1;
const WEAK_DIRECTION: u8 = VERIFICATION + 1;
const AXIS: u8 = WEAK_DIRECTION + 1;
const LEFT_OUT: u8 = AXIS + 1;
const OUTCOME: u8 = LEFT_OUT + crate::identification::outcome::MAX_REJECTED as u8;

/// Positions that are looked at in one call; most have nothing to say.
const POSITIONS_A_CALL: usize = 4;

/// What is being worked out for the next message, a slice a tick.
#[derive(Debug, Clone, Copy)]
enum Preparing {
    Nothing,
    Naming(NamingInWork),
    /// What names the centre is worked out.
    Named,
    WeakDirection(EigenSearch<f32, RESULT_UNKNOWNS>),
}

/// What names a centre, and the checksum of the centre that it was formed of.
#[derive(Debug, Clone, Copy)]
struct Named {
    seal: u32,
    naming: Option<Naming>,
}

/// The report under way, and what waits to be acknowledged.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reporter {
    preparing: Preparing,
    /// What names the new centre that was shown last, and the centre in use.
    named_candidate: Option<Named>,
    named_live: Option<Named>,
    /// Position in the report under way, and its parts.
    report: Option<(u8, Parts)>,
    /// The pose that is being read out, and the next of its cables, from 0.
    pose: Option<(PoseSet, u8, u8)>,
    /// The same for the pose that was captured last: its lengths go out by themselves.
    captured: Option<(PoseSet, u8, u8)>,
    unacknowledged: bool,
    sent_at_ms: u32,
    /// A frame of the report under way was lost on this side of the bus.
    spoilt: bool,
    /// The run whose new centre was shown whole.
    shown_run: Option<u16>,
}

impl Reporter {
    /// A reporter that begins with what the device is and which centre is in use.
    pub const fn at_power_up() -> Self {
        let parts = Parts { device: true, live: true, run: false };
        Self {
            preparing: Preparing::Nothing,
            named_candidate: None,
            named_live: None,
            report: Some((0, parts)),
            pose: None,
            captured: None,
            unacknowledged: false,
            sent_at_ms: 0,
            spoilt: false,
            shown_run: None,
        }
    }

    /// Begins a report. One that is under way begins anew, with the parts of both.
    pub fn begin(&mut self, now_ms: u32, parts: Parts) {
        let before = self.report.map_or(Parts::default(), |(_, parts)| parts);
        let both = Parts {
            device: parts.device || before.device,
            live: parts.live || before.live,
            run: parts.run || before.run,
        };
        self.report = Some((0, both));
        self.preparing = Preparing::Nothing;
        self.sent_at_ms = now_ms;
        self.spoilt = false;
    }

    /// A frame was lost on this side of the bus: what is being reported is not whole.
    pub fn spoil(&mut self) {
        self.spoilt = true;
    }

    /// Has the whole report of this run's new centre been sent?
    pub fn has_shown(&self, run_id: u16) -> bool {
        self.shown_run == Some(run_id)
    }

    /// What names the new centre, as it was shown last; None before.
    pub fn naming_of_candidate(&self, candidate: &FoundJoint<'_>) -> Option<Naming> {
        naming_of(&self.named_candidate, candidate)
    }

    /// What names the centre in use, as it was shown last; None before.
    pub fn naming_of_live(&self, live: &FoundJoint<'_>) -> Option<Naming> {
        naming_of(&self.named_live, live)
    }

    /// A new run begins: nothing of it has been shown.
    pub fn forget_shown(&mut self) {
        self.shown_run = None;
    }

    /// Sends the six lengths of a pose that has just been captured.
    pub fn captured(&mut self, set: PoseSet, index: u8) {
        self.captured = Some((set, index, 0));
    }

    /// Begins the report that is repeated until it is acknowledged.
    pub fn begin_repeated(&mut self, now_ms: u32) {
        self.begin(now_ms, Parts { device: false, live: true, run: true });
        self.unacknowledged = true;
    }

    /// The report need not be repeated any more.
    pub fn stop_repeating(&mut self) {
        self.unacknowledged = false;
    }

    /// Does a report wait to be acknowledged?
    pub const fn is_unacknowledged(&self) -> bool {
        self.unacknowledged
    }

    /// Begins the read-out of one pose. False while another one is under way.
    pub fn read_out(&mut self, set: PoseSet, index: u8) -> bool {
        let free = self.pose.is_none();
        if free {
            self.pose = Some((set, index, 0));
        }
        free
    }

    /// Is there something to send?
    pub fn has_more(&self, now_ms: u32) -> bool {
        self.report.is_some() || self.captured.is_some() || self.pose.is_some() || self.is_overdue(now_ms)
    }

    /// The report waits to be acknowledged, and has waited long enough to be repeated.
    fn is_overdue(&self, now_ms: u32) -> bool {
        self.unacknowledged && now_ms.wrapping_sub(self.sent_at_ms) >= REPEAT_MS
    }

    /// The next message to send, if there is one at the next few positions that is worked out.
    pub fn next(&mut self, now_ms: u32, procedure: &ModuleProcedure, about: &About) -> Option<Message> {
        if self.report.is_none() && self.is_overdue(now_ms) {
            self.begin_repeated(now_ms);
        }
        for _ in 0..POSITIONS_A_CALL {
            let Some((position, parts)) = self.report else { break };
            if !self.prepare(position, parts, procedure) {
                break;
            }
            self.report = (position < OUTCOME).then_some((position + 1, parts));
            let message = self.part(position, parts, procedure, about);
            self.preparing = Preparing::Nothing;
            let in_review = procedure.state() == StateName::Review;
            if position == OUTCOME && parts.run && in_review && !self.spoilt {
                self.shown_run = Some(procedure.run_id());
            }
            if message.is_some() {
                return message;
            }
        }
        let of_captured = next_of_pose(&mut self.captured, procedure);
        of_captured.or_else(|| next_of_pose(&mut self.pose, procedure))
    }

    /// Works out what the message at a position needs, a slice a call; true when it is there.
    fn prepare(&mut self, position: u8, parts: Parts, procedure: &ModuleProcedure) -> bool {
        let is_live = position == LIVE_NAMING && parts.live;
        if is_live || position == CANDIDATE_NAMING && parts.run {
            let shown = if is_live { procedure.live() } else { procedure.candidate() };
            let Some(shown) = shown else { return true };
            if let Preparing::Named = self.preparing {
                return true;
            }
            let mut in_work = match self.preparing {
                Preparing::Naming(in_work) => in_work,
                _ => NamingInWork::new(),
            };
            let Some(naming) = in_work.advance(&shown) else {
                self.preparing = Preparing::Naming(in_work);
                return false;
            };
            let named = Some(Named { seal: seal(&shown, 0, 0), naming });
            *(if is_live { &mut self.named_live } else { &mut self.named_candidate }) = named;
            // It goes out with the next call: all at once would be the longest tick of the board.
            self.preparing = Preparing::Named;
            return false;
        }
        if position == WEAK_DIRECTION
            && parts.run
            && let Some(JointValue::Ball(identified, _)) = shown_result(procedure)
        {
            let Preparing::WeakDirection(search) = &mut self.preparing else {
                self.preparing = Preparing::WeakDirection(EigenSearch::new(&unpacked(&identified.covariance_mm2)));
                return false;
            };
            return search.advance();
        }
        true
    }

    /// The message at a position of the report; None when there is nothing to say there.
    fn part(&self, position: u8, parts: Parts, procedure: &ModuleProcedure, about: &About) -> Option<Message> {
        match position {
            LIVE_NAMING if parts.live => procedure.live().and(self.named_live?.naming).map(Message::LiveNaming),
            CANDIDATE_NAMING if parts.run => {
                procedure.candidate().and(self.named_candidate?.naming).map(Message::CandidateNaming)
            }
            WEAK_DIRECTION if parts.run => {
                let Preparing::WeakDirection(search) = &self.preparing else { return None };
                let direction = search.eigen().largest().1.into();
                Some(Message::WeakDirection(WeakDirection { run_id: procedure.run_id(), direction }))
            }
            _ => part(position, parts, procedure, about),
        }
    }
}

/// The naming, if it was formed of this very centre.
fn naming_of(named: &Option<Named>, centre: &FoundJoint<'_>) -> Option<Naming> {
    let named = named.filter(|named| named.seal == seal(centre, 0, 0))?;
    named.naming
}

/// The result that the run's report is about.
fn shown_result(procedure: &ModuleProcedure) -> Option<JointValue<'_>> {
    procedure.identified().or(accepted(procedure).map(|live| live.value()))
}

/// The next message of a pose that is being sent: its lengths, and behind them how many samples they are the mean of,
/// where the rig makes a difference of that.
fn next_of_pose(sending: &mut Option<(PoseSet, u8, u8)>, procedure: &ModuleProcedure) -> Option<Message> {
    let (set, index, part) = sending.take()?;
    let lengths_mm = procedure.lengths_mm(set, index)?;
    let samples = procedure.samples(set, index);
    let parts = lengths_mm.len() + usize::from(samples.is_some());
    *sending = (usize::from(part) + 1 < parts).then_some((set, index, part + 1));
    let run_id = procedure.run_id();
    Some(match lengths_mm.get(usize::from(part)) {
        Some(length_mm) => Message::RawLength(RawLength { run_id, index, cable: part + 1, set, length_mm: *length_mm }),
        None => Message::PoseSamples(PoseSamples { run_id, index, set, samples: samples? }),
    })
}

/// The message at any other position of the report.
fn part(position: u8, parts: Parts, procedure: &ModuleProcedure, about: &About) -> Option<Message> {
    match position {
        VERSIONS if parts.device => Some(Message::Versions(*about.versions)),
        MODULE if parts.device => Some(Message::Module(about.module)),
        COUNTERS if parts.device => Some(Message::Counters(*about.counters)),
        BUS if parts.device => Some(Message::BusHealth(*about.bus)),
        LAST_STOP if parts.device => Some(Message::LastStop(LastStop::of(about.crash_record?))),
        STOP_TEXT..LIVE if parts.device => {
            StopText::of(about.crash_record?, position - STOP_TEXT).map(Message::StopText)
        }
        LIVE..CANDIDATE if parts.live => {
            let live = procedure.live()?;
            shown::message(Kind::Live, live.run_id(), &live.value(), position - LIVE)
        }
        CANDIDATE..=OUTCOME if parts.run => part_of_run(position, procedure),
        _ => None,
    }
}

fn part_of_run(position: u8, procedure: &ModuleProcedure) -> Option<Message> {
    let run_id = procedure.run_id();
    match position {
        AXIS => {
            let detail = procedure.ending().map(|ending| &ending.detail).or(procedure.refusal())?;
            return Some(Message::Axis(Axis { run_id, axis: detail.axis? }));
        }
        VERIFICATION => {
            let verification = *procedure.candidate().or(accepted(procedure))?.verification();
            return Some(Message::Verification(VerificationReport {
                run_id,
                deviation_mm: verification.deviation_mm,
                limit_mm: verification.limit_mm,
                poses: verification.poses,
            }));
        }
        OUTCOME => return outcome(procedure),
        _ => {}
    }
    if (CANDIDATE..CANDIDATE_NAMING).contains(&position) {
        return shown::message(Kind::Candidate, run_id, &procedure.identified()?, position - CANDIDATE);
    }
    let value = shown_result(procedure)?;
    if position == QUALITY {
        return Some(Message::Quality(quality(run_id, &value)));
    }
    let index = position.checked_sub(LEFT_OUT)?;
    let (pose, cables, of) = left_out(procedure, &value, index)?;
    Some(Message::LeftOut(LeftOut { run_id, index, of, pose, cables }))
}

/// The centre in use, if it is the one of the last run.
fn accepted(procedure: &ModuleProcedure) -> Option<FoundJoint<'_>> {
    procedure.live().filter(|live| live.run_id() == procedure.run_id())
}

/// How the run ended. In the review its reason is [`Reason::Fine`]: nothing is decided yet.
fn outcome(procedure: &ModuleProcedure) -> Option<Message> {
    let poses = procedure.poses_of(PoseSet::Identification) as u8;
    let run_id = procedure.run_id();
    let live = accepted(procedure).is_some();
    let report = match (procedure.ending(), procedure.state()) {
        (Some(ending), _) => OutcomeReport {
            run_id,
            reason: ending.detail.reason,
            pose: ending.detail.pose,
            cable: ending.detail.cable,
            live,
            poses,
            size_mm: ending.detail.size_mm.filter(|size| (0.0..OutcomeReport::SIZE_LIMIT_MM).contains(size)),
        },
        (None, StateName::Review) => {
            OutcomeReport { run_id, reason: Reason::Fine, pose: None, cable: 0, live, poses, size_mm: None }
        }
        _ => return None,
    };
    Some(Message::Outcome(report))
}
