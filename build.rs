//! Link arguments of the firmware images. The library and everything on the host need none of it.
//!
//! `memory.x` and `ccm.x` are taken from the root of the package: rustc links there, and a linker looks into its working
//! directory first. What differs between the boards is passed as symbols.

use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// cortex-m-rt asks for this file by name. It would hold default handlers; the emulated board's vector table names its
/// handlers itself, so there is nothing to say.
const DEVICE_X: &str = "/* every vector is given in vectors.rs */\n";

/// Where a board's flash and its core-coupled memory begin (`memory.x`).
#[derive(Clone, Copy)]
struct Origins {
    flash: u32,
    ccm: u32,
}

/// The drive board's chip (RM0440, section 2).
const CHIP: Origins = Origins { flash: 0x0800_0000, ccm: 0x1000_0000 };
/// The emulated board.
const EMULATOR: Origins = Origins { flash: 0x0000_0000, ccm: 0x2001_8000 };

/// Links the panic-free image although it is not, so that the ways to a panic can be looked at.
const LINK_ANYWAY: &str = "GLENOID_LINK_ANYWAY";

fn main() -> io::Result<()> {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=memory.x");
    println!("cargo::rerun-if-changed=ccm.x");
    let for_board = env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none");
    if for_board && env::var_os("CARGO_FEATURE_NUCLEO_G474RE").is_some() {
        // device.x comes with the chip's register crate
        link_ccm_code("nucleo-g474re");
        link_image("nucleo-g474re", CHIP, None);
        println!("cargo::rustc-link-arg-bin=nucleo-g474re=-Tdefmt.x");
    }
    let out_dir = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    if for_board && env::var_os("CARGO_FEATURE_PANIC_FREE").is_some() {
        fs::write(out_dir.join("device.x"), DEVICE_X)?;
        link_image("panic-free", EMULATOR, Some(&out_dir));
        // It holds more than any board does.
        println!("cargo::rustc-link-arg-bin=panic-free=--defsym=FLASH_LENGTH=480K");
        println!("cargo::rerun-if-env-changed={LINK_ANYWAY}");
        if env::var_os(LINK_ANYWAY).is_some() {
            println!("cargo::rustc-link-arg-bin=panic-free=--defsym=a_way_to_a_panic_is_left=Reset");
        }
    }
    if for_board && env::var_os("CARGO_FEATURE_EMULATED").is_some() {
        fs::write(out_dir.join("device.x"), DEVICE_X)?;
        link_ccm_code("emulated");
        // Its flash begins at 0. Code begins beyond every small number, so that `cargo stack` takes none for a function's address.
        println!("cargo::rustc-link-arg-bin=emulated=--defsym=_stext=0x400");
        link_image("emulated", EMULATOR, Some(&out_dir));
    }
    Ok(())
}

/// Links the binary `name` with the code that asks for it in the core-coupled memory. Comes before [`link_image`]: of two scripts that
/// could place a function, the first one does. The image must copy the code before it calls it.
fn link_ccm_code(name: &str) {
    println!("cargo::rustc-link-arg-bin={name}=-Tccm.x");
}

/// Links the binary `name` with cortex-m-rt's script for a board's memory. `scripts` holds what that script asks
/// for and no crate brings along.
fn link_image(name: &str, origins: Origins, scripts: Option<&Path>) {
    if let Some(scripts) = scripts {
        println!("cargo::rustc-link-arg-bin={name}=-L{}", scripts.display());
    }
    for argument in [
        format!("-L{}", env::var("CARGO_MANIFEST_DIR").unwrap_or_default()),
        format!("--defsym=FLASH_ORIGIN={:#x}", origins.flash),
        format!("--defsym=CCM_ORIGIN={:#x}", origins.ccm),
        "--defsym=RAM_LENGTH=96K".to_owned(),
        "-Tlink.x".to_owned(),
    ] {
        println!("cargo::rustc-link-arg-bin={name}={argument}");
    }
}
