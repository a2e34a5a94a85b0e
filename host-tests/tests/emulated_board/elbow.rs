//! An elbow on the emulated board: told of its rig by parameters, calibrated, switched off and on.

use crate::scene::last_report;
use glenoid::can::hinge::JointKind;
use glenoid::can::report::RawLength;
use glenoid::can::status::Answer;
use glenoid::can::{BaseId, Message, Opcode, Operation, ParameterRequest, Request};
use glenoid::identification::hinge::{HingeEstimator, HingePose, HingeSettings, MAX_CABLES};
use glenoid::parameters::{ParameterSet, TABLE};
use glenoid::procedure::elbow::ElbowRig;
use glenoid::procedure::{ModuleRig, PoseSet, Reason, StateName};
use glenoid::restart::Restart;
use glenoid::rig::{CABLES, Tolerance};
use host_tests::board_lines::BoardLines;
use host_tests::emulator::Emulator;
use host_tests::study::elbow::scene::{Elbow, drawn};
use libtest_mimic::Failed;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::path::Path;
use std::time::Duration;

/// Time between two samples of the encoders, ms; all times are so many samples.
const PERIOD_MS: u32 = 10;
const HOLD_MS: u32 = 500;
/// Longest wait for anything that the board says or does: the solver takes seconds.
const PATIENCE_MS: u32 = 600_000;
const RETRIES: u32 = 200;
const POSES: u32 = 10;

/// A board, the elbow in its machine, and a client on its bus.
struct Scene {
    board: Emulator,
    lines: BoardLines,
    rig: ElbowRig,
    elbow: Elbow,
    flexion_rad: f64,
    nonce: u16,
    heard: Vec<Message>,
}

impl Scene {
    /// A board that has become an elbow's.
    fn new(image: &Path) -> Result<Self, Failed> {
        let drawn_rig = ElbowRig::four_cables().map_err(|error| error.text())?;
        let module = ModuleRig::from(drawn_rig);
        let set = ParameterSet::of_module(&module, &module.default_limits());
        // What the board makes of the parameters.
        let config = set.config(Restart::default(), 0).map_err(|at| format!("index {}", at.index))?;
        let rig = config.rig.hinge().ok_or("the parameters make no elbow")?.clone();
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let hinge = drawn().moved(&[0.03, -0.05, 4.0, -3.0, 0.04, 0.02, 2.0, 3.0, -2.0]);
        let elbow = Elbow::of_hinge(&mut random, MAX_CABLES, &hinge, &Tolerance::exact());
        let board = super::boot(image)?;
        let lines = BoardLines::connect(&board)?;
        let mut scene = Self { board, lines, rig, elbow, flexion_rad: 0.0, nonce: 0, heard: Vec::new() };
        scene.tell(&set)?;
        Ok(scene)
    }

    /// Tells the board of all parameters that differ from the defaults, and starts it anew.
    fn tell(&mut self, set: &ParameterSet) -> Result<(), Failed> {
        let defaults = ParameterSet::new();
        let changed = TABLE.iter().filter(|entry| set.bits(entry.index) != defaults.bits(entry.index));
        let writes = changed.map(|entry| (Operation::Write, entry.index, set.bits(entry.index).unwrap_or_default()));
        for (operation, index, value) in writes.chain([(Operation::Check, 0, 0), (Operation::Save, 0, 0)]) {
            self.heard.clear();
            let request = ParameterRequest { operation: operation as u8, index, nonce: 0, value };
            self.lines.send(&request.pack(BaseId::DEFAULT.parameters()))?;
            let answer = self.wait("answer about a parameter", |message| match message {
                Message::Parameter(answer) if answer.index == index => Some(*answer),
                _ => None,
            })?;
            if answer.code != Reason::Fine {
                return Err(format!("{answer:?}").into());
            }
        }
        self.restart()
    }

    /// Takes the board's supply away and gives it back.
    fn restart(&mut self) -> Result<(), Failed> {
        self.board.power_cycle()?;
        self.lines = BoardLines::connect(&self.board)?;
        self.heard.clear();
        self.command(Opcode::Query, 0)?;
        self.wait_for_module()
    }

    /// The board says, after a start, that it is an elbow's.
    fn wait_for_module(&mut self) -> Result<(), Failed> {
        let module = self.wait("module", |message| if let Message::Module(m) = message { Some(*m) } else { None })?;
        assert_eq!((module.joint, module.cables), (JointKind::Hinge, 4));
        self.hold(HOLD_MS)
    }

    fn counts(&self) -> [i32; CABLES] {
        let mm_per_count = f64::from(self.rig.drum().mm_per_count());
        let count = |length: f64| ((length - 230.0) / mm_per_count).round() as i32;
        let [a, b, c, d] = self.elbow.reading_mm(self.flexion_rad, None).map(count);
        [a, b, c, d, 12_345, -7]
    }

    fn sample(&mut self) -> Result<(), Failed> {
        self.lines.sample(&self.counts())?;
        let frames = self.lines.pass(Duration::from_millis(PERIOD_MS.into()), 0)?;
        self.heard.extend(frames.iter().flat_map(|frame| Message::unpack(frame, BaseId::DEFAULT)));
        Ok(())
    }

    fn hold(&mut self, ms: u32) -> Result<(), Failed> {
        (0..ms / PERIOD_MS).try_for_each(|_| self.sample())
    }

    fn wait<T>(&mut self, what: &str, wanted: impl Fn(&Message) -> Option<T>) -> Result<T, Failed> {
        for _ in 0..PATIENCE_MS / PERIOD_MS {
            if let Some(found) = self.heard.iter().rev().find_map(&wanted) {
                return Ok(found);
            }
            self.sample()?;
        }
        Err(format!("no {what}; the board's log ends with {:?}", self.board.log().last()).into())
    }

    fn wait_for_state(&mut self, state: StateName) -> Result<(), Failed> {
        self.wait("state", |m| matches!(m, Message::Heartbeat(h) if h.state == state).then_some(()))
    }

    fn bend_to(&mut self, degrees: f64) -> Result<(), Failed> {
        let (from, to) = (self.flexion_rad, -degrees.to_radians());
        for step in 1..=40 {
            self.flexion_rad = from + (to - from) * f64::from(step) / 40.0;
            self.sample()?;
        }
        self.hold(HOLD_MS)
    }

    fn ask(&mut self, request: Request) -> Result<Answer, Failed> {
        self.lines.send(&request.pack(BaseId::DEFAULT.command()))?;
        let meant = |m: &Message| match m {
            Message::Answer(answer) if answer.nonce == request.nonce => Some(*answer),
            _ => None,
        };
        self.wait("answer", meant)
    }

    /// Gives a command, again while the arm does not count as still yet.
    fn command(&mut self, opcode: Opcode, argument: u16) -> Result<Answer, Failed> {
        for _ in 0..RETRIES {
            self.nonce += 1;
            let answer = self.ask(Request { opcode: opcode as u8, boot: 0, nonce: self.nonce, run_id: 0, argument })?;
            if !matches!(answer.code, Reason::ArmMoving | Reason::CableLoose | Reason::EncoderSilent) {
                return Ok(answer);
            }
            self.hold(50)?;
        }
        Err("the arm never counts as still".into())
    }

    fn capture(&mut self, poses: u32, most_deg: f64) -> Result<(), Failed> {
        let mut captured = 0;
        for k in 0.. {
            if captured >= poses {
                break;
            }
            self.bend_to(most_deg * (0.5 + 0.618_034 * f64::from(k)).fract())?;
            match self.command(Opcode::Capture, 0)?.code {
                Reason::Fine => captured += 1,
                Reason::PoseTooNear => {}
                other => return Err(format!("{other:?}").into()),
            }
        }
        Ok(())
    }

    /// What the host's own estimator finds from the lengths that the board has sent, in the form of the board's log.
    fn by_the_host(&self) -> [String; 2] {
        let mut lengths = vec![[0.0; MAX_CABLES]; POSES as usize];
        for message in &self.heard {
            if let Message::RawLength(RawLength { index, cable, set: PoseSet::Identification, length_mm, .. }) = message
            {
                lengths[usize::from(*index)][usize::from(*cable) - 1] = *length_mm;
            }
        }
        let mut poses: Vec<HingePose<f32>> = lengths.into_iter().map(HingePose::new).collect();
        let rig = self.rig.hinge();
        let found = HingeEstimator::new(rig, HingeSettings::for_rig(rig)).run(&mut poses);
        let hinge = found.map(|found| found.hinge).expect("a hinge");
        let bits = |vectors: [nalgebra::Vector3<f32>; 2]| {
            let numbers: Vec<f32> = vectors.iter().flat_map(|vector| vector.iter().copied()).collect();
            numbers.iter().map(|x| format!("{:08x}", x.to_bits())).collect::<Vec<_>>().join(" ")
        };
        [bits([*hinge.axis(), *hinge.foot_mm()]), bits([hinge.axis_in_platform(), *hinge.foot_in_platform_mm()])]
    }

    /// The hinge in use as the board shows it on query, 13 frames.
    fn live(&mut self) -> Result<Vec<Message>, Failed> {
        self.heard.clear();
        self.command(Opcode::Query, 0)?;
        for _ in 0..PATIENCE_MS / PERIOD_MS {
            let report = last_report(&self.heard);
            if report.iter().any(|m| matches!(m, Message::LiveNaming(_))) {
                let is_live = |m: &&Message| matches!(m, Message::LiveHingeAxis(_) | Message::LiveHingePlace(_));
                return Ok(report.iter().filter(is_live).copied().collect());
            }
            self.sample()?;
        }
        Err("the board never names the hinge in use".into())
    }
}

/// By commands: told of its rig, calibrated, accepted, stored; switched off and on it has the same axis. What it finds is to the
/// bit what the host finds.
pub fn an_elbow_is_calibrated_and_kept(image: &Path) -> Result<(), Failed> {
    let mut scene = Scene::new(image)?;
    scene.heard.clear();
    assert_eq!(scene.command(Opcode::Start, 1)?.code, Reason::Fine);
    scene.capture(POSES, 120.0)?;
    assert_eq!(scene.command(Opcode::Identify, 0)?.code, Reason::Fine);
    scene.wait_for_state(StateName::Verifying)?;
    let expected = scene.by_the_host();
    let log = scene.board.log();
    for (body, bits) in expected.iter().enumerate() {
        let line = format!("identified a hinge, body {body}: {bits}");
        assert!(log.iter().any(|entry| entry.ends_with(&line)), "{line} is not in {log:#?}");
    }
    scene.capture(3, 115.0)?;
    scene.heard.clear();
    assert_eq!(scene.command(Opcode::Verify, 0)?.code, Reason::Fine);
    scene.wait_for_state(StateName::Review)?;
    let naming = scene.wait("name", |m| if let Message::CandidateNaming(naming) = m { Some(*naming) } else { None })?;
    scene.wait("whole report", |m| matches!(m, Message::Outcome(_)).then_some(()))?;
    scene.nonce += 1;
    let accepted = scene.ask(Request::naming(Opcode::Accept, scene.nonce, &naming))?;
    assert_eq!(accepted.code, Reason::Fine);
    scene.wait_for_state(StateName::Idle)?;
    let before = scene.live()?;
    assert_eq!(before.len(), 13);

    scene.restart()?;
    assert_eq!(scene.live()?, before);
    Ok(())
}
