//! Logs that cannot be read: each complaint names file, line and column. Logs that look odd but can be read.

use super::command::{Desk, Ran, data};
use super::recorded::{Log, csv, shoulder};

const HEADER: &str = "l1,l2,l3,l4,l5,l6\n";
const ROW: &str = "210,220,230,240,250,260\n";

/// Runs the command on a log that cannot be read, and gives what it says.
fn complaint(desk: &Desk, log: impl AsRef<[u8]>) -> String {
    let Ran { code, stdout, stderr } = desk.put("log.csv", log).identify("log.csv --json");
    assert_eq!((code, stdout.as_str()), (Some(1), ""), "{stderr}");
    let told = stderr.strip_prefix("cargo identify: log.csv, ").unwrap_or_else(|| panic!("{stderr}"));
    told.trim_end().to_owned()
}

#[test]
fn each_complaint_names_its_place() {
    let desk = Desk::new("bad_logs");
    let wanted = "the header l1,l2,l3,l4,l5,l6 is wanted";
    let rows = |bad: &str| format!("{HEADER}{ROW}{bad}\n{ROW}");
    let not_a_log = |seen: &str| {
        format!("line 1, column 1: no header l1,l2,l3,l4,l5,l6, but {seen:?}; is this a log of cable lengths?")
    };
    let cases: Vec<(String, String)> = vec![
        ("".into(), format!("line 1, column 1: the file is empty; {wanted}")),
        ("\n \r\n".into(), format!("line 1, column 1: the file is empty; {wanted}")),
        (HEADER.into(), "line 2, column 1: no pose follows the header".into()),
        (ROW.into(), format!("line 1, column 1: the first line holds numbers; {wanted} before them")),
        ("l1,l2,l4,l5,l6\n1,2,3,4,5\n".into(), "line 1, column 6: the column l3 is missing".into()),
        ("time,force\n1,2\n".into(), not_a_log("time,force")),
        (
            "l1 [mm],l2 [m],l3,l4,l5,l6\n".into(),
            "line 1, column 2: l2: the column is in metres; millimetres are wanted".into(),
        ),
        (
            rows("").replace(HEADER, "l1,l2,l3,l4,l5,l6\nmm,mm,mm,cm,mm,mm\n"),
            "line 2, column 4: l4: the column is in centimetres; millimetres are wanted".into(),
        ),
        ("l1,l2,l3,l3,l4,l5,l6\n".into(), "line 1, column 4: the column l3 appears twice".into()),
        (
            "l1;l2;l3;l4;l5;l6\n1,5;2,5;3.5;4,5;5,5;6,5".into(),
            "line 2, column 3: l3: \"3.5\" has a decimal point, the numbers before it have a comma".into(),
        ),
        (
            "l1;l2;l3;l4;l5;l6\n1,5;2,5;1.003,5;4,5;5,5;6,5".into(),
            "line 2, column 3: l3: \"1.003,5\" is not a number".into(),
        ),
        (
            "sep=;\nl1,l2,l3,l4,l5,l6\n".into(),
            "line 2, column 1: no column is called l1 to l6, if semicolons separate them as the line sep= says".into(),
        ),
        (rows("1,2,3,4,5"), "line 3, column 6: l6: missing; the line has 5 values".into()),
        (rows("1,2,3,4,5,6,7"), "line 3, column 7: 7 values where the header has 6".into()),
        (
            rows("210,5,220,5,230,5,240,5,250,5,260,5"),
            "line 3, column 7: 12 values where the header has 6 (is the comma the decimal sign?)".into(),
        ),
        (rows("210,220,slack,240,250,260"), "line 3, column 3: l3: \"slack\" is not a number".into()),
        (rows("210,220,,240,250,260"), "line 3, column 3: l3: empty".into()),
        (rows("210,220,230,NaN,250,260"), "line 3, column 4: l4: NaN mm: the length is not a finite number".into()),
        (rows("210,220,230,240,inf,260"), "line 3, column 5: l5: inf mm: the length is not a finite number".into()),
        (rows("1e999,220,230,240,250,260"), "line 3, column 1: l1: inf mm: the length is not a finite number".into()),
        (rows("210,220,230,240,250,-260"), "line 3, column 6: l6: -260 mm: the length is not positive".into()),
        (rows("210,0,230,240,250,260"), "line 3, column 2: l2: 0 mm: the length is not positive".into()),
        ("l6,l5,l4,l3,l2,l1\n6,5,4,x,2,1\n".into(), "line 2, column 4: l3: \"x\" is not a number".into()),
    ];
    for (log, expected) in cases {
        assert_eq!(complaint(&desk, &log), expected, "{log:?}");
        // The place is the same with the line ends of other systems, and blank lines count.
        assert_eq!(complaint(&desk, log.replace('\n', "\r\n")), expected, "{log:?} with CRLF");
    }
    assert_eq!(
        complaint(&desk, format!("{HEADER}\n\n{ROW}\r\n\r\nx,2,3,4,5,6\r\n")),
        "line 7, column 1: l1: \"x\" is not a number"
    );
}

#[test]
fn what_is_not_text_is_told() {
    let desk = Desk::new("not_text");
    let latin_1 = [HEADER.as_bytes(), b"1,2,3,4,\xb15,6\n"].concat();
    assert_eq!(complaint(&desk, latin_1), "line 2, column 5: l5: \"±5\" is not a number");
    assert!(complaint(&desk, [0u8; 64]).starts_with("line 1, column 1: no header l1,l2,l3,l4,l5,l6, but \"\\0\\0"));
    let utf_16: Vec<u8> = [0xff, 0xfe].into_iter().chain(HEADER.bytes().flat_map(|byte| [byte, 0])).collect();
    assert_eq!(
        complaint(&desk, [&utf_16[..], b"1"].concat()),
        "line 2, column 1: UTF-16 with an odd number of bytes: the file was cut"
    );
    assert_eq!(
        complaint(&desk, [&utf_16[..], &[0, 0xd8, b'1', 0]].concat()),
        "line 2, column 1: half a character of UTF-16"
    );
}

#[test]
fn another_unit_is_told_not_solved() {
    let desk = Desk::new("units");
    for (millimetres, unit) in [(1000.0, "metres"), (25.4, "inches"), (10.0, "centimetres"), (1e-3, "micrometres")] {
        let log: Log = shoulder(1, 20, 0.1).iter().map(|row| row.map(|length| length / millimetres)).collect();
        let told = complaint(&desk, csv(&log));
        assert!(told.starts_with("line 2, column 1: l1: the median length is "), "{told}");
        assert!(told.ends_with(&format!(": these look like {unit}; millimetres are wanted")), "{told}");
    }
}

#[test]
fn the_log_of_another_machine_is_not_taken_for_another_unit() {
    let desk = Desk::new("another_machine");
    // a wrist's cables of some 114 mm, in millimetres, for the shoulder's base, whose sides have 259.8 mm
    let told = complaint(&desk, "l1,l2,l3,l4,l5,l6\n114,112,116,113,115,114\n");
    assert!(
        told.contains("114.0000 mm, which does not go with the base of 259.8 mm: is it the log of another machine"),
        "{told}"
    );
}

#[test]
fn one_row_in_another_unit_is_a_bad_reading_and_does_not_stop_the_rest() {
    let desk = Desk::new("one_row_in_metres");
    let mut log = shoulder(1, 20, 0.1);
    log[4] = log[4].map(|length| length / 1000.0);
    let ran = desk.put("log.csv", csv(&log)).identify("log.csv --json");
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert_eq!(ran.json()["rejected"][0]["pose"], 4);
}

#[test]
fn a_length_that_single_precision_cannot_hold_is_told() {
    let desk = Desk::new("single_precision");
    let mut log = csv(&shoulder(1, 9, 0.0));
    log += "210,220,1e39,240,250,260\n";
    let ran = desk.put("log.csv", log).identify("log.csv --precision f32");
    assert_eq!(ran.code, Some(1), "{ran:?}");
    assert!(ran.stderr.contains("log.csv, line 11, column 3: l3: "), "{ran:?}");
}

#[test]
fn the_same_table_in_other_clothes_gives_the_same_result() {
    let desk = Desk::new("other_clothes");
    let plain = String::from_utf8(data("speed-problem.csv")).unwrap();
    desk.put("rig.toml", data("speed-problem.toml"));
    let solved = |log: Vec<u8>| {
        let ran = desk.put("log.csv", log).identify("log.csv --rig rig.toml --json");
        assert_eq!(ran.code, Some(0), "{ran:?}");
        ran.stdout
    };
    let expected = solved(plain.clone().into_bytes());
    let backwards = |line: &str| line.rsplit(',').collect::<Vec<_>>().join(",") + "\n";
    let quoted = |line: &str| line.split(',').map(|field| format!("\"{field}\"")).collect::<Vec<_>>().join(",") + "\n";
    let others = [
        ("a byte order mark", format!("\u{feff}{plain}")),
        ("CRLF", plain.replace('\n', "\r\n")),
        ("CR", plain.replace('\n', "\r")),
        ("no line end at the end", plain.trim_end().to_owned()),
        ("blank lines", plain.replace('\n', "\n\n")),
        ("blanks and capitals", plain.replace(',', " , ").replace('l', "L")),
        ("columns in another order", plain.lines().map(backwards).collect()),
        ("quoted fields", plain.lines().map(quoted).collect()),
    ];
    for (clothes, log) in others {
        assert_eq!(solved(log.into_bytes()), expected, "{clothes}");
    }
}

#[test]
fn a_file_that_is_not_there_is_told_by_name() {
    let desk = Desk::new("not_there");
    for (arguments, file) in [("none.csv", "none.csv"), (".", "."), ("log.csv --rig none.toml", "none.toml")] {
        let ran = desk.put("log.csv", csv(&shoulder(1, 5, 0.0))).identify(arguments);
        assert_eq!((ran.code, ran.stdout.as_str()), (Some(1), ""), "{ran:?}");
        assert!(ran.stderr.starts_with(&format!("cargo identify: {file}: ")), "{ran:?}");
    }
}

#[test]
fn a_wrong_command_line_is_not_a_refusal() {
    let desk = Desk::new("command_line");
    desk.put("log.csv", csv(&shoulder(1, 5, 0.0)));
    for (arguments, told) in [
        ("", "LOG"),
        ("log.csv --method quick", "paper, full"),
        ("log.csv --start 1,2,3", "six numbers"),
        ("log.csv --start 1,2,3,4,5,x", "\"x\" is not a number"),
        ("log.csv --start 1,2,3,4,5,-6", "must be positive"),
        ("log.csv --start 1,2,nan,4,5,6", "must be finite"),
        ("log.csv --noise -1", "0.0001 to 10 mm"),
        ("log.csv --noise nan", "0.0001 to 10 mm"),
        ("log.csv log.csv", "unexpected argument"),
    ] {
        let ran = desk.identify(arguments);
        assert_eq!((ran.code, ran.stdout.as_str()), (Some(1), ""), "{arguments}: {ran:?}");
        assert!(ran.stderr.contains(told), "{arguments}: {ran:?}");
    }
    let help = desk.identify("--help");
    assert_eq!((help.code, help.stderr.as_str()), (Some(0), ""));
}
