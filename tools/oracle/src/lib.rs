//! The paper written out the long way: the oracle that the library is tested against.
//!
//! Nothing here is clever and nothing is shared with the library. The apex of a tetrahedron is found in explicit
//! local coordinates, `D` is built from the Appendix's `A_i`, its inverse, `B_i` and `C_i`, all `3m` rows are stacked
//! in memory, and the step is the pseudo-inverse with an explicit 6x6 inverse. A mistake in the library's closed
//! form would have to be made here a second time, in other words, to go unnoticed.
//!
//! It needs `core` and nalgebra's fixed-size types only: the stack lives in slices that the caller supplies, so that a
//! firmware image can hold it and it can be measured against the library.
//!
//! # Frames
//! Base points are given in {B}. Everything else is relative to the joint centre O, which is the origin of {O}:
//! the base point seen from O is `b - (x, y, z)`, and the cable at end-point P is the vector
//! `OP - (b - (x, y, z)) = (x, y, z) - b + OP`, which is how the Appendix writes it. {O} is only translated against
//! {B}, so no vector changes its components between the two.
//!
//! # Indices
//! Poses count from 0, end-points and edges from 0 in code and from 1 in the paper. End-point `i` hangs on base points
//! `i` and `i + 1` (modulo 3) by the cables `2i` and `2i + 1`; edge `k` joins the end-points `k` and `k + 1` (modulo 3).
#![no_std]

mod iteration;
mod model;
mod solve;
mod tetrahedron;

use nalgebra::{RealField, Vector3};

pub use iteration::{Ending, Outcome, Workspace, identify};
pub use model::{PoseModel, pose_model, root_mean_square};
pub use solve::{invert_6x6, least_squares};
pub use tetrahedron::apex;

/// What the paper takes as known and free of error: where the cables leave the base, and the platform's edges.
#[derive(Clone, Copy, Debug)]
pub struct Machine<T: RealField + Copy> {
    /// `BB_1`, `BB_2`, `BB_3` in {B}, in mm.
    pub base_mm: [Vector3<T>; 3],
    /// The true distances `p12`, `p23`, `p31` between the end-points, in mm.
    pub edges_mm: [T; 3],
}

/// The six unknowns of Eq. 13, in the paper's order.
#[derive(Clone, Copy, Debug)]
pub struct Estimate<T: RealField + Copy> {
    /// `BO = (x, y, z)` in {B}, in mm.
    pub centre_mm: Vector3<T>,
    /// `p1`, `p2`, `p3`: the distances of the end-points from the centre, in mm.
    pub radii_mm: [T; 3],
}

/// The six cable lengths `L1` to `L6` of one pose, in mm.
pub type Lengths<T> = [T; 6];

/// Why the calculation could not go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The three lengths at an end-point do not close to a tetrahedron over the estimated centre (Eq. 1-9 have no
    /// real solution).
    DoesNotClose {
        /// The pose, from 0.
        pose: usize,
        /// The end-point, from 0.
        end_point: usize,
    },
    /// The apex lies in the plane of O and its two base points: `A_i` has no inverse there.
    FlatTetrahedron {
        /// The pose, from 0.
        pose: usize,
        /// The end-point, from 0.
        end_point: usize,
    },
    /// The poses do not determine all six unknowns: `DᵀD` has no inverse.
    SingularNormalMatrix,
    /// A slice of the caller is shorter than the number of poses or of iterations needs.
    TooLittleRoom,
}
