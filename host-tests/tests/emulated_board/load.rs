//! The board under more traffic than it can serve at once.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::time::{Duration, Instant};

use host_tests::slcan_client::SlcanClient;
use libtest_mimic::Failed;

use crate::{PATIENCE, boot};

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

/// Interrupts that come late on a busy host must not slow the board's clock: time stamps of the adapter are compared with
/// the host's own time while a flood keeps the emulator busy.
pub fn the_clock_keeps_time_under_load(image: &Path) -> Result<(), Failed> {
    let board = boot(image)?;
    let mut line = TcpStream::connect(board.can_address())?;
    line.set_nodelay(true)?;
    line.write_all(b"Z1\rO\r")?;
    let mut other_end = line.try_clone()?;
    let writer = std::thread::spawn(move || other_end.write_all(&b"t7FF80011223344556677\r".repeat(2_000)));
    let first = stamp(&mut line)?;
    let mut last = first;
    while last.1.duration_since(first.1) < Duration::from_secs(2) {
        last = stamp(&mut line)?;
    }
    writer.join().map_err(|_| "the writer panicked")??;
    let board_ms = f64::from((last.0 + 60_000 - first.0) % 60_000);
    let host_ms = last.1.duration_since(first.1).as_secs_f64() * 1_000.0;
    // a stamp may be some way behind its frame: in the queue, in the emulator, on a busy host
    assert!((board_ms - host_ms).abs() < 250.0, "{board_ms} ms on the board, {host_ms} ms on the host");
    Ok(())
}

/// The next time stamp of a frame from the board, and when it was read.
fn stamp(line: &mut TcpStream) -> Result<(u32, Instant), Failed> {
    line.set_read_timeout(Some(PATIENCE))?;
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
            return Ok((u32::from_str_radix(&text[21..], 16)?, Instant::now()));
        }
        text.clear();
    }
}
