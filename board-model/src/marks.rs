//! What the instructions are to the model: where exceptions wait, where the core sleeps, where interrupts are masked.

use crate::image::Image;

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

/// Marks of the code in one memory.
pub struct Marks {
    from: u32,
    of: Vec<u8>,
}

impl Marks {
    /// The marks of the instruction there.
    pub fn at(&self, address: u32) -> u8 {
        self.of.get((address.wrapping_sub(self.from) / 2) as usize).copied().unwrap_or(0)
    }
}

/// The marks of the code that runs from this memory.
pub fn marks(image: &Image, (from, len): (u32, usize)) -> Marks {
    let mut of = vec![0; len / 2];
    let mut left = 0_u32;
    image.instructions(|address, half, next| {
        let Some(place) = of.get_mut((address.wrapping_sub(from) / 2) as usize) else { return };
        if left != 0 {
            *place |= IN_IT;
            left -= 1;
        }
        match half {
            0xBF30 => *place |= SLEEP,
            0xB672 => *place |= MASKS,
            0xB662 => *place |= UNMASKS,
            // MSR; which register it writes does not matter here
            _ if half & 0xFFF0 == 0xF380 => *place |= UNMASKS,
            0xF3EF if next & 0xFF == 5 => *place |= READS_IPSR,
            // IT: the lowest set bit of its mask says how many instructions follow
            _ if half & 0xFF00 == 0xBF00 && half & 0xF != 0 => left = 4 - (half & 0xF).trailing_zeros(),
            _ => {}
        }
    });
    Marks { from, of }
}
