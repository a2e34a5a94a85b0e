//! Link arguments of the firmware images. The library and everything on the host need none.
//!
//! `memory.x` is taken from the root of the package: rustc links there, and a linker looks into its working directory
//! first. What differs between the boards is passed as a symbol.

use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// cortex-m-rt asks for this file by name. It would hold default handlers; the emulated board's vector table names its
/// handlers itself, so there is nothing to say.
const DEVICE_X: &str = "/* every vector is given in vectors.rs */\n";

fn main() -> io::Result<()> {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=memory.x");
    let for_board = env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none");
    if for_board && env::var_os("CARGO_FEATURE_EMULATED").is_some() {
        let out_dir = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
        fs::write(out_dir.join("device.x"), DEVICE_X)?;
        link_image("emulated", 0x0000_0000, &out_dir);
    }
    Ok(())
}

/// Links the binary `name` with cortex-m-rt's script for flash at `flash_origin`.
fn link_image(name: &str, flash_origin: u32, scripts: &Path) {
    for argument in [
        format!("-L{}", scripts.display()),
        format!("-L{}", env::var("CARGO_MANIFEST_DIR").unwrap_or_default()),
        format!("--defsym=FLASH_ORIGIN={flash_origin:#x}"),
        "-Tlink.x".to_owned(),
    ] {
        println!("cargo::rustc-link-arg-bin={name}={argument}");
    }
}
