//! The two protected sets that the device sends by itself: what a controller acts on, and what the cables show now.

use super::{Action, Device};
use crate::can::Message;
use crate::can::live_set::{LIVE_SET_FRAMES, LIVE_SET_LEN};
use crate::can::set::piece;
use crate::can::telemetry::{TELEMETRY_FRAMES, TELEMETRY_LEN, Telemetry};
use crate::kinematics::CableLengths;
use crate::kinematics::rotation::rotation_vector_of;
use crate::procedure::Reason;

/// A set that was packed and goes out a frame a tick.
#[derive(Debug, Clone)]
pub(super) struct Outgoing<const LEN: usize> {
    /// Time between two sets, ms; 0 = off.
    period_ms: u32,
    began_ms: Option<u32>,
    data: [u8; LEN],
    /// The next frame; at the number of frames nothing is left to send.
    next: usize,
    counter: u16,
}

impl<const LEN: usize> Outgoing<LEN> {
    /// Nothing was sent yet.
    pub const fn every(period_ms: u32) -> Self {
        Self { period_ms, began_ms: None, data: [0; LEN], next: usize::MAX, counter: 0 }
    }

    /// Sets the time between two sets, ms; 0 = off.
    pub fn set_period(&mut self, period_ms: u32) {
        self.period_ms = period_ms;
    }

    /// Is another set to be packed now? The last one has gone out whole then.
    fn is_due(&self, now_ms: u32, frames: usize) -> bool {
        let waited = self.began_ms.is_none_or(|began_ms| now_ms.wrapping_sub(began_ms) >= self.period_ms);
        self.period_ms != 0 && waited && self.next >= frames
    }

    /// Begins to send a set, packed with the counter.
    fn begin(&mut self, now_ms: u32, data: [u8; LEN]) {
        self.data = data;
        self.next = 0;
        self.began_ms = Some(now_ms);
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
    /// A set is to be formed.
    pub(super) fn set_is_due(&self, now_ms: u32) -> bool {
        self.live_out.is_due(now_ms, LIVE_SET_FRAMES) || self.telemetry_out.is_due(now_ms, TELEMETRY_FRAMES)
    }

    /// A slice of the computing waits for the next tick when something is sent in this one whose forming takes as long; never
    /// twice in a row, for what is due may not be there.
    pub(super) fn lets_computing_wait(&mut self, now_ms: u32) -> bool {
        let has_much_to_send = self.pace.heartbeat_is_due(now_ms) || self.set_is_due(now_ms);
        self.computing_waits = !self.computing_waits && has_much_to_send && self.is_busy();
        self.computing_waits
    }

    /// Forms at most one of the sets, and sends at most one frame of each.
    pub(super) fn send_sets(&mut self, now_ms: u32, out: &mut impl FnMut(Action)) {
        let live_is_due = self.live_out.is_due(now_ms, LIVE_SET_FRAMES);
        if live_is_due {
            match self.live_set().pack(self.live_out.counter) {
                Ok(data) => self.live_out.begin(now_ms, data),
                Err(_) => self.note_unsendable(),
            }
        }
        if let Some(bytes) = self.live_out.next_piece(LIVE_SET_FRAMES) {
            self.send(&Message::LiveSet(bytes), out);
        }
        if !live_is_due
            && self.telemetry_out.is_due(now_ms, TELEMETRY_FRAMES)
            && let Some(telemetry) = self.telemetry(now_ms)
        {
            match telemetry.pack(self.telemetry_out.counter) {
                Ok(data) => self.telemetry_out.begin(now_ms, data),
                Err(_) => self.note_unsendable(),
            }
        }
        if let Some(bytes) = self.telemetry_out.next_piece(TELEMETRY_FRAMES) {
            self.send(&Message::Telemetry(bytes), out);
        }
    }

    /// What the cables show now; None before the first sample, and while a length cannot be one.
    fn telemetry(&self, now_ms: u32) -> Option<Telemetry> {
        let counts = self.counts?;
        let lengths = CableLengths::from_counts(self.procedure.rig(), &counts).ok()?;
        let live = self.procedure.live();
        let corrected = live.map_or(Ok(lengths), |live| lengths.less(&live.identified.offsets_mm));
        let arm = self.procedure.arm(now_ms);
        let platform = corrected.ok().and_then(|lengths| self.forward_kinematics.solve(&lengths).ok());
        let slack = arm.err().filter(|not_ready| not_ready.reason == Reason::CableLoose);
        Some(Telemetry {
            // modulo 2^16
            time_ms: now_ms as u16,
            still: arm.is_ok(),
            encoders: self.procedure.fault(now_ms).is_none(),
            slack: slack.map_or(0, |not_ready| not_ready.cable),
            standing: self.standing().0,
            lengths_mm: *lengths.as_mm(),
            rotation_rad: platform.as_ref().map(|platform| rotation_vector_of(&platform.rotation).into()),
            centre: match self.slip_monitor.live_joint() {
                Some(joint) => platform
                    .and_then(|platform| joint.at(&platform, &corrected.ok()?))
                    .map(|(centre_mm, sigma_mm)| (centre_mm.into(), sigma_mm)),
                None => live.map(|live| {
                    let kept = self.slip_monitor.centre_sigma_mm();
                    let sigma_mm = kept.unwrap_or_else(|| live.identified.worst_centre_sigma_mm().0);
                    (live.identified.parameters.centre_mm.into(), sigma_mm)
                }),
            },
        })
    }
}
