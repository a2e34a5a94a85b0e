//! Runs the binary in a directory of its own.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What a run gave.
#[derive(Debug)]
pub struct Ran {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Ran {
    /// The object that `--json` prints: one, on one line.
    pub fn json(&self) -> Value {
        assert_eq!(self.stdout.lines().count(), 1, "{self:?}");
        serde_json::from_str(&self.stdout).unwrap_or_else(|error| panic!("{error}: {self:?}"))
    }

    /// What a person reads, wherever the lines are broken.
    pub fn words(&self) -> String {
        self.stdout.split_whitespace().collect::<Vec<_>>().join(" ")
    }
}

/// A directory under the build's own for temporary files, where the files of a test lie under short names.
pub struct Desk(PathBuf);

impl Desk {
    /// An empty directory; `test` is a name that no other test uses.
    pub fn new(test: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("identify").join(test);
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    /// Writes a file.
    pub fn put(&self, name: &str, bytes: impl AsRef<[u8]>) -> &Self {
        std::fs::write(self.0.join(name), bytes).unwrap();
        self
    }

    /// Runs the command here, as `cargo identify -- LENGTHS.csv ...` does; the arguments are separated by blanks.
    pub fn identify(&self, arguments: &str) -> Ran {
        self.run(env!("CARGO_BIN_EXE_identify"), arguments)
    }

    /// Runs `cargo arm -- ...` here.
    pub fn arm(&self, arguments: &str) -> Ran {
        self.run(env!("CARGO_BIN_EXE_arm"), arguments)
    }

    fn run(&self, command: &str, arguments: &str) -> Ran {
        let output =
            Command::new(command).arg("--").args(arguments.split_whitespace()).current_dir(&self.0).output().unwrap();
        Ran {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }
}

/// A file of the repository's own data.
pub fn data(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name)).unwrap()
}

/// A list of numbers in a JSON object.
pub fn numbers(object: &Value, key: &str) -> Vec<f64> {
    let list = object[key].as_array().unwrap_or_else(|| panic!("{key} is no list in {object}"));
    list.iter().map(|number| number.as_f64().unwrap()).collect()
}

/// The largest difference of two lists of numbers.
pub fn difference(one: &[f64], other: &[f64]) -> f64 {
    assert_eq!(one.len(), other.len());
    one.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}
