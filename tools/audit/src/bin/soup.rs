//! `cargo soup`: the third-party crates of the images and of the host side, with version and licence.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::PathBuf;
use std::process::{Command, ExitCode};

use clap::Parser;
use host_tests::command_line;
use host_tests::firmware::{TARGET, workspace};

/// Write docs/soup.md: every third-party crate with its version and licence, as Cargo.lock and the crates themselves say.
#[derive(Parser)]
#[command(name = "cargo soup", bin_name = "cargo soup")]
struct Arguments {
    /// Write nothing; exit 1 when the file in the tree is not what would be written
    #[arg(long)]
    check: bool,
}

/// Where a crate is used, in the order of the columns, and what `cargo tree` is asked for it.
const USES: [(&str, &[&str]); 3] = [
    ("emulated", &["--package", "glenoid", "--target", TARGET, "--features", "emulated"]),
    ("nucleo-g474re", &["--package", "glenoid", "--target", TARGET, "--features", "nucleo-g474re"]),
    ("host", &["--package", "host-tests", "--package", "audit"]),
];

/// Of a crate: its licence, and whether it is code in the product, a part of the compiler's work, or not there.
#[derive(Default)]
struct Found {
    licence: String,
    uses: [&'static str; USES.len()],
}

fn main() -> ExitCode {
    match run(&command_line::parse::<Arguments>()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("cargo soup: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<bool, Box<dyn Error>> {
    let file: PathBuf = workspace().join("docs/soup.md");
    let text = markdown(&crates()?);
    if !arguments.check {
        std::fs::write(&file, text)?;
        return Ok(true);
    }
    let current = std::fs::read_to_string(&file).is_ok_and(|kept| kept == text);
    println!("docs/soup.md is {}", if current { "current" } else { "NOT current: run `cargo soup`" });
    Ok(current)
}

/// The crates by name and version.
fn crates() -> Result<BTreeMap<(String, String), Found>, Box<dyn Error>> {
    let mut crates: BTreeMap<(String, String), Found> = BTreeMap::new();
    for (column, (_, arguments)) in USES.iter().enumerate() {
        let mut tree = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        tree.current_dir(workspace()).args(["tree", "--locked", "--edges", "normal", "--prefix", "depth"]);
        let output = tree.args(["--no-dedupe", "--format", "{p}|{l}"]).args(*arguments).output()?;
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).into());
        }
        // depth in the tree of the crate whose dependencies, too, serve the compiler alone
        let mut compiler: Option<usize> = None;
        for line in String::from_utf8_lossy(&output.stdout).lines().filter(|line| !line.is_empty()) {
            let (package, licence) = line.split_once('|').ok_or("cargo tree prints something else now")?;
            let depth_len = package.find(|c: char| !c.is_ascii_digit()).unwrap_or(package.len());
            let (depth, package) = package.split_at(depth_len);
            let depth: usize = depth.parse()?;
            compiler = compiler.filter(|above| depth > *above);
            if compiler.is_none() && package.contains("(proc-macro)") {
                compiler = Some(depth);
            }
            let mut words = package.split(' ');
            let (Some(name), Some(version)) = (words.next(), words.next()) else { continue };
            if package.contains("(/") || package.contains("file://") {
                // this project's own
                continue;
            }
            let found = crates.entry((name.to_owned(), version.trim_start_matches('v').to_owned())).or_default();
            found.licence = licence.to_owned();
            if compiler.is_none() {
                found.uses[column] = "yes";
            } else if found.uses[column].is_empty() {
                found.uses[column] = "compiler";
            }
        }
    }
    Ok(crates)
}

fn markdown(crates: &BTreeMap<(String, String), Found>) -> String {
    let mut text = String::from(
        "# Third-party crates\n\n\
         Written by `cargo soup`; `.ci/run` holds it against Cargo.lock. \"yes\" is code in the image (or in the commands of\n\
         the host), \"compiler\" runs while compiling and leaves none of its own behind. What only the tests and the build\n\
         scripts use is not listed. The compiler's own libraries (`core`, `compiler_builtins`: MIT OR Apache-2.0) come with\n\
         the toolchain.\n\n",
    );
    let columns = USES.map(|(name, _)| name).join(" | ");
    text.push_str(&format!("| crate | version | licence | {columns} |\n|---|---|---|{}\n", "---|".repeat(USES.len())));
    for ((name, version), found) in crates {
        text.push_str(&format!("| {name} | {version} | {} | {} |\n", found.licence, found.uses.join(" | ")));
    }
    text
}
