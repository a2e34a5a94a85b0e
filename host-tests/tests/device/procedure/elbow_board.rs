//! An elbow on a board of its own: the device with an elbow's rig, its CAN messages, its button, its record.

use glenoid::can::hinge::JointKind;
use glenoid::can::identity::{Naming, checksum};
use glenoid::can::report::RawLength;
use glenoid::can::{BaseId, Message, Opcode, Request, Standing};
use glenoid::device::{Action, Config, Device, Event, LogEntry, MAX_FRAMES};
use glenoid::identification::hinge::{HingeEstimator, HingePose, HingeSettings, MAX_CABLES};
use glenoid::procedure::elbow::ElbowRig;
use glenoid::procedure::{PoseSet, Reason, StateName};
use glenoid::record::{JointRecord, JournalEntry, LoadError, Loaded};
use glenoid::rig::{CABLES, Rig, Tolerance};
use host_tests::power_cut;
use host_tests::study::elbow::scene::{Elbow, drawn};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

const PERIOD_MS: u32 = 10;
const HOLD_MS: u32 = 600;
/// Ticks of a millisecond while there is something to compute: more than a board has, so that a test does not take a day.
const TICKS_A_MILLISECOND: usize = 2_000;

/// A device with an elbow's rig, and an elbow in it.
pub(super) struct Bench {
    pub(super) device: Device,
    pub(super) elbow: Elbow,
    flexion_rad: f64,
    now_ms: u32,
    nonce: u16,
    pub(super) messages: Vec<Message>,
    logs: Vec<LogEntry>,
    pub(super) records: Vec<JointRecord>,
    journal: Vec<JournalEntry>,
}

impl Bench {
    pub(super) fn new() -> Self {
        let step = [0.03, -0.05, 4.0, -3.0, 0.04, 0.02, 2.0, 3.0, -2.0];
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let elbow = Elbow::of_hinge(&mut random, 4, &drawn().moved(&step), &Tolerance::exact());
        let mut bench = Self {
            device: Device::new(&Config::for_rig(rig())),
            elbow,
            flexion_rad: 0.0,
            now_ms: 0,
            nonce: 0,
            messages: Vec::new(),
            logs: Vec::new(),
            records: Vec::new(),
            journal: Vec::new(),
        };
        bench.start(Err(LoadError::Nothing));
        bench
    }

    /// The board is switched on; the record is what it finds.
    pub(super) fn start(&mut self, record: Result<JointRecord, LoadError>) {
        self.device = Device::new(&Config::for_rig(rig()));
        self.messages.clear();
        self.logs.clear();
        let journal = self.journal.last().copied();
        self.event(Event::PowerUp(Loaded { record, journal, parameters: None }));
        self.hold(HOLD_MS);
    }

    fn event(&mut self, event: Event) {
        let Self { device, messages, logs, records, journal, .. } = self;
        let mut frames = 0;
        device.handle(self.now_ms, event, &mut |action| match action {
            Action::Send(frame) => {
                frames += 1;
                messages.push(Message::unpack(&frame, BaseId::DEFAULT).unwrap());
            }
            Action::Store(record) => records.push(record),
            Action::Journal(entry) => journal.push(entry),
            Action::Log(entry) => logs.push(entry),
            Action::StatusLed(_) => {}
            other => panic!("{other:?}"),
        });
        assert!(frames <= MAX_FRAMES, "{frames} frames");
    }

    /// What the six encoders read; two of them hang on nothing.
    fn counts(&self) -> [i32; CABLES] {
        let mm_per_count = f64::from(rig().drum().mm_per_count());
        let [a, b, c, d] = self.elbow.reading_mm(self.flexion_rad, None);
        let count = |length: f64| ((length - 230.0) / mm_per_count).round() as i32;
        [count(a), count(b), count(c), count(d), self.now_ms as i32 * 77, i32::MIN]
    }

    pub(super) fn hold(&mut self, ms: u32) {
        for _ in 0..ms {
            self.now_ms += 1;
            if self.now_ms.is_multiple_of(PERIOD_MS) {
                self.event(Event::Counts(self.counts()));
            }
            self.event(Event::Tick);
            for _ in 1..TICKS_A_MILLISECOND {
                if !self.device.is_busy() {
                    break;
                }
                self.event(Event::Tick);
            }
        }
    }

    pub(super) fn bend_to(&mut self, degrees: f64) {
        let (from, to) = (self.flexion_rad, -degrees.to_radians());
        for step in 1..=40 {
            self.flexion_rad = from + (to - from) * f64::from(step) / 40.0;
            self.hold(PERIOD_MS);
        }
        self.hold(HOLD_MS);
    }

    fn request(&mut self, request: Request) -> (Reason, u16) {
        let before = self.messages.len();
        self.event(Event::Can(request.pack(BaseId::DEFAULT.command())));
        let answer = self.messages[before..].iter().find_map(|message| match message {
            Message::Answer(answer) => Some((answer.code, answer.detail)),
            _ => None,
        });
        answer.expect("an answer")
    }

    pub(super) fn ask(&mut self, opcode: Opcode, run_id: u16, argument: u16) -> Reason {
        self.nonce += 1;
        self.request(Request { opcode: opcode as u8, boot: 0, nonce: self.nonce, run_id, argument }).0
    }

    fn state(&self) -> StateName {
        self.device.procedure().state()
    }

    /// Bends as the golden ratio spreads the flexions, and captures, so many times.
    fn capture(&mut self, poses: u32, most_deg: f64) {
        let mut captured = 0;
        for k in 0.. {
            if captured >= poses {
                break;
            }
            self.bend_to(most_deg * (0.5 + 0.618_034 * f64::from(k)).fract());
            match self.ask(Opcode::Capture, 0, 0) {
                Reason::Fine => captured += 1,
                Reason::PoseTooNear => {}
                other => panic!("{other:?}"),
            }
        }
    }

    /// By commands, to the review.
    pub(super) fn lead_to_review(&mut self) {
        assert_eq!(self.ask(Opcode::Start, 0, 1), Reason::Fine);
        self.capture(22, 120.0);
        assert_eq!(self.ask(Opcode::Identify, 0, 0), Reason::Fine);
        self.hold(1_000);
        assert_eq!(self.state(), StateName::Verifying, "{:?}", self.device.procedure().ending());
        self.capture(5, 115.0);
        assert_eq!(self.ask(Opcode::Verify, 0, 0), Reason::Fine);
        self.hold(300);
        assert_eq!(self.state(), StateName::Review, "{:?}", self.device.procedure().ending());
    }

    pub(super) fn accept(&mut self) -> Reason {
        let naming =
            self.last(|m| if let Message::CandidateNaming(naming) = m { Some(*naming) } else { None }).unwrap();
        self.nonce += 1;
        let reason = self.request(Request::naming(Opcode::Accept, self.nonce, &naming)).0;
        self.hold(50);
        reason
    }

    fn press(&mut self, ms: u32) {
        self.event(Event::Button { down: true });
        self.hold(ms);
        self.event(Event::Button { down: false });
        self.hold(100);
    }

    pub(super) fn last<T>(&self, found: impl Fn(&Message) -> Option<T>) -> Option<T> {
        self.messages.iter().rev().find_map(found)
    }

    /// The frames of the hinge in use that were sent last.
    fn live_frames(&self) -> Vec<Message> {
        let is_live = |m: &&Message| matches!(m, Message::LiveHingeAxis(_) | Message::LiveHingePlace(_));
        let frames: Vec<Message> = self.messages.iter().filter(is_live).copied().collect();
        frames[frames.len().saturating_sub(13)..].to_vec()
    }
}

fn rig() -> ElbowRig {
    ElbowRig::four_cables().unwrap()
}

/// What the host's own estimator finds from the lengths that the board has sent.
fn by_the_host(messages: &[Message], poses: usize) -> glenoid::identification::hinge::IdentifiedHinge<f32> {
    let mut lengths = vec![[0.0; MAX_CABLES]; poses];
    for message in messages {
        if let Message::RawLength(RawLength { index, cable, set: PoseSet::Identification, length_mm, .. }) = message {
            lengths[usize::from(*index)][usize::from(*cable) - 1] = *length_mm;
        }
    }
    let mut poses: Vec<HingePose<f32>> = lengths.into_iter().map(HingePose::new).collect();
    let rig = rig();
    HingeEstimator::new(rig.hinge(), HingeSettings::for_rig(rig.hinge())).run(&mut poses).unwrap()
}

#[test]
fn by_can_it_finds_to_the_bit_what_the_host_finds_and_a_restart_keeps_it() {
    let mut bench = Bench::new();
    assert_eq!(bench.ask(Opcode::Query, 0, 0), Reason::Fine);
    bench.hold(100);
    let module = bench.last(|m| if let Message::Module(module) = m { Some(*module) } else { None }).unwrap();
    assert_eq!((module.joint, module.cables), (JointKind::Hinge, 4));

    bench.lead_to_review();
    bench.hold(300);
    let found = by_the_host(&bench.messages, 22);
    let bits: Vec<u32> = (bench.logs.iter())
        .filter_map(|entry| if let LogEntry::HingeIdentified { bits, .. } = entry { Some(*bits) } else { None })
        .flatten()
        .collect();
    let expected: Vec<u32> = [
        *found.hinge.axis(),
        *found.hinge.foot_mm(),
        found.hinge.axis_in_platform(),
        *found.hinge.foot_in_platform_mm(),
    ]
    .iter()
    .flat_map(|vector| vector.iter().map(|x| x.to_bits()))
    .collect();
    assert_eq!(bits, expected);

    // What is shown says the same, within what its fields hold, and its name is the checksum of its frames.
    let shown: Vec<Message> = bench
        .messages
        .iter()
        .filter(|m| matches!(m, Message::CandidateHingeAxis(_) | Message::CandidateHingePlace(_)))
        .copied()
        .collect();
    let shown = &shown[shown.len() - 13..];
    for (message, bits) in shown.iter().zip(&expected) {
        let (value, step, sigma) = match message {
            Message::CandidateHingeAxis(m) => (m.value, 2f32.powi(-26), m.sigma),
            Message::CandidateHingePlace(m) => (m.value_mm, 2f32.powi(-17), m.sigma_mm),
            _ => unreachable!(),
        };
        assert!((value - f32::from_bits(*bits)).abs() <= step && sigma > 0.0, "{message:?}");
    }
    let naming: Naming =
        bench.last(|m| if let Message::CandidateNaming(naming) = m { Some(*naming) } else { None }).unwrap();
    let data = shown.iter().map(|m| m.pack(BaseId::DEFAULT).unwrap().data().try_into().unwrap());
    assert_eq!(naming.checksum, checksum(naming.boot, naming.wearer, data));

    assert_eq!(bench.accept(), Reason::Fine);
    assert_eq!((bench.state(), bench.records.len()), (StateName::Idle, 1));
    let live = bench.device.live_set();
    assert_eq!((live.standing, live.hinge, live.run_id), (Standing::Confirmed, true, naming.run_id));
    let axis: [f32; 3] = std::array::from_fn(|k| live.parameters[k].value_mm);
    assert_eq!(axis, <[f32; 3]>::from(*found.hinge.axis()));
    assert_eq!(bench.ask(Opcode::Query, 0, 0), Reason::Fine);
    bench.hold(300);
    let before = bench.live_frames();

    // The angle follows the joint: as far as it is bent from where it is now, and no residual beyond the noise of a count.
    let angle = |bench: &Bench| bench.last(|m| if let Message::HingeAngle(angle) = m { Some(*angle) } else { None });
    let from = (angle(&bench).unwrap(), bench.flexion_rad);
    assert_eq!(from.0.run_id, naming.run_id);
    bench.bend_to(77.0);
    let to = angle(&bench).unwrap();
    let (turned, bent) = (f64::from(to.angle_rad - from.0.angle_rad), bench.flexion_rad - from.1);
    // The axis may be named in either direction.
    assert!((turned.abs() - bent.abs()).abs() < 0.01, "{turned} {bent}");
    assert!(to.residual_mm < 0.1, "{to:?}");

    // Through the flash.
    let record = bench.records[0];
    bench.start(Ok(record));
    bench.hold(300);
    assert_eq!(bench.live_frames(), before);
    assert_eq!(bench.device.live_set().standing, Standing::Unconfirmed);
    let restored = bench.device.procedure().hinge().unwrap().live().unwrap();
    assert_eq!(restored.found.hinge, found.hinge);
    assert_eq!(restored.found.covariance.lower_triangle(), found.covariance.lower_triangle());
}

#[test]
fn by_button_alone() {
    let mut bench = Bench::new();
    bench.press(1_500);
    assert_eq!(bench.state(), StateName::Collecting);
    for k in 0..60 {
        if bench.state() != StateName::Collecting {
            break;
        }
        bench.bend_to(120.0 * (0.5 + 0.618_034 * f64::from(k)).fract());
    }
    bench.hold(1_000);
    for k in 0..60 {
        if bench.state() != StateName::Verifying {
            break;
        }
        bench.bend_to(115.0 * (0.5 + 0.618_034 * f64::from(k)).fract());
    }
    bench.hold(1_500);
    assert_eq!(bench.state(), StateName::Review, "{:?}", bench.device.procedure().ending());
    // As many short presses as the LED blinks, 2 to 4, then a long one.
    for presses in 2..=4 {
        (0..presses).for_each(|_| bench.press(200));
        bench.press(1_500);
        if bench.state() == StateName::Idle {
            break;
        }
        bench.hold(3_100);
    }
    assert_eq!((bench.state(), bench.records.len()), (StateName::Idle, 1));
    assert!(bench.device.procedure().hinge().unwrap().live().is_some());
}

#[test]
fn what_only_a_ball_has_is_refused_by_name() {
    let mut bench = Bench::new();
    assert_eq!(bench.ask(Opcode::Start, 0, 2), Reason::NotOfHinge);
    assert_eq!(bench.ask(Opcode::Start, 0, 4), Reason::NotOfHinge);
    assert_eq!(bench.ask(Opcode::SetZeroPrior, 0, 300), Reason::NotOfHinge);
    assert_eq!(bench.ask(Opcode::CheckCable, 0, 5), Reason::BadArgument);
    assert_eq!(bench.ask(Opcode::CheckCable, 0, 4), Reason::CableNotPulled);
    assert_eq!(bench.state(), StateName::Idle);
}

#[test]
fn an_elbow_that_never_bends_is_refused_by_name() {
    let mut bench = Bench::new();
    assert_eq!(bench.ask(Opcode::Start, 0, 0), Reason::Fine);
    for k in 0..6 {
        bench.bend_to(f64::from(k % 2) * 2.0);
    }
    bench.hold(121_000);
    let outcome = bench.last(|m| if let Message::Outcome(outcome) = m { Some(*outcome) } else { None }).unwrap();
    assert_eq!((bench.state(), outcome.reason), (StateName::Failed, Reason::TooAlike));
}

/// A ball's record on an elbow's board, and a hinge's on a ball's, even if the fingerprints were alike.
#[test]
fn a_record_of_another_joint_is_refused_by_name() {
    let mut bench = Bench::new();
    bench.lead_to_review();
    bench.hold(300);
    assert_eq!(bench.accept(), Reason::Fine);
    let JointRecord::Hinge(hinge) = bench.records[0] else { panic!("not a hinge's") };
    let ball = power_cut::record(7);
    let loaded = |device: &mut Device, record| {
        let mut reason = None;
        device.handle(
            0,
            Event::PowerUp(Loaded { record: Ok(record), journal: None, parameters: None }),
            &mut |action| {
                if let Action::Log(LogEntry::Loaded { reason: said, .. }) = action {
                    reason = Some(said);
                }
            },
        );
        assert!(device.procedure().live().is_none());
        reason.unwrap()
    };
    let mut elbow = Device::new(&Config::for_rig(rig()));
    let ball = glenoid::record::Record { rig: hinge.rig, ..ball };
    assert_eq!(loaded(&mut elbow, ball.into()), Reason::RecordOfOtherRig);
    let shoulder = Rig::shoulder(150.0).unwrap();
    let mut board = Device::new(&Config::for_rig(shoulder));
    let hinge = glenoid::record::HingeRecord { rig: glenoid::device::fingerprint(&shoulder), ..hinge };
    assert_eq!(loaded(&mut board, hinge.into()), Reason::RecordOfOtherRig);
}
