//! Which paths the image holds. What is left out is not linked, so the sizes of two images differ by what a path
//! takes.

use super::measure::Number;

/// `none`, `paper-f32`, `full-f32`, `paper-f64`, `full-f64`; not set: everything, with the literal form and the device.
const ONLY: Option<&str> = option_env!("GLENOID_SPEED_ONLY");

/// A group of paths that is held together.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The paper's iteration.
    Paper,
    /// Everything else that the identification offers.
    Full,
    /// What only the whole image holds.
    Comparison,
}

/// Is this part in the image, in this precision?
pub const fn holds<T: Number>(part: Part) -> bool {
    let Some(only) = ONLY else { return true };
    let words = match part {
        Part::Paper => [T::PAPER, T::FULL],
        Part::Full => [T::FULL, T::FULL],
        Part::Comparison => return false,
    };
    same(only, words[0]) || same(only, words[1])
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
