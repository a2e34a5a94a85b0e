//! What candump recorded of a run gives the centre that the lengths themselves give.

use super::command::{Desk, Ran};
use super::recorded::{Log, shoulder};
use crate::procedure::bench::Bench;
use glenoid::can::{BaseId, Message, Opcode};
use glenoid::parameters::ParameterSet;
use glenoid::procedure::{PoseSet, StateName};
use glenoid::restart::Restart;
use host_tests::wearer::WearerSettings;
use std::fmt::Write;

/// The lengths as the board sends them: singles.
fn log(seed: u64, poses: usize) -> Log {
    shoulder(seed, poses, 0.1).iter().map(|row| row.map(|mm| f64::from(mm as f32))).collect()
}

/// A frame RawLength of glenoid.dbc (0x68F): run, index, cable and set, length in 2^-20 mm, little-endian.
fn raw_length(run: u16, index: usize, cable: usize, held_out: bool, length_mm: f64) -> [u8; 8] {
    let mut data = [0; 8];
    data[..2].copy_from_slice(&run.to_le_bytes());
    data[2] = index as u8;
    data[3] = cable as u8 | u8::from(held_out) << 4;
    data[4..].copy_from_slice(&((length_mm * 1048576.0) as u32).to_le_bytes());
    data
}

fn hex(data: &[u8]) -> String {
    data.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02X}");
        text
    })
}

/// `candump -l` of a run's lengths, among other traffic.
fn recording(run: u16, poses: &Log, held_out: bool) -> String {
    let mut text = String::new();
    for (index, row) in poses.iter().enumerate() {
        for (cable, length) in row.iter().enumerate() {
            let time = index * 6 + cable;
            let data = hex(&raw_length(run, index, cable + 1, held_out, *length));
            let _ = writeln!(text, "(1700000000.{time:06}) can0 68F#{data}");
            // A drive's own frames, an extended one, a remote one, CAN FD, and a heartbeat of the board.
            let _ = writeln!(text, "(1700000000.{time:06}) can0 181#0102030405060708");
            let _ = writeln!(text, "(1700000000.{time:06}) can0 18FEF100#FFFF");
            let _ = writeln!(text, "(1700000000.{time:06}) can0 181#R");
            let _ = writeln!(text, "(1700000000.{time:06}) can0 181##1AABB");
            let _ = writeln!(text, "(1700000000.{time:06}) can0 682#0100000000000000");
        }
    }
    text
}

/// The result must be that of a plain table with every digit of the lengths.
fn same_centre(desk: &Desk, ran: &Ran, poses: &Log) {
    let rows = poses.iter().map(|row| row.map(|length| length.to_string()).join(",") + "\n");
    let table = "l1,l2,l3,l4,l5,l6\n".to_owned() + &rows.collect::<String>();
    let plain = desk.put("plain.csv", table).identify("plain.csv --json").json();
    let found = ran.json();
    assert_eq!((ran.code, &found["centre_mm"]), (Some(0), &plain["centre_mm"]), "{ran:?}");
}

#[test]
fn a_recording_gives_the_centre_and_its_second_set_verifies_it() {
    let desk = Desk::new("bus_log");
    let (first, second) = (log(1, 12), log(2, 5));
    let both = recording(7, &first, false) + &recording(7, &second, true);
    let ran = desk.put("run.log", &both).identify("run.log --json");
    same_centre(&desk, &ran, &first);
    assert_eq!(
        ran.stderr,
        "cargo identify: run.log: a candump recording: run 7, 12 poses, and 5 held out to verify them\n"
    );
    assert_eq!(ran.json()["verification"]["pose_count"], 5, "{ran:?}");
    // What candump prints, instead of what it writes.
    let printed: String = (0..12)
        .flat_map(|index| (0..6).map(move |cable| (index, cable)))
        .map(|(index, cable)| {
            let data = raw_length(7, index, cable + 1, false, first[index][cable]).map(|byte| format!("{byte:02X}"));
            format!("  can0  68F   [8]  {}\n", data.join(" "))
        })
        .collect();
    same_centre(&desk, &desk.put("run.txt", printed).identify("run.txt --json"), &first);
}

#[test]
fn of_several_runs_the_last_is_taken_even_under_the_same_number() {
    let desk = Desk::new("bus_log_runs");
    let (old, new) = (log(1, 12), log(3, 12));
    for number in [8, 7] {
        let both = recording(7, &old, false) + &recording(number, &new, false);
        let ran = desk.put("run.log", both).identify("run.log --json");
        same_centre(&desk, &ran, &new);
        assert!(ran.stderr.contains(&format!("run {number}, the last of 2 runs, 12 poses")), "{ran:?}");
    }
    // Read out twice: still one run.
    let twice = recording(7, &new, false).repeat(2);
    let ran = desk.put("run.log", twice).identify("run.log --json");
    same_centre(&desk, &ran, &new);
    assert!(ran.stderr.contains("run 7, 12 poses"), "{ran:?}");
}

#[test]
fn a_pose_of_which_nothing_was_recorded_is_named() {
    let desk = Desk::new("bus_log_gap");
    let poses = log(1, 12);
    let without_two = recording(7, &poses, false)
        .lines()
        .filter(|line| !line.contains("68F#070004") && !line.contains("68F#070006"))
        .fold(String::new(), |text, line| text + line + "\n");
    let ran = desk.put("run.log", without_two).identify("run.log --json");
    assert_eq!(ran.code, Some(0), "{ran:?}");
    for pose in [4, 6] {
        let note = format!("pose {pose} of set 1 is left out: no length of it was recorded");
        assert!(ran.stderr.contains(&note), "{ran:?}");
    }
    assert!(ran.stderr.contains("run 7, 10 poses") && !ran.stderr.contains("pose 11 "), "{ran:?}");
}

#[test]
fn a_recording_that_was_cut_says_what_is_missing() {
    let desk = Desk::new("bus_log_cut");
    let poses = log(1, 12);
    let whole = recording(7, &poses, false);
    let without_one: String =
        whole.lines().filter(|line| !line.contains("68F#0700040")).map(|l| l.to_owned() + "\n").collect();
    let first_of_pose_4 =
        recording(7, &poses, false).lines().find(|line| line.contains("68F#07000401")).unwrap().to_owned();
    let ran = desk.put("run.log", without_one + &first_of_pose_4 + "\n(1700000000.1) ca").identify("run.log --json");
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert!(ran.stderr.contains("pose 4 of set 1 is left out: not all six lengths were recorded"), "{ran:?}");
    assert!(ran.stderr.contains("is cut and left out"), "{ran:?}");
    let left: Log = poses.iter().enumerate().filter(|(k, _)| *k != 4).map(|(_, row)| *row).collect();
    same_centre(&desk, &ran, &left);
}

#[test]
fn a_recording_without_poses_or_with_something_else_in_it_says_so() {
    let desk = Desk::new("bus_log_bad");
    for (text, told) in [
        (
            "(1.0) can0 181#01\n(2.0) can0 181#02\n",
            "line 2, column 1: 2 frames, but none with an identifier of the board",
        ),
        (
            "(1.0) can0 682#0100000000000000\n",
            "line 1, column 1: 1 frames of the board, but no pose with all six lengths",
        ),
        (
            "(1.0) can0 181#01\nhello world\n(2.0) can0 181#02\n",
            "line 2, column 7: this is no frame as candump writes it",
        ),
        ("(1.0) can0 181#012\n(2.0) can0 181#02\n", "line 1, column 1: no header"),
        (
            "date Mon Nov 2 10:00:00.000 am 2026\nbase hex  timestamps absolute\n",
            "an ASC recording; `python -m glenoid",
        ),
        (";$FILEVERSION=2.1\n", "a TRC recording; `python -m glenoid poses run.log`"),
        ("timestamp,arbitration_id,extended,remote,error,dlc,data\n", "python-can's CSV recording"),
        ("LOGG\x01\x02", "a BLF recording"),
        ("PK\x03\x04", "save the table as CSV"),
    ] {
        let ran = desk.put("run.log", text).identify("run.log --json");
        assert_eq!((ran.code, ran.stdout.as_str()), (Some(1), ""), "{text:?}: {ran:?}");
        assert!(ran.stderr.contains(told), "{text:?}: {ran:?}");
    }
}

/// A whole run of a device in this process, as candump would record it.
fn recorded_run(parameters: &ParameterSet) -> (String, Vec<Message>) {
    let wearer = WearerSettings { seed: 8, noise_mm: 0.1, ..WearerSettings::default() };
    let mut bench = Bench::of(parameters.config(Restart::default(), 0).unwrap(), wearer);
    bench.command(Opcode::Start);
    let mut messages = bench.take_messages();
    while bench.state() != StateName::Review {
        bench.next_pose();
        bench.pass(100);
        messages.extend(bench.take_messages());
    }
    let lines = messages.iter().map(|message| {
        let frame = message.pack(BaseId::DEFAULT).unwrap();
        format!("(1700000000.000000) can0 {:03X}#{}\n", frame.raw_id(), hex(frame.data()))
    });
    (lines.collect(), messages)
}

/// The centre that the board showed, as it is printed.
fn centre_of(messages: &[Message]) -> String {
    let found = |axis| {
        messages.iter().rev().find_map(|message| match message {
            Message::CandidateCentre(p) if p.index == axis => Some(p.value_mm.to_string()),
            _ => None,
        })
    };
    [0, 1, 2].map(|axis| found(axis).unwrap()).join(" ")
}

/// The compiled-in machine with other values of some parameters.
fn with_singles(values: &[(u16, f32)]) -> ParameterSet {
    let mut parameters = ParameterSet::new();
    values.iter().for_each(|(index, value)| parameters.set_bits(*index, value.to_bits()).unwrap());
    parameters
}

/// The rig of those parameters.
const RIG: &str = "base = [[150, 0, 0], [-75, 129.9038105676658, 0], [-75, -129.9038105676658, 0]]\n\
                   edges = [178.398206, 178.398206, 178.398206]\n\
                   [tolerance]\nbase = 0.5\nedges = 0.5\nzero = 0.3\ndrum = 0.001\n";

/// The lengths that a board sends are corrected by what commissioning found of it: they are not corrected once more.
#[test]
fn a_commissioned_board_s_recording_is_not_corrected_twice() {
    let offset = |cable: u16| (123 + cable, 0.7 * f32::from(cable) - 2.0);
    let scale = |cable: u16| (129 + cable, 1.0 + 0.004 * (f32::from(cable) - 3.0));
    let values: Vec<_> = (1..=6).map(offset).chain((1..=6).map(scale)).collect();
    let (recording, messages) = recorded_run(&with_singles(&values));
    let list = |values: &[(u16, f32)]| format!("{:?}", values.iter().map(|(_, value)| *value).collect::<Vec<_>>());
    let rig = format!("{RIG}[zeros]\nmm = {}\n[drum]\nscale = {}\n", list(&values[..6]), list(&values[6..]));
    let desk = Desk::new("bus_log_commissioned");
    desk.put("rig.toml", rig).put("run.log", &recording);
    let ran = desk.identify("run.log --rig rig.toml --noise 0.058 --precision f32 --json");
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert!(ran.stderr.contains("as the board corrected them"), "{ran:?}");
    let found = ran.json()["centre_mm"].clone();
    let of_board: Vec<f64> = centre_of(&messages).split(' ').map(|mm| mm.parse().unwrap()).collect();
    for (found, of_board) in found.as_array().unwrap().iter().zip(of_board) {
        assert!((found.as_f64().unwrap() - of_board).abs() < 2e-3, "{found} or {of_board}: {ran:?}");
    }
    // The same lengths in a table are readings: there they are corrected.
    let ran = desk.put("run.csv", table_of(&messages)).identify("run.csv --rig rig.toml --noise 0.058 --json");
    let far = ran.json()["centre_mm"][2].as_f64().is_none_or(|z| (z - found[2].as_f64().unwrap()).abs() > 0.1);
    assert!(ran.code == Some(2) || far, "{ran:?}");
}

/// A board that knows the noise of a sample apart says of how many samples each pose is the mean, and the host counts by that.
#[test]
fn the_number_of_samples_of_each_pose_is_recorded() {
    let (recording, messages) = recorded_run(&with_singles(&[(109, 0.05), (116, 0.2)]));
    let samples: Vec<_> = messages
        .iter()
        .filter_map(|message| match message {
            Message::PoseSamples(of) => Some(of.samples),
            _ => None,
        })
        .collect();
    let lengths = messages.iter().filter(|message| matches!(message, Message::RawLength(_))).count();
    assert_eq!(samples.len() * 6, lengths);
    // Four tenths of a second of a hundred samples a second.
    assert!(samples.iter().all(|samples| (40..=60).contains(samples)), "{samples:?}");
    let desk = Desk::new("bus_log_samples");
    desk.put("rig.toml", format!("{RIG}[noise]\npose = 0.05\nsample = 0.2\n")).put("run.log", &recording);
    let with = desk.identify("run.log --rig rig.toml --precision f32 --json");
    let of_board: Vec<f64> = centre_of(&messages).split(' ').map(|mm| mm.parse().unwrap()).collect();
    for (axis, of_board) in of_board.iter().enumerate() {
        let found = with.json()["centre_mm"][axis].as_f64().unwrap();
        assert!((found - of_board).abs() < 2e-3, "{found} or {of_board}: {with:?}");
    }
    // Without them each pose counts as a single sample: its bar is wider.
    let without: String =
        recording.lines().filter(|line| !line.contains("6A1#")).map(|line| line.to_owned() + "\n").collect();
    let without = desk.put("without.log", without).identify("without.log --rig rig.toml --precision f32 --json");
    let sigma = |ran: &Ran| ran.json()["sigma_mm"][2].as_f64().unwrap();
    assert!(sigma(&without) > 1.1 * sigma(&with), "{} {}", sigma(&without), sigma(&with));
}

/// The lengths of the first set as a table.
fn table_of(messages: &[Message]) -> String {
    let mut rows: Vec<[f32; 6]> = Vec::new();
    for message in messages {
        if let Message::RawLength(raw) = message
            && raw.set == PoseSet::Identification
        {
            rows.resize(rows.len().max(usize::from(raw.index) + 1), [0.0; 6]);
            rows[usize::from(raw.index)][usize::from(raw.cable) - 1] = raw.length_mm;
        }
    }
    let lines = rows.iter().map(|row| row.map(|mm| mm.to_string()).join(",") + "\n");
    "l1,l2,l3,l4,l5,l6\n".to_owned() + &lines.collect::<String>()
}

#[test]
fn a_recorded_run_gives_the_boards_own_centre_to_the_last_digit() {
    let (recording, messages) = recorded_run(&ParameterSet::new());
    let centre = centre_of(&messages);
    let desk = Desk::new("bus_log_board");
    let ran = desk.put("run.log", &recording).identify("run.log --json");
    let expected = format!("the board found {centre} mm in run 1; its calculation gives the same here");
    assert!(ran.code == Some(0) && ran.stderr.contains(&expected), "{expected}: {ran:?}");

    // one length is another by its last bit; a pose is missing; the machine is another one
    let changed = recording.lines().map(|line| match line.split_once("68F#01000301") {
        Some((head, length)) => {
            let last_bit = u8::from_str_radix(&length[2..4], 16).unwrap() ^ 0x08;
            format!("{head}68F#01000301{}{last_bit:02X}{}\n", &length[..2], &length[4..])
        }
        None => format!("{line}\n"),
    });
    let ran = desk.put("changed.log", changed.collect::<String>()).identify("changed.log --json");
    assert!(ran.stderr.contains("mm off that here: it goes by other parameters"), "{ran:?}");
    let without: String =
        recording.lines().filter(|line| !line.contains("68F#01000401")).map(|line| line.to_owned() + "\n").collect();
    let ran = desk.put("without.log", without).identify("without.log --json");
    assert!(ran.stderr.contains("or poses are missing from the recording"), "{ran:?}");
}
