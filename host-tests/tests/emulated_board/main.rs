//! The emulated drive board as its clients see it: bytes on two serial lines, and the log.
//!
//! Without the emulator, or without a toolchain for the board, each test is reported as ignored by its name. With
//! `GLENOID_REQUIRE_EMULATOR=1` that is an error instead.

mod runs;

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use glenoid::can::{BaseId, Frame, Message, Opcode, Request};
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, Rig};
use host_tests::debugger::{Debugger, Register};
use host_tests::elf::Elf;
use host_tests::emulator::{self, Emulator, EmulatorError, Options};
use host_tests::firmware::{self, Image};
use host_tests::packages::Consent;
use host_tests::rehearse::{Display, EmulatedBoard, Session};
use host_tests::slcan_client::{PYTHON_CAN_OPENING, SlcanClient};
use host_tests::wearer::{Wearer, WearerSettings};
use libtest_mimic::{Arguments, Failed, Trial};

/// Far longer than anything here takes; a loaded machine gets the time that it needs.
const PATIENCE: Duration = Duration::from_secs(10);

/// Makes the absence of the emulator an error.
const REQUIRED_VARIABLE: &str = "GLENOID_REQUIRE_EMULATOR";

type Test = fn(&Path) -> Result<(), Failed>;

const TESTS: [(&str, Test); 12] = [
    ("python_can_opens_the_channel", python_can_opens_the_channel),
    ("a_closed_channel_is_silent", a_closed_channel_is_silent),
    ("frames_go_both_ways", frames_go_both_ways),
    ("garbage_is_survived_and_counted", garbage_is_survived_and_counted),
    ("a_client_may_vanish_and_return", a_client_may_vanish_and_return),
    ("an_emulator_that_ends_is_told", an_emulator_that_ends_is_told),
    ("a_stack_overflow_ends_the_board", a_stack_overflow_ends_the_board),
    ("a_calibration_finds_the_centre", a_calibration_finds_the_centre),
    ("a_wild_jump_ends_the_board", a_wild_jump_ends_the_board),
    ("calibrations_in_a_row", runs::calibrations_in_a_row),
    ("a_client_that_returns_is_told", runs::a_client_that_returns_is_told),
    ("a_crowded_bus_changes_nothing_but_a_counter", runs::a_crowded_bus_changes_nothing_but_a_counter),
];

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    // listing must not build anything
    let image = if arguments.list { Err("only listed".to_owned()) } else { image() };
    if let Err(reason) = &image
        && !arguments.list
    {
        if std::env::var_os(REQUIRED_VARIABLE).is_some_and(|value| value == "1") {
            eprintln!("error: {REQUIRED_VARIABLE} is set, and the emulated board cannot run: {reason}");
            return ExitCode::FAILURE;
        }
        eprintln!("the emulated board cannot run, its tests are ignored: {reason}");
    }
    let trials = TESTS.map(|(name, test)| {
        let image = image.clone();
        let ignored = image.is_err();
        Trial::test(name, move || test(&image?)).with_ignored_flag(ignored)
    });
    libtest_mimic::run(&arguments, trials.into()).exit_code()
}

/// The image, or why there is none.
fn image() -> Result<PathBuf, String> {
    emulator::ensure_installed(Consent::Refused).map_err(|error| error.to_string())?;
    firmware::build(Image::EMULATED, Consent::Refused).map_err(|error| error.to_string())
}

fn boot(image: &Path) -> Result<Emulator, EmulatorError> {
    Emulator::start(image, &Options::default())
}

/// Reads until `len` bytes are there or time is up.
fn read_some(stream: &mut TcpStream, len: usize, limit: Duration) -> Result<Vec<u8>, Failed> {
    let deadline = Instant::now() + limit;
    let mut bytes = Vec::new();
    stream.set_read_timeout(Some(Duration::from_millis(20)))?;
    while bytes.len() < len && Instant::now() < deadline {
        let mut chunk = [0; 256];
        if let Ok(count) = stream.read(&mut chunk) {
            bytes.extend_from_slice(&chunk[..count]);
        }
    }
    Ok(bytes)
}

/// The bytes that python-can 4.6.1 sends for `Bus(interface="slcan", bitrate=500000)`, then `V` and `N`, as its
/// `get_version` and `get_serial_number` do. Answers by the Lawicel manual.
fn python_can_opens_the_channel(image: &Path) -> Result<(), Failed> {
    let board = boot(image)?;
    let mut line = TcpStream::connect(board.can_address())?;
    line.write_all(b"C\rS6\r\r")?;
    assert_eq!(read_some(&mut line, 3, PATIENCE)?, b"\r\r\r");
    line.write_all(b"V\rN\r")?;
    let answer = read_some(&mut line, 12, PATIENCE)?;
    assert_eq!((answer[0], answer[5], answer[6], answer[11]), (b'V', b'\r', b'N', b'\r'));
    assert!(answer[1..5].iter().all(u8::is_ascii_digit), "python-can reads the version as two decimal numbers");
    line.write_all(b"O\rO\r")?;
    assert_eq!(read_some(&mut line, 2, PATIENCE)?[..2], *b"\r\r");
    Ok(())
}

fn a_closed_channel_is_silent(image: &Path) -> Result<(), Failed> {
    let board = boot(image)?;
    let mut line = TcpStream::connect(board.can_address())?;
    let quiet = Duration::from_millis(500);
    assert_eq!(read_some(&mut line, 1, quiet)?, b"", "a frame before the channel was open");
    line.write_all(b"t1230\r")?;
    assert_eq!(read_some(&mut line, 1, PATIENCE)?, b"\x07", "a frame was taken before the channel was open");
    line.write_all(b"O\r")?;
    let heard = read_some(&mut line, 30, PATIENCE)?;
    assert!(heard.len() >= 30, "no heartbeat on the open channel");
    line.write_all(b"C\r")?;
    // what was under way may still come; after that nothing
    read_some(&mut line, usize::MAX, quiet)?;
    assert_eq!(read_some(&mut line, 1, quiet)?, b"", "a frame after the channel was closed");
    Ok(())
}

/// 500 commands, each with its own nonce, are answered one by one and in order; heartbeats come in between. Foreign
/// frames are acknowledged by the adapter and answered by nobody.
fn frames_go_both_ways(image: &Path) -> Result<(), Failed> {
    let board = boot(image)?;
    let mut client = SlcanClient::open(board.can_address())?;
    let opened = client.acknowledged();
    let mut heartbeats = 0;
    for nonce in 1..=500 {
        client.send(&Frame::new(0x7FF, &[0xFF; 8])?)?;
        let query = Request { opcode: Opcode::Query as u8, nonce, run_id: 0, argument: 0 };
        client.send(&query.pack(BaseId::DEFAULT.command()))?;
        loop {
            let frame = client.receive(PATIENCE)?.ok_or("no answer")?;
            match Message::unpack(&frame, BaseId::DEFAULT)? {
                Message::Answer(answer) => {
                    assert_eq!((answer.opcode, answer.nonce), (Opcode::Query as u8, nonce));
                    break;
                }
                Message::Heartbeat(_) => heartbeats += 1,
                _ => {}
            }
        }
    }
    while heartbeats < 3 {
        let frame = client.receive(PATIENCE)?.ok_or("no heartbeat")?;
        heartbeats += u32::from(matches!(Message::unpack(&frame, BaseId::DEFAULT)?, Message::Heartbeat(_)));
    }
    assert_eq!((client.acknowledged() - opened, client.refused()), (1_000, 0));
    Ok(())
}

fn garbage_is_survived_and_counted(image: &Path) -> Result<(), Failed> {
    let mut board = boot(image)?;
    let mut client = SlcanClient::open(board.can_address())?;
    client.write(b"quatsch\rt12\r")?;
    client.write(&[0xFF; 1000])?;
    client.write(b"\rt8000\r")?;
    board.wait_for_log("slcan: 4 lines refused so far, last: identifier too large (5)", PATIENCE)?;
    let mut rig = board.connect_rig()?;
    rig.write_all(b"e 1 2 3\nb 7\n")?;
    rig.write_all(&[b'9'; 1000])?;
    rig.write_all(b"\ne 1 2 3 4 5 6\nhallo\n")?;
    board.wait_for_log("rig link: 4 lines ignored so far, last: neither counts nor button (2)", PATIENCE)?;
    let heartbeat = client.receive(PATIENCE)?;
    assert!(heartbeat.is_some(), "no heartbeat after garbage");
    assert_eq!(client.refused(), 4);
    Ok(())
}

fn a_client_may_vanish_and_return(image: &Path) -> Result<(), Failed> {
    let board = boot(image)?;
    for _ in 0..5 {
        let mut line = TcpStream::connect(board.can_address())?;
        line.write_all(PYTHON_CAN_OPENING)?;
        assert!(!read_some(&mut line, 40, PATIENCE)?.is_empty());
        // in the middle of a frame
        line.write_all(b"t12381122")?;
    }
    let mut client = SlcanClient::open(board.can_address())?;
    assert!(client.receive(PATIENCE)?.is_some(), "no heartbeat for the client that returned");
    Ok(())
}

fn an_emulator_that_ends_is_told(_: &Path) -> Result<(), Failed> {
    let missing = Path::new("no such image");
    match Emulator::start(missing, &Options::default()) {
        Err(EmulatorError::Ended { complaint, .. }) if complaint.contains("no such image") => Ok(()),
        other => Err(format!("{other:?}").into()),
    }
}

/// The board with registers changed while it ran; gives its last words once it has ended with a failure.
fn last_words(image: &Path, changes: &[(Register, u32)]) -> Result<String, Failed> {
    let mut board = Emulator::start(image, &Options { debugger: true, ..Options::default() })?;
    let address = board.debugger_address().ok_or("the board serves no debugger")?;
    let mut debugger = Debugger::halt(address)?;
    for &(register, value) in changes {
        debugger.set(register, value)?;
    }
    debugger.resume()?;
    let status = board.wait_for_end(PATIENCE)?;
    assert_eq!(status.code(), Some(1), "{:?}", board.log());
    Ok(board.log().pop().unwrap_or_default())
}

/// The guard is the first whole 4 KiB above the static variables. With the stack pointer at its upper end, the next
/// function that is called, be it `main` once more, has no room to put anything down.
fn a_stack_overflow_ends_the_board(image: &Path) -> Result<(), Failed> {
    let elf = Elf::read(image)?;
    let guard_end = u32::try_from(elf.symbol("_stack_end")?)?.next_multiple_of(4096) + 4096;
    // the lowest bit of a function's address says Thumb and is no part of the program counter
    let main = u32::try_from(elf.symbol("main")?)? & !1;
    let changes = [(Register::StackPointer, guard_end), (Register::ProgramCounter, main)];
    let words = last_words(image, &changes)?;
    assert!(words.starts_with("fault: stack overflow"), "{words}");
    Ok(())
}

fn a_wild_jump_ends_the_board(image: &Path) -> Result<(), Failed> {
    // the system region may never be executed (ARMv7-M ARM, B3.1)
    let words = last_words(image, &[(Register::ProgramCounter, 0xE000_0000)])?;
    assert!(words.starts_with("fault: CFSR 0x1,"), "{words}");
    Ok(())
}

/// A whole calibration over both lines, then the stack that it took, which the board measures by itself.
fn a_calibration_finds_the_centre(image: &Path) -> Result<(), Failed> {
    let rig = Rig::shoulder(ASSUMED_BASE_RADIUS_MM).map_err(|error| error.text())?;
    // without noise and with the cables' counts alone, seven poses fix the centre to a few hundredths of a millimetre
    let mut wearer = Wearer::new(rig, WearerSettings { seed: 3, ..WearerSettings::default() });
    let truth = wearer.truth();
    let mut board = EmulatedBoard::connect(boot(image)?)?;
    let session = Session::new(&mut board, &mut wearer, rig.drum().fastest_mm_per_s, &Display::Silent);
    let found = session.calibrate(7, 3)?;
    for (axis, live_mm) in found.live_centre_mm.into_iter().enumerate() {
        assert!((f64::from(live_mm) - truth.centre_mm[axis]).abs() < 0.1, "{:?}, {truth:?}", found.live_centre_mm);
    }
    let line = board.wait_for_log("stack: ", PATIENCE)?;
    let numbers: Vec<u32> = line.split(' ').filter_map(|word| word.parse().ok()).collect();
    let [.., used, size] = numbers[..] else { return Err(line.into()) };
    // the solver alone needs more than the one, and an overflow would have ended the board at the other
    assert!(1_000 < used && used < size, "{line}");
    Ok(())
}
