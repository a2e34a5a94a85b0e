//! What a stopping firmware leaves behind: words of RAM with a checksum, and back again.

use super::cause::ResetCause;
use core::fmt::{self, Write};
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

/// Longest text, bytes; what is longer is cut.
pub const TEXT_LEN: usize = 96;
/// Words of text.
const TEXT_WORDS: usize = TEXT_LEN / 4;
/// Magic, cause with line and length, address, text, checksum.
const AREA_LEN: usize = 3 + TEXT_WORDS + 1;
/// Begins the area.
const MAGIC: u32 = 0x676C_6E21;

/// The RAM that the crash record lies in. A board keeps it out of the memory that start-up code clears.
pub type Area = [u32; AREA_LEN];

/// Why the firmware stopped, and where.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CrashRecord {
    /// Why.
    pub cause: ResetCause,
    /// Address of the instruction, 0 when not known.
    pub address: u32,
    /// Line of the source, 0 when not known.
    pub line: u16,
    text: [u8; TEXT_LEN],
    text_len: u8,
}

impl CrashRecord {
    /// Words with a text, cut at [`TEXT_LEN`] bytes; what is not ASCII becomes `?`.
    pub fn new(cause: ResetCause, address: u32, line: u16, text: fmt::Arguments) -> Self {
        let mut words = Self { cause, address, line, text: [0; TEXT_LEN], text_len: 0 };
        // a text that is too long is cut, which is no failure
        let _ = words.write_fmt(text);
        words
    }

    /// The text.
    pub fn text(&self) -> &str {
        self.text.get(..usize::from(self.text_len)).and_then(|text| str::from_utf8(text).ok()).unwrap_or_default()
    }

    /// The words as they lie in RAM.
    pub fn seal(&self) -> Area {
        let mut area = [0; AREA_LEN];
        let [magic, what, address, text @ .., _] = &mut area;
        *magic = MAGIC;
        *what = u32::from(self.cause.code()) | u32::from(self.line) << 8 | u32::from(self.text_len) << 24;
        *address = self.address;
        for (word, bytes) in text.iter_mut().zip(self.text.as_chunks().0) {
            *word = u32::from_le_bytes(*bytes);
        }
        let sum = checksum(&area);
        if let Some(last) = area.last_mut() {
            *last = sum;
        }
        area
    }

    /// The words in an area, if there are any: RAM after a power-up holds anything.
    pub fn open(area: &Area) -> Option<Self> {
        let [magic, what, address, text @ .., sum] = area;
        if *magic != MAGIC || *sum != checksum(area) {
            return None;
        }
        let [cause, line_low, line_high, text_len] = what.to_le_bytes();
        let mut words = Self {
            cause: ResetCause::from_code(cause)?,
            address: *address,
            line: u16::from_le_bytes([line_low, line_high]),
            text: [0; TEXT_LEN],
            text_len,
        };
        for (bytes, word) in words.text.as_chunks_mut().0.iter_mut().zip(text) {
            *bytes = word.to_le_bytes();
        }
        Some(words)
    }
}

fn checksum(area: &Area) -> u32 {
    const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);
    let mut digest = CRC.digest();
    for word in area.iter().take(AREA_LEN - 1) {
        digest.update(&word.to_le_bytes());
    }
    digest.finalize()
}

/// Appends to the text, as ASCII.
impl Write for CrashRecord {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for character in text.chars() {
            let place = self.text.get_mut(usize::from(self.text_len)).ok_or(fmt::Error)?;
            *place = if character.is_ascii() { character as u8 } else { b'?' };
            self.text_len += 1;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use std::string::ToString;

    fn words() -> CrashRecord {
        CrashRecord::new(ResetCause::Panic, 0x0800_0ABC, 54_321, format_args!("src/a.rs: {} > {}", 3, "2"))
    }

    #[test]
    fn what_was_sealed_is_opened() {
        assert_eq!(CrashRecord::open(&words().seal()), Some(words()));
        assert_eq!(words().text(), "src/a.rs: 3 > 2");
    }

    #[test]
    fn a_long_text_is_cut_and_a_foreign_letter_replaced() {
        let words = CrashRecord::new(ResetCause::Panic, 0, 0, format_args!("é{}", "x".repeat(200)));
        assert_eq!(words.text(), "?".to_string() + &"x".repeat(TEXT_LEN - 1));
        assert_eq!(CrashRecord::open(&words.seal()), Some(words));
    }

    #[test]
    fn one_wrong_bit_is_found() {
        let area = words().seal();
        for bit in 0..AREA_LEN * 32 {
            let mut wrong = area;
            wrong[bit / 32] ^= 1 << (bit % 32);
            assert_eq!(CrashRecord::open(&wrong), None, "bit {bit}");
        }
    }

    #[test]
    fn ram_after_power_up_says_nothing() {
        for word in [0, u32::MAX, 0x5555_5555, MAGIC] {
            assert_eq!(CrashRecord::open(&[word; AREA_LEN]), None);
        }
    }
}
