//! Builds a firmware image, with whichever Rust toolchain of this machine can.
//!
//! rustup's toolchain serves when it has the `core` library of the target, or can fetch it. Where it cannot, Debian's
//! packages of Rust serve: they bring the source of `core`, which is then built along with the image. Both ways lead
//! to the same image from the same sources. `GLENOID_TOOLCHAIN=rustup` or `=debian` forces one.

use std::ffi::OsString;
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::packages::{self, Consent, PackageError};

/// The Cortex-M4F with its floating-point unit.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// Names the toolchain that must be used: `rustup` or `debian`.
pub const TOOLCHAIN_VARIABLE: &str = "GLENOID_TOOLCHAIN";

/// Debian's Rust, its sources and its linker.
const DEBIAN_PACKAGES: [&str; 4] = ["rustc-web", "cargo-web", "rust-web-src", "lld-22"];

/// The package of the boards' images.
const LIBRARY: &str = "glenoid";

/// A firmware image by its name: the binary, its package and the feature that switches it on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Image {
    package: &'static str,
    binary: &'static str,
    feature: &'static str,
}

impl Image {
    /// The emulated drive board (QEMU mps2-an386).
    pub const EMULATED: Self = Self { package: LIBRARY, binary: "emulated", feature: "emulated" };

    /// The real drive board (NUCLEO-G474RE).
    pub const NUCLEO_G474RE: Self = Self { package: LIBRARY, binary: "nucleo-g474re", feature: "nucleo-g474re" };

    /// The same with the control loop of the example in its sampling's interrupt. It takes the other's place on the disk: read
    /// it at once.
    pub const CONTROL_LOOP: Self = Self { package: LIBRARY, binary: "nucleo-g474re", feature: "control-loop" };

    /// The images that make a drive board, real or emulated.
    pub const BOARDS: [Self; 2] = [Self::EMULATED, Self::NUCLEO_G474RE];

    /// The speed figures of the library on that board (see `tools/audit`).
    pub const SPEED: Self = Self { package: "speed-image", binary: "speed", feature: "image" };

    /// The whole library, for `cargo panic-free`; never run.
    pub const PANIC_FREE: Self = Self { package: LIBRARY, binary: "panic-free", feature: "panic-free" };

    /// The name of its binary.
    pub const fn name(self) -> &'static str {
        self.binary
    }
}

/// What builds the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Toolchain {
    /// The active toolchain, with `core` as rustup delivers it.
    Rustup,
    /// Debian's packages, with `core` built from source.
    Debian,
}

impl Toolchain {
    /// The word that chooses it, as in [`TOOLCHAIN_VARIABLE`].
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rustup => "rustup",
            Self::Debian => "debian",
        }
    }

    /// The word and the version of its compiler: figures of two versions cannot be compared.
    ///
    /// # Errors
    /// Why the compiler could not be asked.
    pub fn name_and_version(self) -> std::io::Result<String> {
        let compiler = match self {
            Self::Rustup => std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()),
            Self::Debian => "/usr/bin/rustc".into(),
        };
        let output = Command::new(compiler).arg("--version").current_dir(workspace()).output()?;
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        Ok(format!("{} {}", self.name(), text.split_whitespace().nth(1).unwrap_or("of an unknown version")))
    }
}

/// Why there is no image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FirmwareError {
    /// [`TOOLCHAIN_VARIABLE`] holds another word than `rustup` and `debian`.
    UnknownToolchain(String),
    /// rustup's toolchain lacks the target and could not fetch it.
    NoRustupTarget,
    /// Debian's packages are missing and could not be installed.
    NoDebianPackages(PackageError),
    /// Neither of the two.
    NoToolchain(PackageError),
    /// cargo could not be started, or ended with an error that it has printed.
    BuildFailed(Toolchain),
}

impl fmt::Display for FirmwareError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const RUSTUP: &str = "rustup's toolchain has no `core` for the target and could not fetch it";
        match self {
            Self::UnknownToolchain(word) => {
                write!(f, "{TOOLCHAIN_VARIABLE} is \"{word}\", but it may be \"rustup\" or \"debian\"")
            }
            Self::NoRustupTarget => write!(f, "{RUSTUP}: run `rustup target add {TARGET}`"),
            Self::NoDebianPackages(error) => {
                write!(f, "Debian's packages {} are missing: {error}", DEBIAN_PACKAGES.join(" "))
            }
            Self::NoToolchain(error) => write!(
                f,
                "nothing here builds for {TARGET}: {RUSTUP}, and Debian's packages {} are missing: {error}",
                DEBIAN_PACKAGES.join(" ")
            ),
            Self::BuildFailed(_) => write!(f, "the firmware image was not built, see cargo's message above"),
        }
    }
}

impl std::error::Error for FirmwareError {}

/// Builds the image and gives the path of its ELF file. cargo's progress goes to the error output.
///
/// # Errors
/// [`FirmwareError`].
pub fn build(image: Image, consent: Consent) -> Result<PathBuf, FirmwareError> {
    build_with(choose_toolchain(consent)?, image)
}

/// Builds the image with a given toolchain, which must be there (see [`choose_toolchain`]).
///
/// # Errors
/// [`FirmwareError::BuildFailed`].
pub fn build_with(toolchain: Toolchain, image: Image) -> Result<PathBuf, FirmwareError> {
    build_with_environment(toolchain, image, &[])
}

/// Builds the image as [`build_with`] does, with these variables set for its compiler, or not set.
///
/// # Errors
/// [`FirmwareError::BuildFailed`].
pub fn build_with_environment(
    toolchain: Toolchain,
    image: Image,
    variables: &[(&str, Option<&str>)],
) -> Result<PathBuf, FirmwareError> {
    let target_dir = workspace().join("target").join(match toolchain {
        // Not the folder of the cargo that may be running this very program: it holds the lock of that one.
        Toolchain::Rustup => "firmware",
        Toolchain::Debian => "debian",
    });
    let mut cargo = cargo(toolchain);
    for (name, value) in variables {
        match value {
            Some(value) => cargo.env(name, value),
            None => cargo.env_remove(name),
        };
    }
    let status = cargo
        .current_dir(workspace())
        // "-p": without it the host side's features are unified with the image's, a heap among them
        .args(["build", "--quiet", "--package", image.package, "--profile", "firmware", "--target", TARGET])
        .args(["--bin", image.binary, "--features", image.feature])
        .arg("--target-dir")
        .arg(&target_dir)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .status();
    match status {
        Ok(status) if status.success() => Ok(target_dir.join(TARGET).join("firmware").join(image.binary)),
        _ => Err(FirmwareError::BuildFailed(toolchain)),
    }
}

/// Finds a toolchain that can build for the board, installing one if that is allowed.
///
/// # Errors
/// Every [`FirmwareError`] but [`FirmwareError::BuildFailed`].
pub fn choose_toolchain(consent: Consent) -> Result<Toolchain, FirmwareError> {
    let rustup = || has_rustup_target(consent).then_some(Toolchain::Rustup);
    let debian = || {
        packages::ensure(&DEBIAN_PACKAGES, "building the firmware without rustup's target", consent)
            .map(|()| Toolchain::Debian)
    };
    match std::env::var(TOOLCHAIN_VARIABLE).as_deref() {
        Ok("rustup") => rustup().ok_or(FirmwareError::NoRustupTarget),
        Ok("debian") => debian().map_err(FirmwareError::NoDebianPackages),
        Ok(word) => Err(FirmwareError::UnknownToolchain(word.to_owned())),
        Err(_) => match rustup() {
            Some(toolchain) => Ok(toolchain),
            None => debian().map_err(FirmwareError::NoToolchain),
        },
    }
}

/// The root of the workspace that this program was built from.
pub fn workspace() -> &'static Path {
    let host_tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    host_tests.parent().unwrap_or(host_tests)
}

/// The toolchain has the target's `core`, or has it now that rustup was asked for it.
fn has_rustup_target(consent: Consent) -> bool {
    if has_core() {
        return true;
    }
    if consent == Consent::Refused {
        return false;
    }
    eprintln!("fetching the target {TARGET} by rustup");
    let added = Command::new("rustup")
        .current_dir(workspace())
        .args(["target", "add", TARGET])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .status()
        .is_ok_and(|status| status.success());
    added && has_core()
}

/// The active toolchain has `core` for the target. rustc prints the folder whether it exists or not.
fn has_core() -> bool {
    let output = Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()))
        .current_dir(workspace())
        .args(["--print", "target-libdir", "--target", TARGET])
        .stderr(Stdio::null())
        .output();
    let Ok(output) = output else { return false };
    let folder = PathBuf::from(String::from_utf8_lossy(&output.stdout).trim());
    std::fs::read_dir(folder).is_ok_and(|mut files| {
        files.any(|file| file.is_ok_and(|file| file.file_name().to_string_lossy().starts_with("libcore-")))
    })
}

/// cargo of the given toolchain, free of what an outer cargo or an impatient shell left in the environment: flags
/// from there would replace those of `.cargo/config.toml`.
fn cargo(toolchain: Toolchain) -> Command {
    let mut command = match toolchain {
        Toolchain::Rustup => Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into())),
        Toolchain::Debian => {
            let mut command = Command::new("/usr/bin/cargo");
            command.args(["-Zbuild-std=core"]).env("RUSTC", "/usr/bin/rustc").env("RUSTC_BOOTSTRAP", "1");
            for name in ["RUSTUP_TOOLCHAIN", "LD_LIBRARY_PATH", "CARGO", "RUSTDOC"] {
                command.env_remove(name);
            }
            command
        }
    };
    for name in ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "CARGO_BUILD_RUSTFLAGS", "CARGO_BUILD_TARGET"] {
        command.env_remove(name);
    }
    let profile_overrides: Vec<OsString> = std::env::vars_os()
        .map(|(name, _)| name)
        .filter(|name| name.to_string_lossy().starts_with("CARGO_PROFILE_"))
        .collect();
    for name in profile_overrides {
        command.env_remove(name);
    }
    command
}
