//! Finding the joint centre from the cable lengths of a set of poses: pure functions of numbers.
//!
//! * [`estimator`]: what the device runs. It needs no start and gives a standard deviation or a named refusal.
//! * [`predicted_accuracy`]: the standard deviation that the poses captured so far would give.
//! * [`machine`], [`joint`]: the unknowns beside the joint centre.
//! * [`hinge`]: the elbow, a joint model of its own. [`arm`]: shoulder, elbow and wrist as one chain.
//!
//! `docs/method.md` follows the method from six lengths to a standard deviation, with references. The paper's own
//! iteration stands in [`paper`](crate::paper).

pub mod arm;
pub mod carried_point;
pub mod estimator;
pub mod excitation;
pub mod fault_isolation;
pub mod gates;
pub mod hinge;
pub mod joint;
pub mod leave_one_out;
pub mod machine;
pub mod marginal_information;
pub mod noise;
pub mod outcome;
pub mod parameters;
pub mod pivot_calibration;
pub mod pose;
pub mod pose_buffer;
pub mod pose_in_work;
pub mod predicted_accuracy;
pub mod refusal;
pub mod settings;
pub mod statistics;
pub mod uncertainty;
pub mod verification;
pub mod weights;

pub use estimator::Estimator;
pub use machine::Machine;
pub use outcome::{Identified, Progress, Rejected, Termination};
pub use pose::{Pose, PoseState};
pub use pose_buffer::{DEFAULT_CAPACITY, Full, PoseBuffer};
pub use predicted_accuracy::{Predicted, PredictedAccuracy, Prediction};
pub use refusal::Refusal;
pub use settings::{EstimatorSettings, JointChoice, Noise};
