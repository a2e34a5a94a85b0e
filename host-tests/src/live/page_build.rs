//! Builds the page, and installs what that needs.

use crate::firmware::workspace;
use crate::packages::{self, Consent, PackageError};
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::SystemTime;

/// The library is compiled to this for the page.
const TARGET: &str = "wasm32-unknown-unknown";

/// Why there is no page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PageError {
    /// Node.js and npm, which bundle the page, are missing.
    NoNode(PackageError),
    /// The WebAssembly target is missing and could not be fetched.
    NoTarget,
    /// npm could not install what package-lock.json names; it has printed why.
    NoPackages,
    /// The build ended with an error that it has printed.
    BuildFailed,
}

impl fmt::Display for PageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoNode(error) => write!(f, "Node.js and npm are missing: {error}"),
            Self::NoTarget => write!(f, "nothing here builds WebAssembly: run `rustup target add {TARGET}`"),
            Self::NoPackages => write!(f, "npm could not install the page's packages, see its message above"),
            Self::BuildFailed => write!(f, "the page was not built, see the message above"),
        }
    }
}

impl std::error::Error for PageError {}

/// Builds the page if its sources are newer, and gives the folder that it lies in.
///
/// # Errors
/// [`PageError`].
pub fn build(consent: Consent) -> Result<PathBuf, PageError> {
    let page = workspace().join("page");
    let dist = page.join("dist");
    if newest(&dist) > newest(&page.join("src")).max(newest(&workspace().join("src"))).max(newest(&page.join("wasm"))) {
        return Ok(dist);
    }
    if packages::find_program("node").is_none() || packages::find_program("npm").is_none() {
        packages::ensure(&["nodejs", "npm"], "bundling the page", consent).map_err(PageError::NoNode)?;
    }
    if !has_target() {
        let mut rustup = Command::new("rustup");
        let added = rustup.args(["target", "add", TARGET]).current_dir(workspace()).stdout(std::io::stderr()).status();
        if !added.is_ok_and(|status| status.success()) || !has_target() {
            return Err(PageError::NoTarget);
        }
    }
    if newest(&page.join("node_modules")) < newest(&page.join("package-lock.json")) {
        eprintln!("installing the page's packages (npm ci)");
        run(Command::new("npm").args(["ci", "--no-audit", "--no-fund"]).current_dir(&page), PageError::NoPackages)?;
    }
    run(Command::new("node").arg("build.mjs").current_dir(&page), PageError::BuildFailed)?;
    Ok(dist)
}

fn run(command: &mut Command, failed: PageError) -> Result<(), PageError> {
    let status = command.stdout(std::io::stderr()).stdin(Stdio::null()).status();
    if status.is_ok_and(|status| status.success()) { Ok(()) } else { Err(failed) }
}

fn has_target() -> bool {
    let output = Command::new("rustc").args(["--print", "target-libdir", "--target", TARGET]).output();
    let Ok(output) = output else { return false };
    let folder = PathBuf::from(String::from_utf8_lossy(&output.stdout).trim());
    std::fs::read_dir(folder).is_ok_and(|mut files| files.any(|file| file.is_ok()))
}

/// When the newest file in a folder, or a file, was written; long ago when there is none.
fn newest(path: &Path) -> SystemTime {
    let own = std::fs::metadata(path).and_then(|data| data.modified()).unwrap_or(SystemTime::UNIX_EPOCH);
    let Ok(entries) = std::fs::read_dir(path) else { return own };
    let skipped = |path: &Path| path.ends_with("node_modules") || path.ends_with("dist");
    let inner = entries.flatten().map(|entry| entry.path()).filter(|path| !skipped(path));
    inner.map(|path| newest(&path)).max().unwrap_or(SystemTime::UNIX_EPOCH)
}
