//! What an instruction costs on a Cortex-M4F: ARM DDI 0439, "Cortex-M4 Technical Reference Manual", tables 3-1 and 7-1.
//!
//! An estimate: a branch as if always taken. What an instruction owes to the one before it ([`pipeline`](super::pipeline)) and
//! to the memory that it comes from ([`fetch`](super::fetch)) comes on top.
//! Never checked on silicon; expect it to be right within 20 %.

/// An instruction as the emulator disassembles it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Instruction {
    /// Where it stands.
    pub address: u64,
    /// Its length: 2 or 4.
    pub bytes: u64,
    /// Its mnemonic with the type behind a point.
    pub mnemonic: String,
    /// Its operands.
    pub operands: String,
    /// Its estimated cycles.
    pub cycles: u64,
}

/// The pipeline is filled anew after a branch: one to three cycles, two on average.
const REFILL: u64 = 2;

/// Condition codes as the disassembler writes them behind a mnemonic.
const CONDITIONS: [&str; 15] =
    ["eq", "ne", "hs", "lo", "cs", "cc", "mi", "pl", "vs", "vc", "hi", "ls", "ge", "lt", "gt"];

impl Instruction {
    /// It calls a function.
    pub fn is_call(&self) -> bool {
        self.mnemonic.starts_with("bl") && (is_branch(&self.mnemonic, "bl") || is_branch(&self.mnemonic, "blx"))
    }
}

/// Cycles of one instruction, by its mnemonic and operands as the emulator's disassembler writes them.
pub fn cycles(mnemonic: &str, operands: &str) -> u64 {
    let name = mnemonic.split('.').next().unwrap_or(mnemonic);
    let is = |prefixes: &[&str]| prefixes.iter().any(|prefix| name.starts_with(prefix));
    // Floating point (table 7-1). Loads of double words count as two.
    if is(&["vdiv", "vsqrt"]) {
        return 14;
    }
    if is(&["vfma", "vfms", "vfnm", "vmla", "vmls", "vnmla", "vnmls"]) {
        return 3;
    }
    if is(&["vldr", "vstr"]) {
        return 1 + words(operands);
    }
    if is(&["vldm", "vstm", "vpush", "vpop"]) {
        return 1 + words(operands);
    }
    if name.starts_with('v') {
        return 1;
    }
    // Integer (table 3-1).
    if is(&["ldm", "stm", "push", "pop"]) {
        let into_pc = operands.contains("pc");
        return 1 + words(operands) + if into_pc { REFILL } else { 0 };
    }
    if is(&["ldrd", "strd"]) {
        return 3;
    }
    if is(&["ldr", "str"]) {
        let into_pc = name.starts_with("ldr") && operands.starts_with("pc");
        return 2 + if into_pc { REFILL } else { 0 };
    }
    if is(&["tbb", "tbh"]) {
        return 2 + REFILL;
    }
    if is(&["sdiv", "udiv"]) {
        // 2 to 12, by the operands
        return 7;
    }
    if is(&["mla", "mls"]) {
        return 2;
    }
    if is(&["cbz", "cbnz"]) || is_branch(name, "b") {
        return 2;
    }
    if is_branch(name, "bl") || is_branch(name, "bx") || is_branch(name, "blx") {
        return 1 + REFILL;
    }
    1
}

/// `stem` alone or with a condition.
fn is_branch(name: &str, stem: &str) -> bool {
    name.strip_prefix(stem).is_some_and(|rest| rest.is_empty() || rest == "le" || CONDITIONS.contains(&rest))
}

/// Words that a load or store moves: registers in the braces, or the one in front; double-precision registers are two.
fn words(operands: &str) -> u64 {
    let list = match operands.split_once('{') {
        Some((_, list)) => list,
        None => operands.split(',').next().unwrap_or_default(),
    };
    let size = |register: &str| match register.trim_matches([' ', '}']) {
        "" => 0,
        register if register.starts_with('d') => 2,
        _ => 1,
    };
    list.split(',').map(size).sum()
}

#[cfg(test)]
mod tests {
    use super::cycles;

    #[test]
    fn the_manuals_figures() {
        for (mnemonic, operands, expected) in [
            ("vadd.f32", "s0, s1, s2", 1),
            ("vmul.f32", "s0, s1, s2", 1),
            ("vfma.f32", "s0, s1, s2", 3),
            ("vmla.f32", "s0, s1, s2", 3),
            ("vnmul.f32", "s0, s1, s2", 1),
            ("vdiv.f32", "s0, s1, s2", 14),
            ("vsqrt.f32", "s0, s0", 14),
            ("vmov", "s0, r0", 1),
            ("vmovgt.f32", "s0, s1", 1),
            ("vldr", "s0, [r0, #4]", 2),
            ("vldr", "d8, [sp, #8]", 3),
            ("vldmia", "r0!, {s1, s2, s3, s4}", 5),
            ("vpush", "{d8, d9, d10}", 7),
            ("push.w", "{r4, r5, r6, lr}", 5),
            ("pop", "{r4, r5, r7, pc}", 7),
            ("ldrd", "r0, r1, [r2]", 3),
            ("ldr.w", "r0, [r1, #4]", 2),
            ("str", "r0, [r1]", 2),
            ("bl", "#0x1234", 3),
            ("ble.w", "#0x1234", 2),
            ("bls", "#0x1234", 2),
            ("blt", "#0x1234", 2),
            ("b.w", "#0x1234", 2),
            ("bxeq", "lr", 3),
            ("bic", "r0, r0, #1", 1),
            ("bfi", "r0, r1, #0, #4", 1),
            ("mov", "r0, r1", 1),
            ("umull", "r0, r1, r2, r3", 1),
            ("it", "eq", 1),
        ] {
            assert_eq!(cycles(mnemonic, operands), expected, "{mnemonic} {operands}");
        }
    }
}
