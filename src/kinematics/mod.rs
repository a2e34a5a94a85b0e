//! Geometry of the 3-3 cable arrangement: counts to lengths, lengths to points, rotations to lengths.
//!
//! Two ways lead from cable lengths to the end-points. The [`tetrahedron`] of the paper needs the joint centre; the
//! [`octahedron`](mod@octahedron) needs only the platform's edges. Both turn an end-point about its base edge, the [`hinge`].

pub mod arm;
pub mod cable_length;
pub mod hinge;
pub mod inverse;
pub mod octahedron;
pub mod pivot;
mod spheres;
pub mod tetrahedron;

pub use cable_length::{CableLengths, CountExtender, LengthError, LengthFault};
pub use hinge::{BaseEdges, HingeCoordinates};
pub use octahedron::{Octahedron, OctahedronError, PlatformPose};
pub use pivot::{LengthEquations, Pivot, RigPoints};
