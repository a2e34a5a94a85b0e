//! One bus for many clients, and the page's server: against a board that is only an SLCAN adapter.

use glenoid::can::Frame;
use glenoid::slcan::Adapter;
use host_tests::live::{SharedBus, serve_page, serve_slcan};
use host_tests::slcan_client::{SlcanClient, nothing_came};
use std::io::{Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread;
use std::time::Duration;
use tungstenite::Message;

/// Far longer than anything here takes; a loaded machine gets the time that it needs.
const PATIENCE: Duration = Duration::from_secs(60);

fn listener() -> (TcpListener, SocketAddr) {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let address = listener.local_addr().unwrap();
    (listener, address)
}

fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(id, data).unwrap()
}

/// A board that says what it is told to say, and tells what it hears.
struct Board {
    say: Sender<Frame>,
    heard: Receiver<Frame>,
    address: SocketAddr,
}

fn board() -> Board {
    let (listener, address) = listener();
    let ((say, to_say), (hear, heard)) = (mpsc::channel::<Frame>(), mpsc::channel());
    thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        stream.set_read_timeout(Some(Duration::from_millis(2))).unwrap();
        let mut adapter = Adapter::new();
        loop {
            let mut bytes = [0; 256];
            let len = stream.read(&mut bytes).unwrap_or(0);
            for byte in &bytes[..len] {
                if let Some(answer) = adapter.receive(*byte) {
                    let _ = stream.write_all(answer.reply);
                    answer.frame.map(|frame| hear.send(frame));
                }
            }
            while let Ok(frame) = to_say.try_recv() {
                adapter.forward(&frame, 0).map(|line| stream.write_all(&line));
            }
        }
    });
    Board { say, heard, address }
}

/// A shared bus to a board, and the address that clients connect to.
fn shared() -> (Board, SharedBus, SocketAddr) {
    let board = board();
    let bus = SharedBus::new(board.address);
    let (listener, address) = listener();
    serve_slcan(bus.clone(), listener);
    (board, bus, address)
}

#[test]
fn every_client_hears_the_board_and_the_others_and_the_board_hears_them_all() {
    let (board, _, address) = shared();
    let mut clients: Vec<_> = (0..3).map(|_| SlcanClient::open(address).unwrap()).collect();
    board.say.send(frame(0x682, &[1, 2, 3])).unwrap();
    for client in &mut clients {
        assert_eq!(client.receive(PATIENCE).unwrap(), Some(frame(0x682, &[1, 2, 3])));
    }
    clients[1].send(&frame(0x680, &[9])).unwrap();
    assert_eq!(board.heard.recv_timeout(PATIENCE), Ok(frame(0x680, &[9])));
    for k in [0, 2] {
        assert_eq!(clients[k].receive(PATIENCE).unwrap(), Some(frame(0x680, &[9])));
    }
    // as on a real bus, nobody hears himself
    assert_eq!(clients[1].receive(Duration::from_millis(100)).unwrap(), None);
}

#[test]
fn a_client_that_leaves_or_does_not_read_disturbs_nobody() {
    let (board, _, address) = shared();
    let deaf = SlcanClient::open(address).unwrap();
    drop(SlcanClient::open(address).unwrap());
    let mut client = SlcanClient::open(address).unwrap();
    for number in 0..5000u16 {
        board.say.send(frame(0x69B, &number.to_le_bytes())).unwrap();
        if number % 500 == 499 {
            let last = client.receive_where(PATIENCE, |heard| heard.data() == number.to_le_bytes()).unwrap();
            assert!(last.is_some(), "frame {number}");
        }
    }
    drop(deaf);
}

#[test]
fn a_read_that_a_signal_interrupts_is_tried_again() {
    use std::io::ErrorKind;
    for kind in [ErrorKind::WouldBlock, ErrorKind::TimedOut, ErrorKind::Interrupted] {
        assert!(nothing_came(&kind.into()), "{kind:?}");
    }
    for kind in [ErrorKind::ConnectionReset, ErrorKind::UnexpectedEof, ErrorKind::BrokenPipe] {
        assert!(!nothing_came(&kind.into()), "{kind:?}");
    }
}

/// Asks the page's server for something, and gives the head and the body of its answer.
fn ask(address: SocketAddr, request: &str) -> (String, Vec<u8>) {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream.write_all(format!("{request}\r\nHost: {address}\r\n\r\n").as_bytes()).unwrap();
    let mut all = Vec::new();
    stream.read_to_end(&mut all).unwrap();
    let end = all.windows(4).position(|bytes| bytes == b"\r\n\r\n").unwrap();
    (String::from_utf8_lossy(&all[..end]).into_owned(), all[end + 4..].to_vec())
}

#[test]
fn the_page_is_served_and_nothing_else() {
    let (board, bus, _) = shared();
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("page_server");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("index.html"), "<p>here").unwrap();
    std::fs::write(folder.join("page.wasm"), [0, 97, 115, 109]).unwrap();
    std::fs::write(folder.join("secret.txt"), "no").unwrap();
    let (listener, address) = listener();
    serve_page(bus, listener, folder);
    for path in ["/", "/index.html", "/?a=b"] {
        let (head, body) = ask(address, &format!("GET {path} HTTP/1.1"));
        assert!(head.starts_with("HTTP/1.1 200") && head.contains("text/html"), "{path}: {head}");
        assert_eq!(body, b"<p>here", "{path}");
    }
    let (head, body) = ask(address, "GET /page.wasm HTTP/1.1");
    assert!(head.contains("application/wasm"), "{head}");
    assert_eq!(body, [0, 97, 115, 109]);
    for path in ["/secret.txt", "/../Cargo.toml", "/page.js", "//etc/passwd", "/index.html/.."] {
        assert!(ask(address, &format!("GET {path} HTTP/1.1")).0.starts_with("HTTP/1.1 404"), "{path}");
    }
    drop(board);
}

#[test]
fn the_page_has_the_bus_over_its_socket_and_pages_of_others_have_not() {
    let (board, bus, _) = shared();
    let (listener, address) = listener();
    serve_page(bus, listener, std::env::temp_dir());
    let stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    let (mut socket, _) = tungstenite::client(format!("ws://{address}/bus"), stream).unwrap();
    socket.send(Message::Binary(b"C\rS6\rO\r".to_vec().into())).unwrap();
    let mut read = String::new();
    while read.matches('\r').count() < 3 {
        read += std::str::from_utf8(&socket.read().unwrap().into_data()).unwrap();
    }
    board.say.send(frame(0x682, &[0xAB])).unwrap();
    while !read.contains("t6821AB\r") {
        read += std::str::from_utf8(&socket.read().unwrap().into_data()).unwrap();
    }
    socket.send(Message::Text("t68011F\r".into())).unwrap();
    assert_eq!(board.heard.recv_timeout(PATIENCE), Ok(frame(0x680, &[0x1F])));

    let foreign = "GET /bus HTTP/1.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nOrigin: http://elsewhere.example";
    assert!(ask(address, foreign).0.starts_with("HTTP/1.1 403"));
}
