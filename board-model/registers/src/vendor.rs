//! ST's description, as the `stm32g4` crate renders it: the text of its modules says where each register and each field
//! lies, and what a register holds after a reset.
//!
//! The crate is a dependency only so that cargo brings its text here. It cannot be asked at run time: it is made for
//! code that runs on the chip.

use crate::{Bits, Block, Register};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{fs, io};

/// The crate's folder of the chip.
const CHIP: &str = "src/stm32g474";

/// Where the text lies on this machine.
///
/// # Errors
/// cargo cannot be run, or does not know the crate.
pub fn folder() -> io::Result<PathBuf> {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
    let cargo = option_env!("CARGO").unwrap_or("cargo");
    let output = Command::new(cargo).args(["metadata", "--format-version=1", "--manifest-path", manifest]).output()?;
    let known: serde_json::Value = serde_json::from_slice(&output.stdout)?;
    let packages = known["packages"].as_array().map_or(&[][..], Vec::as_slice);
    let of_crate = packages.iter().find(|package| package["name"] == "stm32g4");
    let path = of_crate.and_then(|package| package["manifest_path"].as_str()).map(Path::new).and_then(Path::parent);
    let path = path.ok_or_else(|| io::Error::other("cargo does not know the crate stm32g4"))?;
    Ok(path.join(CHIP))
}

/// The registers of the block of this name.
///
/// # Errors
/// The text is not there, or is not what svd2rust writes.
pub fn block(folder: &Path, name: &str) -> io::Result<Block> {
    let path = folder.join(name).with_extension("rs");
    let text = read(&path)?;
    let mut block = Block::new();
    let mut place = None;
    for line in text.lines().map(str::trim) {
        if let Some(comment) = line.strip_prefix("///0x") {
            // an array as a whole has a range; its elements follow one by one
            place = comment.split_once(' ').map_or(comment, |(place, _)| place).parse_hex();
        } else if let Some(declared) = line.strip_prefix("pub const fn ")
            && let Some(at) = place.take()
            && let Some((function, of_type)) = declared.split_once("(&self) -> &")
        {
            let module = of_type.trim_end_matches([' ', '{']).to_lowercase();
            let path = folder.join(path_of(&text, name, &module)).with_extension("rs");
            let found = register(&read(&path)?).map_err(|error| in_file(&path, &error))?;
            let entry: &mut Register = block.entry(at).or_default();
            if entry.name.is_empty() {
                entry.name = function.to_uppercase();
                entry.reset = found.reset;
            }
            for (bits, names) in found.fields {
                entry.fields.entry(bits).or_default().extend(names);
            }
        }
    }
    if block.is_empty() { Err(in_file(&path, "no register in it")) } else { Ok(block) }
}

/// Where a register's module lies: it may be another name of a module of this block or of another one.
fn path_of(text: &str, block: &str, module: &str) -> PathBuf {
    let used = text.lines().filter_map(|line| line.strip_prefix("pub use ")?.strip_suffix(';'));
    for used in used {
        let (path, name) = used.split_once(" as ").unwrap_or((used, used.rsplit("::").next().unwrap_or(used)));
        if name == module {
            let path =
                path.strip_prefix("crate::stm32g474::").map_or_else(|| format!("{block}::{path}"), str::to_owned);
            return path.split("::").collect();
        }
    }
    Path::new(block).join(module)
}

fn read(path: &Path) -> io::Result<String> {
    fs::read_to_string(path).map_err(|error| in_file(path, &error.to_string()))
}

fn in_file(path: &Path, error: &str) -> io::Error {
    io::Error::other(format!("{}: {error}", path.display()))
}

/// What the text of a register's module says of it, but for its name. Each field has a line with its bits above the function of its
/// name; the value after a reset is 0 where there is no line with it: svd2rust leaves it out then.
///
/// # Errors
/// A line that is not what svd2rust writes, by its number.
pub fn register(text: &str) -> Result<Register, String> {
    let mut register = Register { reset: Some(0), ..Register::default() };
    let mut bits = None;
    for (index, line) in text.lines().map(str::trim).enumerate() {
        let in_line = |wrong: &str| format!("line {}: {wrong}: {line}", index + 1);
        if let Some(comment) = line.strip_prefix("///Bit") {
            bits = Some(parse_bits(comment).ok_or_else(|| in_line("no bits of a register"))?);
        } else if let Some(declared) = line.strip_prefix("pub fn ").or_else(|| line.strip_prefix("pub const fn "))
            && let Some(bits) = bits.take()
            && let Some((name, _)) = declared.split_once('(')
        {
            register.fields.entry(bits).or_default().insert(name.trim_end_matches('_').to_uppercase());
        } else if let Some(value) = line.strip_prefix("const RESET_VALUE: u32 = ") {
            register.reset = Some(parse_value(value).ok_or_else(|| in_line("no reset value"))?);
        }
    }
    Ok(register)
}

/// ` 8 - text` or `s 2:3 - text`.
fn parse_bits(comment: &str) -> Option<Bits> {
    let (place, _) = comment.trim_start_matches('s').trim_start().split_once(' ')?;
    let (from, to): (u32, u32) = match place.split_once(':') {
        None => (place.parse().ok()?, place.parse().ok()?),
        Some((from, to)) => (from.parse().ok()?, to.parse().ok()?),
    };
    (from <= to && to < 32).then(|| Bits { from, width: to - from + 1 })
}

/// `0x1fff_ffff;` or `0;`.
fn parse_value(value: &str) -> Option<u32> {
    let value = value.strip_suffix(';')?.replace('_', "");
    value.strip_prefix("0x").map_or_else(|| value.parse().ok(), |digits| digits.parse_hex())
}

trait ParseHex {
    fn parse_hex(&self) -> Option<u32>;
}

impl ParseHex for str {
    fn parse_hex(&self) -> Option<u32> {
        u32::from_str_radix(self, 16).ok()
    }
}
