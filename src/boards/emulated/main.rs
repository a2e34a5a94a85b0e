//! The emulated drive board: QEMU's mps2-an386, a Cortex-M4F with the memory sizes of the STM32G474RE.
//!
//! UART0 is the CAN bus as SLCAN, UART1 the rig link, the log goes out by semihosting. No decision is taken here:
//! bytes become events, the [`Device`] decides, actions become bytes.
#![no_std]
#![no_main]

#[cfg(not(target_os = "none"))]
compile_error!("this image is for the Cortex-M4F: use `cargo emulate`, or --target thumbv7em-none-eabihf");

mod clock;
mod faults;
mod log;
mod stack;
mod uart;
mod vectors;

use core::fmt;

use cortex_m::Peripherals;
use cortex_m::interrupt::free;
use cortex_m::{asm, singleton};
use cortex_m_rt::entry;
use glenoid::device::{Action, Device, Event, LampPattern, LogEntry};
use glenoid::rig_link::{RigLink, RigLinkError, Signal};
use glenoid::slcan::{Adapter, SlcanError};

use log::Log;
use uart::{Line, Queues, Uart};

/// Bytes of either line that are handled before the clock is looked at again.
const BYTES_A_TURN: usize = 64;

/// One line of the log.
enum Entry {
    Boot { stack_bytes: usize },
    Device(LogEntry),
    Lamp(LampPattern),
    SlcanRefused { error: SlcanError, so_far: u32 },
    RigLinkRefused { error: RigLinkError, so_far: u32 },
    NobodyReads { dropped: u32 },
    Stack(stack::Usage),
}

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Boot { stack_bytes } => write!(f, "board: ready, {stack_bytes} bytes of stack"),
            Self::Device(entry) => write!(f, "device: {entry:?}"),
            Self::Lamp(pattern) => write!(f, "lamp: {pattern:?}"),
            Self::SlcanRefused { error, so_far } => {
                write!(f, "slcan: refused, {error} ({}), {so_far} so far", error.code())
            }
            Self::RigLinkRefused { error, so_far } => {
                write!(f, "rig link: ignored, {error} ({}), {so_far} so far", error.code())
            }
            Self::NobodyReads { dropped } => write!(f, "can: nobody reads, {dropped} messages dropped so far"),
            Self::Stack(usage) => {
                write!(f, "stack: {} of {} bytes used at most", usage.used_bytes, usage.size_bytes)
            }
        }
    }
}

/// Everything that actions go out through.
struct Outside {
    can: Uart,
    adapter: Adapter,
    lamp: Option<LampPattern>,
    dropped_told: u32,
    log: Log<Entry>,
}

impl Outside {
    fn carry_out(&mut self, now_ms: u32, action: Action) {
        match action {
            Action::Send(frame) => {
                if let Some(line) = self.adapter.forward(&frame, now_ms) {
                    // a full queue drops the frame, as a bus without a listener would
                    let _ = self.can.write(&line);
                }
            }
            Action::Lamp(pattern) if self.lamp == Some(pattern) => {}
            Action::Lamp(pattern) => {
                self.lamp = Some(pattern);
                self.log.push(now_ms, Entry::Lamp(pattern));
            }
            Action::Log(entry) => self.log.push(now_ms, Entry::Device(entry)),
        }
    }

    /// Writes one line of the log, if there is one. Losses are told here, where there is time, and not when they happen.
    fn write_log(&mut self, now_ms: u32) -> bool {
        let dropped = self.can.dropped();
        if dropped != self.dropped_told {
            self.dropped_told = dropped;
            self.log.push(now_ms, Entry::NobodyReads { dropped });
        }
        self.log.write_one()
    }
}

struct Board {
    device: Device,
    rig: Uart,
    rig_link: RigLink,
    outside: Outside,
    last_tick_ms: u32,
}

impl Board {
    fn start() -> Option<Self> {
        let core = Peripherals::take()?;
        stack::protect(core.MPU);
        let can_queues = singleton!(: Queues = Queues::new())?;
        let rig_queues = singleton!(: Queues = Queues::new())?;
        clock::start(core.SYST);
        Some(Self {
            device: Device::new(Default::default()),
            rig: Uart::start(Line::Rig, rig_queues),
            rig_link: RigLink::new(),
            outside: Outside {
                can: Uart::start(Line::Can, can_queues),
                adapter: Adapter::new(),
                lamp: None,
                dropped_told: 0,
                log: Log::new(),
            },
            last_tick_ms: clock::now_ms(),
        })
    }

    fn handle(&mut self, now_ms: u32, event: Event) {
        let Self { device, outside, .. } = self;
        device.handle(now_ms, event, &mut |action| outside.carry_out(now_ms, action));
    }

    /// One turn of the main loop; false if there was nothing to do.
    fn turn(&mut self) -> bool {
        let heard = self.hear_can() | self.hear_rig();
        let busy = self.device.is_busy();
        let now_ms = clock::now_ms();
        let ticked = now_ms != self.last_tick_ms;
        if ticked || busy {
            self.last_tick_ms = now_ms;
            self.handle(now_ms, Event::Tick);
        }
        if busy && !self.device.is_busy() {
            self.outside.log.push(now_ms, Entry::Stack(stack::usage()));
        }
        heard || busy || ticked || self.outside.write_log(now_ms)
    }

    fn hear_can(&mut self) -> bool {
        if self.outside.can.take_overrun() {
            self.outside.adapter.note_overrun();
        }
        for turn in 0..BYTES_A_TURN {
            let Some(byte) = self.outside.can.read() else { return turn != 0 };
            let Some(answer) = self.outside.adapter.receive(byte) else { continue };
            let now_ms = clock::now_ms();
            let _ = self.outside.can.write(answer.reply);
            if let Some(error) = answer.refusal {
                let so_far = self.outside.adapter.counters().refused;
                self.outside.log.push(now_ms, Entry::SlcanRefused { error, so_far });
            }
            if let Some(frame) = answer.frame {
                self.handle(now_ms, Event::Can(frame));
            }
        }
        true
    }

    fn hear_rig(&mut self) -> bool {
        for turn in 0..BYTES_A_TURN {
            let Some(byte) = self.rig.read() else { return turn != 0 };
            let Some(signal) = self.rig_link.push(byte) else { continue };
            let now_ms = clock::now_ms();
            match signal {
                Ok(Signal::Counts(counts)) => self.handle(now_ms, Event::Counts(counts)),
                Ok(Signal::Button { down }) => self.handle(now_ms, Event::Button { down }),
                Err(error) => {
                    let so_far = self.rig_link.refused();
                    self.outside.log.push(now_ms, Entry::RigLinkRefused { error, so_far });
                }
            }
        }
        true
    }

    /// Sleeps until the next interrupt. Interrupts are masked while the queues are looked at: one that comes in
    /// between still ends the sleep.
    fn sleep(&self) {
        free(|_| {
            let idle =
                !self.outside.can.has_received() && !self.rig.has_received() && clock::now_ms() == self.last_tick_ms;
            if idle {
                asm::wfi();
            }
        });
    }
}

#[entry]
fn main() -> ! {
    stack::paint();
    let Some(mut board) = Board::start() else { faults::stop() };
    let stack_bytes = stack::usage().size_bytes;
    board.outside.log.push(clock::now_ms(), Entry::Boot { stack_bytes });
    loop {
        if !board.turn() {
            board.sleep();
        }
    }
}
