//! The linker's bridge for a call that is too far for a branch: from the flash to the core-coupled memory, and back.

use super::instructions::{Instruction, decode};

/// The register that is the linker's between a call and its arrival ("Procedure Call Standard for the Arm
/// Architecture", 6.1.1).
const LINKERS_OWN: u8 = 12;
/// `bx r12`.
const GO_THERE: u16 = 0x4760;

/// Bytes of a veneer.
pub const LEN: u64 = 10;

/// Where the veneer at this address leads; None when there is none: `movw r12`, `movt r12`, `bx r12`. To the call graph
/// it is a call of one function, where it would otherwise be one of every function that a pointer may lead to.
pub fn leads_to(half_word: impl Fn(u64) -> u16, at: u64) -> Option<u64> {
    let instruction = |at| decode(at, half_word(at), half_word(at + 2));
    match (instruction(at), instruction(at + 4), half_word(at + 8)) {
        (
            Instruction::LowerHalf { register: LINKERS_OWN, value: low },
            Instruction::UpperHalf { register: LINKERS_OWN, value: high },
            GO_THERE,
        ) => Some((u64::from(high) << 16 | u64::from(low)) & !1),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As LLVM's assembler gives it: `movw r12, #0xa419`, `movt r12, #0x800`, `bx r12`.
    const VENEER: [u8; 10] = [0x4a, 0xf2, 0x19, 0x4c, 0xc0, 0xf6, 0x00, 0x0c, 0x60, 0x47];

    fn read(bytes: [u8; 10]) -> Option<u64> {
        let half_word = |at: u64| {
            let at = (at - 0x1000) as usize;
            bytes.get(at..at + 2).map_or(0, |half| u16::from_le_bytes([half[0], half[1]]))
        };
        leads_to(half_word, 0x1000)
    }

    #[test]
    fn a_veneer_leads_to_one_place() {
        assert_eq!(read(VENEER), Some(0x0800_a418));
    }

    #[test]
    fn a_jump_through_a_pointer_is_no_veneer() {
        // a load in place of one half; another register at the end; the program's own register all the way
        for (at, byte) in [(1, 0xf8), (5, 0xf8), (8, 0x68)] {
            let mut bytes = VENEER;
            bytes[at] = byte;
            assert_eq!(read(bytes), None, "{at}");
        }
        // movw r3, movt r3, bx r3
        assert_eq!(read([0x4a, 0xf2, 0x19, 0x43, 0xc0, 0xf6, 0x00, 0x03, 0x18, 0x47]), None);
    }
}
