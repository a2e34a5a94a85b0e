//! How an exception begins and ends (ARMv7-M ARM, B1.5.6 to B1.5.8).

use crate::breach::Rule;
use crate::core::nvic::exception::HARD_FAULT;
use crate::core::scb::cfsr;
use crate::machine::{Machine, must};
use unicorn_engine::RegisterARM;

/// CONTROL: there is a floating-point context.
const FPCA: u32 = 1 << 2;
/// xPSR: the stack was aligned by a word.
const ALIGNED: u32 = 1 << 9;
/// xPSR: Thumb.
const THUMB: u32 = 1 << 24;
/// EXC_RETURN: to thread mode; no floating-point context.
const TO_THREAD: u32 = 1 << 3;
const NO_FLOAT: u32 = 1 << 4;
/// Cycles that beginning and ending take, and going over from one to the next (Cortex-M4 TRM, 3.9).
const ENTRY_CYCLES: u64 = 12;
const TAIL_CYCLES: u64 = 6;
/// Bytes of a frame without and with floating-point registers.
const FRAME: u32 = 0x20;
const FLOAT_FRAME: u32 = 0x68;
/// HFSR: a fault was escalated.
const FORCED: u32 = 1 << 30;

const BASIC: [RegisterARM; 6] =
    [RegisterARM::R0, RegisterARM::R1, RegisterARM::R2, RegisterARM::R3, RegisterARM::R12, RegisterARM::LR];
/// D0 to D7 are S0 to S15.
const FLOAT: [RegisterARM; 8] = [
    RegisterARM::D0,
    RegisterARM::D1,
    RegisterARM::D2,
    RegisterARM::D3,
    RegisterARM::D4,
    RegisterARM::D5,
    RegisterARM::D6,
    RegisterARM::D7,
];

impl Machine {
    /// Takes an exception: stores the frame, and goes to its vector.
    pub(crate) fn enter(&mut self, number: usize) {
        let has_float = self.get(RegisterARM::CONTROL) & FPCA != 0;
        let stack = self.get(RegisterARM::SP);
        let len = if has_float { FLOAT_FRAME } else { FRAME };
        let frame = stack.wrapping_sub(len) & !7;
        let in_thread = self.chip().nvic.active.is_empty();
        let in_hard_fault = matches!(self.chip().nvic.current(), 2 | 3);
        let does_not_fit = [frame, frame + len - 4].iter().any(|at| self.chip().mpu.forbids(*at, in_hard_fault));
        if does_not_fit {
            let chip = self.chip_mut();
            chip.scb.cfsr |= cfsr::MSTKERR;
            if number != HARD_FAULT {
                chip.scb.hfsr |= FORCED;
            }
        } else {
            self.store_frame(frame, stack, has_float);
        }
        self.set(RegisterARM::SP, frame);
        let control = self.get(RegisterARM::CONTROL);
        self.set(RegisterARM::CONTROL, control & !FPCA);
        let mut returns = 0xFFFF_FFE1;
        returns |= if in_thread { TO_THREAD } else { 0 } | if has_float { 0 } else { NO_FLOAT };
        self.set(RegisterARM::LR, returns);
        // where the frame does not fit, the fault takes the place of what asked
        let number = if does_not_fit { HARD_FAULT } else { number };
        self.chip_mut().time.cycles += ENTRY_CYCLES;
        self.go_to_vector(number);
    }

    fn go_to_vector(&mut self, number: usize) {
        let chip = self.chip_mut();
        chip.nvic.enter(number);
        let vector = chip.scb.vtor + 4 * number as u32;
        self.protect();
        let handler = self.word(vector);
        if handler & 1 == 0 {
            self.chip_mut()
                .breaches
                .add(Rule::Architecture, format!("the vector of exception {number} is {handler:#x}"));
            self.locked_up = true;
        }
        self.set(RegisterARM::PC, handler | 1);
    }

    fn store_frame(&mut self, frame: u32, stack: u32, has_float: bool) {
        let mut words: Vec<u32> = BASIC.iter().map(|register| self.get(*register)).collect();
        words.push(self.get(RegisterARM::PC) & !1);
        let flags = self.get(RegisterARM::XPSR) & 0xF80F_0000;
        let aligned = if stack & 4 != 0 { ALIGNED } else { 0 };
        words.push(flags | THUMB | aligned | self.chip().nvic.current() as u32);
        if has_float {
            for register in FLOAT {
                let pair = must(self.cpu.reg_read(register));
                words.extend([pair as u32, (pair >> 32) as u32]);
            }
            words.extend([self.get(RegisterARM::FPSCR), 0]);
        }
        for (at, word) in (frame..).step_by(4).zip(words) {
            self.set_word(at, word);
        }
    }

    /// Returns from the innermost exception, to what its frame says or to the next exception that waits.
    pub(crate) fn leave(&mut self, returns: u32) {
        // the branch took the lowest bit for the instruction set
        let returns = returns | 1;
        if self.chip().nvic.active.is_empty() {
            self.chip_mut().breaches.add(Rule::Architecture, "a return from no exception");
            self.locked_up = true;
            return;
        }
        if self.chip().nvic.current() == HARD_FAULT {
            self.set(RegisterARM::FAULTMASK, 0);
        }
        self.chip_mut().leave_exception();
        self.chip_mut().advance();
        let masks = crate::core::nvic::Masks {
            primask: self.get(RegisterARM::PRIMASK) & 1 != 0,
            faultmask: false,
            basepri: self.get(RegisterARM::BASEPRI) as u8,
        };
        if let Some(next) = self.chip().nvic.next(masks) {
            // the frame stays for the next one
            self.set(RegisterARM::LR, returns);
            self.chip_mut().time.cycles += TAIL_CYCLES;
            self.go_to_vector(next);
            return;
        }
        self.protect();
        self.load_frame(returns);
        self.chip_mut().time.cycles += ENTRY_CYCLES;
    }

    fn load_frame(&mut self, returns: u32) {
        let frame = self.get(RegisterARM::SP);
        let has_float = returns & NO_FLOAT == 0;
        for (at, register) in (frame..).step_by(4).zip(BASIC) {
            let word = self.word(at);
            self.set(register, word);
        }
        let (pc, flags) = (self.word(frame + 24), self.word(frame + 28));
        if has_float {
            for (at, register) in (frame + FRAME..).step_by(8).zip(FLOAT) {
                let pair = u64::from(self.word(at)) | u64::from(self.word(at + 4)) << 32;
                must(self.cpu.reg_write(register, pair));
            }
            let status = self.word(frame + 0x60);
            self.set(RegisterARM::FPSCR, status);
        }
        let len = if has_float { FLOAT_FRAME } else { FRAME };
        let aligned = if flags & ALIGNED != 0 { 4 } else { 0 };
        self.set(RegisterARM::SP, frame + len + aligned);
        self.set(RegisterARM::XPSR_NZCVQG, flags);
        let control = self.get(RegisterARM::CONTROL) & !FPCA;
        self.set(RegisterARM::CONTROL, control | if has_float { FPCA } else { 0 });
        let to_thread = self.chip().nvic.active.is_empty();
        if (returns & TO_THREAD != 0) != to_thread {
            self.chip_mut().breaches.add(Rule::Architecture, format!("EXC_RETURN is {returns:#x}"));
        }
        self.set(RegisterARM::PC, pc | 1);
    }

    /// A fault that no other handler is enabled for.
    pub(crate) fn hard_fault(&mut self) {
        if matches!(self.chip().nvic.current(), 2 | 3) {
            self.chip_mut().breaches.add(Rule::Architecture, "a fault within a fault: the core locks up");
            self.locked_up = true;
            return;
        }
        self.chip_mut().scb.hfsr |= FORCED;
        self.enter(HARD_FAULT);
    }
}
