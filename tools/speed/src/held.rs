//! Which paths the image holds. What is left out is not linked, so the sizes of two images differ by what a path
//! takes.

use super::measure::Number;

/// For each precision `f32` (all paths of the library), `paper-f32`, `free-f32`, `machine-f32`, `full-f32`; `device`,
/// `elbow`, `literal`, `none`. All at once would not fit the board's flash.
const ONLY: &str = match option_env!("GLENOID_SPEED_ONLY") {
    Some(only) => only,
    None => "f32",
};

/// A group of paths that is held together.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The paper as it is printed.
    Literal,
    /// The paper's iteration.
    Paper,
    /// Identification without a start, the machine exactly known.
    Free,
    /// Identification without a start, with what is unknown of the machine.
    Machine,
    /// What is done with one sample, before an identification or after it.
    Samples,
    /// What looks at a centre in use.
    InUse,
    /// The whole device.
    Device,
    /// An elbow. In an image of its own, which is not traced: a trace of it would take minutes.
    Elbow,
}

/// Is the image there to be weighed? Its paths are called once then: what counting and preparing take is no part of them.
pub const WEIGHED: bool =
    !same(ONLY, "literal") && !same(ONLY, "device") && !same(ONLY, "elbow") && !same(ONLY, "f32") && !same(ONLY, "f64");

/// Is this part in the image, in this precision?
pub const fn holds<T: Number>(part: Part) -> bool {
    if same(ONLY, T::NAME) {
        return !matches!(part, Part::Device | Part::Elbow);
    }
    let full = same(ONLY, T::FULL);
    match part {
        Part::Literal => same(ONLY, "literal"),
        Part::Paper => same(ONLY, T::PAPER) || full,
        Part::Free => same(ONLY, T::FREE) || full,
        Part::Machine => same(ONLY, T::MACHINE) || full,
        Part::Samples => same(ONLY, T::FREE) || same(ONLY, T::MACHINE) || full,
        Part::InUse => full,
        Part::Device => same(ONLY, "device"),
        Part::Elbow => same(ONLY, "elbow") && same(T::NAME, "f32"),
    }
}

const fn same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    if a.len() != b.len() {
        return false;
    }
    let mut i = 0;
    while i < a.len() {
        if a[i] != b[i] {
            return false;
        }
        i += 1;
    }
    true
}
