//! What is accepted, and how it is told.

use super::command::{Desk, data, difference, numbers};
use super::recorded::{CENTRE_MM, RADII_MM, csv, not_homed, shoulder};
use serde_json::{Value, json};

/// The keys that the design promises, in their order.
const PROMISED: [&str; 11] = [
    "status",
    "reason",
    "centre_mm",
    "radii_mm",
    "sigma_mm",
    "deviation_mm",
    "deviations_mm",
    "iterations",
    "rejected",
    "zeros_mm",
    "weak_direction",
];

fn desk_with_speed_problem(test: &str) -> Desk {
    let desk = Desk::new(test);
    desk.put("log.csv", data("speed-problem.csv")).put("rig.toml", data("speed-problem.toml"));
    desk
}

fn centre_and_radii(found: &Value) -> Vec<f64> {
    [numbers(found, "centre_mm"), numbers(found, "radii_mm")].concat()
}

#[test]
fn the_speed_problem_is_solved_by_both_methods_in_both_precisions() {
    let desk = desk_with_speed_problem("speed_problem");
    // [truth] of the rig file
    let truth = [0.0, 0.0, 148.0, 140.8, 140.8, 140.8];
    for (method, precision, tolerance_mm) in
        [("full", "f64", 1e-9), ("full", "f32", 1e-4), ("paper", "f64", 1e-5), ("paper", "f32", 1e-3)]
    {
        let ran = desk.identify(&format!("log.csv --rig rig.toml --method {method} --precision {precision} --json"));
        assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""), "{method} {precision}");
        let found = ran.json();
        let error_mm = difference(&centre_and_radii(&found), &truth);
        assert!(error_mm < tolerance_mm, "{method} {precision}: off by {error_mm} mm");
        assert_eq!((&found["method"], &found["precision"]), (&json!(method), &json!(precision)));
        assert_eq!(found["rejected"], json!([]));
        assert_eq!(numbers(&found, "deviations_mm").last(), found["deviation_mm"].as_f64().as_ref());
    }
}

#[test]
fn the_keys_come_in_the_promised_order() {
    let desk = desk_with_speed_problem("keys");
    desk.put("two.csv", csv(&shoulder(1, 2, 0.0)));
    for arguments in ["log.csv --rig rig.toml --json", "two.csv --json"] {
        let text = desk.identify(arguments).stdout;
        let places: Vec<_> = PROMISED.iter().map(|key| text.find(&format!("\"{key}\":")).unwrap()).collect();
        assert!(places.is_sorted(), "{text}");
        // serde_json writes a struct in the order of its fields; a map would begin with another key
        assert!(text.starts_with("{\"status\":"), "{text}");
    }
}

#[test]
fn both_precisions_agree_on_a_noisy_log_and_the_error_bar_holds_the_truth() {
    let desk = Desk::new("precisions");
    for seed in 0..5 {
        desk.put("log.csv", csv(&shoulder(seed, 30, 0.1)));
        let [single, double] =
            ["f32", "f64"].map(|precision| desk.identify(&format!("log.csv --precision {precision} --json")).json());
        let (single_mm, double_mm) = (centre_and_radii(&single), centre_and_radii(&double));
        assert!(difference(&single_mm, &double_mm) < 1e-3, "{single_mm:?} {double_mm:?}");
        let sigma_mm = numbers(&double, "sigma_mm");
        for ((found, truth), sigma) in double_mm.iter().zip(CENTRE_MM.iter().chain(&RADII_MM)).zip(&sigma_mm) {
            // four sigma: one value in 16 000, and there are thirty here
            assert!((found - truth).abs() < 4.0 * sigma, "{found} instead of {truth}, sigma {sigma}");
            assert!((1e-3..1.0).contains(sigma), "{sigma}");
        }
        let noise_mm = double["noise_mm"].as_f64().unwrap();
        // uniform within ±0.1 mm: 0.0577 mm; 84 degrees of freedom know it to 8 %
        assert!((0.04..0.075).contains(&noise_mm), "{noise_mm}");
        let length: f64 = numbers(&double, "weak_direction").iter().map(|x| x * x).sum();
        assert!((length - 1.0).abs() < 1e-9, "{length}");
    }
}

#[test]
fn a_given_noise_scales_the_error_bar() {
    let desk = desk_with_speed_problem("noise");
    let sigma = |noise: &str| {
        let found = desk.identify(&format!("log.csv --rig rig.toml --json --noise {noise}")).json();
        assert_eq!(found["given_noise_mm"], found["noise_mm"]);
        assert_eq!(found["noise_mm"].as_f64(), noise.parse().ok());
        numbers(&found, "sigma_mm")
    };
    let (fine, coarse) = (sigma("0.01"), sigma("0.1"));
    for (fine, coarse) in fine.iter().zip(&coarse) {
        assert!((coarse / fine - 10.0).abs() < 1e-6, "{fine} {coarse}");
    }
}

#[test]
fn a_slipped_cable_is_left_out_and_named() {
    let desk = Desk::new("slipped");
    let mut log = shoulder(3, 30, 0.1);
    log[17][3] += 5.0;
    desk.put("log.csv", csv(&log));
    for precision in ["f32", "f64"] {
        let ran = desk.identify(&format!("log.csv --json --precision {precision}"));
        assert_eq!(ran.code, Some(0), "{ran:?}");
        let found = ran.json();
        assert_eq!(found["rejected"], json!([{ "pose": 17, "cable": 4 }]), "{precision}");
        assert_eq!(found["poses_used"], json!(29));
        assert!(difference(&numbers(&found, "centre_mm"), &CENTRE_MM) < 0.3);
    }
    let ran = desk.identify("log.csv");
    // row 17 from 0 stands in line 19: the header is line 1
    assert!(ran.words().contains("29 used, 1 left out: pose 17 (line 19): cable 4 "), "{ran:?}");
}

#[test]
fn a_broken_triangle_in_one_row_is_a_pose_left_out_not_an_unreadable_file() {
    let desk = Desk::new("broken_triangle");
    let mut log = shoulder(4, 20, 0.05);
    log[6][0] = 2000.0;
    let ran = desk.put("log.csv", csv(&log)).identify("log.csv --json");
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let entries = ran.json()["rejected"].as_array().unwrap().clone();
    assert!(!entries.is_empty() && entries.iter().all(|entry| entry["pose"] == json!(6)), "{entries:?}");
    assert!(entries.contains(&json!({ "pose": 6, "cable": 1 })), "{entries:?}");
}

#[test]
fn of_many_rows_an_even_spread_is_used_and_told() {
    let desk = Desk::new("many");
    let mut log = shoulder(5, 800, 0.05);
    // The last row is used, and is the 128th pose that the solver sees; the one before it is not used.
    log[799][1] += 8.0;
    log[798][2] += 8.0;
    desk.put("log.csv", csv(&log));
    let found = desk.identify("log.csv --json").json();
    assert_eq!(found["rows_used"], json!({ "of": 800, "count": 128, "first": 0, "step": 799.0 / 127.0, "last": 799 }));
    assert_eq!(found["rejected"], json!([{ "pose": 799, "cable": 2 }]));
    let told = "128 of 800 used, evenly spread: row 0 (line 2), then every 6.29 rows, to row 799 (line 801)";
    assert!(desk.identify("log.csv").words().contains(told));
}

#[test]
fn the_papers_method_says_where_it_begins() {
    let desk = desk_with_speed_problem("start");
    let from = |arguments: &str| {
        let ran = desk.identify(&format!("log.csv --method paper --json {arguments}"));
        ran.json()["start"].clone()
    };
    let given = from("--rig rig.toml --start -1.5,2,150,140,141,142");
    assert_eq!(given, json!({ "from": "--start", "values_mm": [-1.5, 2.0, 150.0, 140.0, 141.0, 142.0] }));
    assert_eq!(from("--rig rig.toml")["from"], json!("[start] of the rig file"));
    let nominal = from("");
    assert_eq!(nominal["from"], json!("the shoulder's nominal centre and radii"));
    assert_eq!(nominal["values_mm"], json!([0.0, 0.0, 148.0, 140.8, 140.8, 140.8]));
}

#[test]
fn the_papers_method_tells_of_residuals_that_are_no_noise() {
    let desk = Desk::new("no_centre");
    // Three poses out of the air that happen to lead the iteration to an end.
    desk.put(
        "log.csv",
        "l1,l2,l3,l4,l5,l6\n\
         339.68,252.35,150,220.4,216.75,231.59\n\
         320.33,185.41,163.35,216.07,240.77,342.93\n\
         150,188.31,150,266.01,332.1,244.13\n",
    );
    let ran = desk.identify("log.csv --method paper");
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert!(ran.words().contains("these poses have no common centre, or some are bad"), "{ran:?}");
    assert_eq!(desk.identify("log.csv").code, Some(2));
    let sound = desk_with_speed_problem("sound").identify("log.csv --rig rig.toml --method paper");
    assert!(!sound.words().contains("no common centre"), "{sound:?}");
}

#[test]
fn what_is_not_used_is_told() {
    let desk = desk_with_speed_problem("not_used");
    let told = |arguments: &str| {
        let ran = desk.identify(&format!("log.csv {arguments}"));
        assert_eq!(ran.code, Some(0), "{ran:?}");
        ran.stderr
    };
    assert_eq!(
        told("--rig rig.toml --start 0,0,148,140,140,140"),
        "cargo identify: warning: --start is not used: the full method needs none (--method paper begins there)\n"
    );
    assert_eq!(
        told("--rig rig.toml --method paper --noise 0.1"),
        "cargo identify: warning: --noise is not used: the paper's method takes its standard deviation from its own residuals\n"
    );
    assert_eq!(
        told("--rig rig.toml --method paper --zeros"),
        "cargo identify: warning: --zeros is not used: the paper's method takes the zeros for known\n"
    );
}

/// The shoulder over a 150 mm base, with no tolerance.
const EXACT_SHOULDER: &str = "base = [[150, 0, 0], [-75, 129.903810567666, 0], [-75, -129.903810567666, 0]]\n\
     edges = [178.3981997, 178.3981997, 178.3981997]\n";

#[test]
fn unknown_encoder_zeros_are_identified_when_asked_for() {
    let desk = Desk::new("zeros");
    let truth = [3.0, -5.0, 8.0, -2.0, 6.0, -7.0];
    desk.put("log.csv", csv(&not_homed(shoulder(10, 60, 0.1), truth)));
    // Exact but for the zeros.
    desk.put("rig.toml", EXACT_SHOULDER);
    desk.put("second.csv", csv(&not_homed(shoulder(11, 20, 0.1), truth)));
    for precision in ["f32", "f64"] {
        let ran = desk
            .identify(&format!("log.csv --rig rig.toml --zeros --verify second.csv --json --precision {precision}"));
        assert_eq!(ran.code, Some(0), "{ran:?}");
        let found = ran.json();
        let of_centre = difference(&numbers(&found, "centre_mm"), &CENTRE_MM);
        let worst = found["worst_centre"]["sigma_mm"].as_f64().unwrap();
        assert!(of_centre < 4.0 * worst && worst < 0.5, "{precision}: {of_centre} {worst}");
        let homed = found["worst_sigma_if_homed_mm"].as_f64().unwrap();
        assert!(homed > 0.005 && homed < worst / 3.0, "{homed} of {worst}");
        let sigmas = numbers(&found, "zero_sigmas_mm");
        for ((zero, truth), sigma) in numbers(&found, "zeros_mm").iter().zip(truth).zip(&sigmas) {
            assert!((zero - truth).abs() < 4.0 * sigma && *sigma < 1.0, "{precision}: {zero} {truth} {sigma}");
        }
        let verified_mm = found["verification"]["deviation_mm"].as_f64().unwrap();
        assert!(verified_mm < 0.5, "{verified_mm}");
    }
    let told = desk.identify("log.csv --rig rig.toml --zeros").stdout;
    assert!(told.contains("mm too much at encoder") && told.contains("the centre depends on the zeros"), "{told}");
    // Not asked for, they are not looked for; and they are too large for noise.
    let without = desk.identify("log.csv --rig rig.toml --json --joint ball");
    assert_eq!((without.code, &without.json()["zeros_mm"]), (Some(2), &Value::Null));
}

#[test]
fn a_second_log_verifies_the_result() {
    let desk = Desk::new("verify");
    let mut second = shoulder(7, 25, 0.1);
    second[11][0] += 2.0;
    second[20][5] = 700.0;
    desk.put("first.csv", csv(&shoulder(6, 30, 0.1))).put("second.csv", csv(&second));
    let found = desk.identify("first.csv --verify second.csv --json").json();
    let verification = &found["verification"];
    assert_eq!(verification["pose_count"], json!(25));
    assert_eq!(verification["poses"].as_array().map(Vec::len), Some(24));
    assert_eq!(verification["worst_pose"], json!(11));
    assert_eq!(verification["contradicting"], json!([20]));
    assert!(verification["worst_deviation_mm"].as_f64() > verification["deviation_mm"].as_f64());
    let ran = desk.identify("first.csv --verify first.csv --json");
    assert!(ran.stderr.contains("poses that identify verify nothing"), "{}", ran.stderr);
    let same = ran.json();
    let deviation_mm = same["verification"]["deviation_mm"].as_f64().unwrap();
    assert!((0.01..0.3).contains(&deviation_mm), "{deviation_mm}");
    assert_eq!(same["verification"]["contradicting"], json!([]));
}

/// The layout without what another rounding may change: decimals and the count of iterations.
fn masked(text: &str) -> String {
    let mut decimals = false;
    let mask = |c: char| {
        decimals = c == '.' || (decimals && c.is_ascii_digit());
        if decimals && c != '.' { '#' } else { c }
    };
    let text: String = text.chars().map(mask).collect();
    match text.split_once(" iterations") {
        Some((before, after)) => {
            format!("{} # iterations{after}", before.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end())
        }
        None => text,
    }
}

#[test]
fn the_table_reads_like_this() {
    let desk = Desk::new("table");
    let mut log = shoulder(8, 40, 0.1);
    log[5][2] += 6.0;
    log[33].swap(0, 5);
    let ran = desk.put("log.csv", csv(&log)).identify("log.csv");
    assert_eq!(masked(&ran.stdout), include_str!("accepted.txt"));
}
