//! What the emulator prints: the board's log.

use std::io::{BufRead, BufReader, Read};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// The lines that the emulator printed.
#[derive(Debug, Default)]
pub struct Log {
    lines: Mutex<Vec<String>>,
    grown: Condvar,
}

impl Log {
    /// All of them so far.
    pub fn lines(&self) -> MutexGuard<'_, Vec<String>> {
        // a reader that panicked has at worst left out a line
        self.lines.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The line that contains the text for this time, waiting once for new lines.
    pub fn find(&self, text: &str, times: usize, limit: Duration) -> Option<String> {
        let find =
            |lines: &[String]| lines.iter().filter(|line| line.contains(text)).nth(times.saturating_sub(1)).cloned();
        let lines = self.lines();
        find(&lines).or_else(|| {
            let (lines, _) = self.grown.wait_timeout(lines, limit).unwrap_or_else(PoisonError::into_inner);
            find(&lines)
        })
    }
}

/// Collects lines until the stream ends.
pub fn follow(stream: impl Read + Send + 'static, log: Arc<Log>, show: bool) -> JoinHandle<()> {
    thread::spawn(move || {
        for line in BufReader::new(stream).lines().map_while(Result::ok) {
            if show {
                eprintln!("{line}");
            }
            log.lines().push(line);
            log.grown.notify_all();
        }
    })
}
