//! Heartbeat, faults, reports and status LED: what the device sends and shows without being asked.

use super::report::About;
use super::status_led::BlinkPattern;
use super::{Action, Device, Held, LogEntry};
use crate::can::hinge::{JointKind, Module};
use crate::can::message::PROTOCOL;
use crate::can::report::PoseReport;
use crate::can::status::{Flags, Heartbeat, Versions};
use crate::can::{Message, Standing};
use crate::procedure::module::JointValue;
use crate::procedure::{self, ModuleRig, PoseNotice, Reason, StateName, elbow};
use crate::restart::ResetCause;

/// Time between two heartbeats, ms.
const HEARTBEAT_MS: u32 = 100;
/// Frames of a report that are sent in one tick. At one tick a millisecond and 500 kbit/s the bus carries four.
const FRAMES_A_TICK: usize = 2;
/// How long the LED shows that a pose was taken, or something refused, ms.
const SHOWN_MS: u32 = 1_000;

/// What has its own pace.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pace {
    heartbeat_at_ms: Option<u32>,
    sequence: u8,
    fault_turn: u8,
    led: Option<BlinkPattern>,
    /// Shown for a moment, and since when.
    momentary: Option<(BlinkPattern, u32)>,
    /// Why the button was refused, and when: the button has no other way to say so.
    refused_press: Option<(Reason, u32)>,
}

impl Pace {
    /// A heartbeat is due at once.
    pub const fn at_power_up() -> Self {
        Self { heartbeat_at_ms: None, sequence: 0, fault_turn: 0, led: None, momentary: None, refused_press: None }
    }

    /// Is the next heartbeat due, or was there none yet?
    pub fn heartbeat_is_due(&self, now_ms: u32) -> bool {
        self.heartbeat_at_ms.is_none_or(|at_ms| now_ms.wrapping_sub(at_ms) >= HEARTBEAT_MS)
    }

    /// The next heartbeat is due now.
    pub fn hurry(&mut self) {
        self.heartbeat_at_ms = None;
    }

    /// The button was refused: the LED shows it for a moment, and the heartbeat says why.
    pub fn refuse(&mut self, now_ms: u32, reason: Reason) {
        self.momentary = Some((BlinkPattern::Refused, now_ms));
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
pub(super) fn versions(reset_cause: ResetCause, fingerprint: u32, rig: &ModuleRig) -> Versions {
    Versions {
        protocol: PROTOCOL,
        firmware: FIRMWARE,
        reset_cause,
        capacity: capacities(rig.hinge().is_some()).0,
        rig: (fingerprint >> 16) as u16 ^ fingerprint as u16,
    }
}

/// Poses that the first and the second set have room for.
const fn capacities(is_hinge: bool) -> (u8, u8) {
    if is_hinge {
        (elbow::CAPACITY as u8, elbow::HELD_OUT_CAPACITY as u8)
    } else {
        (procedure::CAPACITY as u8, procedure::HELD_OUT_CAPACITY as u8)
    }
}

impl Device {
    /// Which module this is.
    fn module(&self) -> Module {
        let is_hinge = self.procedure.hinge().is_some();
        let (capacity, held_out_capacity) = capacities(is_hinge);
        let joint = if is_hinge { JointKind::Hinge } else { JointKind::Ball };
        Module { joint, cables: self.procedure.cables(), capacity, held_out_capacity, rig: self.fingerprint }
    }

    pub(super) fn send_heartbeat(&mut self, now_ms: u32, out: &mut impl FnMut(Action)) {
        let arm = self.procedure.arm(now_ms);
        let refused_press = self
            .pace
            .refused_press
            .filter(|(_, at_ms)| now_ms.wrapping_sub(*at_ms) < SHOWN_MS)
            .map(|(reason, _)| reason);
        // in the idle state the centre in use is what matters
        let (standing, why) = self.standing();
        let in_doubt =
            Some(why).filter(|_| standing == Standing::NotToBeUsed && self.procedure.state() == StateName::Idle);
        let heartbeat = Heartbeat {
            run_id: self.procedure.run_id(),
            state: self.procedure.state(),
            guidance: self.procedure.guidance(now_ms),
            poses: self.procedure.pose_count(),
            progress_percent: self.procedure.progress_percent(),
            reason: refused_press.or(in_doubt).unwrap_or(self.procedure.reason(now_ms)),
            flags: Flags {
                live: self.procedure.live().is_some(),
                still: arm.is_ok(),
                encoders: self.procedure.fault(now_ms).is_none(),
                button: self.button.held() != Held::Not,
                unacknowledged: self.reporter.is_unacknowledged(),
                by_command_only: self.procedure.by_command_only(),
                held_phase: self.procedure.is_held_phase(),
            },
            standing,
            sequence: self.pace.sequence,
        };
        self.pace.sequence = self.pace.sequence.wrapping_add(1);
        self.pace.heartbeat_at_ms = Some(now_ms);
        self.send(&Message::Heartbeat(heartbeat), out);
        self.send(&Message::Identity(self.identity()), out);
    }

    /// Reports one fault source per tick, round-robin, to bound bus load.
    pub(super) fn report_fault(&mut self, now_ms: u32, out: &mut impl FnMut(Action)) {
        let run_id = self.procedure.run_id();
        // the encoders three times as often: a glitch lasts one sample
        self.pace.fault_turn = (self.pace.fault_turn + 1) % 12;
        let reported = match self.pace.fault_turn {
            0 | 4 | 8 => {
                let encoder = self.procedure.fault(now_ms).map(|fault| (fault.reason, fault.cable));
                self.encoder_fault.update(now_ms, run_id, encoder)
            }
            1 => {
                let stuck = (self.button.held() == Held::Stuck).then_some((Reason::ButtonStuck, 0));
                self.button_fault.update(now_ms, run_id, stuck)
            }
            2 => self.record_fault.update(now_ms, run_id, self.persistence.wrong.map(|reason| (reason, 0))),
            3 => self.overrun.report(now_ms, run_id, Reason::ReceiveOverrun),
            9 => self.unsendable.report(now_ms, run_id, Reason::ReportOutOfRange),
            5 => self.bus_off.report(now_ms, run_id, Reason::BusOff),
            7 => {
                let failed = self.journal_failed.then_some((Reason::JournalUnwritable, 0));
                self.journal_fault.update(now_ms, run_id, failed)
            }
            10 => {
                let wrong = self.parameters_wrong.then_some((Reason::ParametersDamaged, 0));
                self.parameters_fault.update(now_ms, run_id, wrong)
            }
            6 => self.restarted.update(now_ms, run_id, self.restart_is_news.then_some((Reason::Restarted, 0))),
            _ => {
                let slipped = self.slipped();
                let reported = self.slip.update(now_ms, run_id, slipped);
                if reported.is_some() {
                    self.report_slip(out);
                }
                reported
            }
        };
        if let Some(fault) = reported {
            self.send(&Message::Fault(fault), out);
        }
    }

    pub(super) fn send_report(&mut self, now_ms: u32, out: &mut impl FnMut(Action)) {
        for _ in 0..FRAMES_A_TICK {
            let about = About {
                versions: &self.versions,
                module: self.module(),
                counters: &self.counters,
                bus: &self.bus,
                crash_record: self.crash_record.as_ref(),
            };
            let Some(message) = self.reporter.next(now_ms, &self.procedure, &about) else { return };
            self.send(&message, out);
        }
    }

    /// Reports a pose that was captured or refused.
    pub(super) fn note_pose(&mut self, now_ms: u32, notice: &PoseNotice, out: &mut impl FnMut(Action)) {
        let taken = notice.reason == Reason::Fine;
        self.pace.momentary = Some((if taken { BlinkPattern::Captured } else { BlinkPattern::Refused }, now_ms));
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
        if taken {
            self.reporter.captured(notice.set, notice.index);
        }
        out(Action::Log(LogEntry::Pose(*notice)));
    }

    /// A change of state is sent with the next tick, and the report that belongs to the new state begins.
    pub(super) fn note_transition(
        &mut self,
        now_ms: u32,
        from: StateName,
        to: StateName,
        out: &mut impl FnMut(Action),
    ) {
        let run_id = self.procedure.run_id();
        out(Action::Log(LogEntry::State { run_id, from, to, reason: self.procedure.reason(now_ms) }));
        self.pace.hurry();
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
                self.log_identified(run_id, out);
            }
            // Acknowledged: there is nothing left to repeat.
            (StateName::Failed, StateName::Idle) if !self.reporter.is_unacknowledged() => {}
            (_, StateName::Idle | StateName::Review | StateName::Failed) => self.reporter.begin_repeated(now_ms),
        }
    }

    fn log_identified(&self, run_id: u16, out: &mut impl FnMut(Action)) {
        match self.procedure.identified() {
            Some(JointValue::Ball(identified, _)) => {
                let bits = identified.parameters.to_array().map(f32::to_bits);
                out(Action::Log(LogEntry::Identified { run_id, bits }));
            }
            Some(JointValue::Hinge(found)) => {
                for body in 0..2 {
                    let bits = core::array::from_fn(|k| {
                        let [value, _] = found.number(usize::from(body) * 6 + k);
                        value.to_bits()
                    });
                    out(Action::Log(LogEntry::HingeIdentified { run_id, body, bits }));
                }
            }
            None => {}
        }
    }

    /// Shows on the LED what is to be shown now.
    pub(super) fn show(&mut self, now_ms: u32, out: &mut impl FnMut(Action)) {
        let pattern = self.pattern(now_ms);
        if self.pace.led != Some(pattern) {
            self.pace.led = Some(pattern);
            out(Action::StatusLed(pattern));
        }
    }

    fn pattern(&self, now_ms: u32) -> BlinkPattern {
        match self.button.held() {
            Held::Long => return BlinkPattern::LongPress,
            Held::VeryLong => return BlinkPattern::VeryLongPress,
            Held::Stuck => return BlinkPattern::Fault,
            Held::Not | Held::Short => {}
        }
        if let Some((pattern, at_ms)) = self.pace.momentary
            && now_ms.wrapping_sub(at_ms) < SHOWN_MS
        {
            return pattern;
        }
        let faulty = self.procedure.fault(now_ms).is_some();
        match self.procedure.state() {
            StateName::Idle | StateName::Collecting | StateName::Verifying if faulty => BlinkPattern::Fault,
            StateName::Idle => match self.standing().0 {
                Standing::NotToBeUsed => BlinkPattern::Slipped,
                Standing::Unconfirmed => BlinkPattern::Unconfirmed,
                Standing::Confirmed => BlinkPattern::InUse,
                Standing::NoCentre => BlinkPattern::Ready,
            },
            StateName::Collecting => BlinkPattern::Collecting,
            StateName::Identifying => BlinkPattern::Working,
            StateName::Verifying => BlinkPattern::Verifying,
            StateName::Review => self.accept_pattern(),
            StateName::Failed => BlinkPattern::Failed,
        }
    }
}
