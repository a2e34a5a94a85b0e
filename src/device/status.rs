//! Heartbeat, faults, reports and lamp: what the device tells of itself without being asked.

use super::lamp::LampPattern;
use super::report::About;
use super::{Action, Device, Held, LogEntry};
use crate::can::Message;
use crate::can::message::PROTOCOL;
use crate::can::report::PoseReport;
use crate::can::status::{Flags, Heartbeat, Versions};
use crate::procedure::{CAPACITY, PoseNotice, Reason, StateName};
use crate::restart::ResetCause;

/// Time between two heartbeats, ms.
const HEARTBEAT_MS: u32 = 100;
/// Frames of a report that are sent in one tick. At one tick a millisecond and 500 kbit/s the bus carries four.
const FRAMES_A_TICK: usize = 2;
/// How long the lamp shows that a pose was taken, or something refused, ms.
const SHOWN_MS: u32 = 1_000;

/// What has its own pace.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pace {
    heartbeat_at_ms: Option<u32>,
    sequence: u8,
    fault_turn: u8,
    lamp: Option<LampPattern>,
    /// Shown for a moment, and since when.
    momentary: Option<(LampPattern, u32)>,
    /// Why the button was refused, and when: nobody else can tell its user.
    refused_press: Option<(Reason, u32)>,
}

impl Pace {
    pub const fn at_power_up() -> Self {
        Self { heartbeat_at_ms: None, sequence: 0, fault_turn: 0, lamp: None, momentary: None, refused_press: None }
    }

    pub fn heartbeat_is_due(&self, now_ms: u32) -> bool {
        self.heartbeat_at_ms.is_none_or(|at_ms| now_ms.wrapping_sub(at_ms) >= HEARTBEAT_MS)
    }

    pub fn refuse(&mut self, now_ms: u32, reason: Reason) {
        self.momentary = Some((LampPattern::Refused, now_ms));
        self.refused_press = Some((reason, now_ms));
    }
}

/// This firmware's version, major, minor, patch.
pub(super) const FIRMWARE: [u8; 3] = [
    number(env!("CARGO_PKG_VERSION_MAJOR")),
    number(env!("CARGO_PKG_VERSION_MINOR")),
    number(env!("CARGO_PKG_VERSION_PATCH")),
];

/// A decimal number of one byte; 255 stands for a larger one.
const fn number(digits: &str) -> u8 {
    match u8::from_str_radix(digits, 10) {
        Ok(number) => number,
        Err(_) => u8::MAX,
    }
}

/// What the device is.
pub(super) fn versions(reset_cause: ResetCause, fingerprint: u32) -> Versions {
    Versions {
        protocol: PROTOCOL,
        firmware: FIRMWARE,
        reset_cause,
        capacity: CAPACITY as u8,
        rig: (fingerprint >> 16) as u16 ^ fingerprint as u16,
    }
}

impl Device {
    pub(super) fn send_heartbeat(&mut self, now_ms: u32, out: &mut impl FnMut(Action)) {
        self.check_live(out);
        let arm = self.procedure.arm(now_ms);
        let refused_press = self
            .pace
            .refused_press
            .filter(|(_, at_ms)| now_ms.wrapping_sub(*at_ms) < SHOWN_MS)
            .map(|(reason, _)| reason);
        let in_use = self.procedure.state() == StateName::Idle;
        let slipped = self.slipped().filter(|_| in_use).map(|(reason, _)| reason);
        let heartbeat = Heartbeat {
            run_id: self.procedure.run_id(),
            state: self.procedure.state(),
            guidance: self.procedure.guidance(now_ms),
            poses: self.procedure.pose_count(),
            progress_percent: self.procedure.progress_percent(),
            reason: refused_press.or(slipped).unwrap_or(self.procedure.reason(now_ms)),
            flags: Flags {
                live: self.procedure.live().is_some(),
                still: arm.is_ok(),
                encoders: self.procedure.fault(now_ms).is_none(),
                button: self.button.held() != Held::Not,
                unacknowledged: self.reporter.is_unacknowledged(),
                by_command_only: self.procedure.by_command_only(),
            },
            sequence: self.pace.sequence,
        };
        self.pace.sequence = self.pace.sequence.wrapping_add(1);
        self.pace.heartbeat_at_ms = Some(now_ms);
        self.send(&Message::Heartbeat(heartbeat), out);
    }

    /// Looks after one kind of fault a tick, in turn, so that many at once do not crowd the bus.
    pub(super) fn tell_fault(&mut self, now_ms: u32, out: &mut impl FnMut(Action)) {
        let run_id = self.procedure.run_id();
        self.pace.fault_turn = self.pace.fault_turn.wrapping_add(1);
        let told = match self.pace.fault_turn % 8 {
            0 => {
                let encoder = self.procedure.fault(now_ms).map(|fault| (fault.reason, fault.cable));
                self.encoder_fault.update(now_ms, run_id, encoder)
            }
            1 => {
                let stuck = (self.button.held() == Held::Stuck).then_some((Reason::ButtonStuck, 0));
                self.button_fault.update(now_ms, run_id, stuck)
            }
            2 => self.record_fault.update(now_ms, run_id, self.keeping.wrong.map(|reason| (reason, 0))),
            3 => self.overrun.tell(now_ms, run_id, Reason::ReceiveOverrun),
            4 => self.unsendable.tell(now_ms, run_id, Reason::ReportOutOfRange),
            5 => self.bus_off.tell(now_ms, run_id, Reason::BusOff),
            6 => self.restarted.update(now_ms, run_id, self.restart_is_news.then_some((Reason::Restarted, 0))),
            _ => {
                let slipped = self.slipped();
                let told = self.slip.update(now_ms, run_id, slipped);
                if told.is_some() {
                    self.tell_slip(out);
                }
                told
            }
        };
        if let Some(fault) = told {
            self.send(&Message::Fault(fault), out);
        }
    }

    pub(super) fn send_report(&mut self, now_ms: u32, out: &mut impl FnMut(Action)) {
        for _ in 0..FRAMES_A_TICK {
            let about = About {
                versions: &self.versions,
                counters: &self.counters,
                bus: &self.bus,
                last_words: self.last_words.as_ref(),
            };
            let Some(message) = self.reporter.next(now_ms, &self.procedure, &about) else { return };
            self.send(&message, out);
        }
    }

    /// Reports a pose that was captured or refused.
    pub(super) fn note_pose(&mut self, now_ms: u32, notice: &PoseNotice, out: &mut impl FnMut(Action)) {
        let taken = notice.reason == Reason::Fine;
        self.pace.momentary = Some((if taken { LampPattern::Captured } else { LampPattern::Refused }, now_ms));
        let report = PoseReport {
            run_id: self.procedure.run_id(),
            index: notice.index,
            guidance: notice.guidance,
            set: notice.set,
            reason: notice.reason,
            sigma_mm: notice.sigma_mm.filter(|sigma| *sigma <= PoseReport::SIGMA_LIMIT_MM),
            distance_deg: notice.distance_rad.map(f32::to_degrees),
        };
        self.send(&Message::Pose(report), out);
        out(Action::Log(LogEntry::Pose(*notice)));
    }

    /// A change of state is told at once, and the report that belongs to the new state begins.
    pub(super) fn note_transition(
        &mut self,
        now_ms: u32,
        from: StateName,
        to: StateName,
        out: &mut impl FnMut(Action),
    ) {
        let run_id = self.procedure.run_id();
        out(Action::Log(LogEntry::State { run_id, from, to, reason: self.procedure.reason(now_ms) }));
        self.send_heartbeat(now_ms, out);
        self.pace.momentary = None;
        match (from, to) {
            (_, StateName::Collecting) => {
                self.reporter.stop_repeating();
                if from == StateName::Identifying {
                    self.reporter.begin(now_ms, super::report::Parts { device: false, live: false, run: true });
                }
            }
            (_, StateName::Identifying) => {}
            (_, StateName::Verifying) => {
                self.reporter.begin(now_ms, super::report::Parts { device: false, live: false, run: true });
                if let Some(identified) = self.procedure.identified() {
                    let bits = identified.parameters.to_array().map(f32::to_bits);
                    out(Action::Log(LogEntry::Identified { run_id, bits }));
                }
            }
            // Acknowledged: there is nothing left to repeat.
            (StateName::Failed, StateName::Idle) if !self.reporter.is_unacknowledged() => {}
            (_, StateName::Idle | StateName::Review | StateName::Failed) => self.reporter.begin_repeated(now_ms),
        }
    }

    /// Shows on the lamp what is to be shown now.
    pub(super) fn show(&mut self, now_ms: u32, out: &mut impl FnMut(Action)) {
        let pattern = self.pattern(now_ms);
        if self.pace.lamp != Some(pattern) {
            self.pace.lamp = Some(pattern);
            out(Action::Lamp(pattern));
        }
    }

    fn pattern(&self, now_ms: u32) -> LampPattern {
        match self.button.held() {
            Held::Long => return LampPattern::LongPress,
            Held::VeryLong => return LampPattern::VeryLongPress,
            Held::Stuck => return LampPattern::Fault,
            Held::Not | Held::Short => {}
        }
        if let Some((pattern, at_ms)) = self.pace.momentary
            && now_ms.wrapping_sub(at_ms) < SHOWN_MS
        {
            return pattern;
        }
        let faulty = self.procedure.fault(now_ms).is_some();
        match self.procedure.state() {
            StateName::Idle | StateName::Collecting | StateName::Verifying if faulty => LampPattern::Fault,
            StateName::Idle if self.guard.warning().is_some() => LampPattern::Slipped,
            StateName::Idle if self.procedure.live().is_some() => LampPattern::InUse,
            StateName::Idle => LampPattern::Ready,
            StateName::Collecting => LampPattern::Collecting,
            StateName::Identifying => LampPattern::Working,
            StateName::Verifying => LampPattern::Verifying,
            StateName::Review => LampPattern::Review,
            StateName::Failed => LampPattern::Failed,
        }
    }
}
