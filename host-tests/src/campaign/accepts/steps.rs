//! What may happen to a board, in shares such that runs get somewhere: a weighted mix of poses, commands and presses, and
//! garbage at every layer, jumps of the clock among it.

use super::world::{Accepting, World};
use glenoid::can::{BaseId, Frame, Opcode, Request};
use glenoid::device::Event;
use glenoid::procedure::StateName;
use rand::Rng;

/// Counts of one pose.
pub type Counts = [i32; 6];

impl World {
    /// Something happens.
    pub fn step(&mut self, poses: &[Counts]) {
        for client in &mut self.clients {
            client.wander(&mut self.random);
        }
        let run_id = self.device.procedure().run_id();
        // a review is rare: decide on it more often than chance would
        if self.state() == StateName::Review && self.random.random_ratio(1, 3) {
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
            46 if self.random.random_ratio(1, 2) => self.leap(poses),
            46 => self.silence(700),
            45..50 => self.command(Opcode::Start as u8, 0, 0),
            50..75 => {
                let opcode = self.random.random_range(1..=14);
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
            80..86 => self.garbage(),
            86..92 => {
                let ms = [20, 200, 1_500, 2_000, 4_500, 13_000][self.random.random_range(0..6)];
                self.press(ms);
            }
            92..95 => {
                let extremes = [i32::MIN, i32::MAX, 0, -1, 1, i32::MIN];
                let counts = if self.random.random_ratio(1, 2) { self.random.random() } else { extremes };
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

    /// One of the two clients accepts.
    fn accept(&mut self) {
        let which = self.random.random_range(0..2);
        let (frame, meant) = self.clients[which].accept(&mut self.random);
        self.accepting = Accepting::Command(meant);
        self.event(Event::Can(frame));
        self.accepting = Accepting::Nothing;
    }

    /// Presses the button some times, then long.
    fn press_often(&mut self) {
        for _ in 0..self.random.random_range(0..6) {
            self.press(200);
        }
        self.press(1_500);
    }

    fn press(&mut self, ms: u32) {
        self.event(Event::Button { down: true });
        self.pass(ms);
        // a long press accepts, when it is let go
        self.accepting = if (1_200..4_000).contains(&ms) { Accepting::Press } else { Accepting::Nothing };
        self.event(Event::Button { down: false });
        self.pass(40);
        self.accepting = Accepting::Nothing;
    }

    /// Time passes, the arm rests.
    fn pass(&mut self, ms: u32) {
        for _ in 0..ms.div_ceil(10) {
            self.now_ms = self.now_ms.wrapping_add(10);
            if let Some(counts) = self.counts {
                self.event(Event::Counts(counts));
            }
            self.event(Event::Tick);
        }
    }

    /// Time passes, and the encoders say nothing.
    fn silence(&mut self, ms: u32) {
        let counts = self.counts.take();
        self.pass(ms);
        self.counts = counts;
    }

    fn hold(&mut self, counts: &Counts) {
        self.counts = Some(*counts);
        for _ in 0..5 {
            self.now_ms = self.now_ms.wrapping_add(10);
            self.event(Event::Counts(*counts));
            self.event(Event::Tick);
        }
        while self.device.is_busy() {
            self.event(Event::Tick);
        }
    }

    /// One encoder leaps, and stays where it leapt to for a while.
    fn leap(&mut self, poses: &[Counts]) {
        let mut counts = poses[0];
        counts[self.random.random_range(0..6)] += self.random.random_range(-50_000..50_000);
        self.hold(&counts);
        self.hold(&counts);
    }

    /// A frame of no sense, half of them with the identifier of the commands or of the requests about parameters.
    fn garbage(&mut self) {
        let mut bytes = [0u8; 8];
        self.random.fill(&mut bytes);
        let length = self.random.random_range(0..=8);
        let id = match self.random.random_range(0..4) {
            0 => BaseId::DEFAULT.command().as_raw(),
            1 => BaseId::DEFAULT.parameters().as_raw(),
            _ => self.random.random_range(0..0x800),
        };
        if let Ok(frame) = Frame::new(id, &bytes[..length]) {
            self.event(Event::Can(frame));
        }
    }

    /// Gives a command with a nonce by chance.
    pub fn command(&mut self, opcode: u8, run_id: u16, argument: u16) {
        let request = Request { opcode, boot: 0, nonce: self.random.random(), run_id, argument };
        self.event(Event::Can(request.pack(BaseId::DEFAULT.command())));
    }
}
