//! Debian packages that a command needs: separate from the rest because they need a privilege and a consent.

use std::fmt;
use std::io::{self, BufRead, IsTerminal, Write};
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// Whether something may be installed on this machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Consent {
    /// Yes, without asking (`--yes`).
    Given,
    /// The user is asked on the terminal; no terminal means no.
    Ask,
    /// No. Tests never install anything.
    Refused,
}

/// Why a package is still missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum PackageError {
    /// Nobody allowed the installation.
    NotAllowed = 1,
    /// This system has no `apt-get`.
    NoPackageManager = 2,
    /// Neither root nor `sudo`.
    NoPrivilege = 3,
    /// `apt-get` ran and failed; it has printed why.
    InstallFailed = 4,
}

impl fmt::Display for PackageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotAllowed => "installation was not allowed (--yes allows it)",
            Self::NoPackageManager => "this system has no apt-get, so that must be done by hand",
            Self::NoPrivilege => "apt-get needs root, and there is no sudo",
            Self::InstallFailed => "apt-get failed, see its message above",
        })
    }
}

impl std::error::Error for PackageError {}

/// Makes sure that Debian's packages `names` are installed. `purpose` is shown when the user is asked.
///
/// # Errors
/// [`PackageError`]; the packages are then missing, in whole or in part.
pub fn ensure(names: &[&str], purpose: &str, consent: Consent) -> Result<(), PackageError> {
    let missing: Vec<&str> = names.iter().copied().filter(|name| !is_installed(name)).collect();
    if missing.is_empty() {
        return Ok(());
    }
    if find_program("apt-get").is_none() {
        return Err(PackageError::NoPackageManager);
    }
    let list = missing.join(" ");
    if !is_allowed(&format!("{purpose} needs the packages {list}. Install them with apt-get?"), consent) {
        return Err(PackageError::NotAllowed);
    }
    eprintln!("installing {list}");
    let mut install = vec!["install", "--yes", "--no-install-recommends"];
    install.extend(&missing);
    // The lists of a fresh system are empty: fetch them and try again.
    if apt_get(&install)? || (apt_get(&["update"])? && apt_get(&install)?) {
        Ok(())
    } else {
        Err(PackageError::InstallFailed)
    }
}

/// The program's path, if it is on `PATH`.
pub fn find_program(name: &str) -> Option<PathBuf> {
    std::env::split_paths(&std::env::var_os("PATH")?).map(|folder| folder.join(name)).find(|path| path.is_file())
}

fn is_installed(package: &str) -> bool {
    Command::new("dpkg-query")
        .args(["--show", "--showformat=${db:Status-Status}", package])
        .stderr(Stdio::null())
        .output()
        .is_ok_and(|output| output.stdout == b"installed")
}

fn is_allowed(question: &str, consent: Consent) -> bool {
    match consent {
        Consent::Given => true,
        Consent::Refused => false,
        Consent::Ask if !io::stdin().is_terminal() => false,
        Consent::Ask => {
            eprint!("{question} [y/N] ");
            let _ = io::stderr().flush();
            let mut answer = String::new();
            io::stdin().lock().read_line(&mut answer).is_ok() && matches!(answer.trim(), "y" | "Y" | "yes")
        }
    }
}

/// Runs apt-get, as root or by sudo; true if it succeeded. Its words go to the error output, so that a command's
/// result stays alone on standard output.
fn apt_get(arguments: &[&str]) -> Result<bool, PackageError> {
    let mut command = if is_root() {
        Command::new("apt-get")
    } else if find_program("sudo").is_some() {
        let mut sudo = Command::new("sudo");
        sudo.arg("apt-get");
        sudo
    } else {
        return Err(PackageError::NoPrivilege);
    };
    command
        .env("DEBIAN_FRONTEND", "noninteractive")
        .args(["-o", "Acquire::Retries=5"])
        .args(arguments)
        .stdout(io::stderr());
    command.status().map(|status| status.success()).map_err(|_| PackageError::NoPackageManager)
}

fn is_root() -> bool {
    Command::new("id").arg("-u").output().is_ok_and(|output| output.stdout.trim_ascii() == b"0")
}
