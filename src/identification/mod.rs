//! Finding the joint centre from the cable lengths of a set of poses: pure functions of numbers.
//!
//! * [`solver`]: the way that the device goes. No start estimate, an error bar, refusal of what cannot be known.
//! * [`survey`]: the error bar foretold, pose by pose.
//! * [`paper`]: the iteration of the paper's Fig. 4, from a start estimate.
//! * [`zeros`]: unknown encoder zeros as six more unknowns.
//! * [`verification`]: the deviation over a second set of poses that was never used to identify.

pub mod blocks;
pub mod model;
pub mod normal_equations;
pub mod observability;
pub mod outcome;
pub mod paper;
mod pass_sum;
pub mod pivot_fit;
pub mod pose_buffer;
pub mod pose_information;
pub mod solver;
pub mod survey;
pub mod uncertainty;
pub mod verification;
pub mod zeros;

pub use outcome::Rejected;
pub use outcome::{Identified, Progress, Refusal, Termination};
pub use paper::{PaperIteration, PaperSettings};
pub use pose_buffer::{DEFAULT_CAPACITY, Full, PoseBuffer};
pub use solver::{Noise, Solver, SolverSettings};
pub use survey::{Foretold, Survey};
pub use verification::verify;
