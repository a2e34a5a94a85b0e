//! The emulated drive board: QEMU's mps2-an386, a Cortex-M4F with the memory sizes of the STM32G474RE.
//!
//! UART0 is the CAN bus as SLCAN, UART1 the rig link, the log goes out by semihosting, and the record lies in a file of
//! the host. No decision is taken here:
//! bytes become events, the [`Device`] decides, actions become bytes.
#![no_std]
#![no_main]

#[cfg(not(target_os = "none"))]
compile_error!("this image is for the Cortex-M4F: use `cargo emulate`, or --target thumbv7em-none-eabihf");

mod clock;
mod cmsdk;
#[path = "../cortex_m/mod.rs"]
mod cortex;
mod device_entry;
mod entry;
mod flash;
mod interrupt;
mod log;
mod losses;
mod uart;
mod vectors;
mod watchdog;

use cortex_m::interrupt::free;
use cortex_m::{Peripherals, asm, singleton};
use glenoid::device::{Action, BlinkPattern, Device, Event, LogEntry, module_fingerprint};
use glenoid::identification::{Estimator, PoseBuffer};
use glenoid::record::{LoadError, Storage, StoreError};
use glenoid::restart::{CrashRecord, ResetCause, Restart};
use glenoid::rig_link::{RigLink, Signal};
use glenoid::slcan::Adapter;

use clock::Clock;
use cortex::{ccm_code, faults, in_place, retained_ram, stack};
use entry::Entry;
use flash::FileFlash;
use log::Log;
use losses::{LossReporter, Losses};
use uart::{CAN_LINE, FORTY_FRAMES, NOTHING, Queues, RIG_LINE, Uart};
use watchdog::Watchdog;

/// Bytes of either line that are handled before the clock is looked at again.
const BYTES_A_TURN: usize = 64;

/// Everything that actions go out through.
struct Outside {
    can: Uart,
    adapter: Adapter,
    led: Option<BlinkPattern>,
    log: Log<Entry>,
    storage: &'static mut Storage<FileFlash>,
    /// The record that was refused, which the device is still to hear.
    refused: Option<StoreError>,
    /// The deepest calls of this firmware lie just behind us.
    measure_stack: bool,
}

impl Outside {
    fn carry_out(&mut self, now_ms: u32, action: Action) {
        match action {
            Action::Send(frame) => {
                if let Some(line) = self.adapter.forward(&frame, now_ms) {
                    self.can.write(&line);
                }
            }
            Action::StatusLed(pattern) if self.led == Some(pattern) => {}
            Action::StatusLed(pattern) => {
                self.led = Some(pattern);
                self.log.push(now_ms, Entry::StatusLed(pattern));
            }
            Action::Store(record) => self.refused = self.storage.store(record).err(),
            Action::StoreParameters(set) => self.storage.store_parameters(&set),
            Action::EraseRecord => self.storage.erase_record(),
            Action::Journal(entry) => self.storage.append(&entry),
            Action::Stop(cause) => faults::stop(cause, 0, 0, format_args!("{}", cause.text())),
            Action::Log(entry) => {
                self.measure_stack |=
                    matches!(entry, LogEntry::Identified { .. } | LogEntry::HingeIdentified { body: 1, .. });
                self.log.push(now_ms, Entry::Device(entry));
            }
        }
    }
}

struct Board {
    device: &'static mut Device,
    rig: Uart,
    rig_link: RigLink,
    outside: Outside,
    losses: Losses,
    loss_reporter: LossReporter,
    clock: Clock,
    watchdog: Watchdog,
    last_tick_ms: u32,
}

/// The board before its device has heard anything.
struct Assembled {
    board: &'static mut Board,
    /// Fingerprint of the rig.
    rig: u32,
    /// Why the stored parameters are not those in use.
    parameters: Option<LoadError>,
}

impl Board {
    /// The parts in their places. None if it was called before: the peripherals and the queues exist once.
    fn assemble(restart: Restart) -> Option<Assembled> {
        let core = Peripherals::take()?;
        stack::protect(&core.MPU);
        let can_queues = singleton!(: Queues<FORTY_FRAMES> = Queues::new())?;
        let rig_queues = singleton!(: Queues<NOTHING> = Queues::new())?;
        let mut clock = Clock::start(core.SYST);
        let storage = storage()?;
        let (config, parameters) = storage.config(restart, 0)?;
        let rig = module_fingerprint(&config.rig);
        let device = in_place::device(&config)?;
        // In a place of its own: on the stack it would lie under everything, twice while it is built.
        let board = singleton!(: Board = Board {
            device,
            rig: Uart::start(&RIG_LINE, rig_queues),
            rig_link: RigLink::new(),
            outside: Outside {
                can: Uart::start(&CAN_LINE, can_queues),
                adapter: Adapter::new(),
                led: None,
                log: Log::new(),
                storage,
                refused: None,
                measure_stack: false,
            },
            losses: Losses::default(),
            loss_reporter: LossReporter::default(),
            last_tick_ms: clock.now_ms(),
            clock,
            watchdog: Watchdog::start(),
        })?;
        Some(Assembled { board, rig, parameters })
    }

    fn power_up(&mut self, restart: &Restart, rig: u32, parameters: Option<LoadError>) {
        log_start(restart);
        let loaded = self.outside.storage.load(rig, parameters);
        self.handle(self.last_tick_ms, Event::PowerUp(loaded));
        let memory = Entry::Memory {
            device: size_of::<Device>(),
            poses: size_of::<PoseBuffer<f32>>(),
            estimator: size_of::<Estimator<f32>>(),
        };
        for entry in [Entry::Ready { stack: stack::usage() }, memory] {
            self.outside.log.push(self.last_tick_ms, entry);
        }
    }

    fn handle(&mut self, now_ms: u32, event: Event) {
        let Self { device, outside, .. } = self;
        device.handle(now_ms, event, &mut |action| outside.carry_out(now_ms, action));
        if let Some(error) = outside.refused.take() {
            device.handle(now_ms, Event::Stored(Err(error)), &mut |action| outside.carry_out(now_ms, action));
        }
    }

    /// One turn of the main loop; false if there was nothing to do.
    fn turn(&mut self) -> bool {
        self.watchdog.feed();
        // While something is stored, commands wait: whoever gets the next answer can rely on it.
        let heard = (!self.outside.storage.is_storing() && self.hear_can()) | self.hear_rig();
        let busy = self.device.is_busy() | self.outside.storage.is_quick();
        let now_ms = self.clock.now_ms();
        let ticked = now_ms != self.last_tick_ms;
        if ticked || busy {
            self.last_tick_ms = now_ms;
            self.handle(now_ms, Event::Tick);
        }
        if let Some(event) = self.outside.storage.go_on().and_then(Event::of) {
            self.handle(now_ms, event);
        }
        heard || busy || ticked || self.write_log(now_ms)
    }

    fn hear_can(&mut self) -> bool {
        if self.outside.can.take_overrun() {
            self.outside.adapter.note_overrun();
            let now_ms = self.clock.now_ms();
            self.handle(now_ms, Event::ReceiveOverrun { lost: 1 });
        }
        for turn in 0..BYTES_A_TURN {
            let Some(byte) = self.outside.can.read() else { return turn != 0 };
            let Some(answer) = self.outside.adapter.receive(byte) else { continue };
            self.outside.can.write(answer.reply);
            if let Some(error) = answer.refusal {
                self.losses.slcan.1 = Some(error);
            }
            if let Some(frame) = answer.frame {
                let now_ms = self.clock.now_ms();
                self.handle(now_ms, Event::Can(frame));
            }
        }
        true
    }

    fn hear_rig(&mut self) -> bool {
        for turn in 0..BYTES_A_TURN {
            let Some(byte) = self.rig.read() else { return turn != 0 };
            let Some(signal) = self.rig_link.push(byte) else { continue };
            let now_ms = self.clock.now_ms();
            match signal {
                Ok(Signal::Counts(counts)) => self.handle(now_ms, Event::Counts(counts)),
                Ok(Signal::Button { down }) => self.handle(now_ms, Event::Button { down }),
                Err(error) => self.losses.rig_link.1 = Some(error),
            }
        }
        true
    }

    /// Writes one line of the log, if there is one. Called when there is nothing else to do.
    fn write_log(&mut self, now_ms: u32) -> bool {
        let Self { outside, losses, .. } = self;
        let counters = outside.adapter.counters();
        losses.slcan.0 = counters.refused;
        losses.overruns = counters.overruns;
        losses.rig_link.0 = self.rig_link.refused();
        losses.dropped = outside.can.dropped();
        self.loss_reporter.report(now_ms, *losses, |entry| outside.log.push(now_ms, entry));
        if core::mem::take(&mut outside.measure_stack) {
            outside.log.push(now_ms, Entry::Stack(stack::usage()));
        }
        outside.log.write_one()
    }

    /// Sleeps until the next interrupt. Interrupts are masked while the queues are looked at: one that comes in
    /// between still ends the sleep.
    fn sleep(&mut self) {
        free(|_| {
            let idle = !self.outside.can.has_received()
                && !self.rig.has_received()
                && self.clock.now_ms() == self.last_tick_ms;
            if idle {
                asm::wfi();
            }
        });
    }
}

/// Says why the board starts: at once, since a crash record would take most of the log's queue.
fn log_start(restart: &Restart) {
    let cause = restart.cause.text();
    match &restart.crash_record {
        None => log::write_now(format_args!("board: started by {cause}")),
        Some(words) => {
            log::write_now(format_args!("board: started by {cause}; its crash record says: {}", words.text()));
        }
    }
}

/// Called by [`cortex`] just before a reset: the host listens at any moment.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
fn board_says(words: &CrashRecord) {
    let (cause, address, line) = (words.cause.text(), words.address, words.line);
    log::write_now(format_args!("stop: {cause}, at {address:#x}, line {line}: {}", words.text()));
}

/// Called by [`cortex`]: the watchdog is all that this board's non-maskable interrupt comes from.
// SAFETY: as above.
#[unsafe(no_mangle)]
fn board_on_nmi(address: u32) {
    faults::stop(ResetCause::Watchdog, address, 0, format_args!("the main loop stood still"))
}

#[cortex_m_rt::entry]
fn main() -> ! {
    ccm_code::load();
    let restart = retained_ram::take(None);
    stack::paint();
    // another start would find the same
    let Some(assembled) = Board::assemble(restart) else { log::give_up(format_args!("board: started twice")) };
    run(assembled, &restart)
}

/// The board at work.
fn run(Assembled { board, rig, parameters }: Assembled, restart: &Restart) -> ! {
    board.power_up(restart, rig, parameters);
    // what is measured from here on is the work, not the start
    stack::paint();
    let mut comparison = ccm_code::Comparison::new();
    loop {
        if !board.turn() {
            comparison.go_on();
            board.sleep();
        }
    }
}

/// The storage in its place, once.
fn storage() -> Option<&'static mut Storage<FileFlash>> {
    singleton!(: Storage<FileFlash> = Storage::new(FileFlash::open(), 0))
}
