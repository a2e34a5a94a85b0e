//! The board under more traffic than it can serve at once.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::time::{Duration, Instant};

use glenoid::can::{BaseId, Message, Opcode, Request};
use glenoid::slcan::{self, Command};
use host_tests::slcan_client::SlcanClient;
use libtest_mimic::Failed;

use crate::{PATIENCE, boot};

/// Foreign frames between two questions: more than the board's queue holds.
const FLOOD_BETWEEN: usize = 40;

/// A sender that never waits is held back, not cut off: every frame is acknowledged.
pub fn a_flood_is_served_to_its_last_frame(image: &Path) -> Result<(), Failed> {
    const FRAMES: u64 = 4_000;
    let board = boot(image)?;
    let mut client = SlcanClient::open(board.can_address())?;
    let opened = client.acknowledged();
    let flood = b"t7FF80011223344556677\r".repeat(FRAMES as usize);
    let mut other_end = client.stream().try_clone()?;
    let writer = std::thread::spawn(move || other_end.write_all(&flood));
    let mut silent_since = Instant::now();
    let mut acknowledged = opened;
    while acknowledged < opened + FRAMES {
        client.receive(Duration::from_millis(100))?;
        if client.acknowledged() != acknowledged {
            (acknowledged, silent_since) = (client.acknowledged(), Instant::now());
        }
        assert!(silent_since.elapsed() < PATIENCE, "{} of {FRAMES} acknowledged", acknowledged - opened);
    }
    writer.join().map_err(|_| "the writer panicked")??;
    assert_eq!((acknowledged - opened, client.refused()), (FRAMES, 0));
    Ok(())
}

/// Interrupts that come late on a busy host must not slow the board's clock. The adapter stamps each answer of the board
/// somewhere between the host's sending of the question and its reading of the answer: by how much the two clocks differ is
/// known that well from each answer, and must be the same in all of them while a flood keeps the emulator busy. However long
/// either of the two stands still, that only widens its bounds.
pub fn the_clock_keeps_time_under_load(image: &Path) -> Result<(), Failed> {
    /// The board counts whole milliseconds, and works with the one in which its turn began.
    const ROUNDING_MS: f64 = 3.0;
    let board = boot(image)?;
    let mut line = TcpStream::connect(board.can_address())?;
    line.set_nodelay(true)?;
    line.set_read_timeout(Some(PATIENCE))?;
    line.write_all(b"Z1\rO\r")?;
    let flood = b"t7FF80011223344556677\r".repeat(FLOOD_BETWEEN);
    let began = Instant::now();
    // lower and upper bounds of the board's clock less the host's, ms
    let (mut lowest, mut highest) = (f64::NEG_INFINITY, f64::INFINITY);
    let (mut before_ms, mut board_ms) = (None, 0);
    for nonce in 1.. {
        line.write_all(&flood)?;
        let asked = began.elapsed();
        let query = Request { opcode: Opcode::Query as u8, boot: 0, nonce, run_id: 0, argument: 0 };
        line.write_all(&slcan::encode(&query.pack(BaseId::DEFAULT.command()), None))?;
        let stamp_ms = answer_stamp(&mut line, nonce)?;
        let answered = began.elapsed();
        // stamps begin anew every minute
        board_ms += (stamp_ms + 60_000 - before_ms.unwrap_or(stamp_ms)) % 60_000;
        before_ms = Some(stamp_ms);
        lowest = f64::max(lowest, f64::from(board_ms) - answered.as_secs_f64() * 1_000.0 - ROUNDING_MS);
        highest = f64::min(highest, f64::from(board_ms) - asked.as_secs_f64() * 1_000.0 + ROUNDING_MS);
        if answered > Duration::from_secs(3) {
            break;
        }
    }
    assert!(lowest <= highest, "the board's clock drifts by {} ms against the host's", lowest - highest);
    Ok(())
}

/// The time stamp of the board's answer to this question.
fn answer_stamp(line: &mut TcpStream, nonce: u16) -> Result<u32, Failed> {
    let mut text = String::new();
    loop {
        let mut byte = [0];
        line.read_exact(&mut byte)?;
        if byte != *b"\r" {
            text.push(char::from(byte[0]));
            continue;
        }
        // every frame of the device has 8 bytes: identifier, length, data, stamp
        if text.starts_with('t') && text.len() == 1 + 3 + 1 + 16 + 4 {
            let (frame, stamp) = text.split_at(21);
            let Ok(Command::Transmit(frame)) = slcan::parse(frame.as_bytes()) else { return Err(text.into()) };
            if matches!(Message::unpack(&frame, BaseId::DEFAULT)?, Message::Answer(answer) if answer.nonce == nonce) {
                return Ok(u32::from_str_radix(stamp, 16)?);
            }
        }
        text.clear();
    }
}
