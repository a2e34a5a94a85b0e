//! Geometry of the six cables: counts to lengths, lengths to the platform's pose, rotations to lengths.
//!
//! * [`cable_length`]: encoder counts to the six lengths of a pose.
//! * [`stewart_gough`]: the platform's whole pose from six lengths (forward kinematics of a 3-3 Stewart-Gough platform,
//!   from one constant start); [`general_platform`] finishes it where every cable has ends of its own.
//! * [`length_jacobian`]: how the lengths change with the joint centre and the platform's rotation.
//! * [`attitude`]: the platform's rotation from six lengths once the joint centre is known.

pub mod attitude;
pub mod base_edges;
pub mod cable_length;
pub mod general_platform;
pub mod geometry;
pub mod inverse;
pub mod length_jacobian;
pub mod rotation;
pub mod stewart_gough;
mod trilateration;

pub use attitude::{AttitudeFit, AttitudeSearch, AttitudeSolver, AttitudeTrack, CableSet};
pub use base_edges::{BaseEdges, HingeCoordinates};
pub use cable_length::{CableLengths, LengthError, LengthFault};
pub use general_platform::{PlatformSearch, PlatformSolver};
pub use geometry::Geometry;
pub use length_jacobian::{JointCentre, LengthJacobian, LengthRow};
pub use stewart_gough::{ForwardKinematics, PlatformError, PlatformPose};
