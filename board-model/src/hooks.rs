//! What happens at every instruction: time passes, and the core stops when the chip has something to say.

use crate::machine::{Failed, Longest, State, must};
use crate::marks as mark;
use crate::memories::{CCM, FLASH};
use unicorn_engine::unicorn_const::{HookType, MemType};
use unicorn_engine::{RegisterARM, Unicorn};

/// Sees every instruction, and every access that fails.
pub fn hook(cpu: &mut Unicorn<'static, State>) {
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
        state.chip.time.cycles += state.cycles_an_instruction;
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
