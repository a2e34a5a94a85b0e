//! The firmware's ELF file: what is loaded, what lies where, and which instructions matter to the model.

use object::elf::{FileHeader32, PT_LOAD};
use object::read::elf::{FileHeader, ProgramHeader};
use object::{Endianness, Object, ObjectSymbol, SymbolKind};
use std::collections::BTreeMap;
use std::path::Path;
use std::{fs, io};

/// An image that was read from its file.
#[derive(Debug, Clone)]
pub struct Image {
    /// The whole file, for the decoder of its log.
    pub file: Vec<u8>,
    /// What the flash holds: address and bytes.
    pub stored: Vec<(u32, Vec<u8>)>,
    /// Where code runs: address and bytes.
    pub code: Vec<(u32, Vec<u8>)>,
    symbols: BTreeMap<String, (u32, u32)>,
    /// Functions by address: length and name.
    functions: BTreeMap<u32, (u32, String)>,
    /// Starts of code (true) and of constants (false) between it.
    mapping: BTreeMap<u32, bool>,
}

impl Image {
    /// Reads an ELF file.
    ///
    /// # Errors
    /// It cannot be read, or is no ELF file.
    pub fn read(path: &Path) -> io::Result<Self> {
        let file = fs::read(path).map_err(|error| io::Error::other(format!("{}: {error}", path.display())))?;
        Self::parse(file).map_err(|error| io::Error::other(format!("{}: {error}", path.display())))
    }

    fn parse(file: Vec<u8>) -> Result<Self, object::Error> {
        let header = FileHeader32::<Endianness>::parse(&*file)?;
        let endian = header.endian()?;
        let (mut stored, mut code) = (Vec::new(), Vec::new());
        for segment in header.program_headers(endian, &*file)? {
            let bytes = segment.data(endian, &*file).unwrap_or_default().to_vec();
            if segment.p_type(endian) != PT_LOAD || bytes.is_empty() {
                continue;
            }
            if segment.p_flags(endian) & object::elf::PF_X != 0 {
                code.push((segment.p_vaddr(endian), bytes.clone()));
            }
            stored.push((segment.p_paddr(endian), bytes));
        }
        let (mut symbols, mut functions, mut mapping) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
        for symbol in object::File::parse(&*file)?.symbols() {
            let (Ok(name), at) = (symbol.name(), symbol.address() as u32) else { continue };
            if name.starts_with("$t") || name.starts_with("$d") {
                mapping.insert(at, name.starts_with("$t"));
                continue;
            }
            symbols.insert(name.to_owned(), (at, symbol.size() as u32));
            if symbol.kind() == SymbolKind::Text {
                let shown = format!("{:#}", rustc_demangle::demangle(name));
                functions.insert(at & !1, (symbol.size() as u32, shown));
            }
        }
        Ok(Self { file, stored, code, symbols, functions, mapping })
    }

    /// The address of a symbol.
    pub fn symbol(&self, name: &str) -> Option<u32> {
        self.symbols.get(name).map(|(address, _)| *address)
    }

    /// The function that an address lies in, and how far inside; the address itself where there is none.
    pub fn name_of(&self, address: u32) -> String {
        match self.functions.range(..=address).next_back() {
            Some((from, (len, name))) if address < from + len.max(&2) => format!("{name} + {:#x}", address - from),
            _ => format!("{address:#x}"),
        }
    }

    /// Address and length of everything whose name contains `part`.
    pub fn variables(&self, part: &str) -> Vec<(u32, u32)> {
        self.symbols.iter().filter(|(name, _)| name.contains(part)).map(|(_, place)| *place).collect()
    }

    /// Calls `see` with the address of every instruction, its first half-word and the one behind.
    pub fn instructions(&self, mut see: impl FnMut(u32, u16, u16)) {
        for (from, bytes) in &self.code {
            let mut at = 0;
            while at + 2 <= bytes.len() {
                let address = from + at as u32;
                let is_code = self.mapping.range(..=address).next_back().is_some_and(|(_, is_code)| *is_code);
                let half_at =
                    |at: usize| bytes.get(at..at + 2).map_or(0, |half| u16::from_le_bytes([half[0], half[1]]));
                let half = half_at(at);
                if is_code {
                    see(address, half, half_at(at + 2));
                }
                // 0b11101, 0b11110 and 0b11111 begin an instruction of 32 bits (ARMv7-M ARM, A5.1)
                at += if is_code && half >> 11 >= 0b11101 { 4 } else { 2 };
            }
        }
    }
}
