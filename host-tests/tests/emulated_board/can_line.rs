//! The CAN line as its clients see it, and the rig link beside it.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::time::Duration;

use glenoid::can::{BaseId, Frame, Message, Opcode, Request};
use host_tests::slcan_client::{PYTHON_CAN_OPENING, SlcanClient, nothing_came};
use libtest_mimic::Failed;

use crate::{PATIENCE, boot};

/// The next line, to its end, which is a carriage return or a bell; None when none has come within `limit`.
fn read_line(stream: &mut TcpStream, limit: Duration) -> Result<Option<String>, Failed> {
    stream.set_read_timeout(Some(limit))?;
    let (mut line, mut byte) = (String::new(), [0]);
    loop {
        match stream.read(&mut byte) {
            Ok(0) => return Err(format!("the line was closed after {line:?}").into()),
            Ok(_) => line.push(char::from(byte[0])),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) if nothing_came(&error) && line.is_empty() => return Ok(None),
            Err(error) => return Err(format!("{error} after {line:?}").into()),
        }
        if line.ends_with(['\r', '\x07']) {
            return Ok(Some(line));
        }
    }
}

/// The adapter's next answer. Once the channel is open, frames from the bus may stand before it: those are left out.
fn read_answer(stream: &mut TcpStream) -> Result<String, Failed> {
    loop {
        let line = read_line(stream, PATIENCE)?.ok_or("no answer")?;
        if !line.starts_with('t') {
            return Ok(line);
        }
    }
}

fn read_answers<const N: usize>(stream: &mut TcpStream) -> Result<[String; N], Failed> {
    let mut answers = [const { String::new() }; N];
    for answer in &mut answers {
        *answer = read_answer(stream)?;
    }
    Ok(answers)
}

/// The bytes that python-can 4.6.1 sends for `Bus(interface="slcan", bitrate=500000)`, then `V` and `N`, as its
/// `get_version` and `get_serial_number` do. Answers by the Lawicel manual.
pub fn python_can_opens_the_channel(image: &Path) -> Result<(), Failed> {
    let board = boot(image)?;
    let mut line = TcpStream::connect(board.can_address())?;
    line.write_all(b"C\rS6\r\r")?;
    assert_eq!(read_answers(&mut line)?, ["\r", "\r", "\r"]);
    line.write_all(b"V\rN\r")?;
    let [version, serial_number] = read_answers(&mut line)?;
    let digits = version.strip_prefix('V').and_then(|version| version.strip_suffix('\r'));
    assert!(
        digits.is_some_and(|digits| digits.len() == 4 && digits.bytes().all(|digit| digit.is_ascii_digit())),
        "python-can reads the version as two decimal numbers, not {version:?}"
    );
    assert!(serial_number.starts_with('N') && serial_number.len() == 6, "{serial_number:?}");
    line.write_all(b"O\rO\r")?;
    assert_eq!(read_answers(&mut line)?, ["\r", "\r"]);
    Ok(())
}

pub fn a_closed_channel_is_silent(image: &Path) -> Result<(), Failed> {
    let board = boot(image)?;
    let mut line = TcpStream::connect(board.can_address())?;
    let quiet = Duration::from_millis(500);
    assert_eq!(read_line(&mut line, quiet)?, None, "before the channel was open");
    line.write_all(b"t1230\r")?;
    assert_eq!(read_answer(&mut line)?, "\x07", "a frame was taken before the channel was open");
    line.write_all(b"O\r")?;
    assert_eq!(read_answer(&mut line)?, "\r");
    let heard = read_line(&mut line, PATIENCE)?.ok_or("no heartbeat on the open channel")?;
    assert!(heard.starts_with('t'), "{heard:?}");
    line.write_all(b"C\r")?;
    // what was under way comes before the answer, and after it nothing
    assert_eq!(read_answer(&mut line)?, "\r");
    assert_eq!(read_line(&mut line, quiet)?, None, "after the channel was closed");
    Ok(())
}

/// 500 commands, each with its own nonce, are answered one by one and in order; heartbeats come in between. Foreign
/// frames are acknowledged by the adapter and answered by nobody.
pub fn frames_go_both_ways(image: &Path) -> Result<(), Failed> {
    let board = boot(image)?;
    let mut client = SlcanClient::open(board.can_address())?;
    let opened = client.acknowledged();
    let mut heartbeats = 0;
    for nonce in 1..=500 {
        client.send(&Frame::new(0x7FF, &[0xFF; 8])?)?;
        let query = Request { opcode: Opcode::Query as u8, boot: 0, nonce, run_id: 0, argument: 0 };
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

pub fn garbage_is_survived_and_counted(image: &Path) -> Result<(), Failed> {
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
    // heartbeats that were on their way stand before the four refusals
    while client.refused() < 4 {
        assert!(client.receive(PATIENCE)?.is_some(), "no heartbeat, {} refusals after garbage", client.refused());
    }
    assert!(client.receive(PATIENCE)?.is_some(), "no heartbeat after garbage");
    assert_eq!(client.refused(), 4);
    Ok(())
}

pub fn a_client_may_vanish_and_return(image: &Path) -> Result<(), Failed> {
    let board = boot(image)?;
    for _ in 0..5 {
        let mut line = TcpStream::connect(board.can_address())?;
        line.write_all(PYTHON_CAN_OPENING)?;
        read_line(&mut line, PATIENCE)?.ok_or("no answer")?;
        // in the middle of a frame
        line.write_all(b"t12381122")?;
    }
    let mut client = SlcanClient::open(board.can_address())?;
    assert!(client.receive(PATIENCE)?.is_some(), "no heartbeat for the client that returned");
    Ok(())
}
