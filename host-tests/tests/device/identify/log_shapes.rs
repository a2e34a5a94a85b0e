//! One table in the shapes in which loggers, spreadsheets and scripts write it: the same centre, and a word on what was
//! taken for what.

use super::command::Desk;
use super::recorded::{Log, csv, shoulder};
use host_tests::identify::lengths_file::LengthsFile;

const HEADER: &str = "l1,l2,l3,l4,l5,l6\n";

fn log() -> Log {
    // With the digits of a table.
    shoulder(5, 14, 0.1).iter().map(|row| row.map(|length| (length * 1e6).round() / 1e6)).collect()
}

/// The table with each row made by `line` from its number and its six fields.
fn table(header: &str, line: impl Fn(usize, &[String]) -> String) -> String {
    let rows = log().iter().map(|row| row.map(|length| length.to_string())).collect::<Vec<_>>();
    let rows: String = rows.iter().enumerate().map(|(k, fields)| line(k, fields) + "\n").collect();
    format!("{header}\n{rows}")
}

/// Runs the command on a log: the result must be that of the plain table, and the words must contain `said`.
fn same(desk: &Desk, shape: &str, bytes: impl AsRef<[u8]>, said: &[&str]) {
    let ran = desk.put("log.csv", bytes).identify("log.csv --json");
    assert_eq!(ran.code, Some(0), "{shape}: {ran:?}");
    let plain = desk.put("plain.csv", csv(&log())).identify("plain.csv --json");
    assert_eq!((plain.code, plain.stderr.as_str()), (Some(0), ""), "a plain table needs no word");
    let (found, expected) = (ran.json(), plain.json());
    for key in ["status", "centre_mm", "radii_mm", "poses_used"] {
        assert_eq!(found[key], expected[key], "{shape}: {key}");
    }
    for words in said {
        assert!(ran.stderr.contains(words), "{shape}: {words:?} is not said: {}", ran.stderr);
    }
    assert!(ran.stderr.lines().all(|line| line.starts_with("cargo identify: log.csv: ")), "{shape}: {}", ran.stderr);
}

#[test]
fn columns_are_found_by_name_and_the_others_named() {
    let desk = Desk::new("columns_by_name");
    let among = table("time,l6,l1,flag,l2,l3,l4,l5,temperature", |k, f| {
        format!("{}.5,{},{},ok,{},{},{},{},21", k, f[5], f[0], f[1], f[2], f[3], f[4])
    });
    same(&desk, "columns among others", among, &[r#"columns left out: "time", "flag", "temperature""#]);
    let index = table(",l1,l2,l3,l4,l5,l6", |k, f| format!("{k},{}", f.join(",")));
    same(&desk, "an index without a name", index, &["columns left out: column 1"]);
    for header in [
        "l1 [mm],l2 [mm],l3 [mm],l4 [mm],l5 [mm],l6 [mm]",
        "L1(mm),L2(mm),L3(mm),L4(mm),L5(mm),L6(mm)",
        "l_1_mm,l_2_mm,l_3_mm,l_4_mm,l_5_mm,l_6_mm",
        "Length 1,Length 2,Length 3,Length 4,Length 5,Length 6",
    ] {
        same(&desk, header, table(header, |_, f| f.join(",")), &[]);
    }
}

#[test]
fn what_is_no_row_is_passed_over_and_said() {
    let desk = Desk::new("passed_over");
    let commented = "# made on a Tuesday\n".to_owned() + &csv(&log()) + "# the end\n";
    same(&desk, "comments", commented, &["passed over: 2 comments"]);
    let units = csv(&log()).replace(HEADER, "l1,l2,l3,l4,l5,l6\nmm,mm,mm,mm,mm,mm\n");
    same(&desk, "a row of units", units, &["the units in line 2"]);
    let timed = table("t,l1,l2,l3,l4,l5,l6\n[s],[mm],[mm],[mm],[mm],[mm],[mm]", |k, f| format!("{k},{}", f.join(",")));
    same(&desk, "units of other columns", timed, &["the units in line 2", r#"left out: "t""#]);
    same(&desk, "sep=,", format!("sep=,\n{}", csv(&log())), &[]);
    same(&desk, "commas at the end", table("l1,l2,l3,l4,l5,l6,,", |_, f| f.join(",") + ",,"), &[]);
    same(&desk, "rows of nothing", csv(&log()) + ",,,,,\n,,,,,\n", &["2 rows of empty cells"]);
    let mut again: Vec<String> = csv(&log()).lines().map(str::to_owned).collect();
    again.insert(7, HEADER.trim().to_owned());
    same(&desk, "the header again", again.join("\n"), &["the header again, 1 times, first in line 8"]);
    let numpy = csv(&log()).replace(HEADER, "# l1,l2,l3,l4,l5,l6\n");
    same(&desk, "a header in a comment", numpy, &[]);
}

#[test]
fn a_header_that_comes_again_may_have_another_order() {
    let row = |line: &str| line.to_owned() + "\n";
    let two = [HEADER.to_owned(), row("1,2,3,4,5,6"), row("l6,l5,l4,l3,l2,l1"), row("6,5,4,3,2,1")].concat();
    let log = LengthsFile::parse("log.csv", two.as_bytes()).unwrap();
    assert_eq!(log.rows().iter().map(|row| row.line).collect::<Vec<_>>(), [2, 4]);
    assert!(log.rows().iter().all(|row| row.lengths_mm == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), "{log:?}");
    assert_eq!(log.at(4, 0, "odd".into()).to_string(), "log.csv, line 4, column 6: l1: odd");
    assert_eq!(log.at(2, 0, "odd".into()).to_string(), "log.csv, line 2, column 1: l1: odd");
}

#[test]
fn separators_and_decimal_signs_are_seen_and_said() {
    let desk = Desk::new("separators");
    for (sign, called) in [(';', "semicolons"), ('\t', "tabs"), ('|', "bars"), (' ', "blanks")] {
        let text = csv(&log()).replace(',', &sign.to_string());
        let words = format!("columns are separated by {called}; the point is the decimal sign");
        same(&desk, called, &text, &[&words]);
        let comma = text.replace('.', ",");
        let words = format!("columns are separated by {called}; the comma is the decimal sign");
        same(&desk, &format!("{called} and decimal commas"), comma, &[&words]);
    }
    let quoted = table("l1,l2,l3,l4,l5,l6", |_, f| {
        f.iter().map(|field| format!("\"{}\"", field.replace('.', ","))).collect::<Vec<_>>().join(",")
    });
    same(&desk, "quoted decimal commas", quoted, &["separated by commas; the comma is the decimal sign"]);
    let named = format!("sep=;\n{}", csv(&log()).replace(',', ";"));
    same(&desk, "sep=;", named, &["columns are separated by semicolons"]);
}

#[test]
fn other_encodings_are_read_and_said() {
    let desk = Desk::new("encodings");
    let text = csv(&log());
    let little = |text: &str| text.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>();
    let big = |text: &str| text.encode_utf16().flat_map(u16::to_be_bytes).collect::<Vec<u8>>();
    same(&desk, "UTF-16 LE", [&[0xff, 0xfe][..], &little(&text)].concat(), &["read as UTF-16"]);
    same(&desk, "UTF-16 BE", [&[0xfe, 0xff][..], &big(&text)].concat(), &["read as UTF-16"]);
    same(&desk, "UTF-16 LE, no mark", little(&text), &["read as UTF-16"]);
    same(&desk, "UTF-16 BE, no mark", big(&text), &["read as UTF-16"]);
    // German Excel: a degree sign in one byte, semicolons, decimal commas.
    let rows = table("Winkel [?];l1;l2;l3;l4;l5;l6", |_, f| format!("1,5;{}", f.join(";").replace('.', ",")));
    let bytes: Vec<u8> = rows.bytes().map(|byte| if byte == b'?' { 0xb0 } else { byte }).collect();
    let said = ["read as Latin-1", "the comma is the decimal sign", r#"columns left out: "Winkel [°]""#];
    same(&desk, "Latin-1", bytes, &said);
}

#[test]
fn a_hundred_thousand_rows_are_read_at_once() {
    let row = "210.12345,220.23456,230.34567,240.45678,250.56789,260.6789\n";
    let plain = HEADER.to_owned() + &row.repeat(100_000);
    for text in [plain.clone(), plain.replace(',', ";").replace('.', ",")] {
        let before_s = processor_seconds();
        let log = LengthsFile::parse("log.csv", text.as_bytes()).unwrap();
        let took_s = processor_seconds() - before_s;
        assert_eq!(log.rows().len(), 100_000);
        assert_eq!(log.rows()[99_999].line, 100_001);
        // 60 ms on the machine that this was written on
        assert!(took_s < 3.0, "{took_s} s");
    }
}

/// The time that this thread has had on a processor, s: what others had in between does not count. Fields 14 and 15 of
/// `stat` (proc_pid_stat(5)), in hundredths of a second.
fn processor_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/thread-self/stat").unwrap();
    let (_, behind_the_name) = stat.rsplit_once(") ").unwrap();
    let ticks = behind_the_name.split(' ').skip(11).take(2).map(|field| field.parse::<f64>().unwrap());
    ticks.sum::<f64>() / 100.0
}
