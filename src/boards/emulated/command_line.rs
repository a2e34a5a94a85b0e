//! What the emulator was started with (`-semihosting-config arg=firmware,arg=serial=7,arg=record=PATH`): the record's file,
//! and the board's serial number, which other boards have in their chip.

use cortex_m_semihosting::nr;

/// Longest command line of the emulator.
const LEN: usize = 1024;
/// What stands before the serial number.
const SERIAL: &[u8] = b"serial=";

/// The words, one space apart, with a zero behind them.
pub struct CommandLine([u8; LEN]);

impl CommandLine {
    /// Asks the emulator. None when it does not say.
    pub fn read() -> Option<Self> {
        let mut line = [0; LEN];
        // in: address and room, with a place for the zero; out: address and length
        let mut block = [line.as_mut_ptr().expose_provenance(), LEN];
        // SAFETY: the host writes within `line`, and into `block`, which is borrowed mutably.
        let failed =
            unsafe { cortex_m_semihosting::syscall1(nr::GET_CMDLINE, (&raw mut block).expose_provenance()) } != 0;
        (!failed).then_some(Self(line))
    }

    /// What stands behind a key, up to the zero and with it.
    pub fn after(&self, key: &[u8]) -> Option<&[u8]> {
        let line = self.0.split_inclusive(|byte| *byte == 0).next()?;
        let at = line.windows(key.len()).position(|window| window == key)?;
        line.get(at + key.len()..)
    }
}

/// Serial number of this board; 0 when it has none.
pub fn serial_number() -> u32 {
    let line = CommandLine::read();
    let digits = line.as_ref().and_then(|line| line.after(SERIAL)).unwrap_or_default();
    let digits = digits.iter().take_while(|byte| byte.is_ascii_digit());
    digits.fold(0, |serial: u32, digit| serial.wrapping_mul(10).wrapping_add(u32::from(digit - b'0')))
}
