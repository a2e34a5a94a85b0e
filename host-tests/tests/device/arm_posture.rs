//! `cargo arm` where one thing is wrong: a length of the posture, a log, a joint. What is named is what was put wrong here.

use super::arm::{Scene, csv};
use super::identify::command::{Ran, numbers};
use clap::Parser;
use glenoid::rig::Rig;
use host_tests::anatomy::Shoulder;
use host_tests::rehearse::Options;
use host_tests::wearer::Wearer;

/// The lengths of a module's posture as they stand in the arm's file.
fn posture(arm: &str, module: &str) -> Vec<f64> {
    let section = arm.split(&format!("[{module}]")).nth(1).unwrap();
    let list = section.split("posture = [").nth(1).unwrap().split(']').next().unwrap();
    list.split(',').map(|number| number.trim().parse().unwrap()).collect()
}

/// The arm's file with other lengths there.
fn with_posture(arm: &str, module: &str, lengths_mm: &[f64]) -> String {
    arm.replace(&format!("{:?}", posture(arm, module)), &format!("{lengths_mm:?}"))
}

fn refused(ran: &Ran, module: &str) -> serde_json::Value {
    let report = ran.json();
    assert_eq!((ran.code, report["module"].as_str()), (Some(2), Some(module)), "{ran:?}");
    assert!(report["hand"].is_null(), "{report}");
    report
}

#[test]
fn a_wrong_length_of_the_posture_is_named_with_its_cable() {
    let scene = Scene::new("arm_wrong_length", 1, 120.0);
    for (module, cable, too_long_mm) in
        [("shoulder", 3, 20.0), ("shoulder", 6, -7.0), ("elbow", 2, 20.0), ("elbow", 4, -6.0), ("wrist", 1, 6.0)]
    {
        let mut lengths_mm = posture(&scene.arm, module);
        lengths_mm[cable - 1] += too_long_mm;
        let arm = with_posture(&scene.arm, module, &lengths_mm);
        let report = refused(&scene.run(&arm, "--json"), module);
        let found = &report["posture"];
        assert!(found["chi_square"].as_f64().unwrap() > found["limit"].as_f64().unwrap(), "{report}");
        // Another one may explain it nearly as well.
        let causes = found["causes"].as_array().unwrap();
        let cause = causes.iter().find(|cause| cause["cable"].as_u64() == Some(cable as u64));
        let off_mm = cause.unwrap_or_else(|| panic!("{report}"))["too_long_mm"].as_f64().unwrap() - too_long_mm;
        assert!(off_mm.abs() < 1.0 && causes.len() <= 2, "{module} {cable}: {off_mm} {report}");
        let words = scene.run(&arm, "").words();
        assert!(
            words.contains("this alone would explain it: ") && words.contains(&format!("cable {cable} is")),
            "{words}"
        );
        assert!(words.contains(&format!("posture = [...] of [{module}] in arm.toml")), "{words}");
    }
}

#[test]
fn exchanged_lengths_of_the_posture_are_named() {
    let scene = Scene::new("arm_exchanged_lengths", 1, 120.0);
    for (module, one, other) in [("shoulder", 1, 2), ("elbow", 1, 3), ("wrist", 4, 6)] {
        let mut lengths_mm = posture(&scene.arm, module);
        lengths_mm.swap(one - 1, other - 1);
        let report = refused(&scene.run(&with_posture(&scene.arm, module, &lengths_mm), "--json"), module);
        assert_eq!(numbers(&report["posture"]["causes"][0], "cables"), [one as f64, other as f64], "{report}");
    }
}

/// None of those has a place in the file that could be read otherwise.
#[test]
fn what_is_no_posture_or_no_log_of_a_module_is_named_with_its_place() {
    let scene = Scene::new("arm_no_posture", 1, 120.0);
    let arm = &scene.arm;
    let metres = |lengths: &[Vec<f64>]| -> Vec<Vec<f64>> {
        lengths.iter().map(|row| row.iter().map(|length| length / 1000.0).collect()).collect()
    };
    let [shoulder, elbow, wrist] = scene.logs.each_ref().map(|log| csv(&metres(log)));
    scene.desk.put("metres0.csv", shoulder).put("metres1.csv", elbow).put("metres2.csv", wrist);
    scene.desk.put("copy.csv", csv(&scene.logs[0]));
    let negative: Vec<_> = posture(arm, "elbow").iter().map(|length| -length).collect();
    for (text, complaint) in [
        (with_posture(arm, "elbow", &negative), "posture: a length is positive"),
        (arm.replace("shoulder.csv", "metres0.csv"), "metres0.csv, line 2, column 1: l1: the median length is"),
        (arm.replace("elbow.csv", "metres1.csv"), "metres1.csv, line 2, column 1: l1: the median length is"),
        (arm.replace("wrist.csv", "metres2.csv"), "these look like metres; millimetres are wanted"),
        (arm.replace("wrist.csv", "copy.csv"), "wrist: the log is that of the shoulder"),
        (arm.replace("elbow.csv", "shoulder.csv"), "elbow: the log is that of the shoulder"),
        (arm.clone() + "sigma_deg = 200.0\n", "sigma_deg: a standard deviation of 0 to 30 is wanted"),
        (arm.clone() + "sigma_mm = 1e9\n", "sigma_mm: a standard deviation of 0 to 100 is wanted"),
    ] {
        let ran = scene.run(&text, "");
        assert_eq!(ran.code, Some(1), "{complaint}: {ran:?}");
        assert!(ran.stderr.contains(complaint) && ran.stdout.is_empty(), "{complaint}: {ran:?}");
    }
}

/// What a module's refusal says to do is a command that can be typed, and refuses the same log.
#[test]
fn the_command_of_a_remedy_refuses_the_same_log() {
    let stiff = Scene::new("arm_remedy", 1, 10.0);
    let few = Scene::new("arm_remedy_few", 1, 120.0);
    few.desk.put("shoulder.csv", csv(&few.logs[0][..3]));
    for (scene, module) in [(&stiff, "elbow"), (&few, "shoulder")] {
        let report = refused(&scene.run(&scene.arm, "--json"), module);
        let remedy = report["remedy"].as_str().unwrap();
        let arguments = remedy.split("cargo identify -- ").nth(1).unwrap();
        assert!(arguments.contains(&format!("{module}.csv --rig {module}.toml --noise")), "{remedy}");
        let ran = scene.desk.identify(arguments);
        assert_eq!(ran.code, Some(2), "{ran:?}");
        assert!(ran.words().contains(report["reason"].as_str().unwrap()), "{ran:?}");
    }
}

#[test]
fn a_shoulder_whose_centre_moves_is_named() {
    let scene = Scene::new("arm_moving", 1, 120.0);
    let options = Options::try_parse_from(["rehearse", "--shoulder", "1", "--poses", "60"]).unwrap();
    let mut person = Wearer::new(Rig::shoulder(150.0).unwrap(), options.wearer());
    person.wear(Shoulder::new(1, 0.0));
    let moving: Vec<_> = (0..60).map(|_| person.next_pose().spans_mm.to_vec()).collect();
    scene.desk.put("shoulder.csv", csv(&moving));
    let ran = scene.run(&scene.arm, "--json");
    let report = refused(&ran, "shoulder");
    assert!(report["reason"].as_str().unwrap().starts_with("its centre moves with the limb"), "{ran:?}");
    assert!(report["remedy"].as_str().unwrap().contains("shoulder blade held"), "{ran:?}");
}

/// The file that the document shows, with the logs that it names.
#[test]
fn the_arm_of_the_document_is_found() {
    let document = include_str!("../../../docs/commands.md");
    let section = document.split("## A whole arm").nth(1).unwrap();
    let arm = section.split("```toml").nth(1).unwrap().split("```").next().unwrap();
    let scene = Scene::new("arm_document", 1, 120.0);
    let ran = scene.run(arm, "--json");
    assert_eq!(ran.code, Some(0), "{ran:?}");
    // Every key of the report that the document names is there, and the other way round.
    let keys = document.split("prints one object:").nth(1).unwrap().split("An elbow's own log").next().unwrap();
    for key in ran.json().as_object().unwrap().keys() {
        assert!(keys.contains(&format!("`{key}`")), "{key} is not in the document");
    }
}
