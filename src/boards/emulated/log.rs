//! The log: plain text by semihosting, one line an entry.
//!
//! A semihosting call stops the core until the host has answered, so entries wait in a queue and are written while
//! the board has nothing else to do. An entry that finds the queue full is dropped and counted.

use core::fmt::{self, Display, Write};

use cortex_m_semihosting::debug::{self, EXIT_FAILURE};
use cortex_m_semihosting::hio::{self, HostStream};
use heapless::{Deque, String};

/// Longest line; what is longer is cut.
const LINE_LEN: usize = 256;

/// Entries that may wait.
const CAPACITY: usize = 20;

/// Text that is cut where its buffer ends.
#[derive(Default)]
struct Cut(String<LINE_LEN>);

impl Write for Cut {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for character in text.chars() {
            if self.0.push(character).is_err() {
                break;
            }
        }
        Ok(())
    }
}

/// Queue of entries of the type `E`, each with its time.
pub struct Log<E> {
    waiting: Deque<(u32, E), CAPACITY>,
    dropped: u32,
    stream: Option<HostStream>,
}

impl<E: Display> Log<E> {
    /// An empty log on the host's standard output. Without a host that answers, entries vanish.
    pub fn new() -> Self {
        Self { waiting: Deque::new(), dropped: 0, stream: hio::hstdout().ok() }
    }

    /// Queues an entry.
    pub fn push(&mut self, now_ms: u32, entry: E) {
        if self.waiting.push_back((now_ms, entry)).is_err() {
            self.dropped = self.dropped.wrapping_add(1);
        }
    }

    /// Writes the oldest entry; false if there was none.
    pub fn write_one(&mut self) -> bool {
        if let Some((time_ms, entry)) = self.waiting.pop_front() {
            self.write_line(format_args!("[{time_ms:>8} ms] {entry}"));
            return true;
        }
        if self.dropped != 0 {
            let dropped = core::mem::take(&mut self.dropped);
            self.write_line(format_args!("log: {dropped} entries dropped"));
            return true;
        }
        false
    }

    fn write_line(&mut self, text: fmt::Arguments) {
        if let Some(stream) = &mut self.stream {
            write_line(stream, text);
        }
    }
}

/// Writes a line and ends the emulator with a failure: for what no restart can mend.
pub fn give_up(text: fmt::Arguments) -> ! {
    write_now(text);
    debug::exit(EXIT_FAILURE);
    loop {
        cortex_m::asm::bkpt();
    }
}

/// Writes a line at once: for a board that is about to stop.
pub fn write_now(text: fmt::Arguments) {
    if let Ok(mut stream) = hio::hstdout() {
        write_line(&mut stream, text);
    }
}

fn write_line(stream: &mut HostStream, text: fmt::Arguments) {
    let mut line = Cut::default();
    let _ = line.write_fmt(text);
    // one call for the text and one for its end; a host that does not listen is no reason to stop
    let _ = stream.write_all(line.0.as_bytes());
    let _ = stream.write_all(b"\n");
}
