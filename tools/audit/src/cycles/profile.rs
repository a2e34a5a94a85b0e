//! Where the instructions go: by function of the source, those that the compiler has inlined included.

use std::collections::HashMap;
use std::path::Path;

use addr2line::Loader;

use super::trace::Executed;

/// Instructions and estimated cycles spent in one place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Share {
    /// A function, or a line of the source.
    pub place: String,
    /// Instructions.
    pub instructions: u64,
    /// Estimated cycles, waits for the flash included.
    pub cycles: u64,
    /// The waits alone.
    pub waits: u64,
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
pub fn by_place(image: &Path, instructions: &[Executed<'_>], place: Place) -> Result<Vec<Share>, String> {
    let loader = Loader::new(image).map_err(|error| error.to_string())?;
    let mut names: HashMap<u64, String> = HashMap::new();
    let mut shares: HashMap<String, (u64, u64, u64)> = HashMap::new();
    for (one, times, waits) in instructions {
        let name = match names.get(&one.address) {
            Some(name) => name.clone(),
            None => {
                let name = name(&loader, one.address, place).map_err(|error| error.to_string())?;
                names.entry(one.address).or_insert(name).clone()
            }
        };
        let share = shares.entry(name).or_default();
        share.0 += times;
        share.1 += times * one.cycles + waits;
        share.2 += waits;
    }
    let mut shares: Vec<Share> = shares
        .into_iter()
        .map(|(place, (instructions, cycles, waits))| Share { place, instructions, cycles, waits })
        .collect();
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
    let mut frames = loader.find_frames(address)?;
    while let Some(frame) = frames.next()? {
        let Some(location) = frame.location else { continue };
        let Some((_, file)) = location.file.and_then(|file| file.split_once("src/")).filter(|_| is_own(location.file))
        else {
            continue;
        };
        if place == Place::Line {
            return Ok(format!("{file}:{}", location.line.unwrap_or(0)));
        }
        if let Some(function) = frame.function {
            return Ok(format!("{:#}", rustc_demangle::demangle(&function.raw_name().unwrap_or_default())));
        }
    }
    Ok(symbol())
}

/// Not of a library.
fn is_own(file: Option<&str>) -> bool {
    file.is_some_and(|file| !file.contains("/registry/") && !file.contains("/library/") && !file.contains("/rustc/"))
}
