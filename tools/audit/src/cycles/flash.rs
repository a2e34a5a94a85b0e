//! Flash of the library's parts: the speed image with them less the same image without, and what is in it by module.

use std::collections::BTreeMap;
use std::path::Path;

use firmware_image::elf::{Elf, ElfError};
use host_tests::firmware::{self, FirmwareError, Image, Toolchain};

/// Selects what the image holds (`held.rs` in the image's sources).
const ONLY: &str = "GLENOID_SPEED_ONLY";

/// Images that hold a part of the library each, by the word that selects them.
pub const PARTS: [&str; 8] =
    ["paper-f32", "free-f32", "machine-f32", "full-f32", "paper-f64", "free-f64", "machine-f64", "full-f64"];

/// The images of all paths of the library, one for each precision: all at once would not fit the board's flash.
pub const SINGLE: &str = "f32";
/// The same in double precision.
pub const DOUBLE: &str = "f64";
/// The image of the whole device.
pub const DEVICE: &str = "device";

/// The image of an elbow, in single precision.
pub const ELBOW: &str = "elbow";

/// The image of the paper as it is printed, alone.
const LITERAL: &str = "literal";
/// Overrides how the image's profile is compiled; the speed of code that is unrolled is bought with its size.
const FOR_SPEED: (&str, &str) = ("CARGO_PROFILE_FIRMWARE_OPT_LEVEL", "3");

/// Bytes of flash of each part.
///
/// # Errors
/// [`FirmwareError`] or [`ElfError`], as text.
pub fn parts(toolchain: Toolchain) -> Result<Vec<(String, u64)>, String> {
    let size = |only: &str| -> Result<u64, String> {
        let image = build(toolchain, only).map_err(|error| error.to_string())?;
        flash_bytes(&Elf::read(&image).map_err(text)?).map_err(text)
    };
    let without = size("none")?;
    PARTS.iter().map(|part| Ok(((*part).to_owned(), size(part)?.saturating_sub(without)))).collect()
}

/// Builds the speed image with all paths of one precision, or with one part of them.
///
/// # Errors
/// [`FirmwareError::BuildFailed`].
pub fn build(toolchain: Toolchain, only: &str) -> Result<std::path::PathBuf, FirmwareError> {
    firmware::build_with_environment(toolchain, Image::SPEED, &[(ONLY, Some(only))])
}

/// Builds the image of the literal form compiled for speed: what a laboratory would hold the library against.
///
/// # Errors
/// [`FirmwareError::BuildFailed`].
pub fn build_literal_for_speed(toolchain: Toolchain) -> Result<std::path::PathBuf, FirmwareError> {
    let (name, level) = FOR_SPEED;
    firmware::build_with_environment(toolchain, Image::SPEED, &[(ONLY, Some(LITERAL)), (name, Some(level))])
}

/// Bytes of an image by module: the first three parts of each symbol's name.
///
/// # Errors
/// [`ElfError`].
pub fn by_module(image: &Path) -> Result<Vec<(String, u64)>, ElfError> {
    let mut modules: BTreeMap<String, u64> = BTreeMap::new();
    for symbol in Elf::read(image)?.symbols()? {
        *modules.entry(module(&symbol.name)).or_default() += symbol.size_bytes;
    }
    let mut modules: Vec<(String, u64)> = modules.into_iter().collect();
    modules.sort_by_key(|(_, bytes)| std::cmp::Reverse(*bytes));
    Ok(modules)
}

fn flash_bytes(image: &Elf) -> Result<u64, ElfError> {
    Ok(image.sections()?.iter().filter(|section| section.in_flash).map(|section| section.size_bytes).sum())
}

/// `glenoid::identification::estimator::Estimator<T>::advance` is of `glenoid::identification::estimator`.
fn module(name: &str) -> String {
    let plain = name.trim_start_matches(['<', '&']);
    let parts: Vec<&str> = plain.split("::").take(3).collect();
    match parts[..] {
        ["glenoid", area, module] => format!("glenoid::{area}::{module}"),
        ["glenoid" | "nalgebra" | "simba" | "core" | "heapless" | "libm" | "compiler_builtins" | "speed", ..] => {
            parts[0].to_owned()
        }
        _ => "other".to_owned(),
    }
}

fn text(error: ElfError) -> String {
    error.to_string()
}
