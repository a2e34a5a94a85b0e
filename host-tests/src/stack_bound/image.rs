//! The functions of an image, from its ELF file.

use std::collections::{BTreeMap, BTreeSet};

use super::frame::{Code, walk};
use super::{Bounds, Function, is_formatting};
use crate::elf::{Elf, ElfError};

/// Code of an image, told from data by the assembler's marks.
struct Text {
    from: u64,
    bytes: Vec<u8>,
    /// From each address on, until the next: is it code?
    marks: BTreeMap<u64, bool>,
}

impl Text {
    fn is_code(&self, address: u64) -> bool {
        self.marks.range(..=address).next_back().is_none_or(|(_, is_code)| *is_code)
    }
}

impl Code for Text {
    fn halfword(&self, address: u64) -> Option<u16> {
        let bytes = [self.byte(address)?, self.byte(address + 1)?];
        self.is_code(address).then(|| u16::from_le_bytes(bytes))
    }

    fn data_len(&self, address: u64) -> u64 {
        if self.is_code(address) {
            return 0;
        }
        let end = self.marks.range(address..).find(|(_, is_code)| **is_code).map(|(at, _)| *at);
        end.unwrap_or(self.from + self.bytes.len() as u64) - address
    }

    fn byte(&self, address: u64) -> Option<u8> {
        self.bytes.get(usize::try_from(address.checked_sub(self.from)?).ok()?).copied()
    }
}

/// Reads an image.
///
/// # Errors
/// [`ElfError`].
pub fn read(image: &Elf) -> Result<Bounds, ElfError> {
    let (from, bytes) = image.content(".text")?;
    let end = from + bytes.len() as u64;
    let text = Text { from, bytes, marks: image.code_marks()? };
    let names = image.functions()?;
    let mut functions = BTreeMap::new();
    for (address, name) in &names {
        // up to the next one: functions written in assembler have no size
        let next = names.range(address + 1..).next().map_or(end, |(next, _)| *next);
        if (from..end).contains(address) {
            functions.insert(*address, Function { name: name.clone(), frame: walk(&text, *address, next) });
        }
    }
    let mut pointed_at = BTreeSet::new();
    for section in [".rodata", ".data"] {
        for word in image.words(section)? {
            let address = u64::from(word & !1);
            let is_wanted = |function: &Function| !is_formatting(&function.name);
            if word & 1 == 1 && functions.get(&address).is_some_and(is_wanted) {
                pointed_at.insert(address);
            }
        }
    }
    Ok(Bounds::new(functions, pointed_at))
}
