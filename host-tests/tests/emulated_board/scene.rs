//! A board, the person at its arm, and a client on its bus.

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
/// Bytes that may be on their way to the board at once, about three samples. A host under load stops the emulator for
/// seconds. All samples of that time would wait in the line then, and the board would get them within a few milliseconds
/// each: an arm in motion would be an encoder that leaps, and the run would end.
const BYTES_UNDER_WAY: u64 = 120;
/// Foreign frames that may be on their way beside them.
const FRAMES_UNDER_WAY: u64 = 200;
/// After so long without an answer the board has been reset, and has forgotten what it was asked.
const FORGOTTEN: Duration = Duration::from_secs(3);

/// A board, the person at its arm, and a client on its bus.
pub struct Scene {
    pub board: Emulator,
    rig: TcpStream,
    can: SlcanClient,
    pub wearer: Wearer,
    at: Pose,
    clock: Instant,
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
    pub fn sample(&mut self, [c1, c2, c3, c4, c5, c6]: [i32; 6]) -> Result<(), Failed> {
        self.wait_for_the_board()?;
        let line = format!("e {c1} {c2} {c3} {c4} {c5} {c6}\n");
        self.rig.write_all(line.as_bytes())?;
        // As many bytes on the line that answers: the emulator takes both lines byte by byte.
        self.can.ping(line.len())?;
        for _ in 0..self.crowd {
            // A host that runs the emulator slowly gets a thinner crowd, not an endless queue before each command.
            if self.can.under_way() >= BYTES_UNDER_WAY + FRAMES_UNDER_WAY {
                break;
            }
            self.sent += 1;
            // Without data: the emulated UART takes byte after byte, about 20 000 a second, which is 2 000 of these
            // frames or 800 of eight bytes.
            let [low, ..] = self.sent.to_le_bytes();
            self.can.send(&Frame::new(0x200 + u16::from(low), &[])?)?;
        }
        self.clock = (self.clock + PERIOD).max(Instant::now());
        while let Some(left) = self.clock.checked_duration_since(Instant::now()) {
            if let Some(frame) = self.can.receive(left)? {
                self.heard.extend(Message::unpack(&frame, BaseId::DEFAULT));
            }
        }
        Ok(())
    }

    /// The machine goes no faster than the board that looks at it: waits while too much is on its way.
    fn wait_for_the_board(&mut self) -> Result<(), Failed> {
        let most = BYTES_UNDER_WAY + if self.crowd > 0 { FRAMES_UNDER_WAY } else { 0 };
        let until = Instant::now() + FORGOTTEN;
        while self.can.under_way() >= most {
            if let Some(frame) = self.can.receive(Duration::from_millis(1))? {
                self.heard.extend(Message::unpack(&frame, BaseId::DEFAULT));
            }
            if Instant::now() >= until {
                self.can.forget_under_way();
            }
        }
        Ok(())
    }

    /// One encoder leaps, and stays where it leapt to.
    pub fn lose_a_count(&mut self) -> Result<(), Failed> {
        self.at.counts[2] += 30_000;
        self.hold(Duration::from_millis(300))?;
        self.at.counts[2] -= 30_000;
        Ok(())
    }

    pub fn hold(&mut self, time: Duration) -> Result<(), Failed> {
        let until = Instant::now() + time;
        while Instant::now() < until {
            self.sample(self.at.counts)?;
        }
        Ok(())
    }

    /// Holds the arm still until one of the messages since the last command is the wanted one.
    pub fn wait<T>(&mut self, what: &str, wanted: impl Fn(&Message) -> Option<T>) -> Result<T, Failed> {
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
        let until = Instant::now() + PATIENCE;
        while Instant::now() < until {
            self.can.send(&frame)?;
            let again = Instant::now() + Duration::from_millis(300);
            while Instant::now() < again {
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

    /// The client vanishes, and another one that knows nothing takes its place. The line has one end: the old client
    /// must have gone before the new one can be heard.
    pub fn with_a_new_client(self) -> Result<Self, Failed> {
        let Self { board, rig, can, wearer, at, clock, .. } = self;
        drop(can);
        let can = SlcanClient::open(board.can_address())?;
        Ok(Self { board, rig, can, wearer, at, clock, nonce: 1_000, heard: Vec::new(), crowd: 0, sent: 0 })
    }

    /// Gives a command without waiting for its answer.
    pub fn tell(&mut self, opcode: Opcode) -> Result<(), Failed> {
        self.nonce += 1;
        let request = Request { opcode: opcode as u8, boot: 0, nonce: self.nonce, run_id: 0, argument: 0 };
        Ok(self.can.send(&request.pack(BaseId::DEFAULT.command()))?)
    }

    /// Asks again while the arm does not count as still yet.
    pub fn ask_when_still(&mut self, opcode: Opcode, argument: u16) -> Result<Answer, Failed> {
        loop {
            let answer = self.ask(opcode, 0, argument)?;
            // a busy host may have sent no counts for a while
            if !matches!(answer.code, Reason::ArmMoving | Reason::CableLoose | Reason::EncoderSilent) {
                return Ok(answer);
            }
            self.hold(Duration::from_millis(50))?;
        }
    }

    pub fn capture(&mut self, poses: u32) -> Result<(), Failed> {
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
