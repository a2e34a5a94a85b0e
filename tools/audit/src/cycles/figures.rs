//! The figures of a path.

/// A path in one precision, as the emulator counted it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Path {
    /// Its name in the speed image.
    pub name: String,
    /// `f32` or `f64`.
    pub precision: String,
    /// How often it was counted: once for a whole run, else once a pose or a slice.
    pub counts: u64,
    /// Instructions of all counts together.
    pub instructions: u64,
    /// Instructions of the longest count.
    pub worst: u64,
    /// Static memory beside the pose buffer, bytes.
    pub state_bytes: u64,
    /// Depth of its stack, bytes.
    pub stack_bytes: u64,
    /// Least-squares steps of a whole run, else 0.
    pub steps: u64,
    /// Distance of the identified centre from the true one, nm; 0 when it identifies none.
    pub error_nm: u64,
}

/// Poses of the problem.
pub const POSES: u64 = 100;

/// The paper written out the long way: what every other run is compared with.
pub const LITERAL: &str = "literal";

/// The same compiled for speed instead of size.
pub const LITERAL_FOR_SPEED: &str = "literal-opt-3";

impl Path {
    /// A run from beginning to end, in one count.
    pub fn is_whole(&self) -> bool {
        self.counts == 1
    }
}
