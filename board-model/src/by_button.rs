//! A calibration without a client: the button, an arm that is moved and held still, and what the heartbeat tells.

use crate::board::Board;
use glenoid::can::{BaseId, Opcode, Request};
use glenoid::procedure::StateName;
use host_tests::rehearse::{Bench, BenchError, Inbox};
use host_tests::wearer::Wearer;

/// A press that is long: it starts a run, and accepts a centre, ms.
const LONG_MS: u32 = 1_500;
/// A press that is short, ms, and the length of the lamp's rhythm.
const SHORT_MS: u32 = 200;
const RHYTHM_MS: u32 = 4_000;
/// A movement, and how long a pose is held, ms. It is captured by itself after half a second.
const MOVE_MS: u32 = 1_500;
const HOLD_MS: u32 = 900;
/// Poses before nobody believes in it any more.
const MOST_POSES: usize = 60;
/// From the accept until the record is kept, ms.
const STORE_MS: u32 = 500;

/// The person at the arm.
pub struct ByButton<'a> {
    board: &'a mut Board,
    inbox: Inbox,
}

impl<'a> ByButton<'a> {
    /// Nothing is heard yet.
    pub fn new(board: &'a mut Board) -> Self {
        Self { board, inbox: Inbox::default() }
    }

    /// Goes through a calibration; the centre that is in use afterwards, mm.
    ///
    /// # Errors
    /// What did not come about.
    pub fn calibrate(&mut self, wearer: &mut Wearer) -> Result<[f32; 3], BenchError> {
        let mut at = wearer.home();
        self.board.set_counts(&at.counts)?;
        self.pass(2_000)?;
        self.press(LONG_MS)?;
        self.expect(StateName::Collecting)?;
        for _ in 0..MOST_POSES {
            if self.state() == Some(StateName::Review) {
                break;
            }
            let pose = wearer.next_pose();
            for counts in wearer.motion(&at, &pose, MOVE_MS, 10) {
                self.board.set_counts(&counts)?;
                self.pass(10)?;
            }
            at = pose;
            self.pass(HOLD_MS)?;
        }
        self.expect(StateName::Review)?;
        // as many short presses as the lamp blinks: nobody accepts what he has not seen
        for _ in 0..self.blinks()? {
            self.press(SHORT_MS)?;
        }
        self.press(LONG_MS)?;
        self.pass(STORE_MS)?;
        self.live()
    }

    /// The centre in use, asked for over the bus, mm.
    ///
    /// # Errors
    /// There is none.
    pub fn live(&mut self) -> Result<[f32; 3], BenchError> {
        self.inbox = Inbox::default();
        let query = Request { opcode: Opcode::Query as u8, boot: 0, nonce: 99, run_id: 0, argument: 0 };
        self.board.send(&query.pack(BaseId::DEFAULT.command()))?;
        self.pass(200)?;
        let [x, y, z, ..] = self.inbox.live().ok_or_else(|| BenchError("no centre is in use".to_owned()))?;
        Ok([x, y, z].map(|parameter| parameter.value_mm))
    }

    /// Times that the lit lamp goes dark within four seconds, its rhythm's length.
    fn blinks(&mut self) -> Result<u32, BenchError> {
        let (mut blinks, mut was_lit) = (0, self.board.lamp());
        for _ in 0..RHYTHM_MS {
            self.pass(1)?;
            let is_lit = self.board.lamp();
            blinks += u32::from(was_lit && !is_lit);
            was_lit = is_lit;
        }
        Ok(blinks)
    }

    fn press(&mut self, ms: u32) -> Result<(), BenchError> {
        self.board.press(true);
        self.pass(ms)?;
        self.board.press(false);
        self.pass(300)
    }

    fn pass(&mut self, ms: u32) -> Result<(), BenchError> {
        for frame in self.board.pass(ms)? {
            self.inbox.take(&frame, BaseId::DEFAULT);
        }
        Ok(())
    }

    fn state(&self) -> Option<StateName> {
        self.inbox.heartbeat.map(|heartbeat| heartbeat.state)
    }

    fn expect(&self, state: StateName) -> Result<(), BenchError> {
        match self.inbox.heartbeat {
            Some(now) if now.state == state => Ok(()),
            now => Err(BenchError(format!("{state:?} was expected, and this is the heartbeat: {now:?}"))),
        }
    }
}
