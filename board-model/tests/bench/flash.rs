//! The record's flash: option bytes, protection, torn words, and power cuts in every operation of a store.

use crate::scene::{
    calibrate, calibrated, faults, hear, heartbeats, image, is_fault, kept_board, live, new_board, query,
};
use board_model::board::Board;
use board_model::peripheral::words::Word;
use board_model::power_cuts;
use glenoid::can::{BaseId, Message, Operation, ParameterRequest};
use glenoid::procedure::Reason;
use host_tests::rehearse::Bench;

const DBANK: u32 = 1 << 22;
const BFB2: u32 = 1 << 20;
/// The record's two pages in the second bank: the first two of the storage, which begins 500 KiB behind the flash's start.
const PAGES: [usize; 2] = [122, 123];

/// B13: wrong option bytes. The board says so, begins without a centre, works on, and writes nothing, whatever is asked of it: a
/// calibration's centre is in use until the supply goes, and a save is refused.
#[test]
fn wrong_option_bytes_are_told() {
    for wrong in [0xFFEF_F8AA & !DBANK, 0xFFEF_F8AA | BFB2] {
        let mut cells = calibrated().0;
        cells.optr = wrong;
        let before = cells.words.clone();
        let mut board = Board::power_on(image(), cells, 3);
        let said = hear(&mut board, 3_000);
        assert!(faults(&said).contains(&(Reason::FlashLayout, 0, true)), "{wrong:#x}: {said:?}");
        assert_eq!(live(&query(&mut board)), None);
        let new = calibrate(&mut board, 5);
        let said = hear(&mut board, 3_000);
        assert!(faults(&said).contains(&(Reason::FlashLayout, 0, true)), "{wrong:#x}: {said:?}");
        assert_eq!(live(&query(&mut board)), Some(new));
        let saved = ParameterRequest { operation: Operation::Save as u8, index: 0, nonce: 1, value: 0 };
        board.send(&saved.pack(BaseId::DEFAULT.parameters())).unwrap();
        let said = hear(&mut board, 500);
        let refused = |message: &Message| matches!(message, Message::Parameter(answer) if answer.code != Reason::Fine);
        assert!(said.iter().any(refused), "{wrong:#x}: {said:?}");
        assert_eq!(live(&query(&mut board)), Some(new));
        assert_eq!(board.machine.chip().flash.operations, 0, "{wrong:#x}");
        assert!(board.machine.chip().flash.cells.words == before, "{wrong:#x}: something was written");
        assert_eq!(board.machine.resets, []);
        assert_eq!(board.complaints(), [""; 0]);
        // set right, the old record is there as it was
        board.machine.chip_mut().flash.cells.optr = 0xFFEF_F8AA;
        board.power_cycle();
        hear(&mut board, 50);
        assert_eq!(live(&query(&mut board)), Some(calibrated().1));
    }
}

/// B13: the record's pages are protected: the new centre is in use, which is told, and the old record stays.
#[test]
fn a_protected_flash_is_told_after_an_accept() {
    let mut board = kept_board();
    board.machine.chip_mut().flash.cells.protected.extend(PAGES);
    let new = calibrate(&mut board, 5);
    let said = hear(&mut board, 3_000);
    assert!(is_fault(&said, Reason::StoreRefused), "{said:?}");
    assert_eq!(live(&query(&mut board)), Some(new));
    board.power_cycle();
    hear(&mut board, 50);
    assert_eq!(live(&query(&mut board)), Some(calibrated().1));
    assert_eq!(board.complaints(), [""; 0]);
}

/// B4: a word of the record that cannot be corrected strikes as an NMI and reads as zeros: the record is damaged, the
/// program goes on. The other page is erased, so there is no centre.
#[test]
fn a_torn_word_of_the_record_ends_in_no_restart() {
    let mut cells = calibrated().0;
    let from = PAGES[0] * 256;
    let holds = |words: &[Word], page: usize| matches!(words[page * 256], Word::Whole(_));
    let page = if holds(&cells.words, PAGES[0]) { from } else { from + 256 };
    cells.words[page + 7] = Word::Broken(0x0123_4567_89AB_CDEF);
    let mut board = Board::power_on(image(), cells, 3);
    let said = hear(&mut board, 3_000);
    assert!(is_fault(&said, Reason::RecordDamaged), "{said:?}");
    assert_eq!(live(&query(&mut board)), None);
    assert_eq!(board.machine.resets, []);
    assert_eq!(board.complaints(), [""; 0]);
}

/// B3: the power fails in flash operations of a calibration and of a save, and in the recovery: always the old or the new.
/// `board-model/run run --bin power-cut -- 10000` cuts as often as one likes.
#[test]
fn no_power_cut_loses_a_centre() {
    let tally = power_cuts::campaign(&image(), &calibrated().0, 60, 1);
    println!("{tally}");
    assert!(tally.cuts >= 60, "{tally}");
    assert_eq!(tally.failures(), 0, "{tally:?}");
}

/// A board that is switched on for the first time holds whatever was in its flash: that is told as a damaged record and
/// damaged parameters, since nobody can tell it from them, and is over with the first accept and the first save.
#[test]
fn noise_in_the_flash_of_a_new_board_is_told_until_something_is_stored() {
    let mut board = new_board();
    let said = hear(&mut board, 3_000);
    assert!(is_fault(&said, Reason::RecordDamaged), "{said:?}");
    assert!(is_fault(&said, Reason::ParametersDamaged), "{said:?}");
    let new = calibrate(&mut board, 5);
    hear(&mut board, 3_000);
    board.power_cycle();
    let said = hear(&mut board, 3_000);
    assert!(!is_fault(&said, Reason::RecordDamaged), "{said:?}");
    assert_eq!(live(&query(&mut board)), Some(new));
    assert_eq!(board.machine.resets, []);
    assert_eq!(board.complaints(), [""; 0]);
}

/// While a record is stored the heartbeat goes on, the sampling misses nothing, and no load waits for the flash.
#[test]
fn a_store_holds_nothing_up() {
    let mut board = kept_board();
    board.machine.chip_mut().flash.journal = Some(Vec::new());
    calibrate(&mut board, 5);
    let said = hear(&mut board, 300);
    assert!(heartbeats(&said) >= 2, "{said:?}");
    let operations = board.machine.chip_mut().flash.journal.take().unwrap();
    assert!(operations.len() >= 43, "{} flash operations", operations.len());
    let flash = &board.machine.chip().flash;
    assert_eq!(flash.stalls, 0, "loads that waited for the flash");
    assert_eq!(board.complaints(), [""; 0]);
}
