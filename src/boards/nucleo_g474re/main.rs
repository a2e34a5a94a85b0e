//! The real drive board: a NUCLEO-G474RE with six encoders and a CAN transceiver. `docs/nucleo-g474re.md` says how it is
//! wired and first switched on.
//!
//! No decision is taken here: registers become events, the [`Device`] decides, actions become registers. What there is
//! of arithmetic lies in [`glenoid::drive_board`], where the host tests it.
#![no_std]
#![no_main]

#[cfg(not(target_os = "none"))]
compile_error!("this image is for the Cortex-M4F: use `cargo build-nucleo`");

mod can;
mod clock;
#[cfg(feature = "control-loop")]
mod control;
#[path = "../cortex_m/mod.rs"]
mod cortex;
mod encoders;
mod flash;
mod sampling;

use cortex_m::{asm, singleton};
use defmt_rtt as _;
use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::pac;
use embassy_stm32::peripherals::IWDG;
use embassy_stm32::uid;
use embassy_stm32::wdg::IndependentWatchdog;
use glenoid::can::health::BusHealth;
use glenoid::device::{Action, BlinkPattern, Device, Event, LogEntry, module_fingerprint};
use glenoid::drive_board::flash_layout::{EccVerdict, ecc_verdict};
use glenoid::drive_board::reset;
use glenoid::parameters::ParameterSet;
use glenoid::record::{LoadError, Storage, StoreError, Stored};
use glenoid::restart::{CrashRecord, ResetCause, Restart};

use can::Bus;
use cortex::{ccm_code, faults, in_place, retained_ram, stack};
use encoders::{Encoders, Wiring};
use flash::ChipFlash;

/// Longest time without food for the watchdog, us. It is the last resort: a main loop that stands still is seen before,
/// by the sampling.
const PATIENCE_US: u32 = 500_000;
/// How often the counts are shown while the encoders are put into service (`DEFMT_LOG=debug`), ms.
const SHOWN_EVERY_MS: u32 = 500;
const _: () = assert!(PATIENCE_US > sampling::STANDSTILL_MS * 1_000);
/// Frames that are handled before the clock is looked at again.
const FRAMES_A_TURN: usize = 4;

/// Everything that actions go out through.
struct Outside {
    bus: Bus,
    led_pattern: BlinkPattern,
    /// None: the flash is divided otherwise than expected.
    storage: Option<&'static mut Storage<ChipFlash>>,
    /// What was not stored at all, which the device is still to hear.
    refused: Option<Event>,
    /// The deepest calls of this firmware, or its longest standstill, lie just behind us.
    measure: bool,
}

impl Outside {
    fn carry_out(&mut self, action: Action) {
        match action {
            Action::Send(frame) => self.bus.send(frame),
            Action::StatusLed(pattern) => self.led_pattern = pattern,
            Action::Store(_) | Action::StoreParameters(_) | Action::EraseRecord | Action::Journal(_) => {
                self.refused = self.keep(action);
            }
            Action::Stop(cause) => faults::stop(cause, 0, 0, format_args!("{}", cause.text())),
            Action::Log(entry) => {
                self.measure |= matches!(entry, LogEntry::Identified { .. } | LogEntry::Stored { .. });
                defmt::info!("device: {}", entry);
            }
        }
    }

    /// Begins to store; what comes of it is heard from the storage later. What the device is to hear at once, if that cannot
    /// be.
    fn keep(&mut self, action: Action) -> Option<Event> {
        let Some(storage) = self.storage.as_mut() else {
            let refused = Err(StoreError::FlashLayout);
            return Event::of(match action {
                Action::Store(_) => Stored::Record(refused),
                Action::StoreParameters(_) => Stored::Parameters(refused),
                Action::EraseRecord => Stored::Erased(refused),
                _ => Stored::Journal(refused),
            });
        };
        match action {
            Action::Store(record) => return storage.store(record).err().map(|error| Event::Stored(Err(error))),
            Action::StoreParameters(set) => storage.store_parameters(&set),
            Action::EraseRecord => storage.erase_record(),
            Action::Journal(entry) => storage.append(&entry),
            _ => {}
        }
        None
    }

    /// The next step of what is to be stored; what the device is to hear of it.
    fn go_on_storing(&mut self) -> Option<Event> {
        self.storage.as_mut().and_then(|storage| storage.go_on()).and_then(Event::of)
    }
}

struct Board {
    device: &'static mut Device,
    outside: Outside,
    led: Output<'static>,
    watchdog: IndependentWatchdog<'static, IWDG>,
    bus_health: BusHealth,
    last_sample_ms: u32,
    _encoders: Encoders,
    _button: Input<'static>,
}

/// The board before its device has heard anything.
struct Assembled {
    board: &'static mut Board,
    core: cortex_m::Peripherals,
    /// Fingerprint of the rig.
    rig: u32,
    /// Why the stored parameters are not those in use.
    parameters: Option<LoadError>,
}

impl Board {
    /// The parts in their places. None if it was called before: the peripherals and the device exist once.
    fn assemble(restart: Restart) -> Option<Assembled> {
        let core = cortex_m::Peripherals::take()?;
        stack::protect(&core.MPU);
        let chip = clock::start();
        // The driver has let in the DMA channels' interrupts, which nobody here serves.
        for lines in &core.NVIC.icer {
            // SAFETY: nothing but the lines that are enabled from here on is waited for.
            unsafe { lines.write(u32::MAX) };
        }
        // a core that a debugger holds does not starve the watchdog
        pac::DBGMCU.apb1lfzr().modify(|w| w.set_iwdg(true));
        let encoders = Encoders::start(Wiring {
            cable_1: (chip.TIM1, chip.PC0, chip.PC1),
            cable_2: (chip.TIM2, chip.PA0, chip.PA1),
            cable_3: (chip.TIM3, chip.PA6, chip.PA7),
            cable_4: (chip.TIM4, chip.PB6, chip.PB7),
            cable_5: (chip.TIM5, chip.PB2, chip.PC12),
            cable_6: (chip.TIM8, chip.PC6, chip.PC7),
        });
        let mut storage = match ChipFlash::open(chip.FLASH) {
            Ok((flash, from)) => Some(storage(flash, from)?),
            Err(error) => {
                defmt::error!("flash: {}, so nothing is kept", error);
                None
            }
        };
        let serial = serial_number();
        let (config, parameters) = match storage.as_mut() {
            Some(storage) => storage.config(restart, serial)?,
            None => (ParameterSet::new().config(restart, serial).ok()?, None),
        };
        let device = in_place::device(&config)?;
        #[cfg(feature = "control-loop")]
        if let Some(rig) = config.rig.ball() {
            control::start(rig);
        }
        let bus = Bus::join(chip.FDCAN1, chip.PA11, chip.PA12, config.base)?;
        let rig = module_fingerprint(&config.rig);
        // In a place of its own: on the stack it would lie under everything, twice while it is built.
        let board = singleton!(: Board = Board {
            device,
            outside: Outside { bus, led_pattern: BlinkPattern::Ready, storage, refused: None, measure: false },
            led: Output::new(chip.PA5, Level::Low, Speed::Low),
            watchdog: IndependentWatchdog::new(chip.IWDG, PATIENCE_US),
            bus_health: BusHealth::default(),
            last_sample_ms: 0,
            _encoders: encoders,
            // closed, it connects the pin to the supply (UM2505, "Push-buttons")
            _button: Input::new(chip.PC13, Pull::Down),
        })?;
        Some(Assembled { board, core, rig, parameters })
    }

    fn power_up(&mut self, restart: &Restart, rig: u32, parameters: Option<LoadError>) {
        defmt::info!("board: started by {}", restart.cause);
        if let Some(words) = restart.crash_record {
            defmt::warn!("board: its crash record says: {=str}, at {=u32:#x}", words.text(), words.address);
        }
        let loaded = match self.outside.storage.as_mut() {
            Some(storage) => storage.load(rig, parameters),
            None => Err(LoadError::FlashLayout).into(),
        };
        self.handle(0, Event::PowerUp(loaded));
        let usage = stack::usage();
        defmt::info!("board: ready, {=usize} of {=usize} bytes of stack used", usage.used_bytes, usage.size_bytes);
    }

    fn handle(&mut self, now_ms: u32, event: Event) {
        let mut next = Some(event);
        // a refusal follows its event, and causes no other
        while let Some(event) = next {
            let Self { device, outside, .. } = self;
            device.handle(now_ms, event, &mut |action| outside.carry_out(action));
            next = self.outside.refused.take();
        }
    }

    /// One turn of the main loop; false if there was nothing to do.
    fn turn(&mut self) -> bool {
        // While something is stored, commands wait: whoever gets the next answer can rely on it.
        let stores = self.outside.storage.as_ref().is_some_and(|storage| storage.is_storing());
        let heard = !stores && self.hear_bus();
        let sample = sampling::latest();
        let busy = self.device.is_busy();
        let now_ms = sample.at_ms;
        let sampled = now_ms != self.last_sample_ms;
        if sampled {
            self.last_sample_ms = now_ms;
            // reached only while both the loop and the sampling are alive
            self.watchdog.pet();
            sampling::note_taken(now_ms);
            self.handle(now_ms, Event::Counts(sample.counts));
            self.handle(now_ms, Event::Button { down: sample.button_down });
            self.watch_bus(now_ms);
            #[cfg(feature = "control-loop")]
            self.serve_control_loop(now_ms);
            if now_ms.is_multiple_of(SHOWN_EVERY_MS) {
                defmt::debug!("counts: {}", sample.counts);
            }
            self.led.set_level(Level::from(self.outside.led_pattern.is_lit(now_ms)));
        }
        if sampled || busy {
            self.handle(now_ms, Event::Tick);
        }
        if let Some(event) = self.outside.go_on_storing() {
            self.handle(now_ms, event);
        }
        let stores_on = self.outside.storage.as_ref().is_some_and(|storage| storage.is_quick());
        if !busy && core::mem::take(&mut self.outside.measure) {
            let usage = stack::usage();
            defmt::info!("stack: {=usize} of {=usize} bytes used at most", usage.used_bytes, usage.size_bytes);
            defmt::info!("sampling: {=u32} cycles between two samples at most", sample.longest_cycles);
        }
        heard || sampled || busy || stores_on
    }

    #[cfg(feature = "control-loop")]
    fn serve_control_loop(&mut self, now_ms: u32) {
        /// How often the log says how the loop fares, ms.
        const TOLD_EVERY_MS: u32 = 1_000;
        control::publish(self.device);
        if now_ms.is_multiple_of(TOLD_EVERY_MS) {
            control::tell();
            control::measure_anew();
        }
    }

    fn hear_bus(&mut self) -> bool {
        let now_ms = self.last_sample_ms;
        for turn in 0..FRAMES_A_TURN {
            let Some(frame) = self.outside.bus.receive() else { return turn != 0 };
            self.handle(now_ms, Event::Can(frame));
        }
        true
    }

    fn watch_bus(&mut self, now_ms: u32) {
        let lost = self.outside.bus.take_lost();
        if lost != 0 {
            self.handle(now_ms, Event::ReceiveOverrun { lost });
        }
        let health = self.outside.bus.health();
        if health != self.bus_health {
            self.bus_health = health;
            self.handle(now_ms, Event::Bus(health));
        }
    }
}

/// Called by [`cortex`] just before a reset.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
fn board_says(words: &CrashRecord) {
    defmt::error!("stop: {}, at {=u32:#x}: {=str}", words.cause, words.address, words.text());
}

/// Called by [`cortex`]: the flash has met a word that it cannot correct, or something this firmware never switched on
/// has struck.
// SAFETY: as above.
#[unsafe(no_mangle)]
fn board_on_nmi(address: u32) {
    let eccr = pac::FLASH.eccr().read();
    match ecc_verdict(eccr.0) {
        EccVerdict::RecordWord => {
            // written back, the flags that are set are cleared
            pac::FLASH.eccr().write_value(eccr);
            flash::note_bad_word();
        }
        EccVerdict::ProgramWord => {
            faults::stop(ResetCause::MemoryError, address, 0, format_args!("flash, ECCR {:#x}", eccr.0))
        }
        EccVerdict::NotFlash => faults::stop(ResetCause::UnexpectedInterrupt, address, 0, format_args!("NMI")),
    }
}

/// Why the chip started; the flags are cleared for the next time.
fn reset_cause() -> ResetCause {
    let flags = pac::RCC.csr().read();
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
    reset::cause(flags.0)
}

/// The chip's own number (RM0440, 47.1), folded into four bytes.
fn serial_number() -> u32 {
    uid::uid().as_chunks().0.iter().fold(0, |serial, word| serial ^ u32::from_le_bytes(*word))
}

#[cortex_m_rt::entry]
fn main() -> ! {
    // Before the code is read: a word of it that reads wrongly stops the board, and the start after that must find why.
    let restart = retained_ram::take(Some(reset_cause()));
    ccm_code::load();
    stack::paint();
    let Some(assembled) = Board::assemble(restart) else { give_up("started twice") };
    run(assembled, &restart)
}

/// The board at work.
fn run(Assembled { board, core, rig, parameters }: Assembled, restart: &Restart) -> ! {
    board.power_up(restart, rig, parameters);
    let (mut scb, mut dcb) = (core.SCB, core.DCB);
    sampling::start(core.SYST, &mut scb, &mut dcb, core.DWT);
    board.watchdog.unleash();
    // what is measured from here on is the work, not the start; painting holds the sampling up
    stack::paint();
    sampling::measure_anew();
    let mut comparison = ccm_code::Comparison::new();
    loop {
        if !board.turn() {
            comparison.go_on();
            asm::wfi();
        }
    }
}

/// Stands still, dark and silent: another start would find the same.
fn give_up(reason: &str) -> ! {
    defmt::error!("board: {=str}", reason);
    loop {
        asm::wfi();
    }
}

/// The storage in its place, once.
fn storage(flash: ChipFlash, from: u32) -> Option<&'static mut Storage<ChipFlash>> {
    singleton!(: Storage<ChipFlash> = Storage::new(flash, from))
}
