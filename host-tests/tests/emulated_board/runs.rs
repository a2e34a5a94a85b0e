//! Runs of the procedure on the emulated board: many in a row, with clients that vanish, on a crowded bus.

use super::{PATIENCE, boot};
use glenoid::can::status::Answer;
use glenoid::can::{BaseId, Frame, Message, Opcode, Request};
use glenoid::procedure::{Reason, StateName};
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, Rig};
use host_tests::emulator::Emulator;
use host_tests::slcan_client::SlcanClient;
use host_tests::wearer::{Pose, Wearer, WearerSettings};
use libtest_mimic::Failed;
use std::io::Write;
use std::net::TcpStream;
use std::path::Path;
use std::time::{Duration, Instant};

/// Time between two samples of the encoders.
const PERIOD: Duration = Duration::from_millis(10);
/// Duration of a movement, ms: slow enough for the drive.
const MOVE_MS: u32 = 400;
/// Set this to a number to run as many calibrations in a row (100 take about eight minutes).
const RUNS_VARIABLE: &str = "GLENOID_RUNS";

/// Foreign frames that may be on their way to the board at once.
const MOST_UNDER_WAY: u64 = 200;

/// A board, the person at its arm, and a client on its bus.
struct Scene {
    board: Emulator,
    rig: TcpStream,
    can: SlcanClient,
    wearer: Wearer,
    at: Pose,
    clock: Instant,
    nonce: u16,
    /// Messages since the last [`Scene::ask`].
    heard: Vec<Message>,
    /// Foreign frames to send with every sample.
    crowd: u32,
    sent: u32,
}

impl Scene {
    fn new(image: &Path, seed: u64) -> Result<Self, Failed> {
        let board = boot(image)?;
        let rig = Rig::shoulder(ASSUMED_BASE_RADIUS_MM).map_err(|error| error.text())?;
        let wearer = Wearer::new(rig, WearerSettings { seed, noise_mm: 0.1, ..WearerSettings::default() });
        let mut scene = Self {
            rig: board.connect_rig()?,
            can: SlcanClient::open(board.can_address())?,
            at: wearer.home(),
            board,
            wearer,
            clock: Instant::now(),
            nonce: 0,
            heard: Vec::new(),
            crowd: 0,
            sent: 0,
        };
        scene.hold(Duration::from_millis(600))?;
        Ok(scene)
    }

    /// One sample of the encoders at its time; takes in what the board sends meanwhile.
    fn sample(&mut self, [c1, c2, c3, c4, c5, c6]: [i32; 6]) -> Result<(), Failed> {
        self.rig.write_all(format!("e {c1} {c2} {c3} {c4} {c5} {c6}\n").as_bytes())?;
        for _ in 0..self.crowd {
            // A host that runs the emulator slowly gets a thinner crowd, not an endless queue before each command.
            if u64::from(self.sent) >= self.can.acknowledged() + MOST_UNDER_WAY {
                break;
            }
            self.sent += 1;
            let [low, high, ..] = self.sent.to_le_bytes();
            self.can.send(&Frame::new(0x200 + u16::from(low), &[low, high, 3, 4, 5, 6, 7, 8])?)?;
        }
        self.clock = (self.clock + PERIOD).max(Instant::now());
        while let Some(left) = self.clock.checked_duration_since(Instant::now()) {
            if let Some(frame) = self.can.receive(left)? {
                self.heard.extend(Message::unpack(&frame, BaseId::DEFAULT));
            }
        }
        Ok(())
    }

    fn hold(&mut self, time: Duration) -> Result<(), Failed> {
        let until = Instant::now() + time;
        while Instant::now() < until {
            self.sample(self.at.counts)?;
        }
        Ok(())
    }

    /// Holds the arm still until one of the messages since the last command is the wanted one.
    fn wait<T>(&mut self, what: &str, wanted: impl Fn(&Message) -> Option<T>) -> Result<T, Failed> {
        let until = Instant::now() + PATIENCE;
        while Instant::now() < until {
            if let Some(found) = self.heard.iter().rev().find_map(&wanted) {
                return Ok(found);
            }
            self.sample(self.at.counts)?;
        }
        Err(format!("no {what}; the board's log ends with {:?}", self.board.log().last()).into())
    }

    /// Asks until there is an answer: on a crowded line it may be lost, and the nonce keeps the command from being
    /// obeyed twice.
    fn ask(&mut self, opcode: Opcode, run_id: u16, argument: u16) -> Result<Answer, Failed> {
        self.nonce += 1;
        let nonce = self.nonce;
        self.heard.clear();
        let frame = Request { opcode: opcode as u8, nonce, run_id, argument }.pack(BaseId::DEFAULT.command());
        let until = Instant::now() + PATIENCE;
        while Instant::now() < until {
            self.can.send(&frame)?;
            let again = Instant::now() + Duration::from_millis(300);
            while Instant::now() < again {
                self.sample(self.at.counts)?;
                let answer = self.heard.iter().find_map(|message| match message {
                    Message::Answer(answer) if answer.nonce == nonce => Some(*answer),
                    _ => None,
                });
                if let Some(answer) = answer {
                    return Ok(answer);
                }
            }
        }
        Err(format!("no answer to {opcode:?}; the board's log ends with {:?}", self.board.log().last()).into())
    }

    /// The client vanishes, and another one that knows nothing takes its place. The line has one end: the old client
    /// must have gone before the new one can be heard.
    fn with_a_new_client(self) -> Result<Self, Failed> {
        let Self { board, rig, can, wearer, at, clock, .. } = self;
        drop(can);
        let can = SlcanClient::open(board.can_address())?;
        Ok(Self { board, rig, can, wearer, at, clock, nonce: 1_000, heard: Vec::new(), crowd: 0, sent: 0 })
    }

    /// Asks again while the arm does not count as still yet.
    fn ask_when_still(&mut self, opcode: Opcode, argument: u16) -> Result<Answer, Failed> {
        loop {
            let answer = self.ask(opcode, 0, argument)?;
            if !matches!(answer.code, Reason::ArmMoving | Reason::CableLoose) {
                return Ok(answer);
            }
            self.hold(Duration::from_millis(50))?;
        }
    }

    fn capture(&mut self, poses: u32) -> Result<(), Failed> {
        let mut captured = 0;
        while captured < poses {
            let pose = self.wearer.next_pose();
            let way = self.wearer.motion(&self.at, &pose, MOVE_MS, PERIOD.as_millis() as u32);
            for counts in way {
                self.sample(counts)?;
            }
            self.at = pose;
            match self.ask_when_still(Opcode::Capture, 0)?.code {
                Reason::Fine => captured += 1,
                Reason::PoseTooNear => {}
                other => return Err(format!("{other:?}").into()),
            }
        }
        Ok(())
    }

    fn wait_for_state(&mut self, state: StateName) -> Result<(), Failed> {
        self.wait("state", |m| matches!(m, Message::Heartbeat(h) if h.state == state).then_some(()))
    }

    /// Starts a run and leads it to the review; returns its id.
    fn run_to_review(&mut self, poses: u32) -> Result<u16, Failed> {
        let answer = self.ask_when_still(Opcode::Start, 1)?;
        if answer.code != Reason::Fine {
            return Err(format!("{answer:?}").into());
        }
        self.capture(poses)?;
        self.ask(Opcode::Identify, 0, 0)?;
        self.wait_for_state(StateName::Verifying)?;
        self.capture(2)?;
        self.ask(Opcode::Verify, 0, 0)?;
        self.wait_for_state(StateName::Review)?;
        Ok(answer.run_id)
    }
}

/// Each calibration has its own run id, everything reported in it carries that id, and the centre is right.
pub fn calibrations_in_a_row(image: &Path) -> Result<(), Failed> {
    let runs = std::env::var(RUNS_VARIABLE).ok().and_then(|runs| runs.parse().ok()).unwrap_or(3);
    let mut scene = Scene::new(image, 21)?;
    let truth = scene.wearer.truth().centre_mm;
    for run in 1..=runs {
        let run_id = scene.run_to_review(6)?;
        assert_eq!(run_id, run);
        for axis in 0..3 {
            let candidate = scene.wait("candidate", |message| match message {
                Message::CandidateCentre(p) if p.index == axis => Some(*p),
                _ => None,
            })?;
            assert_eq!(candidate.run_id, run);
            let error_mm = f64::from(candidate.value_mm) - truth[usize::from(axis)];
            assert!(error_mm.abs() < 5.0 * f64::from(candidate.sigma_mm), "run {run}: {candidate:?}, truth {truth}");
        }
        let answer = scene.ask(Opcode::Accept, run_id, 0)?;
        assert_eq!((answer.code, answer.run_id), (Reason::Fine, run));
        let outcome = scene.wait("outcome", |message| match message {
            Message::Outcome(outcome) if outcome.reason != Reason::Fine => Some(*outcome),
            _ => None,
        })?;
        assert_eq!((outcome.run_id, outcome.reason, outcome.live), (run, Reason::Accepted, true));
        assert_eq!(scene.ask(Opcode::Acknowledge, run_id, 0)?.code, Reason::Fine);
    }
    Ok(())
}

/// The client vanishes in the middle of a run; another one comes, knows nothing, and is told where the run stands.
pub fn a_client_that_returns_is_told(image: &Path) -> Result<(), Failed> {
    let mut scene = Scene::new(image, 22)?;
    let run_id = scene.ask_when_still(Opcode::Start, 1)?.run_id;
    scene.capture(3)?;
    let mut scene = scene.with_a_new_client()?;
    let answer = scene.ask(Opcode::Query, 0, 0)?;
    assert_eq!((answer.run_id, answer.detail), (run_id, u16::from(StateName::Collecting.code())));
    let heartbeat = scene.wait("heartbeat", |m| if let Message::Heartbeat(h) = m { Some(*h) } else { None })?;
    assert_eq!((heartbeat.run_id, heartbeat.state, heartbeat.poses), (run_id, StateName::Collecting, 3));
    scene.capture(4)?;
    scene.ask(Opcode::Identify, run_id, 0)?;
    scene.wait_for_state(StateName::Verifying)
}

/// 2 000 foreign frames a second while a calibration runs: the calibration ends as it would, the frames are counted.
pub fn a_crowded_bus_changes_nothing_but_a_counter(image: &Path) -> Result<(), Failed> {
    let mut scene = Scene::new(image, 23)?;
    scene.crowd = 20;
    let began = Instant::now();
    scene.run_to_review(5)?;
    let seconds = began.elapsed().as_secs_f64();
    scene.crowd = 0;
    eprintln!("{:.0} foreign frames a second", f64::from(scene.sent) / seconds);
    assert!(scene.sent > 2_000, "only {} frames in {seconds} s", scene.sent);
    scene.ask(Opcode::Query, 0, 0)?;
    let counters = scene.wait("counters", |m| if let Message::Counters(c) = m { Some(*c) } else { None })?;
    assert_eq!((counters.foreign, counters.malformed), (scene.sent, 0));
    Ok(())
}
