//! Writes what is made from the table of the parameters: their signals in `glenoid.dbc`, and `docs/parameters.md`.

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let dbc = root.join("glenoid.dbc");
    let written = std::fs::read_to_string(&dbc)
        .and_then(|text| std::fs::write(&dbc, vocabulary::parameters::dbc(&text)))
        .and_then(|()| std::fs::write(root.join("docs/parameters.md"), vocabulary::parameters::document()));
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("vocabulary: {error}");
            ExitCode::FAILURE
        }
    }
}
