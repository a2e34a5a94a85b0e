//! What is refused: exit code 2, a reason, its figures, and a remedy.

use super::command::{Desk, Ran, numbers};
use super::recorded::{about, csv, shoulder, wandering};
use serde_json::{Value, json};

/// Runs and checks what every refusal has in common.
fn refused(desk: &Desk, arguments: &str) -> (Ran, Value) {
    let ran = desk.identify(&format!("log.csv {arguments} --json"));
    assert_eq!(ran.code, Some(2), "{ran:?}");
    let found = ran.json();
    assert_eq!(found["status"], json!("refused"));
    assert!(found["reason"].as_str().is_some_and(|reason| !reason.is_empty()));
    for key in ["centre_mm", "radii_mm", "sigma_mm", "deviation_mm", "weak_direction"] {
        assert_eq!(found[key], Value::Null, "{key}");
    }
    let told = desk.identify(&format!("log.csv {arguments}"));
    assert_eq!(told.code, Some(2), "{told:?}");
    (told, found)
}

#[test]
fn poses_about_one_axis_and_the_axis() {
    let desk = Desk::new("one_axis");
    let axis = [0.6, 0.8, 0.0];
    desk.put("log.csv", csv(&about(axis, 12)));
    for precision in ["f32", "f64"] {
        let (told, found) = refused(&desk, &format!("--precision {precision}"));
        assert_eq!(found["reason"], json!("degenerate: all poses turn about one axis"));
        let named = numbers(&found["refusal"], "axis");
        let along: f64 = named.iter().zip(axis).map(|(a, b)| a * b).sum();
        // an axis has no sign; within one degree
        assert!(along.abs() > 1f64.to_radians().cos(), "{named:?}");
        assert!(told.words().contains("about another axis"), "{told:?}");
    }
}

#[test]
fn poses_that_are_all_alike() {
    let desk = Desk::new("alike");
    // Rows this near count as one pose.
    desk.put("log.csv", csv(&[shoulder(1, 1, 0.0), shoulder(1, 1, 0.0), shoulder(1, 1, 0.0)].concat()));
    let (_, found) = refused(&desk, "");
    assert_eq!(found["refusal"], json!({ "kind": "too_few_poses", "poses": 1 }));
}

#[test]
fn fewer_than_three_poses() {
    let desk = Desk::new("too_few");
    desk.put("log.csv", csv(&shoulder(1, 2, 0.0)));
    for method in ["full", "paper"] {
        let (told, found) = refused(&desk, &format!("--method {method}"));
        assert_eq!(found["refusal"], json!({ "kind": "too_few_poses", "poses": 2 }));
        assert!(told.words().contains("2 poses in log.csv"), "{told:?}");
    }
}

#[test]
fn three_poses_that_nothing_checks() {
    let desk = Desk::new("three_poses");
    desk.put("log.csv", csv(&shoulder(13, 3, 0.1)));
    let (told, found) = refused(&desk, "");
    assert_eq!(found["refusal"]["kind"], json!("hangs_on_one_pose"));
    assert!(found["refusal"]["pose"].as_u64() < Some(3), "{found}");
    assert!(told.words().contains("Add poses"), "{told:?}");
}

#[test]
fn zeros_that_a_handful_of_poses_does_not_determine() {
    let desk = Desk::new("zeros_unknown");
    desk.put("log.csv", csv(&shoulder(12, 6, 0.1)));
    let (told, found) = refused(&desk, "--zeros --noise 0.06");
    assert_eq!(found["refusal"]["kind"], json!("zero_not_determined"));
    assert!(told.words().contains("home the cables"), "{told:?}");
}

#[test]
fn a_start_that_is_too_far_off() {
    let desk = Desk::new("far_start");
    desk.put("log.csv", csv(&shoulder(1, 10, 0.0)));
    let (told, found) = refused(&desk, "--method paper --start 0,0,600,20,20,20");
    assert_eq!(found["refusal"]["kind"], json!("not_closing"));
    assert!(told.words().contains("--start nearer to the truth"), "{told:?}");
    assert!(told.words().contains("--method full"), "{told:?}");
}

#[test]
fn readings_that_contradict_each_other() {
    let desk = Desk::new("outliers");
    let mut log = shoulder(2, 20, 0.1);
    for (pose, row) in log.iter_mut().enumerate().take(9) {
        row[pose % 6] += 4.0 + pose as f64;
    }
    desk.put("log.csv", csv(&log));
    let (told, found) = refused(&desk, "--noise 0.06");
    assert_eq!(found["refusal"]["kind"], json!("too_many_outliers"));
    assert_eq!(found["refusal"]["poses"], json!(20));
    assert!(told.words().contains("slack cables"), "{told:?}");
}

#[test]
fn another_rig_than_the_log_was_recorded_with() {
    let desk = Desk::new("other_rig");
    // The base of the log has a radius of 150 mm.
    let base = [[165.0, 0.0], [-82.5, 142.894], [-82.5, -142.894]].map(|[x, y]| format!("[{x}, {y}, 0.0]")).join(", ");
    desk.put("log.csv", csv(&shoulder(2, 40, 0.1)));
    desk.put("rig.toml", format!("base = [{base}]\nedges = [178.398, 178.398, 178.398]\n"));
    for noise in ["", "--noise 0.06"] {
        let (told, found) = refused(&desk, &format!("--rig rig.toml --joint ball {noise}"));
        assert!(found["reason"].is_string());
        assert!(told.words().contains("what to do"), "{told:?}");
    }
}

#[test]
fn a_centre_that_wanders() {
    let desk = Desk::new("wanders");
    desk.put("log.csv", csv(&wandering(9, 40, 0.05, 4.0)));
    let (_, found) = refused(&desk, "--noise 0.03");
    assert_eq!(found["refusal"]["kind"], json!("not_explained"));
    let (told, found) = refused(&desk, "--noise 0.03 --joint ball");
    assert_eq!(found["refusal"]["kind"], json!("not_a_ball"));
    let wander_mm = found["refusal"]["wander_mm"].as_f64().unwrap();
    // 4 mm of amplitude along one of three axes: 2.8 mm root mean square, 1.6 mm spread over three
    assert!((0.8..4.0).contains(&wander_mm), "{wander_mm}");
    assert!(told.words().contains("tighten the straps"), "{told:?}");
}

#[test]
fn the_refusal_reads_like_this() {
    let desk = Desk::new("refusal_text");
    let ran = desk.put("log.csv", csv(&about([0.0, 1.0, 0.0], 9))).identify("log.csv");
    assert_eq!(ran.stdout, include_str!("refused.txt"));
}
