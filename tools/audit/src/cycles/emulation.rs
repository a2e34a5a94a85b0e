//! Running the speed image in QEMU from beginning to end.

use std::fmt;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;
use std::process::{ExitStatus, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use host_tests::emulator;

/// A run takes a second, a traced one five; a machine under load gets much more.
const LIMIT: Duration = Duration::from_secs(300);

/// Why a run gave no figures.
#[derive(Debug)]
pub enum RunError {
    /// The emulator could not be started, or its output not be read.
    Emulator(io::Error),
    /// It ended otherwise than by the image's last word; the text is what it printed last.
    Failed(ExitStatus, String),
    /// It was stopped after the time that it may take.
    TooLong,
    /// The image printed a line that says nothing known.
    Line(String),
    /// A path did not end as it should.
    Path(String),
    /// The loop of two million instructions was counted as this many: the emulator does not count as expected.
    Loop(u64),
    /// The emulator's log is not what this program reads.
    Trace(String),
}

impl fmt::Display for RunError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Emulator(error) => write!(f, "the emulator could not be run: {error}"),
            Self::Failed(status, last) => write!(f, "the speed image ended with {status}: {last}"),
            Self::TooLong => write!(f, "the speed image did not end within {} s", LIMIT.as_secs()),
            Self::Line(line) => write!(f, "the speed image printed \"{line}\", which is not understood"),
            Self::Path(name) => write!(f, "the path {name} did not end as it should"),
            Self::Loop(count) => write!(f, "a loop of 2000000 instructions was counted as {count}"),
            Self::Trace(what) => write!(f, "the emulator's trace is not understood: {what}"),
        }
    }
}

impl std::error::Error for RunError {}

/// Boots the image with further options of the emulator and an argument of the image, and gives what it prints.
/// `log` gets the emulator's own lines, without their ends.
///
/// # Errors
/// [`RunError::Emulator`], [`RunError::Failed`], [`RunError::TooLong`].
pub fn run(image: &Path, options: &[&str], argument: &str, mut log: impl FnMut(&[u8])) -> Result<String, RunError> {
    let mut command = emulator::command();
    command.args(["-serial", "none", "-semihosting-config"]);
    command.arg(format!("enable=on,target=native,arg=speed,arg={argument}"));
    command.args(options).arg("-kernel").arg(image);
    let mut child = command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(RunError::Emulator)?;
    let (out, err) = (child.stdout.take(), child.stderr.take());
    let printed = thread::spawn(move || {
        let mut text = String::new();
        out.map_or(Ok(0), |mut out| out.read_to_string(&mut text)).map(|_| text)
    });
    let (done, wait) = mpsc::channel::<()>();
    let end = thread::spawn(move || {
        let too_long = wait.recv_timeout(LIMIT) == Err(RecvTimeoutError::Timeout);
        if too_long {
            let _ = child.kill();
        }
        (child.wait(), too_long)
    });
    // The log ends when the emulator does. What is left unread would stop it.
    let mut last = Vec::new();
    let read = err.map_or(Ok(()), |err| {
        each_line(err, |line| {
            log(line);
            last.clear();
            last.extend_from_slice(line);
        })
    });
    drop(done);
    let (status, too_long) = end.join().unwrap_or_else(|_| (Err(io::ErrorKind::Other.into()), false));
    let printed = printed.join().unwrap_or_else(|_| Err(io::ErrorKind::Other.into()));
    if too_long {
        return Err(RunError::TooLong);
    }
    read.map_err(RunError::Emulator)?;
    let (status, printed) = (status.map_err(RunError::Emulator)?, printed.map_err(RunError::Emulator)?);
    // a failed path is told by the image in its own words
    if !status.success() && !printed.contains("failed ") {
        let last = printed.lines().last().map_or_else(|| String::from_utf8_lossy(&last).into_owned(), str::to_owned);
        return Err(RunError::Failed(status, last));
    }
    Ok(printed)
}

fn each_line(stream: impl Read, mut log: impl FnMut(&[u8])) -> io::Result<()> {
    let mut reader = BufReader::with_capacity(1 << 16, stream);
    let mut line = Vec::new();
    loop {
        line.clear();
        if reader.read_until(b'\n', &mut line)? == 0 {
            return Ok(());
        }
        log(line.trim_ascii_end());
    }
}
