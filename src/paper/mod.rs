//! The paper's own identification, whole: the tetrahedra of Fig. 3 ([`tetrahedron`]), the model Y = D X of Eq. 13 and
//! the Appendix ([`model`]), the iteration of Fig. 4 from a start estimate ([`iteration`]), and step 4 of its
//! procedure, the verification on a second set ([`verification`]).
//!
//! For comparison only: it needs a start, and its error is larger. The drive board uses the
//! [`estimator`](crate::identification::estimator).

pub mod iteration;
pub mod model;
mod pass_sum;
pub mod tetrahedron;
pub mod verification;

pub use iteration::{PaperIteration, PaperSettings};
pub use verification::verify;

use crate::linear_algebra::NormalEquations;

/// The normal equations of the paper's six unknowns x, y, z, p1, p2, p3 (Eq. 15).
pub type SixUnknowns<T> = NormalEquations<T, 6, 21>;
