//! The button: a contact that sticks, and a wire that is cut.

use crate::scene::{beats, calibrated, collect, faults, hear, kept_board, live, query, state};
use board_model::board::Board;
use board_model::peripheral::gpio::Wire;
use glenoid::procedure::{Reason, StateName};

/// PC13.
const BUTTON: (usize, u32) = (2, 13);
const STUCK: Reason = Reason::ButtonStuck;

/// A press that is long enough to start a run.
fn long_press(board: &mut Board) {
    board.press(true);
    hear(board, 1_500);
    board.press(false);
}

/// A contact that sticks is told, and does nothing else, in no run and in one; when it has come loose the fault is over, the
/// release is no press, and the button works again.
#[test]
fn a_stuck_button_is_told_and_ignored() {
    for in_run in [false, true] {
        let mut board = kept_board();
        if in_run {
            collect(&mut board);
        }
        let before = *beats(&hear(&mut board, 200)).last().unwrap();
        board.spoil(BUTTON, Some(Wire::High));
        let said = hear(&mut board, 14_000);
        assert_eq!(faults(&said), [(STUCK, 0, true)]);
        let same = |now: &glenoid::can::status::Heartbeat| {
            (now.state, now.run_id, now.poses) == (before.state, before.run_id, before.poses) && now.flags.live
        };
        assert!(beats(&said).len() >= 139 && beats(&said).iter().all(same), "{said:?}");
        assert_eq!(live(&query(&mut board)), Some(calibrated().1));
        board.spoil(BUTTON, None);
        let said = hear(&mut board, 1_000);
        assert_eq!(faults(&said), [(STUCK, 0, false)]);
        assert!(beats(&said).iter().all(same), "{said:?}");
        if !in_run {
            long_press(&mut board);
            assert_eq!(state(&hear(&mut board, 500)), Some(StateName::Collecting));
        }
        assert_eq!(board.machine.resets, []);
        assert_eq!(board.complaints(), [""; 0]);
    }
}

/// One that is closed when the supply comes on is stuck from the start.
#[test]
fn a_button_that_is_stuck_at_power_up_starts_nothing() {
    let mut board = kept_board();
    board.spoil(BUTTON, Some(Wire::High));
    board.power_cycle();
    let said = hear(&mut board, 3_000);
    assert!(faults(&said).contains(&(STUCK, 0, true)), "{said:?}");
    assert!(beats(&said).iter().all(|now| now.state == StateName::Idle), "{said:?}");
    board.spoil(BUTTON, None);
    let said = hear(&mut board, 1_000);
    assert!(faults(&said).contains(&(STUCK, 0, false)), "{said:?}");
    assert_eq!(state(&said), Some(StateName::Idle));
}
