//! Runs a firmware image in QEMU as the emulated drive board.

use glenoid::record::STORAGE_PAGES;
use std::ffi::OsString;
use std::fmt;
use std::io::{self, BufRead, BufReader, Read};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::flash::PAGE_LEN;
use crate::monitor;
use crate::packages::{self, Consent, PackageError};

/// The emulator's program.
const PROGRAM: &str = "qemu-system-arm";

/// Debian's package that holds it.
const PACKAGE: &str = "qemu-system-arm";

/// The firmware's first line; once it is there, both serial lines are served.
const READY: &str = "board: ready";

/// Booting takes a tenth of a second; a machine under load gets much more.
const BOOT_LIMIT: Duration = Duration::from_secs(20);

/// Tries to find ports, should another program take one between the search and the start.
const PORT_TRIES: usize = 3;

/// How a board is started.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// TCP port of the CAN line (SLCAN); any free one if None.
    pub can_port: Option<u16>,
    /// TCP port of the rig link; any free one if None.
    pub rig_port: Option<u16>,
    /// File that stands for the flash that the record lies in; one of this board's own, gone with it, if None.
    pub record: Option<PathBuf>,
    /// Serve a debugger, which may change registers (see [`crate::debugger`]).
    pub debugger: bool,
    /// Serve a monitor, which may reset the board (see [`Emulator::reset`]).
    pub monitor: bool,
    /// Repeat each line of the log on the error output.
    pub show_log: bool,
}

/// Why the board does not run.
#[derive(Debug)]
pub enum EmulatorError {
    /// The emulator is not installed.
    Missing(PackageError),
    /// It could not be started.
    Start(io::Error),
    /// The file that is to stand for the flash is something else.
    NotARecord(String),
    /// It ended by itself; the texts are its error output and the end of the board's log.
    Ended {
        /// How it ended.
        status: ExitStatus,
        /// What it complained about.
        complaint: String,
    },
    /// The log did not show this text in time.
    Silent(String),
    /// It should have ended, and runs on.
    StillRunning,
    /// A serial line could not be reached.
    Connect(io::Error),
}

impl fmt::Display for EmulatorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing(error) => write!(f, "`{PROGRAM}` is not on PATH (Debian's package {PACKAGE}): {error}"),
            Self::NotARecord(what) => f.write_str(what),
            Self::Start(error) => write!(f, "`{PROGRAM}` could not be started: {error}"),
            Self::Ended { status, complaint } => write!(f, "the emulator ended ({status}): {complaint}"),
            Self::Silent(text) => write!(f, "the board did not log \"{text}\" in time"),
            Self::StillRunning => write!(f, "the emulator did not end in time"),
            Self::Connect(error) => write!(f, "a serial line of the board could not be reached: {error}"),
        }
    }
}

impl std::error::Error for EmulatorError {}

/// Makes sure that the emulator is installed.
///
/// # Errors
/// [`EmulatorError::Missing`].
pub fn ensure_installed(consent: Consent) -> Result<(), EmulatorError> {
    if packages::find_program(PROGRAM).is_some() {
        return Ok(());
    }
    packages::ensure(&[PACKAGE], "emulating the drive board", consent).map_err(EmulatorError::Missing)
}

/// The emulator with the board's machine and nothing around it.
pub fn command() -> Command {
    let mut command = Command::new(PROGRAM);
    command.args(["-M", "mps2-an386", "-display", "none", "-monitor", "none"]);
    command
}

/// A running board. Dropping it ends it.
#[derive(Debug)]
pub struct Emulator {
    image: PathBuf,
    options: Options,
    child: Child,
    can: SocketAddr,
    rig: SocketAddr,
    debugger: Option<SocketAddr>,
    monitor: Option<SocketAddr>,
    log: Arc<Log>,
    readers: Vec<JoinHandle<()>>,
    record: RecordFile,
}

impl Emulator {
    /// Boots the image and waits until its serial lines are served.
    ///
    /// # Errors
    /// [`EmulatorError`].
    pub fn start(image: &Path, options: &Options) -> Result<Self, EmulatorError> {
        let mut tries = 1;
        loop {
            match Self::start_once(image, options) {
                Err(EmulatorError::Ended { complaint, .. })
                    if complaint.contains("Address already in use") && tries < PORT_TRIES =>
                {
                    tries += 1;
                }
                result => return result,
            }
        }
    }

    fn start_once(image: &Path, options: &Options) -> Result<Self, EmulatorError> {
        let can = local_address(options.can_port).map_err(EmulatorError::Start)?;
        let rig = local_address(options.rig_port).map_err(EmulatorError::Start)?;
        let mut command = command();
        let record = match &options.record {
            Some(path) => {
                refuse_what_is_no_record(path)?;
                RecordFile::Given(path.clone())
            }
            None => RecordFile::Own(own_record()),
        };
        command.arg("-semihosting-config").arg(record.semihosting());
        for line in [can, rig] {
            // the UART sends single bytes; without "nodelay" each answer would wait 40 ms for the client's acknowledgement
            command.arg("-serial").arg(format!("tcp:{line},server=on,wait=off,nodelay=on"));
        }
        let debugger = options.debugger.then(|| local_address(None)).transpose().map_err(EmulatorError::Start)?;
        if let Some(address) = debugger {
            command.arg("-gdb").arg(format!("tcp:{address}"));
        }
        let monitor = options.monitor.then(|| local_address(None)).transpose().map_err(EmulatorError::Start)?;
        if let Some(address) = monitor {
            command.arg("-qmp").arg(format!("tcp:{address},server=on,wait=off"));
        }
        command.arg("-kernel").arg(image);
        let mut child = command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(EmulatorError::Start)?;
        let log = Arc::new(Log::default());
        let readers = [
            child.stdout.take().map(|out: ChildStdout| follow(out, Arc::clone(&log), options.show_log)),
            child.stderr.take().map(|err: ChildStderr| follow(err, Arc::clone(&log), options.show_log)),
        ];
        let readers = readers.into_iter().flatten().collect();
        let (image, options) = (image.to_owned(), options.clone());
        let mut emulator = Self { image, options, child, can, rig, debugger, monitor, log, readers, record };
        emulator.wait_for_log(READY, BOOT_LIMIT)?;
        Ok(emulator)
    }

    /// Where an SLCAN client connects.
    pub fn can_address(&self) -> SocketAddr {
        self.can
    }

    /// Where the rig connects.
    pub fn rig_address(&self) -> SocketAddr {
        self.rig
    }

    /// The file that stands for the flash that the record lies in.
    pub fn record(&self) -> &Path {
        self.record.path()
    }

    /// Where a debugger connects, if the board serves one.
    pub fn debugger_address(&self) -> Option<SocketAddr> {
        self.debugger
    }

    /// Resets the board as its reset pin would. RAM and the record's flash keep their content.
    ///
    /// # Errors
    /// [`EmulatorError::Connect`] when the emulator serves no monitor.
    pub fn reset(&self) -> Result<(), EmulatorError> {
        let address = self.monitor.ok_or_else(|| io::Error::other("the emulator was started without a monitor"));
        address.and_then(monitor::reset).map_err(EmulatorError::Connect)
    }

    /// Takes the supply away and gives it back: RAM is lost, the record's flash keeps its content, the log begins anew.
    /// Ports that were free ones are other ones now.
    ///
    /// # Errors
    /// [`EmulatorError`]; the board is then off.
    pub fn power_cycle(&mut self) -> Result<(), EmulatorError> {
        let _ = self.child.kill();
        let _ = self.child.wait();
        self.finish_reading();
        let same_flash = Options { record: Some(self.record().to_owned()), ..self.options.clone() };
        let mut next = Self::start(&self.image, &same_flash)?;
        // the file goes with the board that made it
        std::mem::swap(&mut next.record, &mut self.record);
        next.options = self.options.clone();
        *self = next;
        Ok(())
    }

    /// The rig link, connected.
    ///
    /// # Errors
    /// [`EmulatorError::Connect`].
    pub fn connect_rig(&self) -> Result<TcpStream, EmulatorError> {
        let stream = TcpStream::connect(self.rig).map_err(EmulatorError::Connect)?;
        stream.set_nodelay(true).map_err(EmulatorError::Connect)?;
        Ok(stream)
    }

    /// Everything that the board has logged so far.
    pub fn log(&self) -> Vec<String> {
        self.log.lines().clone()
    }

    /// Waits until a line of the log contains `text`, and gives that line. Lines from before the call count too.
    ///
    /// # Errors
    /// [`EmulatorError::Silent`] after `limit`, [`EmulatorError::Ended`] if the board ended without such a line.
    pub fn wait_for_log(&mut self, text: &str, limit: Duration) -> Result<String, EmulatorError> {
        self.wait_for_log_times(text, 1, limit)
    }

    /// Waits until so many lines of the log contain `text`, and gives the last of these.
    ///
    /// # Errors
    /// As [`Emulator::wait_for_log`].
    pub fn wait_for_log_times(&mut self, text: &str, times: usize, limit: Duration) -> Result<String, EmulatorError> {
        let deadline = Instant::now() + limit;
        loop {
            // The state first: a line that came between the two looks is then still seen.
            let ended = self.exit_status();
            if ended.is_some() {
                self.finish_reading();
            }
            if let Some(line) = self.log.find(text, times, Duration::from_millis(20)) {
                return Ok(line);
            }
            if let Some(status) = ended {
                return Err(EmulatorError::Ended { status, complaint: self.log().join("\n") });
            }
            if Instant::now() >= deadline {
                return Err(EmulatorError::Silent(text.to_owned()));
            }
        }
    }

    /// Waits until the emulator ends.
    ///
    /// # Errors
    /// [`EmulatorError::StillRunning`] after `limit`.
    pub fn wait_for_end(&mut self, limit: Duration) -> Result<ExitStatus, EmulatorError> {
        let deadline = Instant::now() + limit;
        loop {
            if let Some(status) = self.exit_status() {
                self.finish_reading();
                return Ok(status);
            }
            if Instant::now() >= deadline {
                return Err(EmulatorError::StillRunning);
            }
            thread::sleep(Duration::from_millis(5));
        }
    }

    /// How the emulator ended, if it has.
    pub fn exit_status(&mut self) -> Option<ExitStatus> {
        self.child.try_wait().ok().flatten()
    }

    fn finish_reading(&mut self) {
        for reader in self.readers.drain(..) {
            let _ = reader.join();
        }
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        self.finish_reading();
        if let RecordFile::Own(path) = &self.record {
            let _ = std::fs::remove_file(path);
        }
    }
}

/// The file that stands for the flash.
#[derive(Debug)]
enum RecordFile {
    /// Somebody else's, which stays.
    Given(PathBuf),
    /// This board's, which goes with it.
    Own(PathBuf),
}

impl RecordFile {
    fn path(&self) -> &Path {
        let (Self::Given(path) | Self::Own(path)) = self;
        path
    }

    /// The emulator's option that tells the firmware the path. A comma would end it, so it is doubled.
    fn semihosting(&self) -> OsString {
        let path = self.path().to_string_lossy().replace(',', ",,");
        format!("enable=on,target=native,arg=firmware,arg=record={path}").into()
    }
}

/// A path that no other board of this machine has.
/// The board erases and writes this file: one that is there and is no record is somebody's.
fn refuse_what_is_no_record(path: &Path) -> Result<(), EmulatorError> {
    const LEN: u64 = (STORAGE_PAGES * PAGE_LEN) as u64;
    match std::fs::metadata(path) {
        Ok(file) if file.is_file() && [0, LEN].contains(&file.len()) => Ok(()),
        // The board can do nothing to a folder: a flash that refuses everything.
        Ok(file) if file.is_dir() => Ok(()),
        Ok(file) => Err(EmulatorError::NotARecord(format!(
            "{} is no record of the board: it has {} bytes, not {LEN}; it stays as it is",
            path.display(),
            file.len()
        ))),
        // it will be made
        Err(_) => Ok(()),
    }
}

fn own_record() -> PathBuf {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    std::env::temp_dir().join(format!("glenoid-record-{}-{number}", std::process::id()))
}

/// The lines that the emulator printed.
#[derive(Debug, Default)]
struct Log {
    lines: Mutex<Vec<String>>,
    grown: Condvar,
}

impl Log {
    fn lines(&self) -> MutexGuard<'_, Vec<String>> {
        // a reader that panicked has at worst left out a line
        self.lines.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The line that contains the text for this time, waiting once for new lines.
    fn find(&self, text: &str, times: usize, limit: Duration) -> Option<String> {
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
fn follow(stream: impl Read + Send + 'static, log: Arc<Log>, show: bool) -> JoinHandle<()> {
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

/// The given port on this machine alone, or one that is free at this moment.
fn local_address(port: Option<u16>) -> io::Result<SocketAddr> {
    match port {
        Some(port) => Ok(SocketAddr::from((Ipv4Addr::LOCALHOST, port))),
        None => TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?.local_addr(),
    }
}
