//! The two protected sets that the device sends by itself: what a controller acts on, and what the cables show now.

use super::{Action, Device};
use crate::can::Message;
use crate::can::hinge::HingeAngle;
use crate::can::live_set::{LIVE_SET_FRAMES, LIVE_SET_LEN};
use crate::can::set::piece;
use crate::can::telemetry::{TELEMETRY_FRAMES, TELEMETRY_LEN, Telemetry};
use crate::kinematics::rotation::rotation_vector_of;
use crate::kinematics::{CableLengths, PlatformPose};
use crate::procedure::{ModuleProcedure, Reason};
use crate::rig::CABLES;

/// A set that was packed and goes out a frame a tick.
#[derive(Debug, Clone)]
pub(super) struct Outgoing<const LEN: usize> {
    /// Time between two sets, ms; 0 = off.
    period_ms: u32,
    /// When the last set was due.
    due_ms: Option<u32>,
    data: [u8; LEN],
    /// The next frame; at the number of frames nothing is left to send.
    next: usize,
    counter: u16,
}

impl<const LEN: usize> Outgoing<LEN> {
    /// Nothing was sent yet.
    pub const fn every(period_ms: u32) -> Self {
        Self { period_ms, due_ms: None, data: [0; LEN], next: usize::MAX, counter: 0 }
    }

    /// Sets the time between two sets, ms; 0 = off.
    pub fn set_period(&mut self, period_ms: u32) {
        self.period_ms = period_ms;
    }

    /// Is another set to be packed now? The last one has gone out whole then.
    fn is_due(&self, now_ms: u32, frames: usize) -> bool {
        let waited = self.due_ms.is_none_or(|due_ms| now_ms.wrapping_sub(due_ms) >= self.period_ms);
        self.period_ms != 0 && waited && self.next >= frames
    }

    /// Begins to send a set, packed with the counter.
    fn begin(&mut self, now_ms: u32, data: [u8; LEN]) {
        self.data = data;
        self.next = 0;
        self.keep_pace(now_ms);
    }

    /// There is nothing to be sent this time.
    fn leave_out(&mut self, now_ms: u32) {
        self.keep_pace(now_ms);
    }

    /// A late set does not delay the next, unless it comes when that one is due already.
    fn keep_pace(&mut self, now_ms: u32) {
        let due_ms = self.due_ms.map(|before_ms| before_ms.wrapping_add(self.period_ms));
        self.due_ms = due_ms.filter(|due_ms| now_ms.wrapping_sub(*due_ms) < self.period_ms).or(Some(now_ms));
    }

    /// The next frame's bytes.
    fn next_piece(&mut self, frames: usize) -> Option<[u8; 8]> {
        if self.next >= frames {
            return None;
        }
        let bytes = piece(&self.data, self.next, self.counter);
        self.next += 1;
        if self.next >= frames {
            self.counter = self.counter.wrapping_add(1);
        }
        bytes
    }
}

/// A set of telemetry that is being formed: all at once would take 14 000 cycles of a Cortex-M4F.
#[derive(Debug, Clone)]
pub(super) struct TelemetryInWork {
    telemetry: Telemetry,
    /// What the centre is still to be found from: of one that moves.
    pose: Option<(PlatformPose<f32>, CableLengths<f32>)>,
}

/// The time between two sets, ms, that comes nearest to a rate; 0 = off.
pub(super) const fn period_ms(hz: u16) -> u32 {
    match hz {
        0 => 0,
        hz => 1_000 / hz as u32,
    }
}

/// The set of what a controller acts on.
pub(super) type OutgoingLive = Outgoing<LIVE_SET_LEN>;
/// The set of what the cables show now.
pub(super) type OutgoingTelemetry = Outgoing<TELEMETRY_LEN>;

impl Device {
    pub(super) fn live_set_is_due(&self, now_ms: u32) -> bool {
        self.live_out.is_due(now_ms, LIVE_SET_FRAMES)
    }

    pub(super) fn form_live_set(&mut self, now_ms: u32) {
        match self.live_set().pack(self.live_out.counter) {
            Ok(data) => self.live_out.begin(now_ms, data),
            Err(_) => {
                self.live_out.leave_out(now_ms);
                self.note_unsendable();
            }
        }
    }

    pub(super) fn telemetry_is_due(&self, now_ms: u32) -> bool {
        self.telemetry_out.is_due(now_ms, TELEMETRY_FRAMES)
    }

    /// The next slice of the set of what the cables show: the pose, then the centre, then its bytes.
    pub(super) fn form_telemetry(&mut self, now_ms: u32) {
        match self.telemetry_in_work.take() {
            None => {
                self.telemetry_in_work = self.telemetry(now_ms);
                self.form_angle(now_ms);
                if self.telemetry_in_work.is_none() {
                    self.telemetry_out.leave_out(now_ms);
                }
            }
            Some(TelemetryInWork { mut telemetry, pose: Some((platform, lengths)) }) => {
                telemetry.centre = self.live_centre(&platform, &lengths);
                self.telemetry_in_work = Some(TelemetryInWork { telemetry, pose: None });
            }
            Some(TelemetryInWork { telemetry, pose: None }) => match telemetry.pack(self.telemetry_out.counter) {
                Ok(data) => self.telemetry_out.begin(now_ms, data),
                Err(_) => {
                    self.telemetry_out.leave_out(now_ms);
                    self.note_unsendable();
                }
            },
        }
    }

    /// A set is under way.
    pub(super) fn has_pieces(&self) -> bool {
        self.live_out.next < LIVE_SET_FRAMES || self.telemetry_out.next < TELEMETRY_FRAMES
    }

    /// Sends a frame of each set that is under way.
    pub(super) fn send_pieces(&mut self, out: &mut impl FnMut(Action)) {
        if let Some(bytes) = self.live_out.next_piece(LIVE_SET_FRAMES) {
            self.send(&Message::LiveSet(bytes), out);
        }
        if let Some(bytes) = self.telemetry_out.next_piece(TELEMETRY_FRAMES) {
            self.send(&Message::Telemetry(bytes), out);
            if let Some(angle) = self.angle_out.take() {
                self.send(&Message::HingeAngle(angle), out);
            }
        }
    }

    /// What the cables show now; None before the first sample, and while a length cannot be one.
    fn telemetry(&self, now_ms: u32) -> Option<TelemetryInWork> {
        let counts = self.counts?;
        let ModuleProcedure::Ball(procedure) = &self.procedure else { return self.telemetry_of_hinge(now_ms, &counts) };
        let lengths = CableLengths::from_counts(procedure.rig(), &counts).ok()?;
        let live = procedure.live();
        let corrected = live.map_or(Ok(lengths), |live| lengths.less(&live.identified.offsets_mm)).ok();
        let arm = self.procedure.arm(now_ms);
        let pose =
            corrected.and_then(|lengths| Some((self.forward_kinematics.as_ref()?.solve(&lengths).ok()?, lengths)));
        let slack = arm.err().filter(|not_ready| not_ready.reason == Reason::CableLoose);
        let telemetry = Telemetry {
            // modulo 2^16
            time_ms: now_ms as u16,
            still: arm.is_ok(),
            encoders: self.procedure.fault(now_ms).is_none(),
            slack: slack.map_or(0, |not_ready| not_ready.cable),
            standing: self.standing().0,
            lengths_mm: *lengths.as_mm(),
            rotation_rad: pose.as_ref().map(|(platform, _)| rotation_vector_of(&platform.rotation).into()),
            centre: match self.slip_monitor.live_joint() {
                Some(_) => None,
                None => live.map(|live| {
                    let kept = self.slip_monitor.centre_sigma_mm();
                    let sigma_mm = kept.unwrap_or_else(|| live.identified.worst_centre_sigma_mm().0);
                    (live.identified.parameters.centre_mm.into(), sigma_mm)
                }),
            },
        };
        Some(TelemetryInWork { telemetry, pose: pose.filter(|_| self.slip_monitor.live_joint().is_some()) })
    }

    /// How far the hinge in use bends now: goes out with the set.
    fn form_angle(&mut self, now_ms: u32) {
        let Some(counts) = self.counts.filter(|_| self.procedure.fault(now_ms).is_none()) else { return };
        let run_id = self.procedure.live().map_or(0, |live| live.run_id());
        self.angle_out = self.procedure.angle(&counts).map(|followed| HingeAngle {
            run_id,
            // modulo 2^16
            time_ms: now_ms as u16,
            angle_rad: followed.angle_rad,
            residual_mm: followed.residual_mm.min(HingeAngle::MAX_RESIDUAL_MM),
        });
    }

    /// The same of an elbow: its lengths, and 0 for cables that it has not.
    fn telemetry_of_hinge(&self, now_ms: u32, counts: &[i32; CABLES]) -> Option<TelemetryInWork> {
        let lengths = self.procedure.hinge()?.rig().lengths_mm(counts, &[0.0; CABLES]).ok()?;
        let mut lengths_mm = [0.0; CABLES];
        lengths_mm.iter_mut().zip(lengths).for_each(|(place, length)| *place = length);
        let arm = self.procedure.arm(now_ms);
        let slack = arm.err().filter(|not_ready| not_ready.reason == Reason::CableLoose);
        let telemetry = Telemetry {
            // modulo 2^16
            time_ms: now_ms as u16,
            still: arm.is_ok(),
            encoders: self.procedure.fault(now_ms).is_none(),
            slack: slack.map_or(0, |not_ready| not_ready.cable),
            standing: self.standing().0,
            lengths_mm,
            rotation_rad: None,
            centre: None,
        };
        Some(TelemetryInWork { telemetry, pose: None })
    }

    /// Where a centre that moves is in this pose, and its σ, mm.
    fn live_centre(&self, platform: &PlatformPose<f32>, lengths: &CableLengths<f32>) -> Option<([f32; 3], f32)> {
        let (centre_mm, sigma_mm) = self.slip_monitor.live_joint()?.at(platform, lengths)?;
        Some((centre_mm.into(), sigma_mm))
    }
}
