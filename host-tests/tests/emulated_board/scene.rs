//! A board, the person at its arm, and a client on its bus.

use super::boot;
use glenoid::can::status::Answer;
use glenoid::can::{BaseId, Frame, Message, Opcode, Request};
use glenoid::procedure::{Reason, StateName};
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, Rig};
use host_tests::board_lines::BoardLines;
use host_tests::emulator::Emulator;
use host_tests::wearer::{Pose, Wearer, WearerSettings};
use libtest_mimic::Failed;
use std::path::Path;
use std::time::Duration;

/// Time between two samples of the encoders: in this many milliseconds the arm goes on by one, and the board takes it. All
/// times of a scene are so many samples, since a host under load stops the emulator for seconds.
const PERIOD_MS: u32 = 10;
/// Duration of a movement, ms: slow enough for the drive.
const MOVE_MS: u32 = 400;
/// Foreign frames that may be on their way at once.
const FRAMES_UNDER_WAY: u64 = 200;
/// Longest wait for anything that the board says or does, ms.
const PATIENCE_MS: u32 = 60_000;
/// Without an answer for so long a command is sent again, ms.
const REPEAT_MS: u32 = 300;
/// Pause before the board is asked again whether the arm is still, and how often it is asked, ms.
const RETRY_MS: u32 = 50;
const RETRIES: u32 = 200;

/// A board, the person at its arm, and a client on its bus.
pub struct Scene {
    pub board: Emulator,
    lines: BoardLines,
    pub wearer: Wearer,
    at: Pose,
    nonce: u16,
    /// Messages since the last [`Scene::ask`].
    pub heard: Vec<Message>,
    /// Foreign frames to send with every sample.
    pub crowd: u32,
    pub sent: u32,
}

impl Scene {
    pub fn new(image: &Path, seed: u64) -> Result<Self, Failed> {
        Self::on(boot(image)?, seed)
    }

    /// A scene on a board that runs already.
    pub fn on(board: Emulator, seed: u64) -> Result<Self, Failed> {
        let rig = Rig::shoulder(ASSUMED_BASE_RADIUS_MM).map_err(|error| error.text())?;
        let wearer = Wearer::new(rig, WearerSettings { seed, noise_mm: 0.1, ..WearerSettings::default() });
        let mut scene = Self {
            lines: BoardLines::connect(&board)?,
            at: wearer.home(),
            board,
            wearer,
            nonce: 0,
            heard: Vec::new(),
            crowd: 0,
            sent: 0,
        };
        scene.hold(600)?;
        Ok(scene)
    }

    /// One sample of the encoders at its time; takes in what the board sends meanwhile.
    pub fn sample(&mut self, counts: [i32; 6]) -> Result<(), Failed> {
        self.lines.sample(&counts)?;
        for _ in 0..self.crowd {
            // A host that runs the emulator slowly gets a thinner crowd, not an endless queue before each command.
            if self.lines.under_way() >= FRAMES_UNDER_WAY {
                break;
            }
            self.sent += 1;
            // Without data: the emulated UART takes byte after byte, about 20 000 a second, which is 2 000 of these
            // frames or 800 of eight bytes.
            let [low, ..] = self.sent.to_le_bytes();
            self.lines.send(&Frame::new(0x200 + u16::from(low), &[])?)?;
        }
        let granted = if self.crowd > 0 { FRAMES_UNDER_WAY } else { 0 };
        let frames = self.lines.pass(Duration::from_millis(PERIOD_MS.into()), granted)?;
        self.heard.extend(frames.iter().flat_map(|frame| Message::unpack(frame, BaseId::DEFAULT)));
        Ok(())
    }

    /// One encoder leaps, and stays where it leapt to.
    pub fn lose_a_count(&mut self) -> Result<(), Failed> {
        self.at.counts[2] += 30_000;
        self.hold(300)?;
        self.at.counts[2] -= 30_000;
        Ok(())
    }

    /// Holds the arm still.
    pub fn hold(&mut self, ms: u32) -> Result<(), Failed> {
        for _ in 0..ms / PERIOD_MS {
            self.sample(self.at.counts)?;
        }
        Ok(())
    }

    /// Holds the arm still until one of the messages since the last command is the wanted one.
    pub fn wait<T>(&mut self, what: &str, wanted: impl Fn(&Message) -> Option<T>) -> Result<T, Failed> {
        for _ in 0..PATIENCE_MS / PERIOD_MS {
            if let Some(found) = self.heard.iter().rev().find_map(&wanted) {
                return Ok(found);
            }
            self.sample(self.at.counts)?;
        }
        Err(format!("no {what}; the board's log ends with {:?}", self.board.log().last()).into())
    }

    /// Asks until there is an answer: on a crowded line it may be lost, and the nonce keeps the command from being
    /// obeyed twice.
    pub fn ask(&mut self, opcode: Opcode, run_id: u16, argument: u16) -> Result<Answer, Failed> {
        self.nonce += 1;
        self.ask_for(opcode, Request { opcode: opcode as u8, boot: 0, nonce: self.nonce, run_id, argument })
    }

    /// Accepts the new centre of a run, by the name under which it was shown.
    pub fn accept(&mut self, run_id: u16) -> Result<Answer, Failed> {
        let naming = self.wait("name of the new centre", |message| match message {
            Message::CandidateNaming(naming) if naming.run_id == run_id => Some(*naming),
            _ => None,
        })?;
        self.wait("whole report", |message| match message {
            Message::Outcome(outcome) if outcome.run_id == run_id => Some(()),
            _ => None,
        })?;
        self.nonce += 1;
        self.ask_for(Opcode::Accept, Request::naming(Opcode::Accept, self.nonce, &naming))
    }

    fn ask_for(&mut self, opcode: Opcode, request: Request) -> Result<Answer, Failed> {
        let nonce = request.nonce;
        self.heard.clear();
        let frame = request.pack(BaseId::DEFAULT.command());
        for _ in 0..PATIENCE_MS / REPEAT_MS {
            self.lines.send(&frame)?;
            for _ in 0..REPEAT_MS / PERIOD_MS {
                self.sample(self.at.counts)?;
                let answer = self.heard.iter().find_map(|message| match message {
                    Message::Answer(answer) if (answer.nonce, answer.opcode) == (nonce, opcode as u8) => Some(*answer),
                    _ => None,
                });
                if let Some(answer) = answer {
                    return Ok(answer);
                }
            }
        }
        Err(format!("no answer to {opcode:?}; the board's log ends with {:?}", self.board.log().last()).into())
    }

    /// The client vanishes, and another one that knows nothing takes its place.
    pub fn with_a_new_client(self) -> Result<Self, Failed> {
        let lines = self.lines.with_a_new_client(&self.board)?;
        Ok(Self { lines, nonce: 1_000, heard: Vec::new(), crowd: 0, sent: 0, ..self })
    }

    /// Gives a command without waiting for its answer.
    pub fn tell(&mut self, opcode: Opcode) -> Result<(), Failed> {
        self.nonce += 1;
        let request = Request { opcode: opcode as u8, boot: 0, nonce: self.nonce, run_id: 0, argument: 0 };
        Ok(self.lines.send(&request.pack(BaseId::DEFAULT.command()))?)
    }

    /// Asks again while the arm does not count as still yet.
    pub fn ask_when_still(&mut self, opcode: Opcode, argument: u16) -> Result<Answer, Failed> {
        for _ in 0..RETRIES {
            let answer = self.ask(opcode, 0, argument)?;
            // a busy host may have sent no counts for a while
            if !matches!(answer.code, Reason::ArmMoving | Reason::CableLoose | Reason::EncoderSilent) {
                return Ok(answer);
            }
            self.hold(RETRY_MS)?;
        }
        Err("the arm never counts as still".into())
    }

    pub fn capture(&mut self, poses: u32) -> Result<(), Failed> {
        let mut captured = 0;
        while captured < poses {
            let pose = self.wearer.next_pose();
            let way = self.wearer.motion(&self.at, &pose, MOVE_MS, PERIOD_MS);
            for counts in way {
                self.sample(counts)?;
            }
            self.at = pose;
            match self.ask_when_still(Opcode::Capture, 0)?.code {
                Reason::Fine => captured += 1,
                Reason::PoseTooNear => {}
                other => {
                    let states: Vec<String> =
                        self.board.log().into_iter().filter(|line| line.contains(" to: ")).collect();
                    return Err(format!("{other:?}; the board's states: {states:?}").into());
                }
            }
        }
        Ok(())
    }

    pub fn wait_for_state(&mut self, state: StateName) -> Result<(), Failed> {
        self.wait("state", |m| matches!(m, Message::Heartbeat(h) if h.state == state).then_some(()))
    }

    /// Starts a run and leads it to the review; returns its id.
    pub fn run_to_review(&mut self, poses: u32) -> Result<u16, Failed> {
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

/// The last report on query among what was heard. A report begins with the versions; a query begins one that is under way
/// anew, and what was sent of it before counts no more.
pub fn last_report(heard: &[Message]) -> &[Message] {
    let begins = heard.iter().rposition(|message| matches!(message, Message::Versions(_))).unwrap_or(0);
    heard.get(begins..).unwrap_or_default()
}
