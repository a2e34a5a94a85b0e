//! Finding the joint centre from the cable lengths of a set of poses: pure functions of numbers.
//!
//! * [`paper`]: the iteration of the paper's Fig. 4, from a start estimate.
//! * [`verification`]: the deviation over a second set of poses that was never used to identify.

pub mod model;
pub mod normal_equations;
pub mod outcome;
pub mod paper;
pub mod pose_buffer;
pub mod verification;

pub use outcome::{Identified, Progress, Refusal, Termination};
pub use paper::{PaperIteration, PaperSettings};
pub use pose_buffer::{DEFAULT_CAPACITY, Full, PoseBuffer};
pub use verification::verify;
