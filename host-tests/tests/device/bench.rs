//! A wearer, a client and a device in one process: time is counted, nothing is random but the wearer.

use glenoid::can::status::{Answer, Heartbeat};
use glenoid::can::{BaseId, Frame, Message, Opcode, Request};
use glenoid::device::{Action, Config, Device, Event, LampPattern, LogEntry, MOST_FRAMES};
use glenoid::rig::Rig;
use host_tests::wearer::{Pose, Wearer, WearerSettings};

/// Time between two samples of the encoders, ms.
pub const SAMPLE_MS: u32 = 10;

pub struct Bench {
    pub device: Device,
    pub wearer: Wearer,
    pub now_ms: u32,
    pub at: Pose,
    /// Cables whose encoder no longer counts.
    pub frozen: Option<usize>,
    /// No samples come.
    pub silent: bool,
    pub messages: Vec<Message>,
    pub lamps: Vec<LampPattern>,
    pub logs: Vec<LogEntry>,
    counts: [i32; 6],
    nonce: u16,
}

impl Bench {
    pub fn new(settings: WearerSettings) -> Self {
        let config = Config::for_rig(Rig::shoulder(150.0).unwrap());
        Self::with(config, Wearer::new(Rig::shoulder(150.0).unwrap(), settings))
    }

    pub fn with(config: Config, wearer: Wearer) -> Self {
        let at = wearer.home();
        let mut bench = Self {
            device: Device::new(config),
            now_ms: 0,
            counts: at.counts,
            at,
            wearer,
            frozen: None,
            silent: false,
            messages: Vec::new(),
            lamps: Vec::new(),
            logs: Vec::new(),
            nonce: 0,
        };
        // long enough for the arm to count as still
        bench.pass(600);
        bench
    }

    pub fn event(&mut self, event: Event) {
        let Self { device, now_ms, messages, lamps, logs, .. } = self;
        let mut frames = 0;
        device.handle(*now_ms, event, &mut |action| match action {
            Action::Send(frame) => {
                frames += 1;
                messages.push(Message::unpack(&frame, BaseId::DEFAULT).unwrap());
            }
            Action::Lamp(pattern) => lamps.push(pattern),
            Action::Log(entry) => logs.push(entry),
        });
        assert!(frames <= MOST_FRAMES, "{frames} frames after {event:?}");
    }

    /// Time passes with the arm where it is: a tick a millisecond, a sample every [`SAMPLE_MS`].
    pub fn pass(&mut self, ms: u32) {
        for _ in 0..ms {
            self.now_ms = self.now_ms.wrapping_add(1);
            if self.now_ms % SAMPLE_MS == 0 && !self.silent {
                self.event(Event::Counts(self.counts));
            }
            self.event(Event::Tick);
        }
    }

    pub fn set_counts(&mut self, counts: [i32; 6]) {
        for (index, (now, new)) in self.counts.iter_mut().zip(counts).enumerate() {
            if self.frozen != Some(index) {
                *now = new;
            }
        }
    }

    /// Moves the arm to a pose in 600 ms, without holding it there.
    pub fn move_to(&mut self, pose: Pose) {
        for counts in self.wearer.motion(&self.at, &pose, 600, SAMPLE_MS) {
            self.set_counts(counts);
            self.pass(SAMPLE_MS);
        }
        self.at = pose;
    }

    /// Moves the arm to a random pose and holds it long enough to be still.
    pub fn next_pose(&mut self) {
        let pose = self.wearer.next_pose();
        self.move_to(pose);
        self.pass(500);
    }

    pub fn request(&mut self, opcode: u8, run_id: u16, argument: u16) -> Answer {
        self.nonce = self.nonce.wrapping_add(1).max(1);
        let request = Request { opcode, nonce: self.nonce, run_id, argument };
        self.raw(request.pack(BaseId::DEFAULT.command()))
    }

    /// Sends a frame and returns the answer to it.
    pub fn raw(&mut self, frame: Frame) -> Answer {
        let before = self.messages.len();
        self.event(Event::Can(frame));
        let answers: Vec<Answer> = self.messages[before..]
            .iter()
            .filter_map(|m| if let Message::Answer(a) = m { Some(*a) } else { None })
            .collect();
        assert_eq!(answers.len(), 1, "exactly one answer to {frame:?}");
        answers[0]
    }

    pub fn command(&mut self, opcode: Opcode) -> Answer {
        self.request(opcode as u8, 0, 0)
    }

    /// A command that names the run.
    pub fn decide(&mut self, opcode: Opcode) -> Answer {
        self.request(opcode as u8, self.device.procedure().run_id(), 0)
    }

    pub fn press(&mut self, ms: u32) {
        self.event(Event::Button { down: true });
        self.pass(ms);
        self.event(Event::Button { down: false });
        self.pass(100);
    }

    pub fn heartbeat(&self) -> Heartbeat {
        self.messages.iter().rev().find_map(|m| if let Message::Heartbeat(h) = m { Some(*h) } else { None }).unwrap()
    }
}
