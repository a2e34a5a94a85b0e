//! B15: why the chip started is told, whatever the cause, and the centre is in use again.

use crate::scene::{calibrated, cause, hear, kept_board, live, query};
use board_model::peripheral::rcc::Cause;
use glenoid::restart::ResetCause;

#[test]
fn every_cause_is_told() {
    let causes = [
        (Cause::Power, ResetCause::PowerOn),
        (Cause::Pin, ResetCause::Pin),
        (Cause::Software, ResetCause::Requested),
        (Cause::Watchdog, ResetCause::Watchdog),
        (Cause::WindowWatchdog, ResetCause::Watchdog),
        (Cause::OptionBytes, ResetCause::OptionBytes),
        (Cause::LowPower, ResetCause::Unknown),
    ];
    for (by, told) in causes {
        let mut board = kept_board();
        board.machine.reset(by);
        hear(&mut board, 50);
        let said = query(&mut board);
        assert_eq!(cause(&said), Some(told), "{by:?}");
        assert_eq!(live(&said), Some(calibrated().1), "{by:?}");
        assert_eq!(board.complaints(), [""; 0]);
    }
}

/// Without its crystal the firmware waits: lamp dark, bus silent, and no restart.
#[test]
fn without_a_crystal_it_waits() {
    let mut board = kept_board();
    board.power_cycle();
    board.machine.chip_mut().rcc.crystal = false;
    assert_eq!(hear(&mut board, 1_000), []);
    assert!(!board.lamp());
    assert_eq!(board.machine.resets, []);
}
