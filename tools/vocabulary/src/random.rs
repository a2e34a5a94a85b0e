//! Random messages of every kind, within what their fields can hold.

use glenoid::can::Standing;
use glenoid::can::health::{BusHealth, LastStop, StopText};
use glenoid::can::hinge::{HingeAngle, HingeAxis, HingePlace, JointKind, Module};
use glenoid::can::identity::{Identity, Naming};
use glenoid::can::message::Message;
use glenoid::can::report::{LeftOut, OutcomeReport, PoseReport, PoseSamples, RawLength};
use glenoid::can::result::{Axis, MotionPart, Parameter, Quality, VerificationReport, WeakDirection, ZeroError};
use glenoid::can::status::{Answer, Counters, Fault, Flags, Heartbeat, Versions};
use glenoid::can::watch::WatchReport;
use glenoid::procedure::{Guidance, PoseSet, Reason, StateName};
use glenoid::restart::ResetCause;
use rand::Rng;

/// How many kinds of messages the device sends, without the multiplexed ones.
pub const KINDS: u8 = 35;

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
        23 => Message::Identity(Identity { serial: any.0.random(), boot: any.0.random(), wearer: any.0.random() }),
        24 => Message::CandidateNaming(any.naming()),
        25 => Message::LiveNaming(any.naming()),
        26 => Message::CandidateMotion(any.motion()),
        27 => Message::LiveMotion(any.motion()),
        28 => Message::PoseSamples(PoseSamples {
            run_id: any.0.random(),
            index: any.0.random(),
            set: PoseSet::held_out_if(any.0.random()),
            samples: any.0.random(),
        }),
        29 => Message::Module(Module {
            joint: JointKind::ALL[any.0.random_range(0..JointKind::ALL.len())],
            cables: any.0.random(),
            capacity: any.0.random(),
            held_out_capacity: any.0.random(),
            rig: any.0.random(),
        }),
        30 => Message::CandidateHingeAxis(any.hinge_axis()),
        31 => Message::CandidateHingePlace(any.hinge_place()),
        32 => Message::LiveHingeAxis(any.hinge_axis()),
        33 => Message::LiveHingePlace(any.hinge_place()),
        34 => Message::HingeAngle(HingeAngle {
            run_id: any.0.random(),
            time_ms: any.0.random(),
            angle_rad: any.around_zero(7.9),
            residual_mm: any.up_to(HingeAngle::MAX_RESIDUAL_MM),
        }),
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

    fn hinge_axis(&mut self) -> HingeAxis {
        HingeAxis {
            run_id: self.0.random(),
            index: self.below(6),
            value: self.around_zero(1.0),
            sigma: self.up_to(0.49),
        }
    }

    fn hinge_place(&mut self) -> HingePlace {
        HingePlace {
            run_id: self.0.random(),
            index: self.below(7),
            value_mm: self.around_zero(1_023.9),
            sigma_mm: self.up_to(31.9),
        }
    }

    fn naming(&mut self) -> Naming {
        Naming { run_id: self.0.random(), boot: self.0.random(), wearer: self.0.random(), checksum: self.0.random() }
    }

    fn motion(&mut self) -> MotionPart {
        let numbers = std::array::from_fn(|_| self.0.random_range(-16_384..=16_383));
        MotionPart { run_id: self.0.random(), part: self.below(8), numbers }
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
                held_phase: self.0.random(),
            },
            standing: Standing::ALL[self.0.random_range(0..Standing::ALL.len())],
            sequence: self.0.random(),
        }
    }
}
