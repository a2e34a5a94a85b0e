//! What a firmware image holds: sections and symbols of its ELF file.

mod code;

pub use code::Code;

use std::fmt;
use std::path::{Path, PathBuf};

use object::read::elf::{FileHeader, ProgramHeader};
use object::{Endianness, Object, ObjectSection, ObjectSymbol, SectionFlags, SymbolKind, elf};

/// Why an image cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ElfError {
    /// The file cannot be read.
    Unreadable(PathBuf, String),
    /// The file is no ELF file.
    Malformed(PathBuf, String),
    /// The image has no such symbol.
    NoSymbol(String),
}

impl fmt::Display for ElfError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable(path, error) => write!(f, "{} cannot be read: {error}", path.display()),
            Self::Malformed(path, error) => write!(f, "{} is no ELF file: {error}", path.display()),
            Self::NoSymbol(name) => write!(f, "the image has no symbol {name}"),
        }
    }
}

impl std::error::Error for ElfError {}

/// A section that takes memory on the board.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Section {
    /// Its name, such as `.text`.
    pub name: String,
    /// Its address while the board runs.
    pub address: u64,
    /// Its size.
    pub size_bytes: u64,
    /// It is stored in flash (`.data` is, and is copied to RAM at power-up).
    pub in_flash: bool,
    /// It lies in RAM while the board runs.
    pub in_ram: bool,
}

/// What a programmer writes to the flash in one piece, or start-up clears.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Segment {
    /// Its address while the board runs.
    pub address: u64,
    /// Its size while the board runs.
    pub size_bytes: u64,
    /// Where it is stored.
    pub stored_at: u64,
    /// How much of it is stored; the rest is cleared.
    pub stored_bytes: u64,
    /// The program may write to it.
    pub writable: bool,
}

/// A function or a constant by its name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Symbol {
    /// Its name, demangled and without its hash.
    pub name: String,
    /// Its name as the linker knows it.
    pub linker_name: String,
    /// Its address while the board runs; of a function, that of its first instruction.
    pub address: u64,
    /// Its size.
    pub size_bytes: u64,
}

/// An image, read whole.
#[derive(Debug)]
pub struct Elf {
    path: PathBuf,
    bytes: Vec<u8>,
}

impl Elf {
    /// Reads the file.
    ///
    /// # Errors
    /// [`ElfError::Unreadable`].
    pub fn read(path: &Path) -> Result<Self, ElfError> {
        match std::fs::read(path) {
            Ok(bytes) => Ok(Self { path: path.to_owned(), bytes }),
            Err(error) => Err(ElfError::Unreadable(path.to_owned(), error.to_string())),
        }
    }

    /// The sections that take memory on the board, in the order of the file, empty ones left out.
    ///
    /// # Errors
    /// [`ElfError::Malformed`].
    pub fn sections(&self) -> Result<Vec<Section>, ElfError> {
        let file = self.parse()?;
        let sections = file.sections().filter_map(|section| {
            let SectionFlags::Elf { sh_flags } = section.flags() else { return None };
            let takes_memory = sh_flags & u64::from(elf::SHF_ALLOC) != 0 && section.size() != 0;
            takes_memory.then(|| Section {
                name: section.name().unwrap_or("?").to_owned(),
                address: section.address(),
                size_bytes: section.size(),
                in_flash: section.file_range().is_some(),
                in_ram: sh_flags & u64::from(elf::SHF_WRITE) != 0,
            })
        });
        Ok(sections.collect())
    }

    /// Where the image begins to run, as a debugger starts it.
    ///
    /// # Errors
    /// [`ElfError::Malformed`].
    pub fn entry(&self) -> Result<u64, ElfError> {
        Ok(self.parse()?.entry())
    }

    /// The segments that take memory on the board, empty ones left out.
    ///
    /// # Errors
    /// [`ElfError::Malformed`].
    pub fn segments(&self) -> Result<Vec<Segment>, ElfError> {
        let header = elf::FileHeader32::<Endianness>::parse(&*self.bytes).map_err(|error| self.malformed(error))?;
        let endian = header.endian().map_err(|error| self.malformed(error))?;
        let headers = header.program_headers(endian, &*self.bytes).map_err(|error| self.malformed(error))?;
        let loaded = headers.iter().filter(|segment| segment.p_type(endian) == elf::PT_LOAD);
        let segments = loaded.filter(|segment| segment.p_memsz(endian) != 0).map(|segment| Segment {
            address: segment.p_vaddr(endian).into(),
            size_bytes: segment.p_memsz(endian).into(),
            stored_at: segment.p_paddr(endian).into(),
            stored_bytes: segment.p_filesz(endian).into(),
            writable: segment.p_flags(endian) & elf::PF_W != 0,
        });
        Ok(segments.collect())
    }

    /// A section's content as words.
    ///
    /// # Errors
    /// [`ElfError::Malformed`], [`ElfError::NoSymbol`] when there is no such section.
    pub fn words(&self, section: &str) -> Result<Vec<u32>, ElfError> {
        let file = self.parse()?;
        let section = file.section_by_name(section).ok_or_else(|| ElfError::NoSymbol(section.to_owned()))?;
        let bytes = section.data().map_err(|error| self.malformed(error))?;
        Ok(bytes.as_chunks().0.iter().map(|word| u32::from_le_bytes(*word)).collect())
    }

    /// The address of the only constant or function whose demangled name ends with this.
    ///
    /// # Errors
    /// [`ElfError::Malformed`], [`ElfError::NoSymbol`] when there is none, or more than one.
    pub fn symbol_ending_with(&self, end: &str) -> Result<u64, ElfError> {
        let mut found = self.symbols()?.into_iter().filter(|symbol| symbol.name.ends_with(end));
        match (found.next(), found.next()) {
            (Some(symbol), None) => Ok(symbol.address),
            _ => Err(ElfError::NoSymbol(end.to_owned())),
        }
    }

    /// The value of a symbol: an address on the board.
    ///
    /// # Errors
    /// [`ElfError::Malformed`], [`ElfError::NoSymbol`].
    pub fn symbol(&self, name: &str) -> Result<u64, ElfError> {
        let file = self.parse()?;
        let symbol = file.symbol_by_name(name).ok_or_else(|| ElfError::NoSymbol(name.to_owned()))?;
        Ok(symbol.address())
    }

    /// Functions and constants that take memory, in no particular order.
    ///
    /// # Errors
    /// [`ElfError::Malformed`].
    pub fn symbols(&self) -> Result<Vec<Symbol>, ElfError> {
        let file = self.parse()?;
        Ok(file.symbols().filter(|symbol| symbol.size() != 0).map(|symbol| describe(&symbol)).collect())
    }

    /// A function by its name as the linker knows it.
    ///
    /// # Errors
    /// [`ElfError::Malformed`], [`ElfError::NoSymbol`].
    pub fn function(&self, name: &str) -> Result<Symbol, ElfError> {
        let file = self.parse()?;
        let symbol = file.symbol_by_name(name).ok_or_else(|| ElfError::NoSymbol(name.to_owned()))?;
        Ok(describe(&symbol))
    }

    fn parse(&self) -> Result<object::File<'_>, ElfError> {
        object::File::parse(&*self.bytes).map_err(|error| self.malformed(error))
    }

    fn malformed(&self, error: object::Error) -> ElfError {
        ElfError::Malformed(self.path.clone(), error.to_string())
    }
}

fn describe<'data>(symbol: &impl ObjectSymbol<'data>) -> Symbol {
    // bit 0 of a function's address says that its code is Thumb code
    let thumb = u64::from(symbol.kind() == SymbolKind::Text);
    let linker_name = symbol.name().unwrap_or("?");
    Symbol {
        name: format!("{:#}", rustc_demangle::demangle(linker_name)),
        linker_name: linker_name.to_owned(),
        address: symbol.address() & !thumb,
        size_bytes: symbol.size(),
    }
}
