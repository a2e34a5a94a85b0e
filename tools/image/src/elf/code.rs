//! The code of an image, half-word by half-word.

use super::{Elf, ElfError, Symbol, describe};
use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};
use std::collections::{BTreeMap, BTreeSet};

/// The section that the processor finds its handlers in.
const VECTORS: &str = ".vector_table";

/// Functions, vectors and the content of everything that lies in flash.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Code {
    /// Functions, each by all the names that it has.
    pub functions: Vec<Symbol>,
    /// The vector table: the initial stack pointer, then the addresses of the handlers with the lowest bit set, or 0.
    pub vectors: Vec<u32>,
    /// Content by its address on the board, without the vectors; true where it is code.
    sections: BTreeMap<u64, (bool, Vec<u8>)>,
    /// Where code (false) or data (true) begins within the code ("ELF for the Arm Architecture", 5.5.5).
    marks: BTreeMap<u64, bool>,
}

impl Elf {
    /// The code, and the data that may hold addresses of it.
    ///
    /// # Errors
    /// [`ElfError::Malformed`].
    pub fn code(&self) -> Result<Code, ElfError> {
        let file = self.parse()?;
        let mut code =
            Code { functions: Vec::new(), vectors: Vec::new(), sections: BTreeMap::new(), marks: BTreeMap::new() };
        for section in self.sections()?.iter().filter(|section| section.in_flash) {
            let Some(found) = file.section_by_name(&section.name) else { continue };
            let bytes = found.data().unwrap_or_default();
            if section.name == VECTORS {
                code.vectors = words(bytes).collect();
            } else {
                let is_code = found.kind() == object::SectionKind::Text;
                code.sections.insert(section.address, (is_code, bytes.to_vec()));
            }
        }
        for symbol in file.symbols() {
            match symbol.name() {
                Ok(name) if name == "$d" || name.starts_with("$d.") => drop(code.marks.insert(symbol.address(), true)),
                Ok(name) if name == "$t" || name.starts_with("$t.") => drop(code.marks.insert(symbol.address(), false)),
                Ok(_) if symbol.kind() == SymbolKind::Text => code.functions.push(describe(&symbol)),
                _ => {}
            }
        }
        code.give_sizes();
        Ok(code)
    }
}

impl Code {
    /// Of several names for one function, those with a size say how long it is. A function written in assembler may
    /// come without any: it then goes on to the next one.
    fn give_sizes(&mut self) {
        let sized: BTreeSet<u64> = self.functions.iter().filter(|f| f.size_bytes != 0).map(|f| f.address).collect();
        self.functions.retain(|function| function.size_bytes != 0 || !sized.contains(&function.address));
        let mut begins: Vec<u64> = self.functions.iter().map(|function| function.address).collect();
        begins.extend(self.sections.iter().map(|(begin, (_, bytes))| begin + bytes.len() as u64));
        begins.sort_unstable();
        for function in self.functions.iter_mut().filter(|function| function.size_bytes == 0) {
            let next = begins.iter().find(|begin| **begin > function.address);
            function.size_bytes = next.map_or(0, |next| next - function.address);
        }
    }

    /// There is data at this address amid the code: constants, a jump table.
    pub fn is_data(&self, address: u64) -> bool {
        self.marks.range(..=address).next_back().is_some_and(|(_, is_data)| *is_data)
    }

    /// The half-word at an address of the code; 0 behind its end.
    pub fn half_word(&self, address: u64) -> u16 {
        let section = self.sections.range(..=address).next_back();
        let bytes = section.and_then(|(begin, (_, bytes))| bytes.get((address - begin) as usize..)?.first_chunk());
        bytes.map_or(0, |bytes| u16::from_le_bytes(*bytes))
    }

    /// Every word that could hold an address: all data, be it amid the code.
    pub fn words(&self) -> impl Iterator<Item = u32> {
        self.sections.iter().flat_map(move |(begin, (is_code, bytes))| {
            let all = (*begin..).step_by(4).zip(words(bytes));
            all.filter(move |(at, _)| !is_code || self.is_data(*at)).map(|(_, word)| word)
        })
    }
}

fn words(bytes: &[u8]) -> impl Iterator<Item = u32> {
    bytes.as_chunks().0.iter().map(|word| u32::from_le_bytes(*word))
}
