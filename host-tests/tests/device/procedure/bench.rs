//! A wearer, a client and a device in one process: time is counted, nothing is random but the wearer.

use glenoid::can::identity::Naming;
use glenoid::can::status::{Answer, Heartbeat};
use glenoid::can::{BaseId, Frame, Message, Opcode, Operation, ParameterAnswer, ParameterRequest, Request};
use glenoid::device::{Action, BlinkPattern, Config, Device, Event, LogEntry, MAX_FRAMES};
use glenoid::parameters::ParameterSet;
use glenoid::procedure::{Limits, Procedure, Reason, Settings, StateName};
use glenoid::record::{JournalEntry, LoadError, Loaded, Record, StoreError};
use glenoid::restart::{ResetCause, Restart};
use glenoid::rig::{Drum, Parameters, Rig};
use host_tests::wearer::{Pose, Wearer, WearerSettings};

/// Time between two samples of the encoders, ms.
pub const SAMPLE_MS: u32 = 10;

/// Most ticks of a millisecond: so many slices of 10 000 cycles fit into it.
const TICKS_A_MILLISECOND: usize = 16;

pub struct Bench {
    pub device: Device,
    pub wearer: Wearer,
    pub now_ms: u32,
    pub at: Pose,
    /// Cables whose encoder no longer counts.
    pub frozen: Option<usize>,
    /// The cable that each encoder counts.
    pub wiring: [usize; 6],
    /// No samples come.
    pub silent: bool,
    pub messages: Vec<Message>,
    pub led_patterns: Vec<BlinkPattern>,
    pub logs: Vec<LogEntry>,
    /// Records that the device wanted stored.
    pub records: Vec<Record>,
    counts: [i32; 6],
    nonce: u16,
    /// The last one among the messages that were taken.
    heartbeat: Option<Message>,
    naming: Option<Naming>,
    /// What the device has had noted.
    pub journal: Vec<JournalEntry>,
    /// Parameters that the device wanted stored.
    pub sets: Vec<ParameterSet>,
    /// How often the device wanted the record erased.
    pub erased: u32,
    /// The device has asked to be started anew.
    pub stopped: Option<ResetCause>,
}

impl Bench {
    /// A device with default limits, and a wearer whose cables are wrong by up to the paper's 0.1 mm.
    pub fn new(seed: u64) -> Self {
        Self::with(Settings::default(), WearerSettings { seed, noise_mm: 0.1, ..WearerSettings::default() })
    }

    /// The same with a clock that begins elsewhere.
    pub fn starting_at(seed: u64, now_ms: u32) -> Self {
        let wearer = WearerSettings { seed, noise_mm: 0.1, ..WearerSettings::default() };
        Self::at(now_ms, Settings::default(), wearer)
    }

    pub fn with(settings: Settings, wearer: WearerSettings) -> Self {
        Self::at(0, settings, wearer)
    }

    fn at(now_ms: u32, settings: Settings, wearer: WearerSettings) -> Self {
        let rig = Rig::shoulder(150.0).unwrap();
        let config = Config { limits: Limits::new(&rig, settings).unwrap(), ..Config::for_rig(rig) };
        Self::on(now_ms, config, Rig::shoulder(150.0).unwrap(), wearer)
    }

    /// A device of another kind, with a wearer in its machine.
    pub fn of(config: Config, wearer: WearerSettings) -> Self {
        let (rig, wide) = (config.rig.ball().unwrap(), |mm: &f32| f64::from(*mm));
        let drum = Drum {
            radius_mm: rig.drum().radius_mm.into(),
            counts_per_turn: rig.drum().counts_per_turn.into(),
            home_length_mm: rig.drum().home_length_mm.each_ref().map(wide),
            fastest_mm_per_s: rig.drum().fastest_mm_per_s.into(),
        };
        let nominal = Parameters::from_array(rig.nominal().to_array().each_ref().map(wide));
        let base_mm = rig.base_mm().map(|point| point.cast());
        let edges_mm = rig.edges_mm().each_ref().map(wide);
        let rig = Rig::new(base_mm, edges_mm, drum, rig.length_noise_mm().into(), nominal).unwrap();
        Self::on(0, config, rig, wearer)
    }

    fn on(now_ms: u32, config: Config, rig: Rig<f64>, wearer: WearerSettings) -> Self {
        let wearer = Wearer::new(rig, wearer);
        let at = wearer.home();
        let mut bench = Self {
            device: Device::new(&config),
            now_ms,
            counts: at.counts,
            at,
            wearer,
            frozen: None,
            wiring: [0, 1, 2, 3, 4, 5],
            silent: false,
            messages: Vec::new(),
            led_patterns: Vec::new(),
            logs: Vec::new(),
            records: Vec::new(),
            nonce: 0,
            heartbeat: None,
            naming: None,
            journal: Vec::new(),
            sets: Vec::new(),
            erased: 0,
            stopped: None,
        };
        // long enough for the arm to count as still
        bench.pass(600);
        bench
    }

    pub fn event(&mut self, event: Event) {
        let Self {
            device, now_ms, messages, led_patterns, logs, records, naming, journal, sets, erased, stopped, ..
        } = self;
        let mut frames = 0;
        device.handle(*now_ms, event, &mut |action| match action {
            Action::Send(frame) => {
                frames += 1;
                let message = Message::unpack(&frame, BaseId::DEFAULT).unwrap();
                if let Message::CandidateNaming(shown) = message {
                    *naming = Some(shown);
                }
                messages.push(message);
            }
            Action::StoreParameters(set) => sets.push(set),
            Action::EraseRecord => *erased += 1,
            Action::Journal(entry) => journal.push(entry),
            Action::StatusLed(pattern) => led_patterns.push(pattern),
            Action::Store(record) => records.push(*record.ball().unwrap()),
            Action::Stop(ResetCause::Requested) => *stopped = Some(ResetCause::Requested),
            Action::Stop(cause) => panic!("the device asks for a restart: {cause:?}"),
            Action::Log(entry) => logs.push(entry),
        });
        assert!(frames <= MAX_FRAMES, "{frames} frames after {event:?}");
    }

    /// Time passes with the arm where it is: a tick a millisecond, and more while there is something to compute; a sample
    /// every [`SAMPLE_MS`].
    pub fn pass(&mut self, ms: u32) {
        for _ in 0..ms {
            self.now_ms = self.now_ms.wrapping_add(1);
            if self.now_ms.is_multiple_of(SAMPLE_MS) && !self.silent {
                self.event(Event::Counts(self.wiring.map(|cable| self.counts[cable])));
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

    /// Passes the time until the device leaves a state, half a minute at most.
    pub fn pass_while(&mut self, state: StateName) {
        for _ in 0..300 {
            if self.state() != state {
                return;
            }
            self.pass(100);
        }
        panic!("still {state:?}");
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

    /// Moves the encoders to other counts in 600 ms, in a straight line.
    pub fn glide_to(&mut self, counts: [i32; 6]) {
        let from = self.counts;
        for step in 1..=60 {
            let between = |k: usize| from[k] + (counts[k] - from[k]) * step / 60;
            self.set_counts(std::array::from_fn(between));
            self.pass(SAMPLE_MS);
        }
    }

    /// Presses the button while the arm moves to a pose and back all the time.
    pub fn press_while_moving(&mut self, pose: Pose, ms: u32) {
        let there = self.wearer.motion(&self.at, &pose, 600, SAMPLE_MS);
        self.event(Event::Button { down: true });
        let until = self.now_ms + ms;
        for counts in there.iter().chain(there.iter().rev()).cycle() {
            self.set_counts(*counts);
            self.pass(SAMPLE_MS);
            if self.now_ms >= until {
                break;
            }
        }
        self.event(Event::Button { down: false });
        self.pass(100);
    }

    /// A wearer who only ever turns the arm about its own length.
    pub fn turning_only(seed: u64) -> Self {
        let wearer = WearerSettings { seed, tilt_rad: 0.0, torsion_rad: 0.7, noise_mm: 0.1, ..Default::default() };
        Self::with(Settings { nearest_pose_rad: 0.03, ..Settings::default() }, wearer)
    }

    /// The board is switched off and on; the record is what it finds. Everything said before is forgotten.
    pub fn restart(&mut self, restart: Restart, loaded: Result<Record, LoadError>) {
        let config = Config { restart, ..Config::for_rig(Rig::shoulder(150.0).unwrap()) };
        self.device = Device::new(&config);
        self.heartbeat = None;
        self.messages.clear();
        self.logs.clear();
        let journal = self.journal.last().copied();
        self.event(Event::PowerUp(Loaded { journal, ..loaded.into() }));
        self.pass(600);
    }

    /// The same situation once more.
    pub fn fork(&self) -> Self {
        Self {
            device: self.device.clone(),
            wearer: self.wearer.clone(),
            at: self.at,
            messages: self.messages.clone(),
            led_patterns: self.led_patterns.clone(),
            logs: self.logs.clone(),
            records: self.records.clone(),
            journal: self.journal.clone(),
            sets: self.sets.clone(),
            ..*self
        }
    }

    /// Moves the arm to a random pose and holds it long enough to be still.
    pub fn next_pose(&mut self) {
        let pose = self.wearer.next_pose();
        self.move_to(pose);
        self.pass(500);
    }

    pub fn request(&mut self, opcode: u8, run_id: u16, argument: u16) -> Answer {
        self.nonce = self.nonce.wrapping_add(1).max(1);
        let request = Request { opcode, boot: 0, nonce: self.nonce, run_id, argument };
        self.raw(request.pack(BaseId::DEFAULT.command()))
    }

    /// Sends a frame and returns the answer to it.
    pub fn raw(&mut self, frame: Frame) -> Answer {
        let before = self.messages.len();
        self.event(Event::Can(frame));
        // A capture is answered when the pose has been looked at, some ticks later.
        for _ in 0..TICKS_A_MILLISECOND {
            if self.answers(before).is_empty() {
                self.event(Event::Tick);
            }
        }
        let answers = self.answers(before);
        assert_eq!(answers.len(), 1, "exactly one answer to {frame:?}");
        answers[0]
    }

    fn answers(&self, before: usize) -> Vec<Answer> {
        let answers = self.messages[before..].iter();
        answers.filter_map(|message| if let Message::Answer(answer) = message { Some(*answer) } else { None }).collect()
    }

    /// Sends a request about parameters and returns its answer.
    pub fn parameter(&mut self, request: ParameterRequest) -> ParameterAnswer {
        let before = self.messages.len();
        self.event(Event::Can(request.pack(BaseId::DEFAULT.parameters())));
        self.parameter_answer(before).expect("an answer")
    }

    /// Saves the prepared parameters; the board's store ends so. None when the device does not answer.
    pub fn save_parameters(&mut self, result: Result<(), StoreError>) -> Option<ParameterAnswer> {
        let before = self.messages.len();
        let request = ParameterRequest { operation: Operation::Save as u8, index: 0, nonce: 1, value: 0 };
        self.event(Event::Can(request.pack(BaseId::DEFAULT.parameters())));
        assert_eq!(self.parameter_answer(before), None, "it is answered when the board has stored");
        self.event(Event::ParametersStored(result));
        self.parameter_answer(before)
    }

    fn parameter_answer(&self, from: usize) -> Option<ParameterAnswer> {
        self.messages[from..].iter().find_map(|m| if let Message::Parameter(a) = m { Some(*a) } else { None })
    }

    pub fn command(&mut self, opcode: Opcode) -> Answer {
        self.request(opcode as u8, 0, 0)
    }

    /// A command that names the run.
    pub fn decide(&mut self, opcode: Opcode) -> Answer {
        if opcode == Opcode::Accept && self.state() == StateName::Review {
            return self.accept();
        }
        self.request(opcode as u8, self.device.procedure().run_id(), 0)
    }

    /// Accepts the new centre by the name under which it was shown; the next tick stores it.
    pub fn accept(&mut self) -> Answer {
        let naming = self.naming().expect("the new centre was not named");
        self.nonce = self.nonce.wrapping_add(1).max(1);
        let answer = self.raw(Request::naming(Opcode::Accept, self.nonce, &naming).pack(BaseId::DEFAULT.command()));
        self.event(Event::Tick);
        answer
    }

    /// What the last report named the new centre.
    pub fn naming(&self) -> Option<Naming> {
        self.naming
    }

    pub fn procedure(&self) -> &Procedure {
        self.device.procedure().ball().unwrap()
    }

    pub fn state(&self) -> StateName {
        self.procedure().state()
    }

    /// Captures `poses` random poses by command.
    pub fn capture(&mut self, poses: usize) {
        let mut captured = 0;
        while captured < poses {
            self.next_pose();
            match self.command(Opcode::Capture).code {
                Reason::Fine => captured += 1,
                Reason::PoseTooNear => {}
                other => panic!("{other:?}"),
            }
        }
    }

    /// Starts a run by commands and leads it to a state.
    pub fn lead_to(&mut self, state: StateName) {
        if state == StateName::Idle {
            return;
        }
        assert_eq!(self.request(Opcode::Start as u8, 0, 1).code, Reason::Fine);
        if state == StateName::Collecting {
            return;
        }
        if state == StateName::Failed {
            // nobody captures a pose
            self.pass(Settings::default().collecting_timeout_ms + 1);
            return;
        }
        self.capture(12);
        assert_eq!(self.command(Opcode::Identify).code, Reason::Fine);
        if state == StateName::Identifying {
            return;
        }
        self.pass(300);
        if state == StateName::Verifying {
            return;
        }
        self.capture(3);
        assert_eq!(self.command(Opcode::Verify).code, Reason::Fine);
        // the report of the new centre must be whole before it can be accepted
        self.pass(100);
    }

    /// The messages since the last call.
    pub fn take_messages(&mut self) -> Vec<Message> {
        if let Some(last) = self.messages.iter().rev().find(|m| matches!(m, Message::Heartbeat(_))) {
            self.heartbeat = Some(*last);
        }
        std::mem::take(&mut self.messages)
    }

    pub fn press(&mut self, ms: u32) {
        self.event(Event::Button { down: true });
        self.pass(ms);
        self.event(Event::Button { down: false });
        self.pass(100);
    }

    /// The latest heartbeat.
    pub fn heartbeat(&self) -> Heartbeat {
        let heartbeats = self.heartbeat.iter().chain(&self.messages);
        heartbeats.rev().find_map(|m| if let Message::Heartbeat(h) = m { Some(*h) } else { None }).unwrap()
    }
}
