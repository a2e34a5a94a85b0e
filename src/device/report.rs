//! Sends what there is to say about the run, a frame or two a tick, so that no queue has to be long.

use crate::can::Message;
use crate::can::health::{BusHealth, LastStop, StopText};
use crate::can::report::{LeftOut, OutcomeReport, RawLength};
use crate::can::result::{Axis, Parameter, Quality, VerificationReport, WeakDirection, ZeroError};
use crate::can::status::{Counters, Versions};
use crate::identification::Identified;
use crate::procedure::{Candidate, PoseSet, Procedure, Reason, StateName};
use crate::restart::CrashRecord;
use crate::rig::CABLES;

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
    pub counters: &'a Counters,
    pub bus: &'a BusHealth,
    pub crash_record: Option<&'a CrashRecord>,
}

/// Positions of the parts in a report.
const VERSIONS: u8 = 0;
const COUNTERS: u8 = 1;
const BUS: u8 = 2;
const LAST_STOP: u8 = 3;
const STOP_TEXT: u8 = 4;
const LIVE: u8 = STOP_TEXT + StopText::MAX_PARTS;
const LIVE_ZEROS: u8 = LIVE + 6;
const CANDIDATE: u8 = LIVE_ZEROS + 6;
const CANDIDATE_ZEROS: u8 = CANDIDATE + 6;
const QUALITY: u8 = CANDIDATE_ZEROS + 6;
const VERIFICATION: u8 = QUALITY + 1;
const WEAK_DIRECTION: u8 = VERIFICATION + 1;
const AXIS: u8 = WEAK_DIRECTION + 1;
const LEFT_OUT: u8 = AXIS + 1;
const OUTCOME: u8 = LEFT_OUT + crate::identification::outcome::MAX_REJECTED as u8;

/// The report under way, and what waits to be acknowledged.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reporter {
    /// Position in the report under way, and its parts.
    report: Option<(u8, Parts)>,
    /// The pose that is being read out, and the next of its cables, from 0.
    pose: Option<(PoseSet, u8, u8)>,
    unacknowledged: bool,
    sent_at_ms: u32,
}

impl Reporter {
    /// A reporter that begins with what the device is and which centre is in use.
    pub const fn at_power_up() -> Self {
        let parts = Parts { device: true, live: true, run: false };
        Self { report: Some((0, parts)), pose: None, unacknowledged: false, sent_at_ms: 0 }
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
        self.sent_at_ms = now_ms;
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

    /// The next message to send, if there is one.
    pub fn next(&mut self, now_ms: u32, procedure: &Procedure, about: &About) -> Option<Message> {
        if self.report.is_none() && self.unacknowledged && now_ms.wrapping_sub(self.sent_at_ms) >= REPEAT_MS {
            self.begin_repeated(now_ms);
        }
        while let Some((position, parts)) = self.report {
            self.report = (position < OUTCOME).then_some((position + 1, parts));
            let message = part(position, parts, procedure, about);
            if message.is_some() {
                return message;
            }
        }
        self.next_length(procedure)
    }

    fn next_length(&mut self, procedure: &Procedure) -> Option<Message> {
        let (set, index, cable) = self.pose?;
        self.pose = (usize::from(cable) + 1 < CABLES).then_some((set, index, cable + 1));
        let pose = procedure.poses(set).get(usize::from(index))?;
        let length_mm = *pose.lengths().as_mm().get(usize::from(cable))?;
        let run_id = procedure.run_id();
        Some(Message::RawLength(RawLength { run_id, index, cable: cable + 1, set, length_mm }))
    }
}

/// The message at a position of the report; None when there is nothing to say there.
fn part(position: u8, parts: Parts, procedure: &Procedure, about: &About) -> Option<Message> {
    match position {
        VERSIONS if parts.device => Some(Message::Versions(*about.versions)),
        COUNTERS if parts.device => Some(Message::Counters(*about.counters)),
        BUS if parts.device => Some(Message::BusHealth(*about.bus)),
        LAST_STOP if parts.device => Some(Message::LastStop(LastStop::of(about.crash_record?))),
        STOP_TEXT..LIVE if parts.device => {
            StopText::of(about.crash_record?, position - STOP_TEXT).map(Message::StopText)
        }
        LIVE..LIVE_ZEROS if parts.live => {
            let Candidate { run_id, identified, .. } = procedure.live()?;
            let (is_radius, parameter) = parameter(*run_id, identified, position - LIVE)?;
            Some(if is_radius { Message::LiveRadius(parameter) } else { Message::LiveCentre(parameter) })
        }
        LIVE_ZEROS..CANDIDATE if parts.live => {
            let Candidate { run_id, identified, .. } = procedure.live()?;
            zero(*run_id, identified, position - LIVE_ZEROS).map(Message::LiveZero)
        }
        CANDIDATE..=OUTCOME if parts.run => part_of_run(position, procedure),
        _ => None,
    }
}

fn part_of_run(position: u8, procedure: &Procedure) -> Option<Message> {
    let run_id = procedure.run_id();
    match position {
        AXIS => {
            let detail = procedure.ending().map(|ending| &ending.detail).or(procedure.refusal())?;
            return Some(Message::Axis(Axis { run_id, axis: detail.axis? }));
        }
        VERIFICATION => {
            let verification = procedure.candidate().or(accepted(procedure))?.verification;
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
    if (CANDIDATE_ZEROS..QUALITY).contains(&position) {
        return zero(run_id, procedure.identified()?, position - CANDIDATE_ZEROS).map(Message::CandidateZero);
    }
    if (CANDIDATE..CANDIDATE_ZEROS).contains(&position) {
        let (is_radius, parameter) = parameter(run_id, procedure.identified()?, position - CANDIDATE)?;
        return Some(if is_radius { Message::CandidateRadius(parameter) } else { Message::CandidateCentre(parameter) });
    }
    let identified = procedure.identified().or(accepted(procedure).map(|live| &live.identified))?;
    match position {
        QUALITY => Some(Message::Quality(Quality {
            run_id,
            deviation_mm: identified.rms_residual_mm,
            noise_mm: identified.noise_mm,
            iterations: identified.iterations,
            left_out: identified.rejected.len() as u8,
        })),
        WEAK_DIRECTION => {
            let (direction, _) = identified.weak_direction();
            Some(Message::WeakDirection(WeakDirection { run_id, direction }))
        }
        _ => {
            let index = position.checked_sub(LEFT_OUT)?;
            let rejected = identified.rejected.get(usize::from(index))?;
            let of = identified.rejected.len() as u8;
            let pose = u8::try_from(rejected.pose).ok()?;
            Some(Message::LeftOut(LeftOut { run_id, index, of, pose, cables: rejected.cables }))
        }
    }
}

/// The centre in use, if it is the one of the last run.
fn accepted(procedure: &Procedure) -> Option<&Candidate> {
    procedure.live().filter(|live| live.run_id == procedure.run_id())
}

/// The `index`-th of x, y, z, p1, p2, p3 with its σ; true when it is a radius.
fn parameter(run_id: u16, identified: &Identified<f32>, index: u8) -> Option<(bool, Parameter)> {
    let value_mm = *identified.parameters.to_array().get(usize::from(index))?;
    let sigma_mm = *identified.sigma_mm().get(usize::from(index))?;
    Some((index >= 3, Parameter { run_id, index: index % 3, value_mm, sigma_mm }))
}

/// The zero error of the `index`-th cable, from 0; None when the zeros were known: then there is nothing to say.
fn zero(run_id: u16, identified: &Identified<f32>, index: u8) -> Option<ZeroError> {
    let value_mm = *identified.offsets_mm.get(usize::from(index))?;
    let sigma_mm = *identified.offset_sigmas_mm.get(usize::from(index))?;
    (sigma_mm > 0.0).then_some(ZeroError { run_id, cable: index + 1, value_mm, sigma_mm })
}

/// How the run ended. In the review its reason is [`Reason::Fine`]: nothing is decided yet.
fn outcome(procedure: &Procedure) -> Option<Message> {
    let poses = procedure.poses(PoseSet::Identification).len() as u8;
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
