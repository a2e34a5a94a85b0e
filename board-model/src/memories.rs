//! The processor's memories, and the windows in which its chip answers.

use crate::image::Image;
use crate::machine::{State, must};
use rand::{RngCore, SeedableRng};
use rand_chacha::ChaCha8Rng;
use unicorn_engine::Unicorn;
use unicorn_engine::unicorn_const::Prot;

/// The memories: where they are, and how long.
pub const FLASH: (u32, usize) = (0x0800_0000, 0x4_0000);
/// Static variables and the stack.
pub const SRAM: (u32, usize) = (0x2000_0000, 0x1_8000);
/// The core-coupled memory.
pub const CCM: (u32, usize) = (0x1000_0000, 0x8000);
/// The vectors are looked for here; the chip shows its flash.
pub const ALIAS: u32 = 0;
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
/// The program in the flash, what the factory wrote, and RAM.
pub fn map_memories(cpu: &mut Unicorn<'static, State>, image: &Image) {
    let mut flash = vec![0xFF; FLASH.1];
    for (from, bytes) in &image.stored {
        let at = from.wrapping_sub(FLASH.0) as usize;
        flash[at..at + bytes.len()].copy_from_slice(bytes);
    }
    let mut factory = vec![0xFF; FACTORY.1];
    factory[(FLASH_SIZE.0 - FACTORY.0) as usize..][..2].copy_from_slice(&FLASH_SIZE.1.to_le_bytes());
    let read_only = Prot::READ | Prot::EXEC;
    let memories = [
        (ALIAS, flash.clone(), read_only),
        (FLASH.0, flash, read_only),
        (FACTORY.0, factory, Prot::READ),
        (SRAM.0, vec![0; SRAM.1], Prot::ALL),
        (CCM.0, vec![0; CCM.1], Prot::ALL),
    ];
    for (from, bytes, access) in memories {
        must(cpu.mem_map(from.into(), bytes.len() as u64, access));
        must(cpu.mem_write(from.into(), &bytes));
    }
}

/// Noise in everything that loses its content with the supply.
pub fn fill_with_noise(cpu: &mut Unicorn<'static, State>, seed: u64) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    for (from, len) in [SRAM, CCM] {
        let mut bytes = vec![0; len];
        random.fill_bytes(&mut bytes);
        must(cpu.mem_write(from.into(), &bytes));
    }
}

/// Where the chip answers.
pub fn map_windows(cpu: &mut Unicorn<'static, State>) {
    for (from, len) in WINDOWS {
        let read = move |cpu: &mut Unicorn<'_, State>, offset: u64, size: usize| {
            u64::from(cpu.get_data_mut().read(from + offset as u32, size as u32))
        };
        let write = move |cpu: &mut Unicorn<'_, State>, offset: u64, size: usize, value: u64| {
            cpu.get_data_mut().write(from + offset as u32, size as u32, value as u32);
        };
        must(cpu.mmio_map(from.into(), len.into(), Some(read), Some(write)));
    }
}
