//! Where the instructions go: by function of the source, those that the compiler has inlined included.

use std::collections::HashMap;
use std::path::Path;

use addr2line::Loader;

use super::trace::Instruction;

/// Instructions and estimated cycles spent in one place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Share {
    /// A function, or a line of the source.
    pub place: String,
    /// Instructions.
    pub instructions: u64,
    /// Estimated cycles.
    pub cycles: u64,
}

/// What a place is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The innermost function of this project's own source.
    Function,
    /// The innermost line of this project's own source.
    Line,
    /// The function as the linker knows it, with everything inlined in it.
    Symbol,
}

/// Divides the instructions by place, most first.
///
/// # Errors
/// What is wrong with the image's debug information.
pub fn by_place(image: &Path, instructions: &[(&Instruction, u64)], place: Place) -> Result<Vec<Share>, String> {
    let loader = Loader::new(image).map_err(|error| error.to_string())?;
    let mut names: HashMap<u64, String> = HashMap::new();
    let mut shares: HashMap<String, (u64, u64)> = HashMap::new();
    for (one, times) in instructions {
        let name = match names.get(&one.address) {
            Some(name) => name.clone(),
            None => {
                let name = name(&loader, one.address, place).map_err(|error| error.to_string())?;
                names.entry(one.address).or_insert(name).clone()
            }
        };
        let share = shares.entry(name).or_default();
        share.0 += times;
        share.1 += times * one.cycles;
    }
    let mut shares: Vec<Share> =
        shares.into_iter().map(|(place, (instructions, cycles))| Share { place, instructions, cycles }).collect();
    shares.sort_by(|a, b| (b.instructions, &a.place).cmp(&(a.instructions, &b.place)));
    Ok(shares)
}

fn name(loader: &Loader, address: u64, place: Place) -> Result<String, Box<dyn std::error::Error>> {
    let symbol = || {
        let name = loader.find_symbol(address).unwrap_or("?");
        format!("{:#}", rustc_demangle::demangle(name))
    };
    if place == Place::Symbol {
        return Ok(symbol());
    }
    let Some(Own { function, file, line }) = innermost_own(loader, address)? else { return Ok(symbol()) };
    Ok(match (place, function) {
        (Place::Line, _) => format!("{}:{line}", file.split_once("src/").map_or(&*file, |(_, file)| file)),
        (_, Some(function)) => function,
        (_, None) => symbol(),
    })
}

/// Where an instruction comes from in this project's own source.
pub(super) struct Own {
    pub function: Option<String>,
    pub file: String,
    pub line: u32,
}

/// The innermost function of this project's own source that an instruction was compiled from.
pub(super) fn innermost_own(loader: &Loader, address: u64) -> Result<Option<Own>, Box<dyn std::error::Error>> {
    let mut frames = loader.find_frames(address)?;
    while let Some(frame) = frames.next()? {
        let Some(location) = frame.location else { continue };
        let Some(file) = location.file.filter(|file| file.contains("src/") && is_own(file)) else { continue };
        let function = match &frame.function {
            Some(function) => Some(format!("{:#}", rustc_demangle::demangle(&function.raw_name()?))),
            None => None,
        };
        return Ok(Some(Own { function, file: file.to_owned(), line: location.line.unwrap_or(0) }));
    }
    Ok(None)
}

/// Not of a library.
fn is_own(file: &str) -> bool {
    !file.contains("/registry/") && !file.contains("/library/") && !file.contains("/rustc/")
}
