//! Power cuts in the flash operations of the real image: in each operation of a store, and again in the recovery.

use crate::board::Board;
use crate::image::Image;
use crate::peripheral::flash::{Cells, Operation};
use glenoid::can::{BaseId, Message, Opcode, Request};
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, Rig};
use host_tests::rehearse::{Bench, Display, Session};
use host_tests::wearer::{Wearer, WearerSettings};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::rc::Rc;

/// From power-up until the record has been read, ms.
const START_MS: u32 = 30;
/// A recovery erases two pages and writes one, ms.
const RECOVERY_MS: u32 = 100;

/// What a campaign found.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Tally {
    /// Power cuts.
    pub cuts: u32,
    /// No centre was in use afterwards.
    pub lost: u32,
    /// Another centre than the old or the new one was.
    pub wrong: u32,
    /// The flash was not at rest after the recovery: the next power-up had to work on it again.
    pub stuck: u32,
    /// Rules that were broken.
    pub complaints: Vec<String>,
}

/// The centre in use, to the bit.
type Centre = Option<[u32; 3]>;

/// A store as the flash saw it: its operations with the cells before each.
struct Store {
    operations: Vec<(Cells, Operation)>,
    old: Centre,
    new: Centre,
}

/// Cuts the power in every operation of a store, round after round, until there were `cuts`; half of them are followed by
/// another one in the recovery. `calibrated` is the flash of a board with a centre.
pub fn campaign(image: &Rc<Image>, calibrated: &Cells, cuts: u32, seed: u64) -> Tally {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let store = watch_store(image, calibrated);
    let mut tally = Tally::default();
    while tally.cuts < cuts && !store.operations.is_empty() {
        for (before, operation) in &store.operations {
            let cells = torn(before, *operation, &mut random);
            tally.cuts += 1;
            judge(image, cells, &store, &mut random, &mut tally);
        }
    }
    tally
}

/// Plays another calibration, and keeps what its store does to the flash.
fn watch_store(image: &Rc<Image>, calibrated: &Cells) -> Store {
    let mut board = Board::power_on(Rc::clone(image), calibrated.clone(), 1);
    pass(&mut board, START_MS);
    let old = live(&mut board);
    board.machine.chip_mut().flash.journal = Some(Vec::new());
    let rig = Rig::shoulder(ASSUMED_BASE_RADIUS_MM).unwrap_or_else(|error| panic!("{}", error.text()));
    let mut wearer = Wearer::new(rig, WearerSettings { seed: 23, noise_mm: 0.1, ..WearerSettings::default() });
    let mut session = Session::new(&mut board, &mut wearer, rig.drum().fastest_mm_per_s, &Display::Silent);
    session.calibrate(12, 5, 0).unwrap_or_else(|error| panic!("{error}"));
    pass(&mut board, 2 * RECOVERY_MS);
    let new = live(&mut board);
    Store { operations: board.machine.chip_mut().flash.journal.take().unwrap_or_default(), old, new }
}

/// The cells when the power fails in an operation.
fn torn(before: &Cells, operation: Operation, random: &mut ChaCha8Rng) -> Cells {
    let mut cells = before.clone();
    cells.random = ChaCha8Rng::seed_from_u64(random.random());
    cells.tear(operation);
    cells
}

/// The power comes back, may fail again, and comes back for good.
fn judge(image: &Rc<Image>, cells: Cells, store: &Store, random: &mut ChaCha8Rng, tally: &mut Tally) {
    let mut cells = cells;
    if random.random_bool(0.5) {
        let recovery = power_up(image, &cells, store, random, tally);
        if !recovery.is_empty() {
            let (before, operation) = &recovery[random.random_range(0..recovery.len())];
            cells = torn(before, *operation, random);
            tally.cuts += 1;
        }
    }
    let mut board = Board::power_on(Rc::clone(image), cells, random.random());
    pass(&mut board, START_MS + RECOVERY_MS);
    let found = live(&mut board);
    note(found, store, tally);
    // one page holds the record now and the other one is erased, so that nothing is left to do
    board.power_cycle();
    pass(&mut board, START_MS + RECOVERY_MS);
    tally.stuck += u32::from(board.machine.chip().flash.operations != 0);
    tally.wrong += u32::from(live(&mut board) != found);
    tally.complaints.extend(board.complaints());
}

/// One power-up: the centre must be one of the two. Gives what was done to the flash.
fn power_up(
    image: &Rc<Image>,
    cells: &Cells,
    store: &Store,
    random: &mut ChaCha8Rng,
    tally: &mut Tally,
) -> Vec<(Cells, Operation)> {
    let mut board = Board::power_on(Rc::clone(image), cells.clone(), random.random());
    board.machine.chip_mut().flash.journal = Some(Vec::new());
    pass(&mut board, START_MS + RECOVERY_MS);
    note(live(&mut board), store, tally);
    tally.complaints.extend(board.complaints());
    board.machine.chip_mut().flash.journal.take().unwrap_or_default()
}

fn note(found: Centre, store: &Store, tally: &mut Tally) {
    tally.lost += u32::from(found.is_none());
    tally.wrong += u32::from(found.is_some() && found != store.old && found != store.new);
}

fn pass(board: &mut Board, ms: u32) {
    board.pass(ms).unwrap_or_else(|error| panic!("{error}"));
}

fn live(board: &mut Board) -> Centre {
    let frame = Request { opcode: Opcode::Query as u8, boot: 0, nonce: 1, run_id: 0, argument: 0 };
    board.send(&frame.pack(BaseId::DEFAULT.command())).ok()?;
    let said = board.pass(60).ok()?;
    let axis = |index: u8| {
        said.iter().find_map(|frame| match Message::unpack(frame, BaseId::DEFAULT) {
            Ok(Message::LiveCentre(value)) if value.index == index => Some(value.value_mm.to_bits()),
            _ => None,
        })
    };
    Some([axis(0)?, axis(1)?, axis(2)?])
}
