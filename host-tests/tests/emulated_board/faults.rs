//! The end of a firmware that can no longer be trusted: brought about by the debugger, told after the restart.

use std::io::{BufRead, BufReader, ErrorKind, Read};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};

use firmware_image::ccm_code::CcmCode;
use firmware_image::elf::Elf;
use glenoid::can::health::LastStop;
use glenoid::can::{Message, Opcode};
use glenoid::procedure::Reason;
use glenoid::restart::ResetCause;
use host_tests::debugger::{Debugger, Register};
use host_tests::emulator::{Emulator, EmulatorError, Options};
use libtest_mimic::Failed;

use crate::PATIENCE;
use crate::restarts::{RecordFile, live, reset_cause};
use crate::scene::Scene;

/// RAM of the emulated machine that this firmware, linked for the drive board's memory, has no use for.
const FREE_RAM: u32 = 0x2010_0000;
/// `b .`, an instruction that goes nowhere (ARMv7-M ARM, A7.7.12).
const GO_NOWHERE: [u8; 2] = 0xE7FE_u16.to_le_bytes();
/// `udf #0`, an instruction that will never be one (ARMv7-M ARM, A7.7.194).
const UNDEFINED: [u8; 2] = 0xDE00_u16.to_le_bytes();

pub fn an_emulator_that_ends_is_told(_: &Path) -> Result<(), Failed> {
    let missing = Path::new("no such image");
    match Emulator::start(missing, &Options::default()) {
        Err(EmulatorError::Ended { complaint, .. }) if complaint.contains("no such image") => Ok(()),
        other => Err(format!("{other:?}").into()),
    }
}

/// `cargo emulate` is killed and can do nothing more: its emulator, and the ports that it holds, must not stay behind.
pub fn an_emulator_whose_owner_is_killed_ends(_: &Path) -> Result<(), Failed> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_emulate"));
    command.args(["--yes", "--can-port", "0", "--rig-port", "0"]);
    let mut owner = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn()?;
    let said = BufReader::new(owner.stdout.take().ok_or("nothing is said")?).lines();
    let rig = said.map_while(Result::ok).find_map(|line| {
        let address = line.strip_prefix("rig link")?.trim().split(',').next()?;
        Some(address.to_owned())
    });
    let rig = rig.ok_or("no address of the rig link")?;
    // the emulator serves it, not the one who is killed
    let served = TcpStream::connect(&rig);
    owner.kill()?;
    owner.wait()?;
    let mut served = served?;
    served.set_read_timeout(Some(PATIENCE))?;
    // a line on which the board never says anything: it ends with the emulator
    match served.read(&mut [0]) {
        Ok(0) => Ok(()),
        Err(error) if error.kind() == ErrorKind::ConnectionReset => Ok(()),
        other => Err(format!("the rig link {rig} is still served: {other:?}").into()),
    }
}

/// A board with a centre in use is hurt, and must come back: by itself, idle, with the same centre, and with a word on
/// why. Gives what it says of its stop.
fn hurt(
    image: &Path,
    name: &str,
    cause: ResetCause,
    wound: impl FnOnce(&mut Debugger) -> Result<(), Failed>,
) -> Result<LastStop, Failed> {
    let file = RecordFile::filled(name)?;
    let options = Options { debugger: true, ..file.options() };
    let mut scene = Scene::on(Emulator::start(image, &options)?, 41)?;
    let before = live(&mut scene)?;
    assert_eq!(before.len(), 6, "{before:?}");
    let address = scene.board.debugger_address().ok_or("the board serves no debugger")?;
    let mut debugger = Debugger::halt(address)?;
    wound(&mut debugger)?;
    debugger.resume()?;
    scene.board.wait_for_log_times("board: ready", 2, PATIENCE)?;
    let mut scene = scene.with_a_new_client()?;
    scene.hold(600)?;
    assert_eq!(live(&mut scene)?, before, "the centre in use after {cause:?}");
    assert_eq!(reset_cause(&mut scene)?, cause);
    scene.wait("last stop", |message| if let Message::LastStop(stop) = message { Some(*stop) } else { None })
}

/// The guard is the first whole 4 KiB above the static variables. With the stack pointer at its upper end, the next
/// function that is called, be it `main` once more, has no room to put anything down.
pub fn a_stack_overflow_restarts_the_board(image: &Path) -> Result<(), Failed> {
    let elf = Elf::read(image)?;
    let guard_end = u32::try_from(elf.symbol("_stack_end")?)?.next_multiple_of(4096) + 4096;
    // the lowest bit of a function's address says Thumb and is no part of the program counter
    let main = u32::try_from(elf.symbol("main")?)? & !1;
    hurt(image, "overflow", ResetCause::StackOverflow, |board| {
        board.set(Register::StackPointer, guard_end)?;
        Ok(board.set(Register::ProgramCounter, main)?)
    })?;
    Ok(())
}

pub fn a_wild_jump_restarts_the_board(image: &Path) -> Result<(), Failed> {
    // the system region may never be executed (ARMv7-M ARM, B3.1)
    let stop = hurt(image, "jump", ResetCause::Fault, |board| Ok(board.set(Register::ProgramCounter, 0xE000_0000)?))?;
    assert_eq!(stop.address, 0xE000_0000);
    Ok(())
}

/// The main loop is caught in a loop of its own; interrupts go on. The watchdog finds it out, and says where.
pub fn a_standstill_is_ended_by_the_watchdog(image: &Path) -> Result<(), Failed> {
    let stop = hurt(image, "standstill", ResetCause::Watchdog, |board| {
        board.write(FREE_RAM, &GO_NOWHERE)?;
        Ok(board.set(Register::ProgramCounter, FREE_RAM)?)
    })?;
    assert_eq!(stop.address, FREE_RAM);
    Ok(())
}

/// An instruction that rots away under the running firmware: here the one that it is about to execute.
pub fn a_rotten_instruction_restarts_the_board(image: &Path) -> Result<(), Failed> {
    let stop = hurt(image, "instruction", ResetCause::Fault, |board| {
        board.write(FREE_RAM, &UNDEFINED)?;
        Ok(board.set(Register::ProgramCounter, FREE_RAM)?)
    })?;
    assert_eq!(stop.address, FREE_RAM);
    Ok(())
}

/// One bit of the code that runs from RAM changes there, in a function that is not called for the time being. The board
/// must not wait for the call.
pub fn code_that_changes_in_memory_restarts_the_board(image: &Path) -> Result<(), Failed> {
    let ccm = CcmCode::read(&Elf::read(image)?)?;
    let largest = ccm.functions.iter().max_by_key(|function| function.size_bytes);
    let largest = largest.ok_or("there is no code in the core-coupled memory")?;
    let middle = u32::try_from((largest.address + largest.size_bytes / 2).next_multiple_of(4))?;
    let stop = hurt(image, "code", ResetCause::MemoryError, |board| {
        let byte = board.read(middle, 1)?;
        Ok(board.write(middle, &[byte[0] ^ 1])?)
    })?;
    assert_eq!(stop.address, middle);
    Ok(())
}

/// One bit of the radii in use changes in RAM, the lowest of p1: the board must never tell such a centre as
/// its own for longer than it takes to notice.
pub fn a_centre_that_changes_in_memory_restarts_the_board(image: &Path) -> Result<(), Failed> {
    let elf = Elf::read(image)?;
    let (begin, end) = (u32::try_from(elf.symbol("__sbss")?)?, u32::try_from(elf.symbol("__ebss")?)?);
    let file = RecordFile::filled("memory")?;
    let options = Options { debugger: true, ..file.options() };
    let mut scene = Scene::on(Emulator::start(image, &options)?, 42)?;
    let before = live(&mut scene)?;
    // they come over the bus to the bit
    let wanted = [before[3].value_mm, before[4].value_mm, before[5].value_mm].map(f32::to_le_bytes).concat();
    let mut debugger = Debugger::halt(scene.board.debugger_address().ok_or("the board serves no debugger")?)?;
    let memory = debugger.read(begin, (end - begin) as usize)?;
    let places: Vec<usize> = (0..memory.len() - 12).step_by(4).filter(|at| memory[*at..*at + 12] == wanted).collect();
    assert!(!places.is_empty(), "the radii in use are nowhere in memory");
    for place in places {
        debugger.write(begin + place as u32, &[memory[place] ^ 1])?;
    }
    debugger.resume()?;
    scene.board.wait_for_log_times("board: ready", 2, PATIENCE)?;
    let mut scene = scene.with_a_new_client()?;
    scene.hold(600)?;
    assert_eq!(live(&mut scene)?, before);
    assert_eq!(reset_cause(&mut scene)?, ResetCause::MemoryError);
    Ok(())
}

/// A client that comes after the restart learns of it: first that there was one, then, asking, the whole story.
pub fn a_restart_is_told_on_the_bus(image: &Path) -> Result<(), Failed> {
    let options = Options { debugger: true, ..Options::default() };
    let mut scene = Scene::on(Emulator::start(image, &options)?, 43)?;
    let mut debugger = Debugger::halt(scene.board.debugger_address().ok_or("the board serves no debugger")?)?;
    debugger.set(Register::ProgramCounter, 0xE000_0000)?;
    debugger.resume()?;
    scene.board.wait_for_log_times("board: ready", 2, PATIENCE)?;
    let log = scene.board.wait_for_log("its crash record says: CFSR 0x1,", PATIENCE)?;
    assert!(log.contains("started by a fault of the processor"), "{log}");
    let mut scene = scene.with_a_new_client()?;
    let restarted =
        |m: &Message| matches!(m, Message::Fault(f) if f.code == Reason::Restarted && f.active).then_some(());
    scene.wait("fault", restarted)?;
    scene.ask(Opcode::Query, 0, 0)?;
    let text =
        scene.wait("text", |m| if let Message::StopText(t) = m { (t.index == 0).then_some(t.text) } else { None })?;
    assert_eq!(&text, b"CFSR 0x");
    scene.hold(300)?;
    scene.heard.clear();
    scene.hold(1500)?;
    assert_eq!(scene.heard.iter().find_map(restarted), None, "told again to somebody who knows");
    Ok(())
}
