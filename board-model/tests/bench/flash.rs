//! The record's flash: option bytes, protection, torn words, and power cuts in every operation of a store.

use crate::scene::{calibrate, calibrated, hear, image, is_fault, kept_board, live, query};
use board_model::board::Board;
use board_model::peripheral::words::Word;
use board_model::power_cuts;
use glenoid::procedure::Reason;

const DBANK: u32 = 1 << 22;
const BFB2: u32 = 1 << 20;
/// The record's two pages in the second bank: the first two of the storage, which begins 500 KiB behind the flash's start.
const PAGES: [usize; 2] = [122, 123];

/// B13: wrong option bytes. The board says so, keeps nothing, and works on.
#[test]
fn wrong_option_bytes_are_told() {
    for wrong in [0xFFEF_F8AA & !DBANK, 0xFFEF_F8AA | BFB2] {
        let mut cells = calibrated().0;
        cells.optr = wrong;
        let before = cells.words.clone();
        let mut board = Board::power_on(image(), cells, 3);
        let said = hear(&mut board, 3_000);
        assert!(is_fault(&said, Reason::FlashLayout), "{wrong:#x}: {said:?}");
        assert_eq!(live(&query(&mut board)), None);
        assert!(board.machine.chip().flash.cells.words == before, "something was written");
        assert_eq!(board.complaints(), [""; 0]);
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

/// B3: the power fails in every flash operation of a store, and in the recovery: always the old centre or the new one,
/// and the next store works.
#[test]
#[ignore = "takes minutes; `board-model/run run --bin power-cut -- 10000` cuts as often as one likes"]
fn no_power_cut_loses_a_centre() {
    let tally = power_cuts::campaign(&image(), &calibrated().0, 100, 1);
    assert!(tally.cuts >= 100, "{tally:?}");
    assert_eq!((tally.lost, tally.wrong, tally.stuck), (0, 0, 0), "{tally:?}");
    assert_eq!(tally.complaints, [""; 0]);
}
