//! A board that runs with its bus and its person until somebody ends it: what `cargo emulate` and `cargo view` share.

use super::{Machine, Order, Patient, Person, SharedBus};
use crate::emulator::{self, Emulator, Options};
use crate::firmware::{self, Image};
use crate::packages::Consent;
use std::error::Error;
use std::net::SocketAddr;
use std::process::ExitCode;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::Duration;
use std::{io, thread};

/// A board that runs.
pub struct Running {
    board: Emulator,
    /// Its bus.
    pub bus: SharedBus,
    /// The person at its arm.
    pub patient: Option<Patient>,
    stopped: Receiver<()>,
    shows_log: bool,
}

impl Running {
    /// Builds the firmware, boots it, and sits a person into this machine. Ctrl-C ends [`Running::until_the_end`].
    ///
    /// # Errors
    /// Why one of them did not come about.
    pub fn start(
        options: &Options,
        seated: Option<(Person, Machine)>,
        consent: Consent,
    ) -> Result<Self, Box<dyn Error>> {
        let (stop, stopped) = mpsc::channel();
        // a second Ctrl-C finds nobody listening, and need not
        ctrlc::set_handler(move || {
            let _ = stop.send(());
        })?;
        emulator::ensure_installed(consent)?;
        let image = firmware::build(Image::EMULATED, consent)?;
        let board = Emulator::start(&image, options)?;
        let bus = SharedBus::new(board.can_address());
        let patient = seated
            .map(|(person, machine)| Patient::sit_down(person, machine, board.rig_address(), &bus))
            .transpose()?;
        Ok(Self { board, bus, patient, stopped, shows_log: options.show_log })
    }

    /// Where the rig link is.
    pub fn rig_address(&self) -> SocketAddr {
        self.board.rig_address()
    }

    /// Obeys what is typed until Ctrl-C, or until the board ends by itself. `command` names itself in complaints.
    ///
    /// # Errors
    /// When the board cannot be reset.
    pub fn until_the_end(mut self, command: &str) -> Result<ExitCode, Box<dyn Error>> {
        let typed = words_of_the_terminal();
        loop {
            match self.stopped.recv_timeout(Duration::from_millis(100)) {
                Ok(()) | Err(RecvTimeoutError::Disconnected) => return Ok(ExitCode::SUCCESS),
                Err(RecvTimeoutError::Timeout) => {}
            }
            if let Some(status) = self.board.exit_status() {
                let log = if self.shows_log { String::new() } else { self.board.log().join("\n") };
                eprintln!("{command}: the board ended by itself ({status})\n{log}");
                return Ok(ExitCode::FAILURE);
            }
            while let Ok(word) = typed.try_recv() {
                self.obey(word.trim())?;
            }
        }
    }

    fn obey(&mut self, word: &str) -> Result<(), Box<dyn Error>> {
        match (word, Order::parse(word), &self.patient) {
            ("", ..) => {}
            ("reset", ..) => self.board.reset()?,
            ("where", _, Some(patient)) => {
                println!("person    {}", patient.now());
            }
            (_, Some(order), Some(patient)) => patient.order(order),
            ("where", ..) | (_, Some(_), None) => eprintln!("{word:?} needs --wearer"),
            _ => eprintln!("{word:?}: press, release, silent, sound, pull N, where and reset are known"),
        }
        Ok(())
    }
}

/// Lines that are typed, as they come.
fn words_of_the_terminal() -> Receiver<String> {
    let (words, typed) = mpsc::channel();
    thread::spawn(move || io::stdin().lines().map_while(Result::ok).try_for_each(|line| words.send(line)));
    typed
}
