//! The person at the arm of an emulated board: moves when the board asks for another pose, holds still otherwise.

use super::ball_sitter::BallSitter;
use super::elbow_sitter::ElbowSitter;
use super::link::Link;
use super::person::{Order, PERIOD_MS, Person};
use super::sitter::{Now, Sample, Sitter, Truth};
use super::{Machine, Port, SharedBus};
use glenoid::can::status::Heartbeat;
use glenoid::can::telemetry::TELEMETRY_FRAMES;
use glenoid::can::{BaseId, Frame, Message};
use glenoid::procedure::{Guidance, StateName};
use std::io;
use std::net::SocketAddr;
use std::sync::mpsc::{self, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Time between two samples while it moves, ms: as often as the board sends telemetry.
const MOVING_PERIOD_MS: u32 = 20;

/// Longest wait for the board before the encoders count on all the same: it may be silent on the bus.
const BOARD_LIMIT: Duration = Duration::from_secs(1);

/// A person who plays until the process ends.
#[derive(Debug)]
pub struct Patient {
    orders: Sender<Order>,
    truth: Truth,
    now: Arc<Mutex<Now>>,
}

impl Patient {
    /// Sits a person into a machine, drawn like this, whose rig link is at this address.
    ///
    /// # Errors
    /// When the rig link cannot be reached, or such a person does not fit into such a machine.
    pub fn sit_down(person: Person, drawn: Machine, rig: SocketAddr, bus: &SharedBus) -> io::Result<Self> {
        let sitter: Box<dyn Sitter> = match drawn {
            Machine::Ball(drawn) => Box::new(BallSitter::new(&person, drawn)?),
            Machine::Hinge(drawn) => Box::new(ElbowSitter::new(&person, &drawn)?),
        };
        let (orders, from_outside) = mpsc::channel();
        let link = Link::connect(rig, from_outside)?;
        let (truth, now) = (sitter.truth(), Arc::new(Mutex::new(sitter.now())));
        let mut play = Play { person, sitter, link, port: bus.attach(), heartbeat: None, now: Arc::clone(&now) };
        thread::spawn(move || while play.go_on().is_ok() {});
        Ok(Self { orders, truth, now })
    }

    /// What a calibration should find.
    pub fn truth(&self) -> Truth {
        self.truth
    }

    /// Where the joint is now.
    pub fn now(&self) -> Now {
        *self.now.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Passes an order on.
    pub fn order(&self, order: Order) {
        // A person who is gone takes no orders.
        let _ = self.orders.send(order);
    }
}

struct Play {
    person: Person,
    sitter: Box<dyn Sitter>,
    link: Link,
    port: Port,
    heartbeat: Option<Heartbeat>,
    /// Where the joint is now, for others to see.
    now: Arc<Mutex<Now>>,
}

impl Play {
    /// Holds the pose; then moves on if the board wants that.
    fn go_on(&mut self) -> io::Result<()> {
        for _ in 0..(self.person.hold_ms / PERIOD_MS).max(1) {
            self.wait_for_the_board(if self.link.pulls() { ends_telemetry } else { |_| true });
            let sample = self.sitter.rest(self.is_blade_held());
            self.send(&sample)?;
        }
        if self.is_to_move() {
            for sample in self.sitter.way(self.is_blade_held(), self.person.move_ms, MOVING_PERIOD_MS) {
                self.wait_for_the_board(ends_telemetry);
                self.send(&sample)?;
            }
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

    fn send(&mut self, sample: &Sample) -> io::Result<()> {
        *self.now.lock().unwrap_or_else(PoisonError::into_inner) = sample.now;
        self.link.sample(&sample.counts)
    }
}

/// Is this the end of a set of telemetry?
fn ends_telemetry(frame: &Frame) -> bool {
    match Message::unpack(frame, BaseId::DEFAULT) {
        Ok(Message::Telemetry([head, ..])) => usize::from(head & 0x1F) + 1 == TELEMETRY_FRAMES,
        _ => false,
    }
}
