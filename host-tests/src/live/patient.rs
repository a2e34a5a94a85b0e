//! The person at the arm of an emulated board: moves when the board asks for another pose, holds still otherwise.

use super::{Port, SharedBus};
use crate::wearer::{Wearer, WearerSettings};
use clap::ValueEnum;
use glenoid::can::status::Heartbeat;
use glenoid::can::telemetry::TELEMETRY_FRAMES;
use glenoid::can::{BaseId, Frame, Message};
use glenoid::procedure::{Guidance, StateName};
use glenoid::rig::{CABLES, Rig};
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::VecDeque;
use std::io::{self, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::mpsc::{self, Receiver, Sender, TryRecvError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Time between two samples of the encoders while the arm rests, ms.
const PERIOD_MS: u32 = 10;

/// Time between two samples while it moves, ms: as often as the board sends telemetry.
const MOVING_PERIOD_MS: u32 = 20;

/// Samples that a pull of a cable takes, one with each telemetry, and how fast it is pulled: 12 mm in 0.4 s on the shoulder's drums.
const PULL_SAMPLES: i32 = 40;
const PULL_COUNTS_A_SAMPLE: i32 = 26;

/// Samples from the letting go of a cable to the pull of the next: 0.6 s.
const REST_SAMPLES: i32 = 30;

/// Longest wait for the board before the encoders count on all the same: it may be silent on the bus.
const BOARD_LIMIT: Duration = Duration::from_secs(1);

/// How far the centre of a living shoulder moves with the arm's rotation, mm for each radian about x, y and z: a few
/// millimetres up and forward in an elevation of 45 degrees, as in the cadavers of Meskers (1998) and later studies.
const MIGRATION_MM_PER_RAD: Matrix3<f64> = Matrix3::new(0.0, 6.0, 1.0, -6.0, 0.0, 1.0, 2.0, 2.0, 0.0);

/// While somebody holds the shoulder blade, the arm moves by this share of its usual angles: it stays within 30°.
const SHARE_WITH_BLADE_HELD: f64 = 0.5;

/// What kind of shoulder sits in what kind of machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PersonKind {
    /// A joint that is a ball, in the machine of the drawing.
    Ball,
    /// A shoulder whose centre moves with the arm.
    Moving,
    /// A joint that is a ball, in a machine whose attachment points are up to half a millimetre off the drawing.
    Built,
}

/// How far an attachment point of a machine as it is built may be off along each axis, mm.
const BUILT_WITHIN_MM: f64 = 0.5;

/// Who sits in the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Person {
    /// The shoulder and the machine.
    pub kind: PersonKind,
    /// Seed of the poses and of the true centre.
    pub seed: u64,
    /// Largest error of a cable length, mm.
    pub noise_mm: f64,
    /// How long a pose is held, ms.
    pub hold_ms: u32,
    /// How long a movement takes, ms.
    pub move_ms: u32,
}

/// What the person, or the machine around the person, is to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Press the button, or let go.
    Button(bool),
    /// The encoders fall silent, or count again.
    Encoders(bool),
    /// Pull this cable, 1 to 6, by a finger's breadth, and let go, once the one before has been let go.
    Pull(u8),
}

impl Order {
    /// An order as a terminal writes it: `press`, `release`, `silent`, `sound`, `pull 3`.
    pub fn parse(line: &str) -> Option<Self> {
        match line.trim() {
            "press" => Some(Self::Button(true)),
            "release" => Some(Self::Button(false)),
            "silent" => Some(Self::Encoders(false)),
            "sound" => Some(Self::Encoders(true)),
            other => {
                let cable: u8 = other.strip_prefix("pull ")?.trim().parse().ok()?;
                (1..=CABLES as u8).contains(&cable).then_some(Self::Pull(cable))
            }
        }
    }
}

/// A person who plays until the process ends.
#[derive(Debug)]
pub struct Patient {
    orders: Sender<Order>,
    truth_mm: [f64; 3],
    now_mm: Arc<Mutex<[f64; 3]>>,
}

impl Patient {
    /// Sits a person into a machine, `drawn` like this, whose rig link is at this address.
    ///
    /// # Errors
    /// When the rig link cannot be reached.
    pub fn sit_down(person: Person, drawn: Rig<f64>, rig: SocketAddr, bus: &SharedBus) -> io::Result<Self> {
        let wearer = Wearer::new(machine_of(&person, drawn)?, settings(&person, &drawn));
        let [x, y, z, ..] = wearer.truth().to_array();
        let stream = TcpStream::connect(rig)?;
        stream.set_nodelay(true)?;
        let (orders, from_outside) = mpsc::channel();
        let link = Link {
            address: rig,
            stream,
            orders: from_outside,
            silent: false,
            pulled: None,
            to_pull: VecDeque::new(),
            next: Instant::now(),
        };
        let now_mm = Arc::new(Mutex::new([x, y, z]));
        let at = Rotation3::identity();
        let mut play =
            Play { person, wearer, link, port: bus.attach(), heartbeat: None, at, centre_mm: Arc::clone(&now_mm) };
        thread::spawn(move || while play.go_on().is_ok() {});
        Ok(Self { orders, truth_mm: [x, y, z], now_mm })
    }

    /// The true centre with the arm at home, mm, axes of {B}: what a calibration should find.
    pub fn truth_mm(&self) -> [f64; 3] {
        self.truth_mm
    }

    /// The true centre with the arm where it is now, mm, axes of {B}.
    pub fn centre_mm(&self) -> [f64; 3] {
        *self.now_mm.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Passes an order on.
    pub fn order(&self, order: Order) {
        // A person who is gone takes no orders.
        let _ = self.orders.send(order);
    }
}

/// The person's own measures, in proportion to the machine: a wrist is smaller than a shoulder.
fn settings(person: &Person, drawn: &Rig<f64>) -> WearerSettings {
    const SHOULDER_RADIUS_MM: f64 = 140.8;
    let usual = WearerSettings::default();
    let [radius_mm, ..] = drawn.nominal().radii_mm;
    let size = radius_mm / SHOULDER_RADIUS_MM;
    WearerSettings {
        seed: person.seed,
        noise_mm: person.noise_mm,
        centre_offset_mm: usual.centre_offset_mm * size,
        cuff_offset_mm: usual.cuff_offset_mm * size,
        ..usual
    }
}

/// The machine that the person really sits in.
fn machine_of(person: &Person, drawn: Rig<f64>) -> io::Result<Rig<f64>> {
    if person.kind != PersonKind::Built {
        return Ok(drawn);
    }
    let mut random = ChaCha8Rng::seed_from_u64(person.seed);
    let mut off = || random.random_range(-BUILT_WITHIN_MM..=BUILT_WITHIN_MM);
    let base = drawn.base_mm().map(|point| point + Vector3::from_fn(|_, _| off()));
    let edges = drawn.edges_mm().map(|edge| edge + off());
    Rig::new(base, edges, *drawn.drum(), drawn.length_noise_mm(), *drawn.nominal())
        .map_err(|error| io::Error::other(error.text()))
}

struct Play {
    person: Person,
    wearer: Wearer,
    link: Link,
    port: Port,
    heartbeat: Option<Heartbeat>,
    at: Rotation3<f64>,
    /// The true centre where the arm is now, for others to see.
    centre_mm: Arc<Mutex<[f64; 3]>>,
}

impl Play {
    /// Holds the pose; then moves on if the board wants that.
    fn go_on(&mut self) -> io::Result<()> {
        for _ in 0..(self.person.hold_ms / PERIOD_MS).max(1) {
            self.wait_for_the_board(if self.link.pulls() { ends_telemetry } else { |_| true });
            self.sample(self.at)?;
        }
        if self.is_to_move() {
            let mut to = self.wearer.next_pose().rotation;
            if self.is_blade_held() {
                to = to.powf(SHARE_WITH_BLADE_HELD);
            }
            for rotation in Wearer::path(self.at, to, self.person.move_ms, MOVING_PERIOD_MS) {
                self.wait_for_the_board(ends_telemetry);
                self.sample(rotation)?;
            }
            self.at = to;
        }
        Ok(())
    }

    /// The arm lives in the board's own time: an emulator on a busy machine stands still now and then, and samples that had
    /// piled up meanwhile would come to it all at once, as no encoder's do. Waits for a frame of the board that will do.
    fn wait_for_the_board(&mut self, will_do: fn(&Frame) -> bool) {
        let end = Instant::now() + BOARD_LIMIT;
        while let Some(frame) = self.port.receive(end.saturating_duration_since(Instant::now())) {
            self.hear(&frame);
            if will_do(&frame) {
                // what else is there is as old
                while let Some(frame) = self.port.try_receive() {
                    self.hear(&frame);
                }
                break;
            }
        }
    }

    fn hear(&mut self, frame: &Frame) {
        if let Ok(Message::Heartbeat(heartbeat)) = Message::unpack(frame, BaseId::DEFAULT) {
            self.heartbeat = Some(heartbeat);
        }
    }

    fn is_to_move(&mut self) -> bool {
        while let Some(frame) = self.port.try_receive() {
            self.hear(&frame);
        }
        self.heartbeat.is_some_and(|heartbeat| {
            let in_a_set = matches!(heartbeat.state, StateName::Collecting | StateName::Verifying);
            in_a_set && !matches!(heartbeat.guidance, Guidance::Wait | Guidance::Nothing)
        })
    }

    /// In the first of two phases a helper holds the blade, and the centre stays where it is.
    fn is_blade_held(&self) -> bool {
        self.heartbeat.is_some_and(|heartbeat| heartbeat.flags.held_phase)
    }

    fn sample(&mut self, rotation: Rotation3<f64>) -> io::Result<()> {
        let migration_mm = match self.person.kind {
            PersonKind::Moving if !self.is_blade_held() => MIGRATION_MM_PER_RAD * rotation.scaled_axis(),
            PersonKind::Moving | PersonKind::Ball | PersonKind::Built => Vector3::zeros(),
        };
        let counts = self.wearer.sample(&rotation, migration_mm, None);
        let [x, y, z, ..] = self.wearer.truth().to_array();
        *self.centre_mm.lock().unwrap_or_else(PoisonError::into_inner) =
            [x + migration_mm.x, y + migration_mm.y, z + migration_mm.z];
        self.link.sample(&counts)
    }
}

/// Is this the end of a set of telemetry?
fn ends_telemetry(frame: &Frame) -> bool {
    match Message::unpack(frame, BaseId::DEFAULT) {
        Ok(Message::Telemetry([head, ..])) => usize::from(head & 0x1F) + 1 == TELEMETRY_FRAMES,
        _ => false,
    }
}

struct Link {
    address: SocketAddr,
    stream: TcpStream,
    orders: Receiver<Order>,
    silent: bool,
    /// The cable that is being pulled, from 0, and for how many samples yet; below 0 the cables rest.
    pulled: Option<(usize, i32)>,
    /// The cables to be pulled after it.
    to_pull: VecDeque<usize>,
    next: Instant,
}

impl Link {
    /// Is a cable being pulled, or the pause behind that not over?
    fn pulls(&self) -> bool {
        self.pulled.is_some()
    }

    /// How far which cable is pulled at the next sample, counts.
    fn pull(&mut self) -> Option<(usize, i32)> {
        if self.pulled.is_none() {
            self.pulled = self.to_pull.pop_front().map(|cable| (cable, PULL_SAMPLES));
        }
        let (cable, left) = self.pulled?;
        self.pulled = (left > -REST_SAMPLES).then_some((cable, left - 1));
        // there and back
        (left > 0).then_some((cable, PULL_COUNTS_A_SAMPLE * left.min(PULL_SAMPLES - left)))
    }

    /// Obeys what was ordered, and sends one sample when its time has come.
    fn sample(&mut self, counts: &[i32; CABLES]) -> io::Result<()> {
        thread::sleep(self.next.saturating_duration_since(Instant::now()));
        // A host that fell behind does not catch up: the board would see an arm that leaps.
        self.next = (self.next + Duration::from_millis(PERIOD_MS.into())).max(Instant::now());
        loop {
            match self.orders.try_recv() {
                Ok(Order::Button(down)) => self.write(&format!("b {}\n", u8::from(down)))?,
                Ok(Order::Encoders(sound)) => self.silent = !sound,
                Ok(Order::Pull(cable)) => self.to_pull.push_back(usize::from(cable) - 1),
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => return Err(io::ErrorKind::BrokenPipe.into()),
            }
        }
        let mut counts = *counts;
        if let Some((cable, pulled)) = self.pull() {
            counts[cable] += pulled;
        }
        let [c1, c2, c3, c4, c5, c6] = counts;
        if self.silent { Ok(()) } else { self.write(&format!("e {c1} {c2} {c3} {c4} {c5} {c6}\n")) }
    }

    /// One write for one line: a pause within it would delay the sample. A board that was switched off and on again is
    /// found again.
    fn write(&mut self, line: &str) -> io::Result<()> {
        if self.stream.write_all(line.as_bytes()).is_err() {
            self.stream = TcpStream::connect(self.address)?;
            self.stream.set_nodelay(true)?;
        }
        Ok(())
    }
}
