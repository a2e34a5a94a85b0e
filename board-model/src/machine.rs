//! The processor with its memories: Unicorn executes the instructions, and stops wherever the chip has to say something.

use crate::breach::Rule;
use crate::chip::Chip;
use crate::core::nvic::Masks;
use crate::core::scb::cfsr;
use crate::image::Image;
use crate::peripheral::rcc::Cause;
use rand::{RngCore, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::rc::Rc;
use unicorn_engine::unicorn_const::{Arch, HookType, MemType, Mode, Prot};
use unicorn_engine::{RegisterARM, Unicorn};

/// The memories: where they are, and how long.
pub const FLASH: (u32, usize) = (0x0800_0000, 0x4_0000);
/// Static variables and the stack.
pub const SRAM: (u32, usize) = (0x2000_0000, 0x1_8000);
/// The core-coupled memory.
pub const CCM: (u32, usize) = (0x1000_0000, 0x8000);
/// The vectors are looked for here; the chip shows its flash.
const ALIAS: u32 = 0;
/// What the factory wrote: the size of the flash, KiB.
const FACTORY: (u32, usize) = (0x1FFF_7000, 0x1000);
const FLASH_SIZE: (u32, u16) = (0x1FFF_75E0, 512);
/// Windows of the peripherals.
const WINDOWS: [(u32, u32); 6] = [
    (0x0804_0000, 0x4_0000),
    (0x4000_0000, 0x2_0000),
    (0x4002_0000, 0x8000),
    (0x4800_0000, 0x2000),
    (0xE000_0000, 0x4_0000),
    (0xE004_2000, 0x1000),
];
/// A branch to here returns from an exception.
pub const RETURNS: u32 = 0xFFFF_FF00;

/// What an instruction is to the model.
mod mark {
    /// It stands in an IT block: exceptions wait until it is over.
    pub const IN_IT: u8 = 1;
    /// WFI.
    pub const SLEEP: u8 = 2;
    /// CPSID i.
    pub const MASKS: u8 = 4;
    /// CPSIE i, or MSR to a mask.
    pub const UNMASKS: u8 = 8;
    /// MRS from IPSR, which Unicorn leaves 0.
    pub const READS_IPSR: u8 = 16;
}

/// Marks of the code in one memory.
struct Marks {
    from: u32,
    of: Vec<u8>,
}

impl Marks {
    fn at(&self, address: u32) -> u8 {
        self.of.get((address.wrapping_sub(self.from) / 2) as usize).copied().unwrap_or(0)
    }
}

/// How long something took, and where it began.
#[derive(Debug, Clone, Copy, Default)]
pub struct Longest {
    /// Cycles.
    pub cycles: u64,
    /// The program counter at its beginning.
    pub pc: u32,
}

/// An access that failed.
#[derive(Debug, Clone, Copy)]
struct Failed {
    kind: MemType,
    address: u32,
}

/// What the hooks see.
pub struct State {
    /// The chip.
    pub chip: Chip,
    marks: Rc<[Marks; 2]>,
    deadline: u64,
    /// An exception may be due.
    attention: bool,
    /// One is due as soon as nothing masks it.
    masked: bool,
    pc: u32,
    /// An instruction that Unicorn does not carry out as this model needs.
    stopped: Option<(u32, u8)>,
    /// The last instruction may have ended a masking.
    unmasks: bool,
    failed: Option<Failed>,
    masked_since: Option<(u64, u32)>,
    /// The longest time for which interrupts were masked.
    pub longest_masked: Longest,
    /// Instructions executed.
    pub instructions: u64,
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
        let marks = Rc::new([FLASH.0, CCM.0].map(|from| marks(image, from)));
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
        };
        let mut cpu = Unicorn::new_with_data(Arch::ARM, Mode::MCLASS | Mode::THUMB, state)
            .unwrap_or_else(|error| panic!("Unicorn: {error:?}"));
        // Cortex-M4 by Unicorn's number
        must(cpu.ctl_set_cpu_model(unicorn_engine::ArmCpuModel::CORTEX_M4 as i32));
        map_memories(&mut cpu, image, seed);
        map_windows(&mut cpu);
        hook(&mut cpu);
        let mut machine = Self { cpu, asleep: false, forbidden: Vec::new(), resets: Vec::new(), locked_up: false };
        machine.begin();
        machine
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

fn map_memories(cpu: &mut Unicorn<'static, State>, image: &Image, seed: u64) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut flash = vec![0xFF; FLASH.1];
    for (from, bytes) in &image.stored {
        let at = from.wrapping_sub(FLASH.0) as usize;
        flash[at..at + bytes.len()].copy_from_slice(bytes);
    }
    let mut factory = vec![0xFF; FACTORY.1];
    factory[(FLASH_SIZE.0 - FACTORY.0) as usize..][..2].copy_from_slice(&FLASH_SIZE.1.to_le_bytes());
    let mut noise = |len| {
        let mut bytes = vec![0; len];
        random.fill_bytes(&mut bytes);
        bytes
    };
    let read_only = Prot::READ | Prot::EXEC;
    let memories = [
        (ALIAS, flash.clone(), read_only),
        (FLASH.0, flash, read_only),
        (FACTORY.0, factory, Prot::READ),
        (SRAM.0, noise(SRAM.1), Prot::ALL),
        (CCM.0, noise(CCM.1), Prot::ALL),
    ];
    for (from, bytes, access) in memories {
        must(cpu.mem_map(from.into(), bytes.len() as u64, access));
        must(cpu.mem_write(from.into(), &bytes));
    }
}

fn map_windows(cpu: &mut Unicorn<'static, State>) {
    for (from, len) in WINDOWS {
        let read = move |cpu: &mut Unicorn<'_, State>, offset: u64, size: usize| {
            let state = cpu.get_data_mut();
            state.chip.breaches.pc = state.pc;
            let value = state.chip.read(from + offset as u32, size as u32);
            state.attention = true;
            u64::from(value)
        };
        let write = move |cpu: &mut Unicorn<'_, State>, offset: u64, size: usize, value: u64| {
            let state = cpu.get_data_mut();
            state.chip.breaches.pc = state.pc;
            state.chip.write(from + offset as u32, size as u32, value as u32);
            state.attention = true;
        };
        must(cpu.mmio_map(from.into(), len.into(), Some(read), Some(write)));
    }
}

fn hook(cpu: &mut Unicorn<'static, State>) {
    let each = |cpu: &mut Unicorn<'_, State>, address: u64, _: u32| {
        let state = cpu.get_data_mut();
        let address = address as u32;
        let mark = state.marks[usize::from(address < FLASH.0 || address >= CCM.0)].at(address);
        state.pc = address;
        let is_due = state.attention || state.chip.time.cycles >= state.deadline;
        if is_due && mark & mark::IN_IT == 0 {
            must(cpu.emu_stop());
            return;
        }
        if state.masked && mark & mark::IN_IT == 0 && cpu.reg_read(RegisterARM::PRIMASK) == Ok(0) {
            must(cpu.emu_stop());
            return;
        }
        if cpu.get_data().unmasks {
            end_masking(cpu);
        }
        let state = cpu.get_data_mut();
        state.chip.time.cycles += 1;
        state.instructions += 1;
        if mark & !mark::IN_IT != 0 {
            note(cpu, address, mark);
        }
    };
    must(cpu.add_code_hook(1, 0, each));
    let failed = |cpu: &mut Unicorn<'_, State>, kind: MemType, address: u64, _: usize, _: i64| {
        cpu.get_data_mut().failed = Some(Failed { kind, address: address as u32 });
        false
    };
    must(cpu.add_mem_hook(HookType::MEM_INVALID, 1, 0, failed));
}

/// The instruction before may have let the interrupts in again.
fn end_masking(cpu: &mut Unicorn<'_, State>) {
    let is_open = cpu.reg_read(RegisterARM::PRIMASK) == Ok(0);
    let state = cpu.get_data_mut();
    state.unmasks = false;
    if is_open && let Some((since, pc)) = state.masked_since.take() {
        let cycles = state.chip.time.cycles - since;
        // before the sampling begins nobody minds
        if cycles > state.longest_masked.cycles && state.chip.systick.is_on() {
            state.longest_masked = Longest { cycles, pc };
        }
    }
}

fn note(cpu: &mut Unicorn<'_, State>, address: u32, mark: u8) {
    let state = cpu.get_data_mut();
    let cycle = state.chip.time.cycles;
    if mark & mark::MASKS != 0 && state.masked_since.is_none() {
        state.masked_since = Some((cycle, address));
    }
    state.unmasks |= mark & mark::UNMASKS != 0;
    if mark & (mark::SLEEP | mark::READS_IPSR) != 0 {
        state.stopped = Some((address, mark));
        must(cpu.emu_stop());
    }
}

/// The marks of the code that runs from this memory.
fn marks(image: &Image, from: u32) -> Marks {
    let len = if from == CCM.0 { CCM.1 } else { FLASH.1 };
    let mut of = vec![0; len / 2];
    let mut left = 0_u32;
    image.instructions(|address, half, next| {
        let Some(place) = of.get_mut((address.wrapping_sub(from) / 2) as usize) else { return };
        if left != 0 {
            *place |= mark::IN_IT;
            left -= 1;
        }
        match half {
            0xBF30 => *place |= mark::SLEEP,
            0xB672 => *place |= mark::MASKS,
            0xB662 => *place |= mark::UNMASKS,
            // MSR; which register it writes does not matter here
            _ if half & 0xFFF0 == 0xF380 => *place |= mark::UNMASKS,
            0xF3EF if next & 0xFF == 5 => *place |= mark::READS_IPSR,
            // IT: the lowest set bit of its mask says how many instructions follow
            _ if half & 0xFF00 == 0xBF00 && half & 0xF != 0 => left = 4 - (half & 0xF).trailing_zeros(),
            _ => {}
        }
    });
    Marks { from, of }
}
