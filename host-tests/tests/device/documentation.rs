//! What the documentation names exists.

use firmware_image::drive_board_image::{MOST_FLASH_BYTES, MOST_STATIC_BYTES};
use host_tests::firmware::workspace;
use host_tests::identify::rig_file::RigFile;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

fn read(path: &str) -> String {
    fs::read_to_string(workspace().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// All Rust code below a folder.
fn code(folder: &Path) -> String {
    let mut all = String::new();
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() {
            all.push_str(&code(&entry));
        } else if entry.extension().is_some_and(|extension| extension == "rs") {
            all.push_str(&fs::read_to_string(entry).unwrap());
        }
    }
    all
}

/// What stands between single backquotes.
fn quoted(text: &str) -> BTreeSet<&str> {
    text.split('`').skip(1).step_by(2).collect()
}

/// Names of tests have several words; nothing else in these documents looks like that.
fn tests_in(text: &str) -> BTreeSet<&str> {
    let is_test = |name: &&str| {
        name.matches('_').count() >= 2
            && !name.starts_with('_')
            && name.chars().all(|c| c.is_ascii_lowercase() || c == '_' || c.is_ascii_digit())
    };
    quoted(text).into_iter().filter(is_test).collect()
}

#[test]
fn every_test_that_is_named_exists() {
    let code: String =
        ["host-tests/tests", "src", "board-model/tests"].map(|folder| code(&workspace().join(folder))).concat();
    for (document, least) in [
        ("docs/requirements.md", 40),
        ("docs/safe-states.md", 30),
        ("docs/security.md", 6),
        ("docs/hazards.md", 10),
        ("docs/nucleo-g474re.md", 15),
    ] {
        let text = read(document);
        let named = tests_in(&text);
        assert!(named.len() >= least, "{document} names {} tests", named.len());
        for test in named {
            assert!(code.contains(&format!("fn {test}(")), "{document} names {test}, which does not exist");
        }
    }
}

#[test]
fn every_command_that_is_named_exists() {
    let aliases = read(".cargo/config.toml");
    for document in ["README.md", "docs/requirements.md"] {
        let text = read(document);
        for command in quoted(&text).into_iter().filter_map(|quoted| quoted.strip_prefix("cargo ")) {
            let name = command.split([' ', '[']).next().unwrap();
            let known = ["test", "run", "build", "bench", "+nightly"].contains(&name)
                || aliases.contains(&format!("\n{name} = "));
            assert!(known, "{document} names `cargo {name}`");
        }
    }
}

/// The page for whoever brings up another board names what the emulated one really has.
#[test]
fn another_board_finds_what_it_is_told_to_look_at() {
    let text = read("docs/other-boards.md");
    let all = code(&workspace().join("src")) + &code(&workspace().join("host-tests/src")) + &read("build.rs");
    let emulated = code(&workspace().join("src/boards/emulated"));
    for (kind, name, at) in [
        ("impl ", "Board", &emulated),
        ("fn ", "turn", &emulated),
        ("fn ", "hear_can", &emulated),
        ("fn ", "hear_rig", &emulated),
        ("fn ", "carry_out", &emulated),
        ("pub struct ", "FileFlash", &emulated),
        ("pub fn ", "now_ms", &emulated),
        ("pub fn ", "feed", &emulated),
        ("fn ", "board_says", &emulated),
        ("fn ", "board_on_nmi", &emulated),
        ("pub fn ", "protect", &all),
        ("pub fn ", "stop", &all),
        ("pub fn ", "take", &all),
        ("pub fn ", "load", &all),
        ("pub fn ", "go_on", &all),
        ("fn ", "link_image", &all),
        ("fn ", "link_ccm_code", &all),
        ("pub const ", "BOARDS", &all),
        ("pub const ", "MAX_FRAMES", &all),
        ("pub struct ", "Storage", &all),
        ("pub fn ", "config", &all),
    ] {
        assert!(text.contains(name), "the page does not speak of {name}");
        let found = at.split(&format!("{kind}{name}")).nth(1).and_then(|rest| rest.chars().next());
        assert!(found.is_some_and(|next| !next.is_alphanumeric() && next != '_'), "no {kind}{name}");
    }
    // every variant that a board must know of, and no other
    let device = read("src/device/mod.rs");
    for (name, kind) in [("Event", "pub enum Event {"), ("Action", "pub enum Action {")] {
        let body = device.split(kind).nth(1).and_then(|rest| rest.split("\n}").next()).unwrap();
        let variants = body.lines().filter_map(|line| line.strip_prefix("    ")?.split(['(', ' ', ',']).next());
        let variants: Vec<&str> = variants.filter(|v| v.starts_with(|c: char| c.is_ascii_uppercase())).collect();
        assert!(variants.len() >= 5, "{variants:?}");
        for variant in variants {
            let named = text.contains(&format!("`{variant}`")) || text.contains(&format!("{name}::{variant}"));
            assert!(named, "the page does not speak of {name}::{variant}");
        }
    }
}

/// Every step of the method is found in the code by the name that the document gives it.
#[test]
fn the_method_names_what_exists() {
    let text = read("docs/method.md");
    let code = code(&workspace().join("src"));
    let is_defined = |name: &str| {
        ["fn ", "struct ", "enum ", "trait ", "const "].iter().any(|kind| {
            let ends_there = |rest: &str| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_');
            code.split(&format!("{kind}{name}")).skip(1).any(ends_there)
        })
    };
    let is_variant = |name: &str| code.contains(&format!("\n    {name}("));
    let is_code = |quoted: &&str| {
        !quoted.contains(['/', '.']) && !quoted.starts_with("cargo ") && !["f32", "f64"].contains(quoted)
    };
    let names: Vec<&str> = quoted(&text).into_iter().filter(is_code).flat_map(|quoted| quoted.split("::")).collect();
    assert!(names.len() >= 40, "{names:?}");
    for name in names {
        assert!(is_defined(name) || is_variant(name), "docs/method.md names {name}, which does not exist");
    }
}

#[test]
fn every_link_leads_to_a_file() {
    let entries = fs::read_dir(workspace().join("docs")).unwrap().map(|entry| entry.unwrap().path());
    let documents = entries.filter(|path| path.extension().is_some_and(|extension| extension == "md"));
    for document in documents.chain([workspace().join("README.md")]) {
        let text = fs::read_to_string(&document).unwrap();
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let file = target.split('#').next().unwrap();
            let is_here = !target.starts_with("http") && !file.is_empty();
            let exists = document.parent().unwrap().join(file).exists();
            assert!(!is_here || exists, "{} leads to {target}, which is not there", document.display());
        }
    }
}

/// The first example in TOML behind a heading.
fn example<'t>(text: &'t str, heading: &str) -> &'t str {
    let (_, behind) = text.split_once(heading).unwrap_or_else(|| panic!("no heading {heading}"));
    behind.split("```").nth(1).unwrap().strip_prefix("toml\n").unwrap()
}

#[test]
fn every_key_of_a_rig_s_file_is_explained_and_the_example_is_one() {
    let commands = read("docs/commands.md");
    RigFile::parse("docs/commands.md", example(&commands, "## A rig's file").as_bytes()).unwrap();
    let explained = commands + &read("examples/elbow.toml");
    let known = read("host-tests/src/identify/known_keys.rs");
    let tables = known.split("/// The first key").next().unwrap();
    let keys: BTreeSet<&str> = tables.split('"').skip(1).step_by(2).collect();
    assert!(keys.len() >= 30, "{keys:?}");
    let words: BTreeSet<&str> = explained.split(|c: char| !(c.is_alphanumeric() || c == '_')).collect();
    for key in keys {
        assert!(words.contains(key), "{key} of a rig's file is not in docs/commands.md or examples/elbow.toml");
    }
}

#[test]
fn the_requirement_on_memory_is_the_limit_that_is_checked() {
    let (flash, ram) = (MOST_FLASH_BYTES / 1024, MOST_STATIC_BYTES / 1024);
    let asked = format!("At most {flash} KiB of flash and {ram} KiB of static RAM");
    assert!(read("docs/requirements.md").contains(&asked), "{asked}");
}
