//! One CAN bus with several boards: what a board sends reaches the others and the host, what the host sends reaches all
//! boards.

use crate::rehearse::bench::{Bench, BenchError, InProcess};
use glenoid::can::Frame;
use glenoid::parameters::ParameterSet;
use glenoid::restart::Restart;
use glenoid::rig::CABLES;

/// A bus, its boards, and the wires to each board's encoders. Boards are numbered in the order of their coming.
pub trait Bus {
    /// A new board, as made, is plugged in. Gives its number.
    ///
    /// # Errors
    /// [`BenchError`] when it does not start.
    fn join(&mut self, serial: u32) -> Result<usize, BenchError>;

    /// A board is unplugged. Its number is not given to another one.
    fn unplug(&mut self, board: usize);

    /// Sets the six encoder counters of a board: what it samples from now on.
    fn set_counts(&mut self, board: usize, counts: &[i32; CABLES]);

    /// Puts a frame on the bus.
    ///
    /// # Errors
    /// [`BenchError`] when a board is gone.
    fn send(&mut self, frame: &Frame) -> Result<(), BenchError>;

    /// Every board whose encoders were set samples them, a resting one now and then; then lets `ms` milliseconds pass. Gives the
    /// frames that the boards sent meanwhile, those of one board in order.
    ///
    /// # Errors
    /// [`BenchError`] when a board is gone.
    fn pass(&mut self, ms: u32) -> Result<Vec<Frame>, BenchError>;

    /// Takes a board's supply away and gives it back.
    ///
    /// # Errors
    /// [`BenchError`] when it does not come back.
    fn restart(&mut self, board: usize) -> Result<(), BenchError>;
}

/// One board's place on the bus: the bench of whoever calibrates that board.
pub struct Place<'a> {
    bus: &'a mut dyn Bus,
    board: usize,
}

impl<'a> Place<'a> {
    /// The place of a board.
    pub fn new(bus: &'a mut dyn Bus, board: usize) -> Self {
        Self { bus, board }
    }
}

impl Bench for Place<'_> {
    fn set_counts(&mut self, counts: &[i32; CABLES]) -> Result<(), BenchError> {
        self.bus.set_counts(self.board, counts);
        Ok(())
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BenchError> {
        self.bus.send(frame)
    }

    fn pass(&mut self, ms: u32) -> Result<Vec<Frame>, BenchError> {
        self.bus.pass(ms)
    }

    fn restart(&mut self) -> Result<(), BenchError> {
        self.bus.restart(self.board)
    }
}

/// The devices of the boards in this process, with clocks that are only counted.
#[derive(Default)]
pub struct InProcessBus {
    boards: Vec<Option<(InProcess, Option<[i32; CABLES]>)>>,
}

impl InProcessBus {
    fn plugged(&mut self) -> impl Iterator<Item = (usize, &mut InProcess)> {
        self.boards.iter_mut().enumerate().filter_map(|(number, board)| Some((number, &mut board.as_mut()?.0)))
    }
}

impl Bus for InProcessBus {
    fn join(&mut self, serial: u32) -> Result<usize, BenchError> {
        let config = ParameterSet::new().config(Restart::default(), serial);
        let config = config.map_err(|at| BenchError(format!("the defaults contradict each other at {}", at.index)))?;
        self.boards.push(Some((InProcess::new(config), None)));
        Ok(self.boards.len() - 1)
    }

    fn unplug(&mut self, board: usize) {
        self.boards[board] = None;
    }

    fn set_counts(&mut self, board: usize, counts: &[i32; CABLES]) {
        if let Some((_, sampled)) = &mut self.boards[board] {
            *sampled = Some(*counts);
        }
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BenchError> {
        self.plugged().try_for_each(|(_, board)| board.send(frame))
    }

    fn pass(&mut self, ms: u32) -> Result<Vec<Frame>, BenchError> {
        for (board, counts) in self.boards.iter_mut().flatten() {
            if let Some(counts) = counts {
                board.set_counts(counts)?;
            }
        }
        let mut heard = Vec::new();
        for _ in 0..ms {
            let mut sent = Vec::new();
            for (number, board) in self.plugged() {
                sent.extend(board.pass(1)?.into_iter().map(|frame| (number, frame)));
            }
            for (sender, frame) in sent {
                for (number, board) in self.plugged() {
                    if number != sender {
                        board.send(&frame)?;
                    }
                }
                heard.push(frame);
            }
        }
        Ok(heard)
    }

    fn restart(&mut self, board: usize) -> Result<(), BenchError> {
        match &mut self.boards[board] {
            Some((device, _)) => device.restart(),
            None => Err(BenchError("the board is not plugged in".to_owned())),
        }
    }
}
