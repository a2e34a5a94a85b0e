//! Random event sequences: whatever comes in, the device keeps its promises.
//!
//! * it never panics and never sends more frames an event than it says;
//! * it changes its state only along the table's transitions;
//! * the centre in use is never another one than that whose checksum was accepted: by a command that names boot, run and
//!   checksum of a value that was shown, or by the presses that the LED asked for; over restarts too;
//! * an abort always leads back to idle.
//!
//! Each sequence follows from its number alone. A sequence mixes sense and nonsense: held poses, so that runs get
//! somewhere, and garbage at every layer, jumps of the clock among it. The limits are short so that a sequence that
//! makes sense reaches every state within some hundred events.

use glenoid::can::identity::Naming;
use glenoid::can::{BaseId, Frame, Message, Opcode, Request};
use glenoid::device::{Action, Config, Device, Event, MAX_FRAMES};
use glenoid::procedure::transition::next;
use glenoid::procedure::{Limits, Settings, StateName, Trigger};
use glenoid::record::{JournalEntry, LoadError, Loaded, Record};
use glenoid::rig::{Parameters, Rig};
use host_tests::wearer::{Wearer, WearerSettings};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Steps in one sequence.
const STEPS: usize = 40;

fn settings() -> Settings {
    Settings {
        hold_ms: 20,
        min_samples: 2,
        // poses are far apart in time here, not in space
        sample_jitter_ms: 2_000,
        enough_poses: 4,
        enough_poses_with_zeros: 4,
        target_sigma_mm: 0.5,
        verification_poses: 1,
        verification_deviation_mm: 5.0,
        max_attempts: 2,
        collecting_timeout_ms: 20_000,
        verifying_timeout_ms: 20_000,
        review_timeout_ms: 20_000,
        ..Settings::default()
    }
}

struct World {
    device: Device,
    random: ChaCha8Rng,
    now_ms: u32,
    /// Changes of state that were seen.
    changes: BTreeSet<(StateName, StateName)>,
    accepted: u32,
    /// A device at power-up, for restarts.
    new: Device,
    /// The accept that is being given: the value that it names, or a press that may complete one.
    accepting: Accepting,
    /// Values as they were shown on the bus, by what names them.
    shown: Vec<(Naming, [f32; 6])>,
    /// The value that was accepted last.
    chosen: Option<[f32; 6]>,
    record: Option<Record>,
    journal: Option<JournalEntry>,
    /// Coordinates and radii of the value that is being shown.
    showing: [f32; 6],
    restarts: u32,
}

/// By what the centre in use may change in the event at hand.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Accepting {
    Nothing,
    Command(Naming),
    Press,
}

impl World {
    fn new(device: &Device, number: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(number);
        // every fourth sequence sees the clock wrap
        let now_ms = if random.random_ratio(1, 4) { u32::MAX - random.random_range(0..5_000) } else { 0 };
        Self {
            device: device.clone(),
            random,
            now_ms,
            changes: BTreeSet::new(),
            accepted: 0,
            new: device.clone(),
            accepting: Accepting::Nothing,
            shown: Vec::new(),
            chosen: None,
            record: None,
            journal: None,
            showing: [0.0; 6],
            restarts: 0,
        }
    }

    fn event(&mut self, event: Event) {
        let before = self.device.procedure().state();
        let value = |device: &Device| device.procedure().live().map(|live| live.identified.parameters.to_array());
        let live = value(&self.device);
        let mut frames = 0;
        let Self { device, record, journal, shown, showing, .. } = self;
        device.handle(self.now_ms, event, &mut |action| match action {
            Action::Send(frame) => {
                frames += 1;
                match Message::unpack(&frame, BaseId::DEFAULT).unwrap() {
                    Message::CandidateCentre(p) => showing[usize::from(p.index)] = p.value_mm,
                    Message::CandidateRadius(p) => showing[usize::from(p.index) + 3] = p.value_mm,
                    Message::CandidateNaming(naming) => shown.push((naming, *showing)),
                    _ => {}
                }
            }
            Action::Store(stored) => *record = Some(stored),
            Action::Journal(entry) => *journal = Some(entry),
            _ => {}
        });
        assert!(frames <= MAX_FRAMES, "{frames} frames after {event:?}");

        let after = self.device.procedure().state();
        let reachable = |from: StateName| Trigger::ALL.into_iter().filter_map(move |trigger| next(from, trigger));
        // one event may be a press and a slice of work in one
        let legal = before == after
            || reachable(before).any(|to| to == after)
            || reachable(before).flat_map(reachable).any(|to| to == after);
        assert!(legal, "{before:?} to {after:?} by {event:?}");
        if before != after {
            self.changes.insert((before, after));
        }

        let live_now = value(&self.device);
        if live_now != live {
            assert_eq!((before, after), (StateName::Review, StateName::Idle), "{event:?}");
            let live_now = live_now.expect("a centre in use never vanishes");
            // as it was shown: each field of the bus has its step
            let is_shown = |shown: &[f32; 6]| shown.iter().zip(&live_now).all(|(s, l)| (s - l).abs() <= 1e-5);
            match self.accepting {
                Accepting::Nothing => panic!("{event:?} put a centre in use"),
                Accepting::Command(naming) => {
                    let named = self.shown.iter().rev().find(|(shown, _)| *shown == naming);
                    assert!(named.is_some_and(|(_, value)| is_shown(value)), "{naming:?} was not that value");
                }
                Accepting::Press => {
                    assert!(self.shown.last().is_some_and(|(_, value)| is_shown(value)), "pressed for another value");
                }
            }
            self.accepted += 1;
            self.chosen = Some(live_now);
        }
        assert_eq!(live_now, self.chosen, "{event:?}");
    }

    /// The board is switched off and on. What is in use afterwards was accepted before.
    fn restart(&mut self) {
        self.restarts += 1;
        self.device = self.new.clone();
        let record = self.record.ok_or(LoadError::Nothing);
        // the value does not change by it
        self.chosen = self.record.map(|record: Record| Parameters::to_array(record.parameters));
        let loaded = Loaded { record, journal: self.journal, parameters: None };
        let (accepting, before) = (self.accepting, self.chosen);
        self.device.handle(self.now_ms, Event::PowerUp(loaded), &mut |action| {
            if let Action::Journal(entry) = action {
                self.journal = Some(entry);
            }
        });
        assert_eq!(self.device.procedure().live().map(|live| live.identified.parameters.to_array()), before);
        self.accepting = accepting;
    }

    /// A client accepts: what was shown last, what was shown some time ago, or something that never was.
    fn accept(&mut self) {
        let naming = match self.random.random_range(0..4) {
            0 | 1 => self.shown.last().map(|(naming, _)| *naming),
            2 if !self.shown.is_empty() => Some(self.shown[self.random.random_range(0..self.shown.len())].0),
            _ => None,
        };
        let run_id = self.device.procedure().run_id();
        let naming = naming.unwrap_or(Naming {
            run_id,
            boot: self.device.procedure().boot(),
            wearer: 0,
            checksum: self.random.random(),
        });
        self.accepting = Accepting::Command(naming);
        let nonce = self.random.random_range(0..4);
        self.event(Event::Can(Request::naming(Opcode::Accept, nonce, &naming).pack(BaseId::DEFAULT.command())));
        self.accepting = Accepting::Nothing;
    }

    /// Presses the button some times, then long.
    fn press_often(&mut self) {
        for _ in 0..self.random.random_range(0..6) {
            self.press(200);
        }
        self.press(1_500);
    }

    fn pass(&mut self, ms: u32) {
        for _ in 0..ms.div_ceil(10) {
            self.now_ms = self.now_ms.wrapping_add(10);
            self.event(Event::Tick);
        }
    }

    fn hold(&mut self, counts: &[i32; 6]) {
        for _ in 0..5 {
            self.now_ms = self.now_ms.wrapping_add(10);
            self.event(Event::Counts(*counts));
            self.event(Event::Tick);
        }
        while self.device.is_busy() {
            self.event(Event::Tick);
        }
    }

    fn command(&mut self, opcode: u8, run_id: u16, argument: u16) {
        let request = Request { opcode, boot: 0, nonce: self.random.random(), run_id, argument };
        self.event(Event::Can(request.pack(BaseId::DEFAULT.command())));
    }

    fn press(&mut self, ms: u32) {
        // a long press accepts, when it is let go
        self.event(Event::Button { down: true });
        self.pass(ms);
        self.accepting = if (1_200..4_000).contains(&ms) { Accepting::Press } else { Accepting::Nothing };
        self.event(Event::Button { down: false });
        self.pass(40);
        self.accepting = Accepting::Nothing;
    }

    fn step(&mut self, poses: &[[i32; 6]]) {
        let run_id = self.device.procedure().run_id();
        // a review is rare: decide on it more often than chance would
        if self.device.procedure().state() == StateName::Review && self.random.random_ratio(1, 3) {
            self.pass(200);
            return if self.random.random_ratio(1, 3) { self.press_often() } else { self.accept() };
        }
        match self.random.random_range(0..100) {
            0..40 => {
                let pose = poses[self.random.random_range(0..poses.len())];
                self.hold(&pose);
            }
            40..44 => {
                self.pass(500);
                self.accept();
            }
            44 => self.press_often(),
            45 if self.random.random_ratio(1, 4) => self.restart(),
            46 => {
                type Kind = fn(&mut World, &[[i32; 6]]);
                let kinds: [Kind; 2] = [leap, silence];
                kinds[self.random.random_range(0..kinds.len())](self, poses);
            }
            45..50 => self.command(Opcode::Start as u8, 0, 0),
            50..75 => {
                let opcode = self.random.random_range(1..=13);
                if opcode == Opcode::Accept as u8 {
                    return self.accept();
                }
                let named = matches!(opcode, 6 | 8 | 9 | 13);
                // abort and reject end most runs early: let them be rarer
                if !matches!(opcode, 6 | 7) || self.random.random_ratio(1, 4) {
                    self.command(opcode, if named { run_id } else { 0 }, 0);
                }
            }
            75..80 => {
                let (opcode, run_id, argument) =
                    (self.random.random(), self.random.random_range(0..4), self.random.random_range(0..600));
                self.command(opcode, run_id, argument);
            }
            80..86 => {
                let mut bytes = [0u8; 8];
                self.random.fill(&mut bytes);
                let length = self.random.random_range(0..=8);
                let id = if self.random.random_ratio(1, 2) { 0x680 } else { self.random.random_range(0..0x800) };
                let frame = Frame::new(id, &bytes[..length]).unwrap();
                self.event(Event::Can(frame));
            }
            86..92 => {
                let ms = [20, 200, 1_500, 2_000, 4_500, 13_000][self.random.random_range(0..6)];
                self.press(ms);
            }
            92..95 => {
                let counts: [i32; 6] = if self.random.random_ratio(1, 2) {
                    self.random.random()
                } else {
                    [i32::MIN, i32::MAX, 0, -1, 1, i32::MIN]
                };
                self.event(Event::Counts(counts));
            }
            95..97 => {
                let lost = self.random.random();
                self.event(Event::ReceiveOverrun { lost });
            }
            97..99 => {
                let ms = self.random.random_range(0..30_000);
                self.now_ms = self.now_ms.wrapping_add(ms);
                self.event(Event::Tick);
            }
            _ => {
                self.now_ms = self.random.random();
                self.event(Event::Tick);
            }
        }
    }
}

/// One encoder leaps, and stays where it leapt to for a while.
fn leap(world: &mut World, poses: &[[i32; 6]]) {
    let mut counts = poses[0];
    counts[world.random.random_range(0..6)] += world.random.random_range(-50_000..50_000);
    world.hold(&counts);
    world.hold(&counts);
}

/// The encoders say nothing for a while.
fn silence(world: &mut World, _: &[[i32; 6]]) {
    world.pass(700);
}

/// Runs sequences by their numbers; returns the changes of state that were seen and how many centres were accepted.
fn run(sequences: u64) -> (BTreeSet<(StateName, StateName)>, u64) {
    let rig = Rig::shoulder(150.0).unwrap();
    let config = Config { limits: Limits::new(&rig, settings()).unwrap(), ..Config::for_rig(rig) };
    let device = Device::new(config);
    // Poses of one wearer, and a few of another: those contradict the first.
    let mut poses = Vec::new();
    for (seed, count) in [(1, 24), (2, 6)] {
        let settings = WearerSettings { seed, noise_mm: 0.1, ..Default::default() };
        let mut wearer = Wearer::new(Rig::shoulder(150.0).unwrap(), settings);
        poses.extend((0..count).map(|_| wearer.next_pose().counts));
    }
    (0..sequences)
        .into_par_iter()
        .map(|number| {
            let outcome = std::panic::catch_unwind(|| {
                let mut world = World::new(&device, number);
                for _ in 0..STEPS {
                    world.step(&poses);
                }
                world.command(Opcode::Abort as u8, 0, 0);
                assert_eq!(world.device.procedure().state(), StateName::Idle);
                (world.changes, u64::from(world.accepted))
            });
            outcome.unwrap_or_else(|_| panic!("sequence {number}"))
        })
        .reduce(Default::default, |(mut changes, accepted), (more, also)| {
            changes.extend(more);
            (changes, accepted + also)
        })
}

fn check(sequences: u64) {
    let (changes, accepted) = run(sequences);
    // nonsense alone would prove nothing: every change of state that the table knows has been seen
    for from in StateName::ALL {
        for to in Trigger::ALL.into_iter().filter_map(|trigger| next(from, trigger)).filter(|to| *to != from) {
            assert!(changes.contains(&(from, to)), "{from:?} never became {to:?}");
        }
    }
    assert!(accepted > sequences / 200, "{accepted} centres accepted in {sequences} sequences");
    println!("{sequences} sequences of {STEPS} steps: every change of state seen, {accepted} centres accepted");
}

#[test]
fn twenty_thousand_random_sequences() {
    check(20_000);
}

/// Half a minute on two cores; run it with `cargo test --release --test device -- --ignored a_million`.
#[test]
#[ignore = "half a minute on two cores: cargo test --release --test device -- --ignored a_million"]
fn a_million_random_sequences() {
    check(1_000_000);
}
