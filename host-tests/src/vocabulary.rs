//! The messages of `glenoid.dbc` by name and field, for tests against other codecs and for display.

use glenoid::can::health::{BusHealth, LastStop, StopText};
use glenoid::can::message::Message;
use glenoid::can::report::{LeftOut, OutcomeReport, PoseReport, RawLength};
use glenoid::can::result::{Axis, Parameter, Quality, VerificationReport, WeakDirection, ZeroError};
use glenoid::can::status::{Answer, Counters, Fault, Flags, Heartbeat, Versions};
use glenoid::can::watch::WatchReport;
use glenoid::procedure::{Guidance, PoseSet, Reason, StateName};
use glenoid::restart::ResetCause;
use rand::Rng;

/// A field of a message: its name in the DBC and its physical value. Flags are 0 and 1, codes their numbers; a value
/// that is missing is 0, and the flag beside it says so.
pub type Field = (&'static str, f64);

/// The message's name in the DBC, and its fields in the order of the DBC.
pub fn fields(message: &Message) -> (&'static str, Vec<Field>) {
    match message {
        Message::Answer(m) => ("Answer", answer(m)),
        Message::Heartbeat(m) => ("Heartbeat", heartbeat(m)),
        Message::Fault(m) => ("Fault", fault(m)),
        Message::Pose(m) => ("Pose", pose(m)),
        Message::Outcome(m) => ("Outcome", outcome(m)),
        Message::CandidateCentre(m) => ("CandidateCentre", parameter("axis", m)),
        Message::CandidateRadius(m) => ("CandidateRadius", parameter("end_point", m)),
        Message::Quality(m) => ("Quality", quality(m)),
        Message::Verification(m) => ("Verification", verification(m)),
        Message::WeakDirection(m) => ("WeakDirection", weak_direction(m)),
        Message::LeftOut(m) => ("LeftOut", left_out(m)),
        Message::Axis(m) => ("Axis", axis(m)),
        Message::LiveCentre(m) => ("LiveCentre", parameter("axis", m)),
        Message::LiveRadius(m) => ("LiveRadius", parameter("end_point", m)),
        Message::RawLength(m) => ("RawLength", raw_length(m)),
        Message::Versions(m) => ("Versions", versions(m)),
        Message::Counters(m) => ("Counters", counters(m)),
        Message::BusHealth(m) => ("BusHealth", bus_health(m)),
        Message::LastStop(m) => ("LastStop", last_stop(m)),
        Message::StopText(m) => ("StopText", stop_text(m)),
        Message::CandidateZero(m) => ("CandidateZero", zero(m)),
        Message::LiveZero(m) => ("LiveZero", zero(m)),
        Message::Watch(m) => ("Watch", watch(m)),
    }
}

fn run_id(id: u16) -> Field {
    ("run_id", f64::from(id))
}

fn answer(m: &Answer) -> Vec<Field> {
    vec![
        ("opcode", m.opcode.into()),
        ("code", m.code.code().into()),
        ("nonce", m.nonce.into()),
        run_id(m.run_id),
        ("detail", m.detail.into()),
    ]
}

fn heartbeat(m: &Heartbeat) -> Vec<Field> {
    vec![
        run_id(m.run_id),
        ("state", m.state.code().into()),
        ("guidance", m.guidance.code().into()),
        ("poses", m.poses.into()),
        ("progress", m.progress_percent.into()),
        ("reason", m.reason.code().into()),
        ("live", m.flags.live.into()),
        ("still", m.flags.still.into()),
        ("encoders", m.flags.encoders.into()),
        ("button", m.flags.button.into()),
        ("unacknowledged", m.flags.unacknowledged.into()),
        ("by_command_only", m.flags.by_command_only.into()),
        ("sequence", m.sequence.into()),
    ]
}

fn fault(m: &Fault) -> Vec<Field> {
    vec![
        run_id(m.run_id),
        ("code", m.code.code().into()),
        ("cable", m.cable.into()),
        ("active", m.active.into()),
        ("count", m.count.into()),
    ]
}

fn pose(m: &PoseReport) -> Vec<Field> {
    vec![
        run_id(m.run_id),
        ("index", m.index.into()),
        ("reason", m.reason.code().into()),
        ("guidance", m.guidance.code().into()),
        ("held_out", (m.set == PoseSet::HeldOut).into()),
        ("sigma_known", m.sigma_mm.is_some().into()),
        ("distance_known", m.distance_deg.is_some().into()),
        ("sigma", m.sigma_mm.unwrap_or(0.0).into()),
        ("distance", m.distance_deg.unwrap_or(0.0).into()),
    ]
}

fn outcome(m: &OutcomeReport) -> Vec<Field> {
    vec![
        run_id(m.run_id),
        ("reason", m.reason.code().into()),
        ("pose", m.pose.unwrap_or(0).into()),
        ("cable", m.cable.into()),
        ("live", m.live.into()),
        ("pose_known", m.pose.is_some().into()),
        ("size_known", m.size_mm.is_some().into()),
        ("poses", m.poses.into()),
        ("size", m.size_mm.unwrap_or(0.0).into()),
    ]
}

fn parameter(index: &'static str, m: &Parameter) -> Vec<Field> {
    vec![run_id(m.run_id), (index, m.index.into()), ("value", m.value_mm.into()), ("sigma", m.sigma_mm.into())]
}

fn quality(m: &Quality) -> Vec<Field> {
    vec![
        run_id(m.run_id),
        ("deviation", m.deviation_mm.into()),
        ("noise", m.noise_mm.into()),
        ("iterations", m.iterations.into()),
        ("left_out", m.left_out.into()),
    ]
}

fn verification(m: &VerificationReport) -> Vec<Field> {
    vec![
        run_id(m.run_id),
        ("deviation", m.deviation_mm.into()),
        ("limit", m.limit_mm.into()),
        ("poses", m.poses.into()),
    ]
}

fn weak_direction(m: &WeakDirection) -> Vec<Field> {
    let names = ["x", "y", "z", "p1", "p2", "p3"];
    std::iter::once(run_id(m.run_id)).chain(names.into_iter().zip(m.direction.map(f64::from))).collect()
}

fn left_out(m: &LeftOut) -> Vec<Field> {
    vec![
        run_id(m.run_id),
        ("index", m.index.into()),
        ("of", m.of.into()),
        ("pose", m.pose.into()),
        ("cables", m.cables.into()),
    ]
}

fn axis(m: &Axis) -> Vec<Field> {
    std::iter::once(run_id(m.run_id)).chain(["x", "y", "z"].into_iter().zip(m.axis.map(f64::from))).collect()
}

fn raw_length(m: &RawLength) -> Vec<Field> {
    vec![
        run_id(m.run_id),
        ("index", m.index.into()),
        ("cable", m.cable.into()),
        ("held_out", (m.set == PoseSet::HeldOut).into()),
        ("length", m.length_mm.into()),
    ]
}

fn versions(m: &Versions) -> Vec<Field> {
    let [major, minor, patch] = m.firmware;
    vec![
        ("protocol", m.protocol.into()),
        ("major", major.into()),
        ("minor", minor.into()),
        ("patch", patch.into()),
        ("reset_cause", m.reset_cause.code().into()),
        ("capacity", m.capacity.into()),
        ("rig", m.rig.into()),
    ]
}

fn counters(m: &Counters) -> Vec<Field> {
    vec![
        ("foreign", m.foreign.into()),
        ("malformed", m.malformed.into()),
        ("overruns", m.overruns.into()),
        ("unsendable", m.unsendable.into()),
    ]
}

fn bus_health(m: &BusHealth) -> Vec<Field> {
    vec![
        ("bus_off", m.bus_off.into()),
        ("dropped", m.dropped.into()),
        ("transmit_errors", m.transmit_errors.into()),
        ("receive_errors", m.receive_errors.into()),
        ("error_passive", m.error_passive.into()),
    ]
}

fn last_stop(m: &LastStop) -> Vec<Field> {
    vec![
        ("cause", m.cause.code().into()),
        ("text_len", m.text_len.into()),
        ("line", m.line.into()),
        ("address", m.address.into()),
    ]
}

fn stop_text(m: &StopText) -> Vec<Field> {
    let names = ["c1", "c2", "c3", "c4", "c5", "c6", "c7"];
    let characters = names.into_iter().zip(m.text).map(|(name, character)| (name, f64::from(character)));
    [("index", m.index.into())].into_iter().chain(characters).collect()
}

fn zero(m: &ZeroError) -> Vec<Field> {
    vec![run_id(m.run_id), ("cable", m.cable.into()), ("value", m.value_mm.into()), ("sigma", m.sigma_mm.into())]
}

fn watch(m: &WatchReport) -> Vec<Field> {
    let moved = ["x", "y", "z"].into_iter().zip(m.moved_mm.map(f64::from));
    [run_id(m.run_id), ("cause", m.cause.code().into()), ("cable", m.cable.into())].into_iter().chain(moved).collect()
}

/// How many kinds of messages the device sends.
pub const KINDS: u8 = 23;

/// A random message of a kind, 0 to [`KINDS`] - 1 in the order of the identifiers. Values are random within what
/// their fields can hold, and not rounded to the fields' steps.
pub fn random_message(kind: u8, random: &mut impl Rng) -> Message {
    let mut any = Random(random);
    match kind {
        0 => Message::Answer(Answer {
            opcode: any.0.random(),
            code: any.reason(),
            nonce: any.0.random(),
            run_id: any.0.random(),
            detail: any.0.random(),
        }),
        1 => Message::Heartbeat(any.heartbeat()),
        2 => Message::Fault(Fault {
            run_id: any.0.random(),
            code: any.reason(),
            cable: any.below(7),
            active: any.0.random(),
            count: any.0.random(),
        }),
        3 => Message::Pose(PoseReport {
            run_id: any.0.random(),
            index: any.0.random(),
            reason: any.reason(),
            guidance: any.guidance(),
            set: PoseSet::held_out_if(any.0.random()),
            sigma_mm: any.optional(31.9),
            distance_deg: any.optional(180.0),
        }),
        4 => Message::Outcome(OutcomeReport {
            run_id: any.0.random(),
            reason: any.reason(),
            pose: any.0.random::<bool>().then(|| any.0.random()),
            cable: any.below(7),
            live: any.0.random(),
            poses: any.0.random(),
            size_mm: any.optional(63.9),
        }),
        5 => Message::CandidateCentre(any.parameter()),
        6 => Message::CandidateRadius(any.parameter()),
        7 => Message::Quality(Quality {
            run_id: any.0.random(),
            deviation_mm: any.up_to(15.9),
            noise_mm: any.up_to(15.9),
            iterations: any.0.random(),
            left_out: any.0.random(),
        }),
        8 => Message::Verification(VerificationReport {
            run_id: any.0.random(),
            deviation_mm: any.up_to(15.9),
            limit_mm: any.up_to(15.9),
            poses: any.0.random(),
        }),
        9 => Message::WeakDirection(WeakDirection {
            run_id: any.0.random(),
            direction: std::array::from_fn(|_| any.around_zero(1.0)),
        }),
        10 => Message::LeftOut(LeftOut {
            run_id: any.0.random(),
            index: any.0.random(),
            of: any.0.random(),
            pose: any.0.random(),
            cables: any.below(64),
        }),
        11 => Message::Axis(Axis { run_id: any.0.random(), axis: std::array::from_fn(|_| any.around_zero(1.0)) }),
        12 => Message::LiveCentre(any.parameter()),
        13 => Message::LiveRadius(any.parameter()),
        14 => Message::RawLength(RawLength {
            run_id: any.0.random(),
            index: any.0.random(),
            cable: any.below(7),
            set: PoseSet::held_out_if(any.0.random()),
            length_mm: any.up_to(4_095.0),
        }),
        15 => Message::Versions(Versions {
            protocol: any.0.random(),
            firmware: any.0.random(),
            reset_cause: any.cause(),
            capacity: any.0.random(),
            rig: any.0.random(),
        }),
        16 => Message::Counters(Counters {
            foreign: any.0.random_range(0..1 << 24),
            malformed: any.0.random(),
            overruns: any.0.random_range(0..1 << 12),
            unsendable: any.0.random_range(0..1 << 12),
        }),
        17 => Message::BusHealth(BusHealth {
            bus_off: any.0.random(),
            dropped: any.0.random(),
            transmit_errors: any.0.random(),
            receive_errors: any.0.random(),
            error_passive: any.0.random(),
        }),
        18 => Message::LastStop(LastStop {
            cause: any.cause(),
            text_len: any.0.random(),
            line: any.0.random(),
            address: any.0.random(),
        }),
        19 => Message::StopText(StopText { index: any.0.random(), text: any.0.random() }),
        20 => Message::CandidateZero(any.zero()),
        21 => Message::LiveZero(any.zero()),
        _ => Message::Watch(WatchReport {
            run_id: any.0.random(),
            cause: any.reason(),
            cable: any.below(7),
            moved_mm: std::array::from_fn(|_| any.around_zero(63.9)),
        }),
    }
}

struct Random<'a, R: Rng>(&'a mut R);

impl<R: Rng> Random<'_, R> {
    fn below(&mut self, end: u8) -> u8 {
        self.0.random_range(0..end)
    }

    fn up_to(&mut self, end: f32) -> f32 {
        self.0.random_range(0.0..=end)
    }

    fn around_zero(&mut self, end: f32) -> f32 {
        self.0.random_range(-end..=end)
    }

    fn optional(&mut self, end: f32) -> Option<f32> {
        self.0.random::<bool>().then(|| self.up_to(end))
    }

    fn reason(&mut self) -> Reason {
        Reason::ALL[self.0.random_range(0..Reason::ALL.len())]
    }

    fn cause(&mut self) -> ResetCause {
        ResetCause::ALL[self.0.random_range(0..ResetCause::ALL.len())]
    }

    fn guidance(&mut self) -> Guidance {
        Guidance::ALL[self.0.random_range(0..Guidance::ALL.len())]
    }

    fn parameter(&mut self) -> Parameter {
        Parameter {
            run_id: self.0.random(),
            index: self.below(3),
            value_mm: self.around_zero(1_023.9),
            sigma_mm: self.up_to(7.9),
        }
    }

    fn zero(&mut self) -> ZeroError {
        ZeroError {
            run_id: self.0.random(),
            cable: self.below(7),
            value_mm: self.around_zero(1_023.9),
            sigma_mm: self.up_to(63.9),
        }
    }

    fn heartbeat(&mut self) -> Heartbeat {
        Heartbeat {
            run_id: self.0.random(),
            state: StateName::ALL[self.0.random_range(0..StateName::ALL.len())],
            guidance: self.guidance(),
            poses: self.0.random(),
            progress_percent: self.below(101),
            reason: self.reason(),
            flags: Flags {
                live: self.0.random(),
                still: self.0.random(),
                encoders: self.0.random(),
                button: self.0.random(),
                unacknowledged: self.0.random(),
                by_command_only: self.0.random(),
            },
            sequence: self.0.random(),
        }
    }
}
