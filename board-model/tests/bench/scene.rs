//! What the tests share: the image, a board with a centre in its flash, and what the bus says.

use board_model::board::Board;
use board_model::image::Image;
use board_model::peripheral::flash::Cells;
use glenoid::can::health::{BusHealth, LastStop};
use glenoid::can::status::{Answer, Counters, Heartbeat};
use glenoid::can::{BaseId, Frame, Message, Opcode, Request};
use glenoid::procedure::{Reason, StateName};
use glenoid::restart::ResetCause;
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, Rig};
use host_tests::firmware;
use host_tests::packages::Consent;
use host_tests::rehearse::{Bench, Display, Session};
use host_tests::wearer::{Wearer, WearerSettings};
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::OnceLock;

/// The real image, built once.
pub fn image() -> Rc<Image> {
    static PATH: OnceLock<PathBuf> = OnceLock::new();
    let path = PATH.get_or_init(|| firmware::build(firmware::Image::NUCLEO_G474RE, Consent::Given).unwrap());
    Rc::new(Image::read(path).unwrap())
}

/// A board that has just been switched on for the first time, and samples.
pub fn new_board() -> Board {
    let mut board = Board::new(image(), 7);
    board.pass(50).unwrap();
    board
}

/// The flash of a board that has been calibrated, and the centre that it has in use, to the bit.
pub fn calibrated() -> (Cells, [u32; 3]) {
    static STORED: OnceLock<(Cells, [u32; 3])> = OnceLock::new();
    STORED
        .get_or_init(|| {
            let mut board = new_board();
            let live = calibrate(&mut board, 3);
            assert_eq!(board.complaints(), [""; 0]);
            board.power_cycle();
            (board.machine.chip().flash.cells.clone(), live)
        })
        .clone()
}

/// A board with a centre in use.
pub fn kept_board() -> Board {
    let mut board = Board::power_on(image(), calibrated().0, 11);
    board.pass(50).unwrap();
    board
}

/// Plays a calibration of the wearer with this seed; the centre in use afterwards.
pub fn calibrate(board: &mut Board, seed: u64) -> [u32; 3] {
    let (rig, mut wearer) = (rig(), wearer(seed));
    let mut session = Session::new(board, &mut wearer, rig.drum().fastest_mm_per_s, &Display::Silent);
    let transcript = session.calibrate(12, 5, 0).unwrap();
    transcript.live_centre_mm.map(f32::to_bits)
}

fn rig() -> Rig<f64> {
    Rig::shoulder(ASSUMED_BASE_RADIUS_MM).unwrap()
}

/// The wearer with this seed; the board of [`calibrated`] has the third one's centre.
pub fn wearer(seed: u64) -> Wearer {
    Wearer::new(rig(), WearerSettings { seed, noise_mm: 0.1, ..WearerSettings::default() })
}

/// Waits until the arm has been seen to rest, and starts a run in which poses are captured by command only.
pub fn collect(board: &mut Board) {
    hear(board, 1_000);
    send(board, Opcode::Start, 0, 1);
    assert_eq!(state(&hear(board, 200)), Some(StateName::Collecting));
}

/// Everything that the board says in so many milliseconds.
pub fn hear(board: &mut Board, ms: u32) -> Vec<Message> {
    let unpack = |frame: &Frame| Message::unpack(frame, BaseId::DEFAULT).unwrap();
    board.pass(ms).unwrap().iter().map(unpack).collect()
}

/// Asks for everything that is known; what the board says to that.
pub fn query(board: &mut Board) -> Vec<Message> {
    send(board, Opcode::Query, 0, 0);
    hear(board, 300)
}

/// Sends a command; the nonce that its answer will have.
pub fn send(board: &mut Board, opcode: Opcode, run_id: u16, argument: u16) -> u16 {
    // never the same one within a second, or it would not be obeyed
    let nonce = (board.now_ms() as u16).max(1);
    let frame = Request { opcode: opcode as u8, boot: 0, nonce, run_id, argument }.pack(BaseId::DEFAULT.command());
    board.send(&frame).unwrap();
    nonce
}

/// The centre in use, to the bit; None if there is none.
pub fn live(said: &[Message]) -> Option<[u32; 3]> {
    let axis = |index: u8| {
        said.iter().find_map(|message| match message {
            Message::LiveCentre(value) if value.index == index => Some(value.value_mm.to_bits()),
            _ => None,
        })
    };
    Some([axis(0)?, axis(1)?, axis(2)?])
}

/// Why the board started last.
pub fn cause(said: &[Message]) -> Option<ResetCause> {
    said.iter().find_map(|message| match message {
        Message::Versions(versions) => Some(versions.reset_cause),
        _ => None,
    })
}

/// Where and why the firmware stopped.
pub fn last_stop(said: &[Message]) -> Option<LastStop> {
    said.iter().find_map(|message| match message {
        Message::LastStop(stop) => Some(*stop),
        _ => None,
    })
}

/// How the controller fares, as last told.
pub fn health(said: &[Message]) -> Option<BusHealth> {
    said.iter().rev().find_map(|message| match message {
        Message::BusHealth(health) => Some(*health),
        _ => None,
    })
}

/// A fault of this code was told, as there or as over.
pub fn is_fault(said: &[Message], code: Reason) -> bool {
    faults_told(said).any(|fault| fault.0 == code)
}

/// The faults told, in order and without repetitions: the code, the cable, and whether it lasts. That nobody has saved parameters on this
/// board is left out: it is told of every new board until somebody does.
pub fn faults(said: &[Message]) -> Vec<(Reason, u8, bool)> {
    let mut faults: Vec<_> = faults_told(said).filter(|fault| fault.0 != Reason::ParametersDamaged).collect();
    faults.dedup();
    faults
}

fn faults_told(said: &[Message]) -> impl Iterator<Item = (Reason, u8, bool)> {
    said.iter().filter_map(|message| match message {
        Message::Fault(fault) => Some((fault.code, fault.cable, fault.active)),
        _ => None,
    })
}

/// The answers to commands, in order.
pub fn answers(said: &[Message]) -> Vec<Answer> {
    let answer = |message: &Message| if let Message::Answer(answer) = message { Some(*answer) } else { None };
    said.iter().filter_map(answer).collect()
}

/// The frames that were counted.
pub fn counters(said: &[Message]) -> Option<Counters> {
    said.iter().rev().find_map(|message| if let Message::Counters(counters) = message { Some(*counters) } else { None })
}

/// The heartbeats, in order.
pub fn beats(said: &[Message]) -> Vec<Heartbeat> {
    let beat = |message: &Message| if let Message::Heartbeat(heartbeat) = message { Some(*heartbeat) } else { None };
    said.iter().filter_map(beat).collect()
}

/// The state, as last told.
pub fn state(said: &[Message]) -> Option<StateName> {
    beats(said).last().map(|heartbeat| heartbeat.state)
}

/// Heartbeats heard.
pub fn heartbeats(said: &[Message]) -> usize {
    beats(said).len()
}
