//! A rig whose joint is a hinge, from the outside.

use super::command::{Desk, numbers};
use glenoid::rig::Tolerance;
use host_tests::study::elbow::scene::{Elbow, cables, drawn, flexions_rad};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::fmt::Write as _;

const RIG: &str = include_str!("../../../../examples/elbow.toml");
/// The same with the drawing as a prior.
fn with_prior() -> String {
    RIG.replace("# sigma_", "sigma_")
}

/// The same with a good drawing.
fn good_drawing() -> String {
    with_prior()
        .replace("_deg = 9.0", "_deg = 3.0")
        .replace("_mm = 12.0", "_mm = 3.0")
        .replace("_mm = 8.0", "_mm = 3.0")
}

/// The elbow of the drawing, a little off, and a log of it.
fn log(seed: u64, poses: usize, count: usize, most_deg: f64) -> (Elbow, String) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let step = [0.03, -0.05, 4.0, -3.0, 0.04, 0.02, 2.0, 3.0, -2.0];
    let elbow = Elbow::of_hinge(&mut random, count, &drawn().moved(&step), &Tolerance::exact());
    let flexions = flexions_rad(&mut random, poses, most_deg);
    let mut csv = "time,l1,l2,l3,l4\n".to_owned();
    for (row, reading) in elbow.readings_mm(&mut random, &flexions).iter().enumerate() {
        let cells: Vec<_> = reading.iter().take(count).map(|length| format!("{length:.4}")).collect();
        writeln!(csv, "{row},{}", cells.join(",")).unwrap();
    }
    let header = (1..=count).map(|cable| format!("l{cable}")).collect::<Vec<_>>().join(",");
    (elbow, csv.replace("l1,l2,l3,l4", &header))
}

/// The rig of the first cables.
fn fewer(rig: &str, count: usize) -> String {
    let parts: Vec<_> = rig.split("[[cable]]").collect();
    let last = parts[4].split("\n\n").skip(1).collect::<Vec<_>>().join("\n\n");
    let home = vec!["230.0"; count].join(", ");
    let head = parts[0].replace("home = [230.0, 230.0, 230.0, 230.0]", &format!("home = [{home}]"));
    format!("{head}[[cable]]{}\n{last}", parts[1..=count].join("[[cable]]"))
}

#[test]
fn the_example_elbow_is_the_rig_of_the_study() {
    for (text, cable) in RIG.split("[[cable]]").skip(1).zip(cables()) {
        let of = |key: &str| -> Vec<f64> {
            let list = text.split(&format!("{key} = [")).nth(1).unwrap().split(']').next().unwrap();
            list.split(',').map(|number| number.trim().parse().unwrap()).collect()
        };
        for (found, stated) in [(of("base"), cable.base_mm), (of("end"), cable.end_mm)] {
            assert!(found.iter().zip(&stated).all(|(a, b)| (a - b).abs() < 1e-3), "{found:?} {stated:?}");
        }
    }
}

#[test]
fn an_elbow_is_identified_in_both_precisions() {
    let desk = Desk::new("hinge_accepted");
    let (elbow, csv) = log(1, 30, 4, 120.0);
    desk.put("log.csv", csv).put("rig.toml", RIG);
    let truth = elbow.hinge();
    for precision in ["f64", "f32"] {
        let ran = desk.identify(&format!("log.csv --rig rig.toml --noise 0.0577 --precision {precision} --json"));
        assert_eq!(ran.code, Some(0), "{ran:?}");
        let found = ran.json();
        assert_eq!((found["status"].as_str(), found["joint"].as_str()), (Some("accepted"), Some("hinge")));
        let axis = nalgebra::Vector3::from_vec(numbers(&found, "axis"));
        let sigma = |key: &str| found[key].as_f64().unwrap();
        let off_deg = axis.cross(truth.axis()).norm().asin().to_degrees();
        assert!(off_deg < 4.0 * sigma("axis_sigma_deg"), "{off_deg}");
        assert!((0.02..0.6).contains(&sigma("axis_sigma_deg")), "{}", sigma("axis_sigma_deg"));
        let point = nalgebra::Vector3::from_vec(numbers(&found, "point_mm"));
        let off_mm = (point - truth.nearest_mm(&point)).norm();
        assert!(off_mm < 4.0 * sigma("point_sigma_mm") + 0.3 * sigma("axis_sigma_deg"), "{off_mm}");
        assert!((80.0..=120.0).contains(&sigma("flexion_deg")));
        // Rows that show the same angle are one pose.
        let used = found["poses_used"].as_u64().unwrap();
        assert!((25..=30).contains(&used), "{used}");
        assert_eq!(numbers(&found, "angles_deg").len() as u64, used);
    }
    let words = desk.identify("log.csv --rig rig.toml --noise 0.0577").words();
    assert!(words.starts_with("ACCEPTED: a hinge axis in base"), "{words}");
}

/// The log with so much uniform noise more, mm, in every length.
fn noisier(csv: &str, most_mm: f64) -> String {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut noisy = |(column, cell): (usize, &str)| match cell.parse::<f64>() {
        Ok(length) if column > 0 => format!("{:.4}", length + random.random_range(-most_mm..most_mm)),
        _ => cell.to_owned(),
    };
    let line = |line: &str| line.split(',').enumerate().map(&mut noisy).collect::<Vec<_>>().join(",");
    csv.lines().map(line).collect::<Vec<_>>().join("\n")
}

#[test]
fn the_noise_of_an_elbow_is_what_its_rig_states() {
    let desk = Desk::new("hinge_noise");
    // σ = 0.577 mm: ten times what is expected of a cable.
    let csv = noisier(&log(1, 40, 4, 120.0).1, 1.0);
    // √(0.4² + 2² / 25) = 0.566.
    let stated = good_drawing() + "\n[noise]\npose = 0.4\nsample = 2.0\nsamples = 25\n";
    desk.put("log.csv", csv).put("silent.toml", good_drawing()).put("rig.toml", stated);
    let ran = desk.identify("log.csv --rig silent.toml --json");
    assert_eq!((ran.code, ran.json()["given_noise_mm"].as_f64()), (Some(2), None), "{ran:?}");
    let ran = desk.identify("log.csv --rig rig.toml --json");
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert!((ran.json()["given_noise_mm"].as_f64().unwrap() - 0.5657).abs() < 1e-4, "{ran:?}");
    // What is typed counts before what is stated.
    let ran = desk.identify("log.csv --rig rig.toml --noise 0.6 --json");
    assert_eq!(ran.json()["given_noise_mm"].as_f64(), Some(0.6), "{ran:?}");
}

#[test]
fn fewer_cables_want_a_drawing_and_say_so() {
    for count in [2, 3] {
        let desk = Desk::new(&format!("hinge_{count}_cables"));
        let (elbow, csv) = log(2, 20, count, 110.0);
        desk.put("log.csv", csv)
            .put("bare.toml", fewer(RIG, count))
            .put("drawn.toml", fewer(&good_drawing(), count))
            .put("vague.toml", fewer(&with_prior(), count));
        let ran = desk.identify("log.csv --rig bare.toml --json");
        assert_eq!(ran.code, Some(2), "{ran:?}");
        let refusal = &ran.json()["refusal"];
        assert_eq!(refusal["kind"].as_str(), Some("too_few_cables"));
        assert_eq!(refusal["determined"].as_u64(), Some(if count == 2 { 5 } else { 8 }));
        let words = desk.identify("log.csv --rig bare.toml").words();
        assert!(words.contains("section [hinge], with sigma_deg and sigma_mm"), "{words}");

        let ran = desk.identify("log.csv --rig drawn.toml --json");
        assert_eq!(ran.code, Some(0), "{ran:?}");
        let axis = nalgebra::Vector3::from_vec(numbers(&ran.json(), "axis"));
        let off_deg = axis.cross(elbow.hinge().axis()).norm().asin().to_degrees();
        assert!(off_deg < 4.0 * ran.json()["axis_sigma_deg"].as_f64().unwrap(), "{off_deg}");
        let ran = desk.identify("log.csv --rig vague.toml --json");
        assert_eq!((ran.code, ran.json()["refusal"]["kind"].as_str()), (Some(2), Some("weak")), "{ran:?}");
    }
}

#[test]
fn an_elbow_that_never_bends_is_refused_by_name() {
    let desk = Desk::new("hinge_stiff");
    let (_, csv) = log(3, 20, 4, 12.0);
    desk.put("log.csv", csv).put("rig.toml", RIG);
    let ran = desk.identify("log.csv --rig rig.toml --noise 0.0577");
    assert_eq!(ran.code, Some(2));
    assert!(ran.words().contains("Bend further"), "{}", ran.words());
}

/// The rig's figures in metres.
fn in_metres(rig: &str) -> String {
    let numbers = |line: &str| -> String {
        let Some((key, list)) = line.split_once('[').filter(|_| line.contains(" = [")) else { return line.to_owned() };
        let (list, rest) = list.split_once(']').unwrap();
        let metres: Vec<_> = list.split(',').map(|mm| mm.trim().parse::<f64>().unwrap() / 1000.0).collect();
        format!("{key}{metres:?}{rest}")
    };
    rig.lines().map(numbers).collect::<Vec<_>>().join("\n")
}

#[test]
fn lengths_that_are_none_of_an_elbow_are_named() {
    let desk = Desk::new("hinge_bad_lengths");
    let (_, csv) = log(4, 12, 4, 120.0);
    let rows: Vec<Vec<f64>> =
        csv.lines().skip(1).map(|row| row.split(',').map(|x| x.parse().unwrap()).collect()).collect();
    let scaled = |factor: f64| {
        rows.iter().fold("l1,l2,l3,l4\n".to_owned(), |text, row| {
            let cells: Vec<_> = row[1..].iter().map(|mm| format!("{:.6}", mm * factor)).collect();
            text + &cells.join(",") + "\n"
        })
    };
    desk.put("rig.toml", RIG);
    for (factor, unit) in [(1e-3, "metres"), (0.1, "centimetres"), (1.0 / 25.4, "inches")] {
        desk.put("log.csv", scaled(factor));
        let ran = desk.identify("log.csv --rig rig.toml");
        assert_eq!(ran.code, Some(1), "{unit}: {ran:?}");
        assert!(ran.stderr.contains(&format!("these look like {unit}; millimetres are wanted")), "{}", ran.stderr);
    }
    for factor in [10.0, 1e9] {
        let slipped = format!("{}", rows[3][3] * factor);
        desk.put("log.csv", csv.replace(&format!("{:.4}", rows[3][3]), &slipped));
        let ran = desk.identify("log.csv --rig rig.toml");
        assert_eq!(ran.code, Some(1), "{ran:?}");
        assert!(ran.stderr.contains("line 5, column 4: l3: "), "{}", ran.stderr);
        assert!(ran.stderr.contains("look for a slip of the decimal point"), "{}", ran.stderr);
    }
    // Rows of one pose are called what they are, and counted.
    let row = csv.lines().nth(1).unwrap();
    desk.put("log.csv", format!("time,l1,l2,l3,l4\n{row}\n{row}\n"));
    let ran = desk.identify("log.csv --rig rig.toml");
    assert!(
        ran.stderr.contains("1 of 2 rows repeat a pose that stands there already (all lengths equal"),
        "{}",
        ran.stderr
    );
    assert!(ran.stderr.contains("1 pose left"), "{}", ran.stderr);
}

#[test]
fn a_rig_that_is_no_hinges_is_named_with_its_place() {
    let desk = Desk::new("hinge_bad_rigs");
    let (_, csv) = log(4, 12, 4, 120.0);
    desk.put("log.csv", &csv);
    let drum = "\n[tolerance]\ndrum = 0.001\n";
    for (rig, complaint) in [
        (RIG.replace("\"hinge\"", "\"elbow\""), "line 4, column 9: joint: \"ball\" or \"hinge\" is wanted"),
        (
            RIG.replace("axis = [1.0, 0.0, 0.0]\npoint ", "axis = [0.0, 0.0, 0.0]\npoint "),
            "axis: the direction has no length",
        ),
        (RIG.replace("point = [0.0, 0.0, 160.0]\n", ""), "point = [x, y, z], in mm, is missing"),
        (RIG.replace("range_deg = [-140.0, 15.0]", "range_deg = [15.0, -140.0]"), "range_deg: [smallest, largest]"),
        (
            RIG.replace("range_deg = [-140.0, 15.0]", "range_deg = [-2.44, 0.26]"),
            "line 30, column 13: range_deg: a range of 2.7 looks like radians; degrees are wanted",
        ),
        (RIG.replace("# sigma_deg", "sigma_deg"), "sigma_deg and sigma_mm belong together"),
        (with_prior().replace("sigma_mm = 12.0", "sigma_mm = -1.0"), "sigma_mm: a standard deviation is positive"),
        (RIG.replace("home", "# home") + drum, "home = [4 lengths] is wanted"),
        (RIG.replace("230.0, 230.0]", "230.0]"), "home: [4 lengths] is wanted, one a cable"),
        (fewer(RIG, 1), "two to four tables [[cable]], there are 1"),
        (RIG.replace("joint = \"hinge\"", "joint = \"hinge\"\nedges = [1.0, 1.0, 1.0]"), "edges is not for a hinge"),
        (RIG.replace("range_deg", "ranges_deg"), "unknown key"),
        (RIG.to_owned() + "\n[noise]\npose = 0.0\n", "pose: a noise of 0 mm is not within"),
        (RIG.replace("range_deg = [-140.0, 15.0]", "range_deg = [400.0, 500.0]"), "each from -360 to 360"),
        (RIG.replace("point = [0.0, 0.0, 160.0]", "point = [0.0, 0.0, 1e30]"), "point: coordinates within 2000 mm"),
        (
            RIG.replace("# sigma_along_mm", "sigma_along_mm"),
            "line 34, column 18: sigma_along_mm wants sigma_deg and sigma_mm beside it",
        ),
        (RIG.replace("# sigma_in_platform_mm", "sigma_in_platform_mm"), "sigma_in_platform_mm wants sigma_deg"),
        (
            RIG.replace(
                "base = [42.426, -42.426, 0.0]\nend = [15.391, -42.286",
                "base = [42.426, 42.426, 0.0]\nend = [15.391, 42.286",
            ),
            "cables 1 and 4: both ends",
        ),
        (
            RIG.replacen("end = [15.391, -42.286, 0.0]", "end = [15.391, -42.286, 0.0]\npulley_radius = 1e6", 1),
            "line 22, column 17: pulley_radius: a radius is not negative, and below 1000 mm",
        ),
        (RIG.to_owned() + "\n[tolerance]\nbase = 0.5\nzero = -0.3\n", "column 8: zero = -0.3: a tolerance is negative"),
        (in_metres(RIG), "this looks like metres; millimetres are wanted"),
        (
            RIG.replace("joint = \"hinge\"\n", ""),
            "hinge: a ball has no such section; for an elbow joint = \"hinge\" is wanted",
        ),
        (
            RIG.replace("joint = \"hinge\"\n", "").split("[hinge]").next().unwrap().to_owned(),
            "cable: a ball has six tables [[cable]], there are 4; for an elbow joint = \"hinge\" is wanted",
        ),
    ] {
        let rig = if complaint.starts_with("home: ") { rig + drum } else { rig };
        desk.put("rig.toml", &rig);
        let ran = desk.identify("log.csv --rig rig.toml");
        assert_eq!(ran.code, Some(1), "{complaint}: {ran:?}");
        assert!(ran.stderr.contains(complaint), "{complaint}: {}", ran.stderr);
    }
    desk.put("rig.toml", RIG).put("short.csv", csv.replace(",l4", ",x"));
    let ran = desk.identify("short.csv --rig rig.toml");
    assert_eq!(ran.code, Some(1));
    assert!(ran.stderr.contains("the column l4 is missing"), "{}", ran.stderr);
    let ran = desk.identify("log.csv --rig rig.toml --method paper --noise 0.0577");
    assert!(ran.stderr.contains("--method paper is not for a hinge"), "{}", ran.stderr);
}

/// The elbow is within 5 mm of the drawing; one that is drawn 100 mm further out, to 1 mm, contradicts it.
#[test]
fn a_wrong_drawing_is_named_and_not_the_joint() {
    let desk = Desk::new("hinge_wrong_drawing");
    let (elbow, csv) = log(1, 30, 4, 120.0);
    let wrong = good_drawing().replace("0.0, 160.0]", "0.0, 260.0]").replace("_mm = 3.0", "_mm = 1.0");
    desk.put("log.csv", csv).put("wrong.toml", wrong).put("right.toml", good_drawing());
    let ran = desk.identify("log.csv --rig wrong.toml --noise 0.0577 --json");
    assert_eq!(ran.code, Some(2), "{ran:?}");
    let off_mm = ran.json()["drawing_off"]["place_mm"].as_f64().unwrap();
    let drawn = nalgebra::Vector3::new(0.0, 0.0, 260.0);
    assert!((off_mm - (elbow.hinge().nearest_mm(&drawn) - drawn).norm()).abs() < 3.0, "{off_mm}");
    let words = desk.identify("log.csv --rig wrong.toml --noise 0.0577").words();
    assert!(words.contains("remedy Correct the drawing in the section [hinge]"), "{words}");
    assert!(!words.contains("pronation"), "{words}");
    let ran = desk.identify("log.csv --rig right.toml --noise 0.0577 --json");
    assert!(ran.code == Some(0) && ran.json()["drawing_off"].is_null(), "{ran:?}");
}
