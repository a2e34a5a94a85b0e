//! Power cuts in the flash operations of the real image: in each operation of a calibration's store and of a save of
//! parameters, and again in the recovery.

use crate::board::Board;
use crate::image::Image;
use crate::peripheral::flash::{Cells, Operation};
use crate::peripheral::words::PAGE_WORDS;
use glenoid::can::{BaseId, Message, Opcode, Operation as ParameterOperation, ParameterRequest, Request};
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, Rig};
use host_tests::rehearse::{Bench, Display, Session};
use host_tests::wearer::{Wearer, WearerSettings};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::fmt;
use std::rc::Rc;

/// The longest start: what a power cut left is finished in it, which erases two pages and writes one, ms.
const LONGEST_START_MS: u32 = 150;
/// A store is over, ms.
const STORE_MS: u32 = 400;
/// An answer has come, ms.
const ANSWER_MS: u32 = 60;
/// The journal's pages in the second bank: with each boot something is written there.
const JOURNAL_PAGES: [usize; 2] = [124, 125];
/// The parameter that is saved: the hold time, ms.
const PARAMETER: u16 = 161;
/// Cycles an instruction: only the order of the flash operations matters, and a slower core waits for them in fewer
/// instructions.
const CYCLES_AN_INSTRUCTION: u64 = 8;
/// What it is saved as.
const SAVED: u32 = 450;

/// What a campaign found.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Tally {
    /// Flash operations that were cut: of the calibration, and of the save.
    pub operations: [usize; 2],
    /// Power cuts.
    pub cuts: u32,
    /// No centre was in use afterwards.
    pub lost: u32,
    /// Another centre or parameter than the old or the new one was.
    pub wrong: u32,
    /// The flash was not at rest after the recovery: the next power-up had to work on it again.
    pub stuck: u32,
    /// Rules that were broken.
    pub complaints: Vec<String>,
}

impl Tally {
    /// Everything that must not happen.
    pub fn failures(&self) -> usize {
        (self.lost + self.wrong + self.stuck) as usize + self.complaints.len()
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { operations: [store, save], cuts, lost, wrong, stuck, complaints } = self;
        write!(f, "{cuts} power cuts in {store} flash operations of a calibration and {save} of a save: ")?;
        write!(f, "{lost} lost, {wrong} wrong, {stuck} not at rest afterwards, {} breaches", complaints.len())
    }
}

/// What is in use: the centre, to the bit, and the parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct InUse {
    centre: Option<[u32; 3]>,
    parameter: Option<u32>,
}

/// What was stored as the flash saw it: its operations with the cells before each.
struct Story {
    operations: Vec<(Cells, Operation)>,
    old: InUse,
    new: InUse,
}

/// Cuts the power in every operation, round after round, until there were `cuts`; half of them are followed by another one
/// in the recovery. `calibrated` is the flash of a board with a centre.
pub fn campaign(image: &Rc<Image>, calibrated: &Cells, cuts: u32, seed: u64) -> Tally {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut board = Board::power_on(Rc::clone(image), calibrated.clone(), 1);
    board.machine.state_mut().cycles_an_instruction = CYCLES_AN_INSTRUCTION;
    let stories = [told(&mut board, calibrated, calibrate), told(&mut board, calibrated, save)];
    let operations = [&stories[0], &stories[1]].map(|story| story.operations.len());
    let mut tally = Tally { operations, ..Tally::default() };
    // evenly over all operations, however few cuts there are
    let all: Vec<_> = stories.iter().flat_map(|story| story.operations.iter().map(move |one| (story, one))).collect();
    let stride = (all.len() / cuts.max(1) as usize).max(1);
    while tally.cuts < cuts && operations.iter().all(|count| *count != 0) {
        for (story, (before, operation)) in all.iter().skip(random.random_range(0..stride)).step_by(stride) {
            tally.cuts += 1;
            let cells = torn(before, *operation, &mut random);
            judge(&mut board, cells, story, &mut random, &mut tally);
        }
    }
    tally.complaints = board.complaints();
    tally
}

/// Lets something be stored, and keeps what that does to the flash.
fn told(board: &mut Board, calibrated: &Cells, store: fn(&mut Board)) -> Story {
    start(board, calibrated.clone(), 1);
    let old = in_use(board);
    board.machine.chip_mut().flash.journal = Some(Vec::new());
    store(board);
    let operations = board.machine.chip_mut().flash.journal.take().unwrap_or_default();
    let new = in_use(board);
    Story { operations, old, new }
}

fn calibrate(board: &mut Board) {
    let rig = Rig::shoulder(ASSUMED_BASE_RADIUS_MM).unwrap_or_else(|error| panic!("{}", error.text()));
    let mut wearer = Wearer::new(rig, WearerSettings { seed: 23, noise_mm: 0.1, ..WearerSettings::default() });
    let mut session = Session::new(board, &mut wearer, rig.drum().fastest_mm_per_s, &Display::Silent);
    session.calibrate(12, 5, 0).unwrap_or_else(|error| panic!("{error}"));
    pass(board, STORE_MS);
}

/// Saves a parameter; the board starts anew with it.
fn save(board: &mut Board) {
    ask(board, ParameterOperation::Write, SAVED);
    pass(board, ANSWER_MS);
    ask(board, ParameterOperation::Save, 0);
    pass(board, STORE_MS);
}

/// The cells when the power fails in an operation.
fn torn(before: &Cells, operation: Operation, random: &mut ChaCha8Rng) -> Cells {
    let mut cells = before.clone();
    cells.random = ChaCha8Rng::seed_from_u64(random.random());
    cells.tear(operation);
    cells
}

/// The power comes back, may fail again, and comes back for good.
fn judge(board: &mut Board, cells: Cells, story: &Story, random: &mut ChaCha8Rng, tally: &mut Tally) {
    let mut cells = cells;
    if random.random_bool(0.5) {
        board.switch_on(cells.clone(), random.random());
        board.machine.chip_mut().flash.journal = Some(Vec::new());
        wait_until_up(board);
        let recovery = board.machine.chip_mut().flash.journal.take().unwrap_or_default();
        if !recovery.is_empty() {
            let (before, operation) = &recovery[random.random_range(0..recovery.len())];
            cells = torn(before, *operation, random);
            tally.cuts += 1;
        }
    }
    start(board, cells, random.random());
    let found = in_use(board);
    let Story { old, new, .. } = story;
    tally.lost += u32::from(found.centre.is_none());
    let is_right = [None, old.centre, new.centre].contains(&found.centre)
        && [old.parameter, new.parameter].contains(&found.parameter);
    tally.wrong += u32::from(!is_right);
    // every pair of pages holds one image now, so that nothing is left to do but to note the boot
    board.power_cycle();
    board.machine.chip_mut().flash.journal = Some(Vec::new());
    wait_until_up(board);
    let again = board.machine.chip_mut().flash.journal.take().unwrap_or_default();
    tally.stuck += u32::from(again.iter().any(|(_, operation)| !is_of_journal(*operation)));
    tally.wrong += u32::from(in_use(board) != found);
}

fn is_of_journal(operation: Operation) -> bool {
    let page = match operation {
        Operation::Erase(page) => page,
        Operation::Program(word, _) => word / PAGE_WORDS,
    };
    JOURNAL_PAGES.contains(&page)
}

/// Switches the board on, and waits until it has noted its boot.
fn start(board: &mut Board, cells: Cells, seed: u64) {
    board.switch_on(cells, seed);
    wait_until_up(board);
    pass(board, 40);
}

/// What was kept has been read, and what a power cut left is finished: the sampling begins behind that.
fn wait_until_up(board: &mut Board) {
    for _ in 0..LONGEST_START_MS {
        if board.is_up() {
            return;
        }
        pass(board, 1);
    }
    panic!("it does not start: {:?}", board.last_words());
}

fn pass(board: &mut Board, ms: u32) {
    board.pass(ms).unwrap_or_else(|error| panic!("{error}"));
}

fn ask(board: &mut Board, operation: ParameterOperation, value: u32) {
    // never the same one within a second, or it would not be obeyed
    let nonce = board.now_ms() as u8 | 1;
    let request = ParameterRequest { operation: operation as u8, index: PARAMETER, nonce, value };
    board.send(&request.pack(BaseId::DEFAULT.parameters())).unwrap_or_else(|error| panic!("{error}"));
}

fn in_use(board: &mut Board) -> InUse {
    let frame = Request { opcode: Opcode::Query as u8, boot: 0, nonce: 1, run_id: 0, argument: 0 };
    board.send(&frame.pack(BaseId::DEFAULT.command())).unwrap_or_else(|error| panic!("{error}"));
    ask(board, ParameterOperation::Read, 0);
    let (mut axes, mut parameter) = ([None; 3], None);
    for _ in 0..ANSWER_MS {
        for frame in board.pass(1).unwrap_or_else(|error| panic!("{error}")) {
            match Message::unpack(&frame, BaseId::DEFAULT) {
                Ok(Message::LiveCentre(value)) => {
                    if let Some(axis) = axes.get_mut(usize::from(value.index)) {
                        *axis = Some(value.value_mm.to_bits());
                    }
                }
                Ok(Message::Parameter(answer)) if answer.operation == ParameterOperation::Read as u8 => {
                    parameter = Some(answer.value);
                }
                _ => {}
            }
        }
        if let ([Some(x), Some(y), Some(z)], Some(_)) = (axes, parameter) {
            return InUse { centre: Some([x, y, z]), parameter };
        }
    }
    InUse { centre: None, parameter }
}
