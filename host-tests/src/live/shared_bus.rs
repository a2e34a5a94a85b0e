//! One CAN bus for many clients: what the board sends goes to all, what a client sends goes to the board and the others,
//! as on a real bus.

use crate::slcan_client::SlcanClient;
use glenoid::can::Frame;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver, Sender, SyncSender};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Frames that wait for a client at most. One that does not read loses what comes after them; the board and the others
/// go on.
const WAITING_FRAMES: usize = 8192;

/// Longest wait for a frame of the board before frames of clients are looked for.
const TURN: Duration = Duration::from_millis(2);

/// The board sends a heartbeat every 100 ms. After so much silence its channel is opened again: a board that was reset
/// has a closed one.
const SILENCE: Duration = Duration::from_millis(500);

/// A bus with one board. Clones are the same bus.
#[derive(Clone, Debug)]
pub struct SharedBus {
    ports: Arc<Mutex<Vec<Tap>>>,
    to_board: Sender<(u64, Frame)>,
    next: Arc<AtomicU64>,
}

#[derive(Debug)]
struct Tap {
    number: u64,
    frames: SyncSender<Frame>,
}

/// One client's place on the bus. Dropping it leaves the bus.
#[derive(Debug)]
pub struct Port {
    number: u64,
    frames: Receiver<Frame>,
    to_board: Sender<(u64, Frame)>,
}

impl SharedBus {
    /// A bus to the board at this address. When the board goes away and comes back, so does the bus.
    pub fn new(board: SocketAddr) -> Self {
        let (to_board, from_clients) = mpsc::channel();
        let bus = Self { ports: Arc::default(), to_board, next: Arc::default() };
        let ports = Arc::clone(&bus.ports);
        thread::spawn(move || pump(board, &ports, &from_clients));
        bus
    }

    /// A place on the bus.
    pub fn attach(&self) -> Port {
        let number = self.next.fetch_add(1, Ordering::Relaxed);
        let (sender, frames) = mpsc::sync_channel(WAITING_FRAMES);
        lock(&self.ports).push(Tap { number, frames: sender });
        Port { number, frames, to_board: self.to_board.clone() }
    }
}

impl Port {
    /// Puts a frame on the bus.
    pub fn send(&self, frame: Frame) {
        // The pump lives as long as the process.
        let _ = self.to_board.send((self.number, frame));
    }

    /// The next frame of the board or of another client, waiting at most `limit` for it.
    pub fn receive(&self, limit: Duration) -> Option<Frame> {
        self.frames.recv_timeout(limit).ok()
    }

    /// The next frame that is there already.
    pub fn try_receive(&self) -> Option<Frame> {
        self.frames.try_recv().ok()
    }
}

fn lock(ports: &Mutex<Vec<Tap>>) -> MutexGuard<'_, Vec<Tap>> {
    ports.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Passes a frame to all but its sender; who is gone is forgotten.
fn pass_on(ports: &Mutex<Vec<Tap>>, sender: Option<u64>, frame: Frame) {
    lock(ports).retain(|tap| {
        Some(tap.number) == sender || !matches!(tap.frames.try_send(frame), Err(mpsc::TrySendError::Disconnected(_)))
    });
}

fn pump(board: SocketAddr, ports: &Mutex<Vec<Tap>>, from_clients: &Receiver<(u64, Frame)>) {
    loop {
        if let Ok(mut line) = SlcanClient::open(board) {
            // It ends with the line; what clients send meanwhile is lost, as on a bus without a board.
            let _ = pump_line(&mut line, ports, from_clients);
        }
        while from_clients.try_recv().is_ok() {}
        thread::sleep(Duration::from_millis(200));
    }
}

fn pump_line(
    line: &mut SlcanClient,
    ports: &Mutex<Vec<Tap>>,
    from_clients: &Receiver<(u64, Frame)>,
) -> Result<(), crate::slcan_client::ClientError> {
    let mut heard = Instant::now();
    loop {
        if let Some(frame) = line.receive(TURN)? {
            heard = Instant::now();
            pass_on(ports, None, frame);
        }
        while let Ok((sender, frame)) = from_clients.try_recv() {
            line.send(&frame)?;
            pass_on(ports, Some(sender), frame);
        }
        if heard.elapsed() > SILENCE {
            heard = Instant::now();
            line.write(b"O\r")?;
        }
    }
}
