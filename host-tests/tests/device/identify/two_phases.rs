//! A shoulder whose centre moves, in one phase and in two: what is said of it, and of logs that do not belong together.

use super::bad_rigs::six_cables;
use super::command::{Desk, Ran};
use super::recorded::{Log, csv, exchanged, moving, not_homed, shoulder};
use serde_json::json;

const NOISE: &str = "--noise 0.0577";

/// Free poses, held ones, and free ones to verify on.
fn desk(test: &str) -> Desk {
    let desk = Desk::new(test);
    desk.put("free.csv", csv(&moving(1, 60, 45.0, 1.0)))
        .put("still.csv", csv(&held(20)))
        .put("second.csv", csv(&moving(3, 30, 45.0, 1.0)));
    desk
}

fn held(poses: usize) -> Log {
    moving(2, poses, 28.0, 0.1)
}

/// Exit 1, and what stands on stderr.
fn unreadable(ran: &Ran) -> &str {
    assert_eq!(ran.code, Some(1), "{ran:?}");
    assert_eq!(ran.stdout, "");
    &ran.stderr
}

#[test]
fn a_moving_centre_is_called_so() {
    let desk = desk("moving_centre");
    let one = desk.identify(&format!("free.csv {NOISE}"));
    assert_eq!(one.code, Some(0), "{one:?}");
    assert!(one.words().contains("joint a centre that moves with the arm, and scatters by 0."), "{one:?}");
    // What was found is no better explanation of itself.
    assert!(!one.words().contains("fits better"), "{one:?}");
    let two = desk.identify(&format!("free.csv {NOISE} --still still.csv --verify second.csv"));
    assert!(two.words().contains("held phase 20 poses in still.csv, none left out"), "{two:?}");
    assert!(two.words().contains("mean square of the cable lengths over 30 poses of second.csv"), "{two:?}");
    assert!(two.words().contains("they agree with the result"), "{two:?}");
}

#[test]
fn a_second_log_that_contradicts_says_so() {
    let desk = desk("contradicts");
    let off = not_homed(moving(3, 30, 45.0, 1.0), [9.0, -9.0, 9.0, -9.0, 9.0, -9.0]);
    desk.put("second.csv", csv(&off));
    let ran = desk.identify(&format!("free.csv {NOISE} --verify second.csv"));
    assert!(ran.words().contains("contradict the"), "{ran:?}");
}

#[test]
fn options_that_ask_for_a_fixed_and_a_moving_centre() {
    let desk = desk("options");
    for (arguments, both) in [
        ("--still still.csv --joint ball", ["--still", "--joint ball"]),
        ("--still still.csv --method paper", ["--still", "--method paper"]),
        ("--method paper --joint moving", ["--method paper", "--joint moving"]),
    ] {
        let ran = desk.identify(&format!("free.csv {arguments}"));
        assert!(both.iter().all(|option| unreadable(&ran).contains(option)), "{ran:?}");
        assert!(ran.stderr.contains("leave"), "{ran:?}");
    }
}

#[test]
fn poses_that_are_used_twice() {
    let desk = desk("used_twice");
    desk.put("copy.csv", csv(&moving(1, 60, 45.0, 1.0)[40..]));
    let ran = desk.identify("free.csv --still free.csv");
    for said in ["free.csv, line 2", "60 poses of free.csv stand here again", "or leave out --still"] {
        assert!(unreadable(&ran).contains(said), "{said}: {ran:?}");
    }
    // What is verified by them is shown, for what it is worth.
    for (arguments, file, known) in [
        ("--verify free.csv", "free.csv, line 2", "60 poses of free.csv"),
        ("--verify copy.csv", "copy.csv, line 2", "20 poses of free.csv stand here again, this one from its line 42"),
        ("--still still.csv --verify still.csv", "still.csv, line 2", "20 poses of still.csv"),
    ] {
        let ran = desk.identify(&format!("free.csv {arguments}"));
        assert_eq!(ran.code, Some(0), "{ran:?}");
        for said in [file, known, "poses that identify verify nothing"] {
            assert!(ran.stderr.contains(said), "{said}: {ran:?}");
        }
    }
}

/// Whatever is wrong with the held poses is said of their log, with a remedy for them.
#[test]
fn a_fault_of_the_held_poses_is_named_in_their_log() {
    let desk = desk("held_faults");
    let mut misread = held(20);
    for (pose, cable) in [(1, 0), (4, 3), (12, 5)] {
        misread[pose][cable] += 25.0;
    }
    for (name, log, seen) in [
        ("few", held(7), "7 poses in wrong.csv"),
        ("misread", misread, "pose 1 (line 3), pose 4 (line 6), pose 12 (line 14)"),
        ("wired", exchanged(held(20), 1, 2), "cables 2 and 3 are exchanged"),
        ("loose", moving(2, 20, 28.0, 1.0), "Let somebody hold the shoulder blade"),
    ] {
        desk.put("wrong.csv", csv(&log));
        let ran = desk.identify(&format!("free.csv {NOISE} --still wrong.csv"));
        assert_eq!(ran.code, Some(2), "{name}: {ran:?}");
        assert!(ran.words().contains(seen), "{name}: {ran:?}");
        assert!(!ran.words().contains("in free.csv"), "{name}: {ran:?}");
        let found = desk.identify(&format!("free.csv {NOISE} --still wrong.csv --json")).json();
        assert_eq!(found["held"]["refused"], json!(true), "{name}: {found}");
    }
}

#[test]
fn held_and_free_logs_that_are_exchanged() {
    let desk = desk("exchanged_logs");
    let ran = desk.identify(&format!("still.csv {NOISE} --still free.csv"));
    assert_eq!(ran.code, Some(2), "{ran:?}");
    assert!(ran.words().contains("exchange the two logs"), "{ran:?}");
}

#[test]
fn a_held_pose_that_is_left_out_is_named() {
    let desk = desk("held_left_out");
    let mut log = held(20);
    log[6][2] = 1e6;
    desk.put("still.csv", csv(&log));
    let ran = desk.identify(&format!("free.csv {NOISE} --still still.csv"));
    assert!(ran.words().contains("20 poses in still.csv, left out: pose 6 (line 8)"), "{ran:?}");
}

#[test]
fn exchanged_cables_of_a_moving_centre() {
    let desk = desk("moving_exchanged");
    for (one, other) in [(0, 1), (1, 2), (0, 5), (1, 4), (2, 3)] {
        desk.put("free.csv", csv(&exchanged(moving(1, 60, 45.0, 1.0), one, other)));
        let ran = desk.identify(&format!("free.csv {NOISE}"));
        assert_eq!(ran.code, Some(2), "{ran:?}");
        let named = format!("cables {} and {} are exchanged", one + 1, other + 1);
        assert!(ran.words().contains(&named), "{ran:?}");
    }
}

#[test]
fn a_centre_that_moves_on_a_machine_that_was_not_homed() {
    let desk = desk("moving_not_homed");
    let zeros = [8.0, -6.0, 3.0, 9.0, -7.0, 2.0];
    desk.put("free.csv", csv(&not_homed(moving(1, 60, 45.0, 1.0), zeros)));
    let ran = desk.identify(&format!("free.csv {NOISE} --zeros"));
    assert_eq!(ran.code, Some(2), "{ran:?}");
    assert!(ran.words().contains("Home the encoders, or commission the machine"), "{ran:?}");
    // The same option is no remedy for a ball.
    let ball = desk.put("ball.csv", csv(&not_homed(shoulder(4, 60, 0.1), zeros))).identify("ball.csv --zeros");
    assert_eq!(ball.code, Some(0), "{ball:?}");
}

/// With ends of its own for every cable, all of them uncertain, there are more unknowns than there is room for.
#[test]
fn a_machine_with_too_many_unknown_constants_says_which_are_to_be_known() {
    let desk = desk("six_ends");
    for (tolerance, code, said) in [
        ("base = 0.5\nedges = 0.5", 2, "A centre that moves was not tried"),
        ("zero = 0.3\ndrum = 0.001", 0, "a centre that moves with the arm"),
    ] {
        desk.put("rig.toml", format!("[tolerance]\n{tolerance}\n{}", six_cables(0, "")));
        let ran = desk.identify(&format!("free.csv {NOISE} --rig rig.toml"));
        assert_eq!(ran.code, Some(code), "{ran:?}");
        assert!(ran.words().contains(said), "{said}: {ran:?}");
    }
}
