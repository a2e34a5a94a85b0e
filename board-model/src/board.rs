//! The board on its bench: supply, encoders, button, lamp, bus, and the log.

use crate::breach::Breach;
use crate::chip::Chip;
use crate::image::Image;
use crate::log::Log;
use crate::machine::Machine;
use crate::peripheral::flash::Cells;
use crate::peripheral::gpio::Wire;
use crate::peripheral::message_ram::BusFrame;
use crate::time::PS_A_MS;
use glenoid::can::Frame;
use glenoid::rig::CABLES;
use host_tests::rehearse::{Bench, BenchError};
use std::rc::Rc;

/// The button's pin in port C, and the lamp's in port A.
const BUTTON: usize = 13;
const LAMP: u32 = 5;

/// The drums turn no faster than this, counts a millisecond: 1500 mm/s, as the rig has it.
const FASTEST: i32 = 65;

/// A board with everything that it is wired to.
pub struct Board {
    /// The processor and its chip.
    pub machine: Machine,
    /// Its log.
    pub log: Log,
    /// What its flash holds.
    pub image: Rc<Image>,
    /// Everything that was broken in earlier lives.
    earlier: Vec<Breach>,
    /// The encoders: where they stand, and where they go.
    counts: [i32; CABLES],
    target: [i32; CABLES],
    heard: usize,
    seed: u64,
}

impl Board {
    /// Switches a board on. `seed` chooses what its memories hold.
    pub fn power_on(image: Rc<Image>, cells: Cells, seed: u64) -> Self {
        let machine = Machine::power_on(&image, Chip::new(cells, seed), seed);
        let log = Log::new(&image).unwrap_or_else(|| panic!("the image has no log"));
        let (counts, target) = ([0; CABLES], [0; CABLES]);
        Self { machine, log, image, earlier: Vec::new(), counts, target, heard: 0, seed }
    }

    /// A board that nothing was ever stored on.
    pub fn new(image: Rc<Image>, seed: u64) -> Self {
        Self::power_on(image, Cells::new(seed), seed)
    }

    /// The supply goes away in the middle of whatever is done, and comes back. The encoders stand at 0 then; what is wrong outside
    /// of the chip stays.
    pub fn power_cycle(&mut self) {
        let flash = &mut self.machine.chip_mut().flash;
        flash.cut();
        let cells = flash.cells.clone();
        let chip = self.machine.chip();
        let (lonely, shorted) = (chip.can.bus.lonely, chip.can.bus.shorted);
        let faults = chip.ports.each_ref().map(|port| port.faults);
        self.switch_on(cells, self.seed + 1);
        let chip = self.machine.chip_mut();
        (chip.can.bus.lonely, chip.can.bus.shorted) = (lonely, shorted);
        for (port, faults) in chip.ports.iter_mut().zip(faults) {
            port.faults = faults;
        }
    }

    /// The supply comes on with these cells in the flash: another life of a board whose program is translated already.
    pub fn switch_on(&mut self, cells: Cells, seed: u64) {
        self.earlier.extend(self.machine.chip_mut().breaches.take());
        self.seed = seed;
        self.machine.power_cycle(Chip::new(cells, seed), seed);
        (self.counts, self.target, self.heard) = ([0; CABLES], [0; CABLES], 0);
    }

    /// Everything that was broken so far.
    pub fn breaches(&self) -> Vec<Breach> {
        self.earlier.iter().chain(self.machine.chip().breaches.all()).cloned().collect()
    }

    /// Breaches as text, with the function that each one happened in.
    pub fn complaints(&self) -> Vec<String> {
        self.breaches().iter().map(|breach| format!("{breach}, {}", self.image.name_of(breach.pc))).collect()
    }

    /// Presses or releases the button.
    pub fn press(&mut self, down: bool) {
        let wire = if down { Wire::High } else { Wire::Open };
        self.machine.chip_mut().ports[2].connect(BUTTON, wire);
    }

    /// The wire at a pin is stuck, cut or mended: port (0 is A), number.
    pub fn spoil(&mut self, (port, pin): (usize, u32), fault: Option<Wire>) {
        self.machine.chip_mut().ports[port].faults[pin as usize] = fault;
    }

    /// The lamp is lit.
    pub fn lamp(&self) -> bool {
        self.machine.chip().ports[0].level(LAMP, None)
    }

    /// The static variable whose name contains `part` holds these counts somewhere.
    pub fn holds_counts(&self, part: &str, counts: [i32; CABLES]) -> bool {
        let wanted: Vec<u8> = counts.iter().flat_map(|count| count.to_le_bytes()).collect();
        let places = self.image.variables(part);
        places.iter().any(|(from, len)| {
            self.machine.bytes(*from, *len as usize).windows(wanted.len()).any(|bytes| bytes == wanted)
        })
    }

    /// Time since power-up, ms.
    pub fn now_ms(&self) -> u64 {
        self.machine.chip().time.now_ps() / PS_A_MS
    }

    /// Turns the encoders towards these counts while `ms` milliseconds pass, evenly.
    ///
    /// # Errors
    /// A timer is not set up to count.
    pub fn go_on(&mut self, ms: u32) -> Result<(), String> {
        let start_ps = self.machine.chip().time.now_ps();
        for passed in 0..ms {
            let left = (ms - passed) as i32;
            // whoever moves the arm waits for the lamp
            let left = if self.is_up() { left } else { i32::MAX };
            let step = std::array::from_fn(|cable| {
                ((self.target[cable] - self.counts[cable]) / left).clamp(-FASTEST, FASTEST)
            });
            self.turn(step)?;
            self.machine.run_until(start_ps + u64::from(passed + 1) * PS_A_MS);
            self.log.drain(&mut self.machine);
        }
        Ok(())
    }

    /// The firmware has set its sampling going: what was kept has been read by then.
    pub fn is_up(&self) -> bool {
        self.machine.chip().systick.is_on()
    }

    /// Turns the encoders within a millisecond.
    fn turn(&mut self, step: [i32; CABLES]) -> Result<(), String> {
        let fastest = step.iter().map(|counts| counts.unsigned_abs()).max().unwrap_or(0);
        // a level is two counts long
        let level_ps = if fastest == 0 { u64::MAX } else { 2 * PS_A_MS / u64::from(fastest) };
        self.machine.chip_mut().turn(step, level_ps)?;
        for (counts, step) in self.counts.iter_mut().zip(step) {
            *counts += step;
        }
        Ok(())
    }

    /// The last lines of the log.
    pub fn last_words(&self) -> &[String] {
        &self.log.lines[self.log.lines.len().saturating_sub(12)..]
    }
}

impl Bench for Board {
    fn set_counts(&mut self, counts: &[i32; CABLES]) -> Result<(), BenchError> {
        self.target = *counts;
        Ok(())
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BenchError> {
        let mut data = [0; 8];
        data[..frame.data().len()].copy_from_slice(frame.data());
        let id = frame.raw_id().into();
        let frame = BusFrame { id, extended: false, remote: false, len: frame.data().len(), data };
        self.machine.chip_mut().can.bus.waiting.push_back(frame);
        Ok(())
    }

    fn pass(&mut self, ms: u32) -> Result<Vec<Frame>, BenchError> {
        self.go_on(ms).map_err(BenchError)?;
        if self.machine.locked_up {
            return Err(BenchError(format!("the core locked up: {:?}", self.complaints())));
        }
        let sent = &self.machine.chip().can.bus.sent;
        let frames = sent[self.heard.min(sent.len())..].iter().map(|(_, frame)| {
            let frame_of = |frame: &BusFrame| Frame::new(frame.id as u16, &frame.data[..frame.len]).ok();
            frame_of(frame).ok_or_else(|| BenchError(format!("no frame of this vocabulary: {frame:?}")))
        });
        let frames = frames.collect();
        self.heard = sent.len();
        frames
    }

    fn restart(&mut self) -> Result<(), BenchError> {
        self.power_cycle();
        Ok(())
    }
}
