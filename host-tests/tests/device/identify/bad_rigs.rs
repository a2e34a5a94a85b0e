//! Rig files that cannot be read, or whose rig cannot be: each complaint names file, line and column.

use super::command::Desk;
use super::recorded::{csv, shoulder};

const BASE: &str = "base = [[150, 0, 0], [-75, 129.9, 0], [-75, -129.9, 0]]\n";
const EDGES: &str = "edges = [178.4, 178.4, 178.4]\n";

#[test]
fn each_complaint_names_its_place() {
    let desk = Desk::new("bad_rigs");
    desk.put("log.csv", csv(&shoulder(1, 10, 0.0)));
    let with_edges = |base: &str| format!("{EDGES}base = {base}\n");
    let with_base = |edges: &str| format!("{BASE}edges = {edges}\n");
    let cases: Vec<(String, &str)> = vec![
        ("".into(), "line 1, column 1: base = [[x, y, z], [x, y, z], [x, y, z]], in mm, is missing"),
        (BASE.into(), "line 2, column 1: edges = [p12, p23, p31], in mm, is missing"),
        (with_edges("12"), "line 2, column 8: base: 3 points are wanted, not integer"),
        (with_edges("[[1, 0, 0], [0, 1, 0]]"), "line 2, column 8: base: 3 points are wanted, there are 2"),
        (
            with_edges("[[150, 0, 0],\n  [-75, 129.9],\n  [-75, -129.9, 0]]"),
            "line 3, column 3: a point of base: 3 numbers are wanted, there are 2",
        ),
        (
            with_edges("[[150, 0, 0], [-75, \"129\", 0], [-75, -129.9, 0]]"),
            "line 2, column 28: a point of base: a number is wanted, not the text \"129\"",
        ),
        (with_base("[178.4, nan, 178.4]"), "line 2, column 17: edges: \"nan\" is not a finite number"),
        (with_base("[178.4, 178.4, -inf]"), "line 2, column 24: edges: \"-inf\" is not a finite number"),
        (with_base("[178.4, 178.4, 1e999]"), "line 2, column 24: edges: \"1e999\" is not a finite number"),
        (
            with_base("[100, 100, 201]"),
            "line 2, column 9: the platform's edges do not make a triangle: [100.0, 100.0, 201.0]",
        ),
        (
            with_base("[178.4, 178.4, 0]"),
            "line 2, column 9: the platform's edges do not make a triangle: [178.4, 178.4, 0.0]",
        ),
        (
            with_edges("[[150, 0, 0], [-75, 129.9, 0], [150, 0, 0]]"),
            "line 2, column 8: the attachment points B3 and B1 coincide",
        ),
        (
            with_edges("[[150, 0, 0], [0, 0, 0], [-75, 0, 0]]"),
            "line 2, column 8: attachment points coincide or lie on one line",
        ),
        (
            with_edges("[[150, 0, 0], [-75, 0, 129.9], [-75, 0, -129.9]]"),
            "line 2, column 8: the base plane is parallel to the z axis of {B}",
        ),
        (
            with_edges("[[0.15, 0, 0], [-0.075, 0.1299, 0], [-0.075, -0.1299, 0]]"),
            "line 2, column 8: the longest side of the base is 0.2598: this looks like metres; millimetres are wanted",
        ),
        (
            with_base("[7.02, 7.02, 7.02]"),
            "line 2, column 9: the longest edge of the platform is 7.0200: this looks like inches; millimetres are \
             wanted",
        ),
        (
            format!("{BASE}{EDGES}[start]\nvalues = [0, 0, 148, 140.8, 140.8]\n"),
            "line 4, column 10: values of start: 6 numbers are wanted, there are 5",
        ),
        (
            format!("{BASE}{EDGES}[start]\nvalues = [0, 0, 148, 140.8, 0, 140.8]\n"),
            "line 4, column 10: the radii p1, p2, p3 of the start must be positive",
        ),
        (
            format!("{BASE}{EDGES}[start]\n"),
            "line 3, column 1: start: a section with values = [x, y, z, p1, p2, p3] is wanted",
        ),
        (
            format!("{BASE}{EDGES}\nbsae = 3\n[drum2]\nradius = 15\n"),
            "line 4, column 1: unknown key \"bsae\": the file may hold base, edges, home, joint, cable, noise, tolerance, zeros, drum, covariance, hinge, start, truth",
        ),
        (
            format!("# a misspelt key is refused, not taken for a missing one\nBase = 1\n{EDGES}"),
            "line 2, column 1: unknown key \"Base\": the file may hold base, edges, home, joint, cable, noise, tolerance, zeros, drum, covariance, hinge, start, truth",
        ),
        (
            format!("{BASE}{EDGES}[start]\nvalues = [0, 0, 148, 140, 140, 140]\nvaleus = 1\n"),
            "line 5, column 1: unknown key \"valeus\": start may hold values",
        ),
    ];
    for (rig, expected) in cases {
        for (ends, rig) in [("LF", rig.clone()), ("CRLF", rig.replace('\n', "\r\n"))] {
            let ran = desk.put("rig.toml", &rig).identify("log.csv --rig rig.toml");
            assert_eq!((ran.code, ran.stdout.as_str()), (Some(1), ""), "{rig}: {ran:?}");
            assert_eq!(ran.stderr, format!("cargo identify: rig.toml, {expected}\n"), "{rig} with {ends}");
        }
    }
}

#[test]
fn errors_of_the_language_name_their_place() {
    let desk = Desk::new("toml_syntax");
    desk.put("log.csv", csv(&shoulder(1, 10, 0.0)));
    for (rig, place) in [
        (format!("{BASE}edges = [178.4, 178.4 178.4]\n"), "line 2, column "),
        (format!("{BASE}{EDGES}{EDGES}"), "line 3, column 1: "),
        (format!("{BASE}\n\n= 3\n"), "line 4, column 1: "),
        ("base = [[1, 2, 3]".to_owned(), "line 1, column "),
        ("base".to_owned(), "line 1, column "),
        (format!("{}1{}", "[".repeat(5_000), "]".repeat(5_000)), "line 1, column "),
    ] {
        let ran = desk.put("rig.toml", &rig).identify("log.csv --rig rig.toml");
        assert_eq!((ran.code, ran.stdout.as_str()), (Some(1), ""), "{ran:?}");
        assert!(ran.stderr.starts_with(&format!("cargo identify: rig.toml, {place}")), "{ran:?}");
        assert_eq!(ran.stderr.lines().count(), 1, "{ran:?}");
    }
    let ran = desk.put("rig.toml", [b"# caf\xe9\n".as_slice(), BASE.as_bytes()].concat());
    let ran = ran.identify("log.csv --rig rig.toml");
    assert_eq!(ran.stderr, "cargo identify: rig.toml, line 1, column 6: not UTF-8 text\n");
}

#[test]
fn a_rig_of_another_make_is_solved() {
    // The log's own rig, written in another way: exponents, hexadecimal, a byte order mark, comments.
    let desk = Desk::new("other_make");
    desk.put("log.csv", csv(&shoulder(1, 30, 0.0)));
    let base = "base = [[1.5e2, 0, 0x0], [-75.0, 129.903810567666, 0.0], [\n  -7_5, -129.903810567666, 0]] # mm\n";
    desk.put(
        "rig.toml",
        format!("\u{feff}edges = [178.398206, 178.398206, 178.398206]\n{base}[truth]\nnot = 'read'\n"),
    );
    let ran = desk.identify("log.csv --rig rig.toml --json");
    assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""), "{ran:?}");
    let centre = ran.json()["centre_mm"].clone();
    for (found, truth) in centre.as_array().unwrap().iter().zip(super::recorded::CENTRE_MM) {
        assert!((found.as_f64().unwrap() - truth).abs() < 1e-4, "{centre}");
    }
}

/// The shoulder in six `[[cable]]` tables; `more` is added to the one with this number.
pub fn six_cables(number: usize, more: &str) -> String {
    let points = ["150, 0, 0", "-75, 129.9, 0", "-75, -129.9, 0"];
    let ends = ["51.5, 89.2, 96", "-103, 0, 96", "51.5, -89.2, 96"];
    let base = [0, 1, 1, 2, 2, 0];
    let cable = |k: usize| {
        let more = if k + 1 == number { more } else { "" };
        format!("[[cable]]\nbase = [{}]\nend = [{}]\n{more}", points[base[k]], ends[k / 2])
    };
    (0..6).map(cable).collect()
}

/// Ends, pulleys and tolerances: each complaint names the file, the line, and the thing.
#[test]
fn what_cannot_be_of_a_built_machine_names_its_place() {
    let desk = Desk::new("bad_machines");
    desk.put("log.csv", csv(&shoulder(1, 10, 0.0)));
    let tolerance = |lines: &str| format!("{BASE}{EDGES}[tolerance]\n{lines}");
    let coinciding = six_cables(0, "").replacen("-103, 0, 96", "51.5, 89.2, 96", 2);
    for (rig, place, what) in [
        (format!("{BASE}{}", six_cables(0, "")), "line 1, ", "base and [[cable]] contradict each other"),
        (six_cables(0, "").replacen("[[cable]]", "[[table]]", 1), "line 1, ", "unknown key"),
        (six_cables(3, "pulley_radius = 5\n"), "line 7, ", "pulley_axis"),
        (six_cables(3, "pulley_axis = [0, 0, 1]\n"), "line 10, ", "pulley_axis without pulley_radius"),
        (six_cables(2, "pulley_radius = -5\npulley_axis = [0, 0, 1]\n"), "line 7, ", "a radius is not negative"),
        (six_cables(2, "pulley_radius = 5\npulley_axis = [0, 0, 0]\n"), "line 8, ", "the direction has no length"),
        (
            six_cables(4, "pulley_radius = 300\npulley_axis = [0, 0, 1]\n"),
            "line 1, ",
            "cable 4: a pulley of 300 mm cannot be reached",
        ),
        (coinciding, "line 1, ", "cables 2 and 3"),
        (tolerance("base = -0.5\n"), "line 4, column 8: ", "base = -0.5: a tolerance is negative or absurd"),
        (
            tolerance("base = 0.5\nedges = 1000\n"),
            "line 5, column 9: ",
            "edges = 1000: a tolerance is negative or absurd",
        ),
        (tolerance("drum = 0.5\n"), "line 4, column 8: ", "drum = 0.5: a tolerance is negative or absurd"),
        (tolerance("zero = nan\n"), "line 4, column 8: ", "not a finite number"),
        (format!("{BASE}{EDGES}[noise]\nsample = 0.1\n"), "line 3, ", "pose = "),
        (
            format!("{BASE}{EDGES}[noise]\npose = -0.1\n"),
            "line 4, column 8: ",
            "pose: a noise of -0.1 mm is not within",
        ),
        (format!("{BASE}{EDGES}[noise]\npose = 0.02\nsample = 11\n"), "line 5, column 10: ", "a noise of 11 mm"),
        (format!("{BASE}{EDGES}[noise]\npose = 0.02\nsamples = 0\n"), "line 5, column 11: ", "a whole number of 1 to"),
        (
            format!("{BASE}{EDGES}[noise]\npose = 0.02\nsamples = 4.5\n"),
            "line 5, column 11: ",
            "a whole number of 1 to",
        ),
        (format!("{BASE}{EDGES}[drum]\nscale = [1, 1, 1, 1, 1, 2]\n"), "line 3, ", "scale is off by more than 20 %"),
        (format!("{BASE}{EDGES}[zeros]\nmm = [1, 1]\n"), "line 4, ", "6 numbers are wanted, there are 2"),
    ] {
        let ran = desk.put("rig.toml", &rig).identify("log.csv --rig rig.toml");
        assert_eq!((ran.code, ran.stdout.as_str()), (Some(1), ""), "{rig}: {ran:?}");
        assert!(ran.stderr.starts_with(&format!("cargo identify: rig.toml, {place}")), "{rig}: {ran:?}");
        assert!(ran.stderr.contains(what), "{rig}: {ran:?}");
    }
}
