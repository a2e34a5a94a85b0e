//! What is made from the table of the parameters: their signals in `glenoid.dbc`, and `docs/parameters.md`.

use glenoid::parameters::{Description, Entry, Kind, TABLE};
use std::fmt::Write;

/// The two messages that carry a parameter, and who receives them.
const MESSAGES: [(u16, &str); 2] = [(0x698, "Glenoid"), (0x699, "Client")];

/// A parameter's name in the DBC: `HoldTime` is `hold_time`, `Cable1EndX` is `cable_1_end_x`.
pub fn signal_name(name: &str) -> String {
    let mut signal = String::new();
    let mut before = None::<char>;
    for letter in name.chars() {
        let begins =
            letter.is_ascii_uppercase() || letter.is_ascii_digit() && !before.is_some_and(|b| b.is_ascii_digit());
        if begins && before.is_some() {
            signal.push('_');
        }
        signal.push(letter.to_ascii_lowercase());
        before = Some(letter);
    }
    signal
}

fn number(entry: &Entry, bits: u32) -> String {
    match entry.kind {
        Kind::Single => f32::from_bits(bits).to_string(),
        Kind::Integer => bits.to_string(),
    }
}

fn signal(entry: &Entry, receiver: &str) -> String {
    let Entry { index, minimum, maximum, .. } = entry;
    let Description { unit, .. } = entry.description();
    // DBC marks a single by a line of its own; it counts as signed
    let sign = if entry.kind == Kind::Single { '-' } else { '+' };
    let (name, low, high) = (signal_name(entry.description().name), number(entry, *minimum), number(entry, *maximum));
    format!(" SG_ {name} m{index} : 32|32@1{sign} (1,0) [{low}|{high}] \"{unit}\" {receiver}")
}

/// The DBC with the parameters' signals as the table has them; everything else as it stands.
pub fn dbc(text: &str) -> String {
    let names: Vec<String> = TABLE.iter().map(|entry| signal_name(entry.description().name)).collect();
    let is_ours = |line: &str| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let by_id = MESSAGES.iter().any(|(id, _)| {
            let id = id.to_string();
            match words[..] {
                ["CM_", "SG_", of, name, ..] | ["SIG_VALTYPE_", of, name, ..] | ["BA_", _, "SG_", of, name, ..] => {
                    of == id && !["operation", "parameter", "parameter_nonce", "zero", "code", "plain"].contains(&name)
                }
                _ => false,
            }
        });
        let multiplexed = match words[..] {
            ["SG_", name, mux, ":", position, ..] => position.starts_with("32|32") && mux != "m0" && name != "plain",
            _ => false,
        };
        by_id || multiplexed
    };
    let mut made = String::new();
    let mut message = None;
    for line in text.lines().filter(|line| !is_ours(line)) {
        if let Some(id) = line.strip_prefix("BO_ ").and_then(|rest| rest.split(' ').next()?.parse::<u16>().ok()) {
            message = MESSAGES.into_iter().find(|(of, _)| *of == id);
        }
        let _ = writeln!(made, "{line}");
        if line.starts_with(" SG_ plain ")
            && let Some((_, receiver)) = message
        {
            for entry in TABLE {
                let _ = writeln!(made, "{}", signal(entry, receiver));
            }
        }
        for (id, _) in MESSAGES {
            if line.starts_with(&format!("CM_ SG_ {id} plain ")) {
                for (entry, name) in TABLE.iter().zip(&names) {
                    let _ = writeln!(made, "CM_ SG_ {id} {name} \"{}.\";", entry.description().text);
                }
            }
            if line.starts_with("BA_ \"GenSigStartValue\" SG_ 1680 protocol ") {
                for (entry, name) in TABLE.iter().zip(&names) {
                    let default = number(entry, entry.default);
                    let _ = writeln!(made, "BA_ \"GenSigStartValue\" SG_ {id} {name} {default};");
                }
            }
        }
    }
    for (id, _) in MESSAGES {
        for (_, name) in TABLE.iter().zip(&names).filter(|(entry, _)| entry.kind == Kind::Single) {
            let _ = writeln!(made, "SIG_VALTYPE_ {id} {name} : 1;");
        }
    }
    made
}

/// The page about the parameters.
pub fn document() -> String {
    let mut page = String::from(HEAD);
    for entry in TABLE {
        let Entry { index, default, minimum, maximum, guarded, .. } = entry;
        let Description { name, unit, text } = entry.description();
        let kind = if entry.kind == Kind::Single { "single" } else { "integer" };
        let lock = if *guarded { "yes" } else { "" };
        let [default, low, high] = [default, minimum, maximum].map(|bits| number(entry, *bits));
        let name = signal_name(name);
        let _ =
            writeln!(page, "| {index} | `{name}` | {kind} | {unit} | {default} | {low} | {high} | {lock} | {text} |");
    }
    page
}

const HEAD: &str = "\
# Parameters

Every constant of the machine and every setting of its procedure is a parameter. One image serves every rig: the board keeps
its parameters in flash, and whoever has the key of the lock sets them over CAN. This page and the signals of
`ParameterRequest` and `Parameter` in `glenoid.dbc` are made from the table in
[`src/parameters/table.rs`](../src/parameters/table.rs) by `cargo run -p vocabulary`.

A client sends `ParameterRequest` (operation, index, nonce, value) and gets exactly one `Parameter` back with the same
operation, index and nonce, a code, and the value. A value is an IEEE single or an unsigned integer of 32 bits, as the table
says. The same request within a second, with a nonce other than 0, is answered again and not obeyed again.

| operation | what it does |
|---|---|
| `Read` | sends the value in use |
| `Write` | puts a value into the set that is being prepared; nothing goes by it yet (but `telemetry_rate`, which acts at once) |
| `ReadPrepared` | sends a value of the set that is being prepared |
| `List` | sends the first index that is assigned, from the given one on; `UnknownParameter` after the last |
| `ReadDefault`, `ReadMinimum`, `ReadMaximum` | send what the table says |
| `Check` | checks the prepared set as a whole; `ParametersContradict` carries the index of a parameter that does not fit |
| `Save` | checks it, stores it, answers, and starts the board anew with it; not during a run, nor while the centre in use could not be stored (it would be lost) |
| `Discard` | the prepared set becomes the one in use again |
| `Reset` | the prepared set becomes the defaults; the key of the lock stays |
| `Challenge`, `Unlock`, `Lock` | open and close the lock ([security.md](security.md)) |
| `EraseRecord` | erases the stored centre, and starts the board anew without one; not during a run |

No constant ever changes while something goes by it: a set is stored whole, and the board starts anew with it. A power cut
while it is stored leaves the old set or the new one, never a mixture (`cargo power-cut`). A stored centre belongs to the rig
that it was found on: when the geometry changes, it is refused as `RecordOfOtherRig`.

Lengths are in mm, in the frames {B} of the base and {P} of the platform. Where the column `lock` says yes,
the parameter is written only while the lock is open.

| index | name | type | unit | default | smallest | largest | lock | what it is |
|---|---|---|---|---|---|---|---|---|
";
