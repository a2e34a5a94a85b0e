//! The processor with its memories: Unicorn executes the instructions, and stops wherever the chip has to say something.

use crate::breach::Rule;
use crate::chip::Chip;
use crate::core::nvic::Masks;
use crate::core::scb::cfsr;
use crate::hooks::hook;
use crate::image::Image;
use crate::marks::{self as mark, Marks, marks};
use crate::memories::{ALIAS, CCM, FLASH, fill_with_noise, map_memories, map_windows};
use crate::peripheral::rcc::Cause;
use std::rc::Rc;
use unicorn_engine::unicorn_const::{Arch, MemType, Mode, Prot};
use unicorn_engine::{RegisterARM, Unicorn};

/// A branch to here returns from an exception.
pub const RETURNS: u32 = 0xFFFF_FF00;

/// How long something took, and where it began.
#[derive(Debug, Clone, Copy, Default)]
pub struct Longest {
    /// Cycles of the model: instructions.
    pub cycles: u64,
    /// The program counter at its beginning.
    pub pc: u32,
}

/// An access that failed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Failed {
    pub(crate) kind: MemType,
    pub(crate) address: u32,
}

/// What the hooks see.
pub struct State {
    /// The chip.
    pub chip: Chip,
    pub(crate) marks: Rc<[Marks; 2]>,
    pub(crate) deadline: u64,
    /// An exception may be due.
    pub(crate) attention: bool,
    /// One is due as soon as nothing masks it.
    pub(crate) masked: bool,
    pub(crate) pc: u32,
    /// An instruction that Unicorn does not carry out as this model needs.
    pub(crate) stopped: Option<(u32, u8)>,
    /// The last instruction may have ended a masking.
    pub(crate) unmasks: bool,
    pub(crate) failed: Option<Failed>,
    pub(crate) masked_since: Option<(u64, u32)>,
    /// The longest time for which interrupts were masked.
    pub longest_masked: Longest,
    /// Instructions executed.
    pub instructions: u64,
    /// Cycles that each of them takes: 1. What only looks at the order of things may have a slower core, for a model that
    /// has fewer instructions to execute.
    pub cycles_an_instruction: u64,
}

impl State {
    /// The firmware reads from the chip.
    pub(crate) fn read(&mut self, address: u32, size: u32) -> u32 {
        self.chip.breaches.pc = self.pc;
        self.attention = true;
        self.chip.read(address, size)
    }

    /// The firmware writes to the chip.
    pub(crate) fn write(&mut self, address: u32, size: u32, value: u32) {
        self.chip.breaches.pc = self.pc;
        self.attention = true;
        self.chip.write(address, size, value);
    }
}

/// The processor.
pub struct Machine {
    /// Unicorn.
    pub(crate) cpu: Unicorn<'static, State>,
    /// The core waits for an interrupt.
    asleep: bool,
    forbidden: Vec<(u32, u64)>,
    /// Why the chip was reset, in order.
    pub resets: Vec<Cause>,
    /// The core locked up.
    pub locked_up: bool,
}

impl Machine {
    /// A board that is switched on with this image in its flash; its RAM holds noise.
    pub fn power_on(image: &Image, chip: Chip, seed: u64) -> Self {
        let marks = Rc::new([FLASH, CCM].map(|memory| marks(image, memory)));
        let state = State {
            chip,
            marks,
            deadline: 0,
            attention: false,
            masked: false,
            pc: 0,
            stopped: None,
            unmasks: false,
            failed: None,
            masked_since: None,
            longest_masked: Longest::default(),
            instructions: 0,
            cycles_an_instruction: 1,
        };
        let mut cpu = Unicorn::new_with_data(Arch::ARM, Mode::MCLASS | Mode::THUMB, state)
            .unwrap_or_else(|error| panic!("Unicorn: {error:?}"));
        // Cortex-M4 by Unicorn's number
        must(cpu.ctl_set_cpu_model(unicorn_engine::ArmCpuModel::CORTEX_M4 as i32));
        map_memories(&mut cpu, image);
        map_windows(&mut cpu);
        hook(&mut cpu);
        fill_with_noise(&mut cpu, seed);
        let mut machine = Self { cpu, asleep: false, forbidden: Vec::new(), resets: Vec::new(), locked_up: false };
        machine.begin();
        machine
    }

    /// The supply comes back after it was away: another chip state, the same program, noise in the RAM.
    pub fn power_cycle(&mut self, chip: Chip, seed: u64) {
        fill_with_noise(&mut self.cpu, seed);
        let state = self.cpu.get_data_mut();
        state.chip = chip;
        (state.deadline, state.stopped, state.unmasks, state.failed) = (0, None, false, None);
        (state.longest_masked, state.instructions) = (Longest::default(), 0);
        self.resets.clear();
        self.locked_up = false;
        self.protect();
        self.begin();
    }

    /// The core begins at the reset vector.
    fn begin(&mut self) {
        let stack = self.word(ALIAS);
        let entry = self.word(ALIAS + 4);
        for register in [RegisterARM::PRIMASK, RegisterARM::FAULTMASK, RegisterARM::BASEPRI, RegisterARM::CONTROL] {
            self.set(register, 0);
        }
        self.set(RegisterARM::SP, stack);
        self.set(RegisterARM::LR, u32::MAX);
        self.set(RegisterARM::PC, entry | 1);
        self.asleep = false;
        let state = self.cpu.get_data_mut();
        (state.attention, state.masked, state.masked_since, state.pc) = (false, false, None, entry & !1);
    }

    /// Resets the chip; the memories stay.
    pub fn reset(&mut self, cause: Cause) {
        self.resets.push(cause);
        self.cpu.get_data_mut().chip.restart(cause);
        self.protect();
        self.begin();
    }

    /// The chip.
    pub fn chip(&self) -> &Chip {
        &self.cpu.get_data().chip
    }

    /// The chip, to change it from outside.
    pub fn chip_mut(&mut self) -> &mut Chip {
        let state = self.cpu.get_data_mut();
        state.attention = true;
        &mut state.chip
    }

    /// What the hooks have counted.
    pub fn state(&self) -> &State {
        self.cpu.get_data()
    }

    /// What the hooks have counted, to begin anew.
    pub fn state_mut(&mut self) -> &mut State {
        self.cpu.get_data_mut()
    }

    /// Runs until this time.
    pub fn run_until(&mut self, ps: u64) {
        while self.chip().time.now_ps() < ps && !self.locked_up {
            self.step(ps);
        }
    }

    /// Runs until something happens, at most until this time.
    pub fn step(&mut self, ps: u64) {
        let chip = &mut self.cpu.get_data_mut().chip;
        chip.advance();
        if let Some(cause) = chip.reset.take() {
            self.reset(cause);
            return;
        }
        if std::mem::take(&mut self.cpu.get_data_mut().chip.mpu_changed) {
            self.protect();
        }
        let masks = self.masks();
        let chip = &self.cpu.get_data().chip;
        let (next, wakes) = (chip.nvic.next(masks), chip.nvic.wakes(masks));
        if let Some(number) = next {
            self.asleep = false;
            self.enter(number);
            return;
        }
        self.asleep &= !wakes;
        let state = self.cpu.get_data_mut();
        let deadline = state.chip.next_event().min(state.chip.time.cycle_at(ps)).max(state.chip.time.cycles + 1);
        if self.asleep {
            state.chip.time.cycles = deadline;
            return;
        }
        (state.deadline, state.attention, state.masked) = (deadline, false, wakes);
        self.execute();
    }

    /// Executes instructions until a hook stops them.
    fn execute(&mut self) {
        let from = self.get(RegisterARM::PC) | 1;
        let result = self.cpu.emu_start(from.into(), u64::MAX, 0, 0);
        let state = self.cpu.get_data_mut();
        match state.stopped.take() {
            Some((at, mark)) if mark & mark::SLEEP != 0 => {
                self.asleep = true;
                return self.set(RegisterARM::PC, at + 2 | 1);
            }
            Some((at, _)) => return self.read_ipsr(at),
            None => {}
        }
        let (pc, failed) = (state.pc, state.failed.take());
        // nothing can be executed up there, so the branch ends as an error
        let branched_to = self.get(RegisterARM::PC);
        if result.is_err() && branched_to >= RETURNS {
            self.leave(branched_to);
        } else if let Err(error) = result {
            self.set(RegisterARM::PC, pc | 1);
            self.fault(failed, &format!("{error:?}"));
        } else {
            self.set(RegisterARM::PC, pc | 1);
        }
    }

    /// Carries out the instruction MRS Rd, IPSR.
    fn read_ipsr(&mut self, at: u32) {
        const LOW: [RegisterARM; 8] = [
            RegisterARM::R0,
            RegisterARM::R1,
            RegisterARM::R2,
            RegisterARM::R3,
            RegisterARM::R4,
            RegisterARM::R5,
            RegisterARM::R6,
            RegisterARM::R7,
        ];
        let number = self.chip().nvic.current() as u32;
        match LOW.get(self.bytes(at + 2, 2)[1] as usize & 0xF) {
            Some(register) => self.set(*register, number),
            None => self.chip_mut().breaches.add(Rule::Architecture, "MRS from IPSR to a high register"),
        }
        self.set(RegisterARM::PC, at + 4 | 1);
    }

    /// An instruction could not be carried out.
    fn fault(&mut self, failed: Option<Failed>, error: &str) {
        let scb = &mut self.cpu.get_data_mut().chip.scb;
        match failed {
            Some(Failed { kind: MemType::FETCH_UNMAPPED, .. }) => scb.cfsr |= cfsr::IBUSERR,
            Some(Failed { kind: MemType::FETCH_PROT, .. }) => scb.cfsr |= cfsr::IACCVIOL,
            Some(Failed { kind: MemType::READ_PROT | MemType::WRITE_PROT, address }) => {
                scb.cfsr |= cfsr::DACCVIOL | cfsr::MMARVALID;
                scb.mmfar = address;
            }
            Some(Failed { address, .. }) => {
                scb.cfsr |= cfsr::PRECISERR | cfsr::BFARVALID;
                scb.bfar = address;
            }
            None => scb.cfsr |= cfsr::UNDEFINSTR,
        }
        if failed.is_none() && !error.contains("INSN_INVALID") {
            self.chip_mut().breaches.add(Rule::Architecture, format!("Unicorn: {error}"));
        }
        self.hard_fault();
    }

    fn masks(&self) -> Masks {
        Masks {
            primask: self.get(RegisterARM::PRIMASK) & 1 != 0,
            faultmask: self.get(RegisterARM::FAULTMASK) & 1 != 0,
            basepri: self.get(RegisterARM::BASEPRI) as u8,
        }
    }

    /// Makes the memory as the protection unit has it now.
    pub(crate) fn protect(&mut self) {
        let chip = self.chip();
        let in_hard_fault = matches!(chip.nvic.current(), 2 | 3);
        let forbidden = chip.mpu.forbidden(in_hard_fault);
        if forbidden == self.forbidden {
            return;
        }
        for (from, len) in std::mem::replace(&mut self.forbidden, forbidden.clone()) {
            must(self.cpu.mem_protect(from.into(), len, Prot::ALL));
        }
        for (from, len) in forbidden {
            must(self.cpu.mem_protect(from.into(), len, Prot::NONE));
        }
        must(self.cpu.ctl_flush_tlb());
    }

    /// A register of the core.
    pub fn get(&self, register: RegisterARM) -> u32 {
        self.cpu.reg_read(register).unwrap_or_else(|error| panic!("{register:?}: {error:?}")) as u32
    }

    /// Changes a register of the core, as a debugger does.
    pub fn set(&mut self, register: RegisterARM, value: u32) {
        must(self.cpu.reg_write(register, value.into()));
        if register == RegisterARM::PC {
            self.cpu.get_data_mut().pc = value & !1;
        }
    }

    /// Goes on elsewhere, as a debugger makes it.
    pub fn jump(&mut self, address: u32) {
        self.asleep = false;
        self.set(RegisterARM::PC, address | 1);
    }

    /// Bytes of memory, as a debugger reads them.
    pub fn bytes(&self, address: u32, len: usize) -> Vec<u8> {
        let read = self.cpu.mem_read_as_vec(address.into(), len);
        read.unwrap_or_else(|error| panic!("{len} bytes at {address:#x}: {error:?}"))
    }

    /// A word of memory.
    pub fn word(&self, address: u32) -> u32 {
        u32::from_le_bytes(self.bytes(address, 4).try_into().unwrap_or_default())
    }

    /// Changes a word of memory, as a debugger does.
    pub fn set_word(&mut self, address: u32, value: u32) {
        must(self.cpu.mem_write(address.into(), &value.to_le_bytes()));
    }
}

/// Unicorn's own errors have no remedy here.
pub(crate) fn must<T>(result: Result<T, unicorn_engine::unicorn_const::uc_error>) -> T {
    result.unwrap_or_else(|error| panic!("Unicorn: {error:?}"))
}
