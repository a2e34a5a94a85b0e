//! Whatever stands in the files, the command ends by itself: exit code 0, 1 or 2, and never a panic.

use super::command::{Desk, Ran, data};
use super::recorded::{csv, shoulder};
use host_tests::identify::lengths_file::LengthsFile;
use host_tests::identify::rig_file::RigFile;
use proptest::collection::vec;
use proptest::prelude::*;

/// A test of the whole binary starts a process for each case.
fn with_processes() -> ProptestConfig {
    ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() }
}

fn without_processes() -> ProptestConfig {
    ProptestConfig { cases: 3_000, failure_persistence: None, ..ProptestConfig::default() }
}

fn ends_well(ran: &Ran) -> Result<(), TestCaseError> {
    let known = matches!(ran.code, Some(0..=2)) && !ran.stderr.contains("panicked");
    prop_assert!(known, "{ran:?}");
    // Unreadable: the reason alone. Readable: a report.
    prop_assert_eq!(ran.code == Some(1), ran.stdout.is_empty(), "{:?}", ran);
    Ok(())
}

/// Bytes written over those of a sound file.
fn damaged(mut bytes: Vec<u8>, damage: &[(prop::sample::Index, u8)]) -> Vec<u8> {
    for (place, byte) in damage {
        let at = place.index(bytes.len());
        bytes[at] = *byte;
    }
    bytes
}

/// Mostly what a cable can have, sometimes what it cannot.
fn length() -> impl Strategy<Value = f64> {
    prop_oneof![40 => 150f64..350.0, 1 => 1e-3f64..1e4]
}

/// Numbers as a table would hold them.
fn table(rows: &[[f64; 6]]) -> String {
    let rows = rows.iter().map(|row| row.map(|number| number.to_string()).join(",") + "\n");
    "l1,l2,l3,l4,l5,l6\n".to_owned() + &rows.collect::<String>()
}

proptest! {
    #![proptest_config(with_processes())]

    #[test]
    fn any_bytes_as_a_log(bytes in vec(any::<u8>(), 0..400), header in any::<bool>()) {
        let desk = Desk::new("any_log");
        let before: &[u8] = if header { b"l1,l2,l3,l4,l5,l6\n" } else { b"" };
        ends_well(&desk.put("log.csv", [before, &bytes].concat()).identify("log.csv"))?;
    }

    #[test]
    fn any_damage_to_a_sound_log(damage in vec((any::<prop::sample::Index>(), b' '..b'~'), 1..12)) {
        let desk = Desk::new("damaged_log");
        desk.put("rig.toml", data("speed-problem.toml"));
        desk.put("log.csv", damaged(data("speed-problem.csv"), &damage));
        ends_well(&desk.identify("log.csv --rig rig.toml --json"))?;
    }

    #[test]
    fn any_lengths(
        rows in vec(prop::array::uniform6(length()), 1..40),
        precision in prop::sample::select(vec!["f32", "f64"]),
        arguments in prop::sample::select(vec!["", "--method paper", "--noise 0.0001", "--noise 10", "--zeros"]),
    ) {
        let desk = Desk::new("any_lengths");
        desk.put("log.csv", table(&rows));
        let ran = desk.identify(&format!("log.csv --json --precision {precision} {arguments}"));
        ends_well(&ran)?;
        // Lengths out of the air never have a common centre. The paper's method has no test for it: of three poses
        // it may find the nearest thing, but then its noise tells.
        if ran.code != Some(1) {
            let report = ran.json();
            let noise_tells = report["noise_mm"].as_f64() > report["noise_limit_mm"].as_f64();
            prop_assert!(ran.code == Some(2) || (report["method"] == "paper" && noise_tells), "{ran:?}");
        }
    }

    #[test]
    fn any_rig(base in prop::array::uniform9(-1e3f64..1e3), edges in prop::array::uniform3(1.0f64..1e3)) {
        let desk = Desk::new("any_rig");
        let points: Vec<String> = base.chunks(3).map(|point| format!("{point:?}")).collect();
        desk.put("log.csv", csv(&shoulder(1, 12, 0.1)));
        desk.put("rig.toml", format!("base = [{}]\nedges = {edges:?}\n", points.join(", ")));
        for arguments in ["", "--method paper --precision f32"] {
            ends_well(&desk.identify(&format!("log.csv --rig rig.toml {arguments}")))?;
        }
    }
}

proptest! {
    #![proptest_config(without_processes())]

    #[test]
    fn any_bytes_are_read_or_told(bytes in vec(any::<u8>(), 0..300), before in 0..6usize) {
        let log: [&[u8]; 6] = [
            b"",
            b"l1,l2,l3,l4,l5,l6\n",
            b"l1,l2,l3,l4,l5,l6\n1,2,3,4,5,6\n",
            b"\xff\xfel\x001\x00",
            b"l1;l2;l3;l4;l5;l6\n1,5;2;3;4;5;6\n",
            b"(1.0) can0 68F#0100000100000010\n(1.1) can0 ",
        ];
        let _ = LengthsFile::parse("log.csv", &[log[before], &bytes].concat());
        let _ = RigFile::parse("rig.toml", &bytes);
    }

    #[test]
    fn a_table_in_any_dress_holds_the_same_rows(
        rows in vec(prop::array::uniform6(1f64..1e4), 1..20),
        order in Just((0..8usize).collect::<Vec<_>>()).prop_shuffle(),
        sign in prop::sample::select(vec![',', ';', '\t', '|']),
        decimal_comma in any::<bool>(),
        line_end in prop::sample::select(vec!["\n", "\r\n", "\r"]),
        utf_16 in any::<bool>(),
    ) {
        let names = ["l1", "l2", "l3", "l4", "l5", "l6", "time", ""];
        let line = |cell: &dyn Fn(usize) -> String| {
            order.iter().map(|column| cell(*column)).collect::<Vec<_>>().join(&sign.to_string()) + line_end
        };
        let number = |number: f64| match decimal_comma {
            true if sign == ',' => format!("\"{}\"", number.to_string().replace('.', ",")),
            true => number.to_string().replace('.', ","),
            false => number.to_string(),
        };
        let mut text = line(&|column| names[column].to_owned());
        for row in &rows {
            text += &line(&|column| row.get(column).map_or("x".to_owned(), |length| number(*length)));
        }
        let bytes = match utf_16 {
            true => std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(u16::to_be_bytes).collect(),
            false => text.into_bytes(),
        };
        let log = LengthsFile::parse("log.csv", &bytes).map_err(|error| TestCaseError::fail(error.to_string()))?;
        let read: Vec<_> = log.rows().iter().map(|row| row.lengths_mm).collect();
        prop_assert_eq!(read, rows);
    }

    #[test]
    fn any_damage_to_a_rig_is_read_or_told(damage in vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)) {
        let _ = RigFile::parse("rig.toml", &damaged(data("speed-problem.toml"), &damage));
    }

    #[test]
    fn any_number_is_a_length_or_is_told(number in any::<f64>()) {
        let log = table(&[[number; 6]]);
        let read = LengthsFile::parse("log.csv", log.as_bytes());
        prop_assert_eq!(read.is_ok(), number.is_finite() && number > 0.0);
    }
}
