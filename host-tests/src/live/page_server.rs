//! Serves the page, and the bus to it over WebSocket: the same SLCAN bytes as on a serial line.

use super::port::{Line, serve_line};
use super::shared_bus::SharedBus;
use crate::slcan_client::nothing_came;
use std::io::{self, ErrorKind, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};
use tungstenite::{Message, WebSocket};

/// Longest wait for bytes of the page before frames for it are looked for.
const TURN: Duration = Duration::from_millis(4);
/// Longest request that is looked at, and how long it may take to come.
const LONGEST_REQUEST: usize = 8192;
const REQUEST_LIMIT: Duration = Duration::from_secs(30);
/// A page that takes nothing for so long is gone.
const WRITE_LIMIT: Duration = Duration::from_secs(30);

/// The files of the page and their types. Nothing else is served.
const FILES: [(&str, &str, &str); 5] = [
    ("/", "index.html", "text/html; charset=utf-8"),
    ("/index.html", "index.html", "text/html; charset=utf-8"),
    ("/page.js", "page.js", "text/javascript; charset=utf-8"),
    ("/style.css", "style.css", "text/css; charset=utf-8"),
    ("/page.wasm", "page.wasm", "application/wasm"),
];

/// Serves the page in `folder` until the process ends.
pub fn serve_page(bus: SharedBus, listener: TcpListener, folder: PathBuf) {
    thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let (bus, folder) = (bus.clone(), folder.clone());
            // A browser that hangs up in the middle is no concern of the others.
            thread::spawn(move || drop(serve(&bus, stream, &folder)));
        }
    });
}

fn serve(bus: &SharedBus, mut stream: TcpStream, folder: &Path) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(WRITE_LIMIT))?;
    let request = peek(&stream)?;
    if request.to_ascii_lowercase().contains("\r\nupgrade: websocket") {
        // Other pages in the same browser have no business with the board.
        if !is_local(&request) {
            take_request(&stream, &request)?;
            return stream.write_all(b"HTTP/1.1 403 Forbidden\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
        }
        stream.set_read_timeout(Some(REQUEST_LIMIT))?;
        let socket = tungstenite::accept(stream).map_err(|error| io::Error::other(error.to_string()))?;
        socket.get_ref().set_read_timeout(Some(TURN))?;
        return serve_line(&bus.attach(), &mut Socket(socket));
    }
    let path = request.split(' ').nth(1).unwrap_or("/").split('?').next().unwrap_or("/");
    let file = FILES.iter().find(|(known, ..)| *known == path);
    let content = file.and_then(|(_, name, kind)| Some((std::fs::read(folder.join(name)).ok()?, *kind)));
    let (status, (body, kind)) = match content {
        Some(content) => ("200 OK", content),
        None => ("404 Not Found", (b"not found\n".to_vec(), "text/plain")),
    };
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-cache\r\n\
         Connection: close\r\n\r\n",
        body.len()
    );
    take_request(&stream, &request)?;
    stream.write_all(head.as_bytes())?;
    stream.write_all(&body)
}

/// Reads the request before the line is closed: a browser takes bytes left unread for a broken connection.
fn take_request(stream: &TcpStream, request: &str) -> io::Result<u64> {
    io::copy(&mut io::Read::take(stream, request.len() as u64), &mut io::sink())
}

/// The head of the request, which stays in the line for whoever serves it.
fn peek(stream: &TcpStream) -> io::Result<String> {
    stream.set_read_timeout(Some(REQUEST_LIMIT))?;
    let (mut bytes, begin) = (vec![0; LONGEST_REQUEST], Instant::now());
    loop {
        let len = stream.peek(&mut bytes)?;
        let text = String::from_utf8_lossy(&bytes[..len]);
        if let Some(end) = text.find("\r\n\r\n") {
            return Ok(text[..end + 4].to_owned());
        }
        if len == 0 || len == bytes.len() || begin.elapsed() > REQUEST_LIMIT {
            return Err(ErrorKind::InvalidData.into());
        }
        thread::sleep(Duration::from_millis(2));
    }
}

/// Does the request come from a page that this server has served?
fn is_local(request: &str) -> bool {
    let field = |name: &str| {
        let line = request.lines().find(|line| line.to_ascii_lowercase().starts_with(name));
        line.and_then(|line| line.split_once(':')).map(|(_, value)| value.trim().to_owned())
    };
    match (field("origin:"), field("host:")) {
        (Some(origin), Some(host)) => origin == format!("http://{host}"),
        // A program, not a page.
        (None, _) => true,
        _ => false,
    }
}

struct Socket(WebSocket<TcpStream>);

impl Line for Socket {
    fn read(&mut self) -> io::Result<Vec<u8>> {
        match self.0.read() {
            Ok(Message::Binary(bytes)) => Ok(bytes.to_vec()),
            Ok(Message::Text(text)) => Ok(text.as_bytes().to_vec()),
            Ok(Message::Close(_)) => Err(ErrorKind::UnexpectedEof.into()),
            Ok(_) => Ok(Vec::new()),
            Err(tungstenite::Error::Io(error)) if nothing_came(&error) => Ok(Vec::new()),
            Err(error) => Err(io::Error::other(error.to_string())),
        }
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.send(Message::Binary(bytes.to_vec().into())).map_err(|error| io::Error::other(error.to_string()))
    }
}
