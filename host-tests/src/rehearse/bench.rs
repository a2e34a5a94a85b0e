//! Where a rehearsal takes place: something with six encoders, a button and a CAN bus.

use crate::flash::{MockFlash, TornWord};
use glenoid::can::Frame;
use glenoid::device::{Action, Config, Device, Event, module_fingerprint};
use glenoid::record::{STORAGE_PAGES, Storage};
use glenoid::rig::CABLES;
use std::fmt;

/// The wires to a drive board, and the passing of time.
pub trait Bench {
    /// Sets the six encoder counters.
    ///
    /// # Errors
    /// [`BenchError`] when the wires are gone.
    fn set_counts(&mut self, counts: &[i32; CABLES]) -> Result<(), BenchError>;

    /// Puts a frame on the bus.
    ///
    /// # Errors
    /// [`BenchError`] when the wires are gone.
    fn send(&mut self, frame: &Frame) -> Result<(), BenchError>;

    /// Lets `ms` milliseconds pass and returns the frames that the board sent meanwhile, in order.
    ///
    /// # Errors
    /// [`BenchError`] when the wires are gone.
    fn pass(&mut self, ms: u32) -> Result<Vec<Frame>, BenchError>;

    /// Takes the board's supply away and gives it back.
    ///
    /// # Errors
    /// [`BenchError`] when the board does not come back.
    fn restart(&mut self) -> Result<(), BenchError>;
}

/// The wires are gone, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BenchError(pub String);

impl fmt::Display for BenchError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for BenchError {}

/// The device without a board: the very type that the firmware drives, in this process, with a clock that is only
/// counted. A calibration takes milliseconds and is the same every time.
pub struct InProcess {
    config: Config,
    device: Device,
    storage: Storage<MockFlash>,
    now_ms: u32,
    heard: Vec<Frame>,
}

/// Most ticks that the device gets within one millisecond while it says that it has work to do. On the board it gets
/// as many as the processor can do.
const TICKS_A_MILLISECOND: usize = 20;

impl InProcess {
    /// A bench for a device of this kind with an erased flash, at time zero.
    pub fn new(config: Config) -> Self {
        let storage = Storage::new(MockFlash::new(STORAGE_PAGES, TornWord::Zeros, 1), 0);
        let mut bench = Self { device: Device::new(&config), config, storage, now_ms: 0, heard: Vec::new() };
        bench.start();
        bench
    }

    /// Starts with the stored parameters, or as made when there are none.
    fn start(&mut self) {
        let config = match self.storage.load_parameters() {
            Ok(set) => set.config(self.config.restart, self.config.serial).unwrap_or(self.config.clone()),
            Err(_) => self.config.clone(),
        };
        self.device = Device::new(&config);
        let loaded = self.storage.load(module_fingerprint(&config.rig), None);
        self.handle(Event::PowerUp(loaded));
    }

    fn handle(&mut self, event: Event) {
        let Self { device, storage, heard, .. } = self;
        let mut next = Some(event);
        while let Some(event) = next {
            let mut refused = None;
            device.handle(self.now_ms, event, &mut |action| match action {
                Action::Send(frame) => heard.push(frame),
                Action::Store(centre) => refused = storage.store(centre).err(),
                Action::Journal(entry) => storage.append(&entry),
                Action::StoreParameters(set) => storage.store_parameters(&set),
                Action::EraseRecord => storage.erase_record(),
                Action::Stop(_) | Action::StatusLed(_) | Action::Log(_) => {}
            });
            next = refused.map(|error| Event::Stored(Err(error)));
        }
    }

    /// Everything is stored before time goes on.
    fn store(&mut self) {
        while self.storage.is_working() {
            if let Some(event) = self.storage.go_on().and_then(Event::of) {
                self.handle(event);
            }
        }
    }
}

impl Bench for InProcess {
    fn set_counts(&mut self, counts: &[i32; CABLES]) -> Result<(), BenchError> {
        self.handle(Event::Counts(*counts));
        Ok(())
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BenchError> {
        self.handle(Event::Can(*frame));
        self.store();
        Ok(())
    }

    fn pass(&mut self, ms: u32) -> Result<Vec<Frame>, BenchError> {
        for _ in 0..ms {
            self.now_ms = self.now_ms.wrapping_add(1);
            self.handle(Event::Tick);
            self.store();
            for _ in 1..TICKS_A_MILLISECOND {
                if !self.device.is_busy() {
                    break;
                }
                self.handle(Event::Tick);
            }
        }
        Ok(std::mem::take(&mut self.heard))
    }

    fn restart(&mut self) -> Result<(), BenchError> {
        self.heard.clear();
        self.now_ms = 0;
        self.start();
        Ok(())
    }
}
