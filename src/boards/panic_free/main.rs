//! An image that links only if nothing in the library can panic (`cargo panic-free`).
//!
//! It holds all that the boards call: the device with procedure, identification and slip detection, the CAN vocabulary, SLCAN, the
//! rig link, the record, the crash record, and besides what no board runs yet: the paper's iteration and the hinge.
//! Everything that comes from outside is hidden from the optimiser, so no check is left out because of a value that happens
//! to be known here. The panic handler calls a function that does not exist: a single way to a panic, and there is no image.
//! Never run.
#![no_std]
#![no_main]

#[cfg(not(target_os = "none"))]
compile_error!("this image is for the Cortex-M4F: use `cargo panic-free`");

mod flash;
mod hinge;

use core::hint::black_box;
use core::panic::PanicInfo;

use cortex_m::singleton;
use glenoid::can::{BaseId, Message};
use glenoid::device::{Action, Config, Device, Event, fingerprint};
use glenoid::kinematics::CableLengths;
use glenoid::paper::{PaperIteration, PaperSettings};
use glenoid::record::Storage;
use glenoid::restart::{Area, CrashRecord, ResetCause, Restart};
use glenoid::rig::{Parameters, Rig};
use glenoid::rig_link::RigLink;
use glenoid::slcan::Adapter;

use flash::RamFlash;

unsafe extern "C" {
    /// Defined nowhere. The linker's complaint about it is the finding of this image.
    safe fn a_way_to_a_panic_is_left() -> !;
}

#[panic_handler]
fn on_panic(_: &PanicInfo) -> ! {
    a_way_to_a_panic_is_left()
}

/// The chip's part of the vector table, which the start-up code asks for. It is empty.
#[unsafe(no_mangle)]
// SAFETY: the section exists for this; without a handler no interrupt is switched on.
#[unsafe(link_section = ".vector_table.interrupts")]
static __INTERRUPTS: [u32; 1] = [0];

#[cortex_m_rt::entry]
fn main() -> ! {
    let rig = black_box(Rig::<f32>::shoulder(black_box(150.0)));
    if let Ok(rig) = rig {
        run(rig);
    }
    loop {
        cortex_m::asm::wfi();
    }
}

fn run(rig: Rig<f32>) {
    let restart = Restart::new(black_box(ResetCause::Pin), &black_box(Area::default()));
    let mut store = Storage::new(RamFlash::erased(), 0);
    let Some((config, parameters)) = store.config(restart, black_box(0)) else { return };
    let Some(device) = device(config) else { return };
    let loaded = store.load(fingerprint(&rig), parameters);
    let mut event = Event::PowerUp(loaded);
    let mut links = Links { slcan: Adapter::new(), rig: RigLink::new() };
    loop {
        device.handle(black_box(0), event, &mut |action| match black_box(action) {
            Action::Store(record) => drop(store.store(record)),
            Action::StoreParameters(set) => store.store_parameters(&set),
            Action::EraseRecord => store.erase_record(),
            Action::Journal(entry) => store.append(&entry),
            Action::Send(frame) => drop(black_box(links.slcan.forward(&frame, black_box(0)))),
            other => drop(black_box(other)),
        });
        event = match (store.go_on().and_then(Event::of), black_box(0)) {
            (Some(event), _) => event,
            (_, 0) => Event::Tick,
            (_, 1) => Event::Counts(black_box([0; 6])),
            (_, 2) => Event::Button { down: black_box(true) },
            (_, 3) => Event::ReceiveOverrun { lost: black_box(1) },
            (_, 4) => Event::Bus(black_box(Default::default())),
            (_, 5) => paper(&rig),
            (_, 6) => hinge::identify(),
            (_, other) => links.hear(other),
        };
    }
}

struct Links {
    slcan: Adapter,
    rig: RigLink,
}

impl Links {
    /// A byte on either line, and a client's side of the vocabulary.
    fn hear(&mut self, byte: u8) -> Event {
        black_box(self.rig.push(byte));
        let Some(frame) = self.slcan.receive(byte).and_then(|answer| answer.frame) else { return Event::Tick };
        if let Ok(message) = Message::unpack(&frame, black_box(BaseId::DEFAULT)) {
            black_box(message.pack(black_box(BaseId::DEFAULT))).ok();
        }
        black_box(CrashRecord::new(black_box(ResetCause::Fault), 0, 0, format_args!("{byte}")).seal());
        Event::Can(frame)
    }
}

/// The paper's iteration, which no board runs.
fn paper(rig: &Rig<f32>) -> Event {
    let start = Parameters::from_array(black_box([0.0; 6]));
    let poses: &[CableLengths<f32>] = black_box(&[]);
    let _ = black_box(PaperIteration::new(rig, start, PaperSettings::default()).run(poses));
    Event::Tick
}

/// The device in its place, once.
fn device(config: Config) -> Option<&'static mut Device> {
    singleton!(: Device = Device::new(&config))
}
