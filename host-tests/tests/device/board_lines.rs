//! The pace at which a board is given samples: against a board that is only an SLCAN adapter and a rig link.

use glenoid::can::Frame;
use glenoid::slcan::Adapter;
use host_tests::board_lines::BoardLines;
use host_tests::slcan_client::SlcanClient;
use std::io::{Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::thread;
use std::time::Duration;

/// However long the board stands still, one sample at most waits for it when it goes on: it never sees an arm that leaps.
/// What it says meanwhile arrives in order.
#[test]
fn one_sample_at_most_waits_for_a_board_that_stands_still() {
    const SAMPLES: i32 = 40;
    let [rig, can] = [(); 2].map(|()| TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap());
    let [rig_address, can_address] = [&rig, &can].map(|listener| listener.local_addr().unwrap());
    let board = thread::spawn(move || {
        let (mut can, _) = can.accept().unwrap();
        let (mut rig, _) = rig.accept().unwrap();
        can.set_nonblocking(true).unwrap();
        rig.set_nonblocking(true).unwrap();
        let (mut adapter, mut samples, mut most_at_once) = (Adapter::new(), String::new(), 0);
        for turn in 0_u32.. {
            // now and then long enough for many samples
            thread::sleep(Duration::from_millis(if turn % 8 == 0 { 200 } else { 1 }));
            let mut bytes = [0; 4096];
            let len = rig.read(&mut bytes).unwrap_or(0);
            let heard = std::str::from_utf8(&bytes[..len]).unwrap();
            most_at_once = most_at_once.max(heard.matches('\n').count());
            samples += heard;
            if samples.ends_with(&format!(" {SAMPLES}\n")) {
                break;
            }
            let len = can.read(&mut bytes).unwrap_or(0);
            for byte in &bytes[..len] {
                if let Some(answer) = adapter.receive(*byte) {
                    can.write_all(answer.reply).unwrap();
                }
            }
            if let Some(line) = adapter.forward(&Frame::new(0x682, &turn.to_le_bytes()[..1]).unwrap(), 0) {
                can.write_all(&line).unwrap();
            }
        }
        (samples, most_at_once)
    });
    let rig = TcpStream::connect(rig_address).unwrap();
    let mut lines = BoardLines::over(rig, SlcanClient::open(can_address).unwrap());
    let mut said = Vec::new();
    for sample in 1..SAMPLES {
        lines.sample(&[sample; 6]).unwrap();
        said.extend(lines.pass(Duration::from_millis(10), 0).unwrap().iter().map(|frame| frame.data()[0]));
    }
    lines.sample(&[SAMPLES; 6]).unwrap();
    let (samples, most_at_once) = board.join().unwrap();
    let expected: String = (1..=SAMPLES).map(|k| format!("e {k} {k} {k} {k} {k} {k}\n")).collect();
    assert_eq!(samples, expected);
    assert_eq!(most_at_once, 1);
    assert!(said.windows(2).all(|two| two[1] == two[0].wrapping_add(1)), "{said:?}");
}
