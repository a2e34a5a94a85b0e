//! Which paths the image holds. What is left out is not linked, so the sizes of two images differ by what a path
//! takes.

use super::measure::Number;

/// `none`, `literal`, and for each precision `paper-f32`, `free-f32`, `machine-f32`, `full-f32`; not set: everything.
const ONLY: Option<&str> = option_env!("GLENOID_SPEED_ONLY");

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
}

/// Is the image there to be weighed? Its paths are called once then: what counting and preparing take is no part of them.
pub const WEIGHED: bool = match ONLY {
    Some(only) => !same(only, "literal"),
    None => false,
};

/// Is this part in the image, in this precision?
pub const fn holds<T: Number>(part: Part) -> bool {
    let Some(only) = ONLY else { return true };
    match part {
        Part::Literal => same(only, "literal"),
        Part::Paper => same(only, T::PAPER) || same(only, T::FULL),
        Part::Free => same(only, T::FREE) || same(only, T::FULL),
        Part::Machine => same(only, T::MACHINE) || same(only, T::FULL),
        Part::Samples => same(only, T::FREE) || same(only, T::MACHINE) || same(only, T::FULL),
        Part::InUse => same(only, T::FULL),
        Part::Device => false,
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
