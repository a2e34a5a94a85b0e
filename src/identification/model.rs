//! The identification model Y = D X of one pose (Eq. 10-13, Appendix), in the closed form.
//!
//! An end-point reacts to the six unknowns by one number only, q_i = OP_i·δO + p_i δp_i: it turns about its base edge
//! by a3_i q_i, and the rest of its motion is common to all three end-points. So the row of edge (i, j) with unit
//! vector e is `(e·a3_i) q_i - (e·a3_j) q_j`, which equals the Appendix's (1/p) C A⁻¹ B, and a pose's D is a 3x3 matrix
//! of **turns** K with two entries a row, times the 3x6 matrix W whose rows are the q_i. D itself is never formed to
//! solve (see [`pass_sum`](super::pass_sum)).

use crate::kinematics::hinge::{BaseEdges, HingeCoordinates};
use crate::kinematics::tetrahedron::{Apex, TetrahedronBase};
use crate::kinematics::{CableLengths, LengthError};
use crate::rig::{EDGE_ENDS, POINTS, Parameters};
use crate::scalar::Real;
use nalgebra::Vector3;

/// The three tetrahedra at one estimate of the parameters; poses are laid against it one by one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model<T> {
    tetrahedra: [TetrahedronBase<T>; POINTS],
    edges_mm: [T; POINTS],
}

/// One pose laid against the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseEquations<T> {
    /// Y: actual minus computed p12, p23, p31, mm.
    pub residuals_mm: [T; POINTS],
    /// OP_1..OP_3 in the axes of the base plane, mm.
    pub points_mm: [Vector3<T>; POINTS],
    /// K: for each edge (i, j) its change with q_i and with q_j, 1/mm.
    pub turns: [[T; 2]; POINTS],
}

/// The tetrahedron of an end-point does not close: no point has its two cable lengths and its distance from the
/// estimated centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotClosing {
    /// End-point, 1 to 3.
    pub end_point: u8,
}

/// Why a pose cannot be laid against the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contradiction {
    /// Whatever the parameters: a cable triangle is broken.
    Length(LengthError),
    /// At these parameters.
    NotClosing(NotClosing),
}

impl<T: Real> Model<T> {
    /// The model at `parameters`, for a platform with edges `edges_mm` (p12, p23, p31).
    pub fn new(base: &BaseEdges<T>, edges_mm: &[T; POINTS], parameters: &Parameters<T>) -> Self {
        let base = base.as_array();
        let tetrahedra =
            core::array::from_fn(|i| TetrahedronBase::new(&base[i], &parameters.centre_mm, parameters.radii_mm[i]));
        Self { tetrahedra, edges_mm: *edges_mm }
    }

    /// Y and D of the pose with these cable lengths.
    ///
    /// # Errors
    /// [`Contradiction`]; a broken triangle goes before a tetrahedron that does not close.
    #[inline(always)]
    pub fn pose(&self, base: &BaseEdges<T>, lengths: &CableLengths<T>) -> Result<PoseEquations<T>, Contradiction> {
        // No tetrahedron closes over a broken triangle: the triangles need no look of their own until one does not.
        self.equations(&base.unchecked(lengths)).map_err(|error| contradiction(base, lengths, error))
    }

    /// The end-points OP_1..OP_3 of a pose (Eq. 1-9).
    ///
    /// # Errors
    /// The first end-point whose tetrahedron does not close.
    #[inline(always)]
    fn apices(&self, hinges: &[HingeCoordinates<T>; POINTS]) -> Result<[Apex<T>; POINTS], NotClosing> {
        let close = |i: usize| self.tetrahedra[i].apex(&hinges[i]).ok_or(NotClosing { end_point: i as u8 + 1 });
        Ok([close(0)?, close(1)?, close(2)?])
    }

    /// Y and D of a pose by its hinge coordinates.
    ///
    /// # Errors
    /// The first end-point whose tetrahedron does not close.
    #[inline(always)]
    pub fn equations(&self, hinges: &[HingeCoordinates<T>; POINTS]) -> Result<PoseEquations<T>, NotClosing> {
        let apices = self.apices(hinges)?;
        let points_mm = [apices[0].point_mm, apices[1].point_mm, apices[2].point_mm];
        let spans = [points_mm[0] - points_mm[1], points_mm[1] - points_mm[2], points_mm[2] - points_mm[0]];
        let computed = [spans[0].norm_squared().root(), spans[1].norm_squared().root(), spans[2].norm_squared().root()];
        let (by_height, by_length) = reciprocals(
            [apices[0].height_mm, apices[1].height_mm, apices[2].height_mm],
            computed,
        );
        let gradient = |i: usize| self.tetrahedra[i].gradient(&apices[i], by_height[i]);
        let gradients = [gradient(0), gradient(1), gradient(2)];
        let turns = |edge: usize| {
            let [i, j] = EDGE_ENDS[edge];
            let along = |end: usize| spans[edge].dot(&gradients[end]) * by_length[edge];
            [along(i), -along(j)]
        };
        let residual = |edge: usize| self.edges_mm[edge] - computed[edge];
        Ok(PoseEquations {
            residuals_mm: [residual(0), residual(1), residual(2)],
            points_mm,
            turns: [turns(0), turns(1), turns(2)],
        })
    }
}

impl<T: Real> PoseEquations<T> {
    /// D, 3x6: change of the computed p12, p23, p31 with x, y, z, p1, p2, p3 (dimensionless), at the radii of the
    /// model. For reading; nothing here is solved with it.
    pub fn rows(&self, base: &BaseEdges<T>, radii_mm: &[T; POINTS]) -> [[T; 6]; POINTS] {
        let mut rows = [[T::zero(); 6]; POINTS];
        for (edge, ends) in EDGE_ENDS.iter().enumerate() {
            for (end, turn) in ends.iter().zip(self.turns[edge]) {
                let centre = base.plane().tr_mul(&self.points_mm[*end]) * turn;
                for axis in 0..3 {
                    rows[edge][axis] += centre[axis];
                }
                rows[edge][3 + end] = turn * radii_mm[*end];
            }
        }
        rows
    }
}

/// The reciprocals of three heights and three lengths by one division (14 cycles on a Cortex-M4F) instead of six.
#[inline(always)]
fn reciprocals<T: Real>([h1, h2, h3]: [T; 3], [l1, l2, l3]: [T; 3]) -> ([T; 3], [T; 3]) {
    let (h12, l12) = (h1 * h2, l1 * l2);
    let (heights, lengths) = (h12 * h3, l12 * l3);
    let inverse = T::one() / (heights * lengths);
    let (by_heights, by_lengths) = (inverse * lengths, inverse * heights);
    let (by_h12, by_l12) = (by_heights * h3, by_lengths * l3);
    ([by_h12 * h2, by_h12 * h1, by_heights * h12], [by_l12 * l2, by_l12 * l1, by_lengths * l12])
}

/// The cause behind a tetrahedron that does not close.
#[cold]
#[inline(never)]
fn contradiction<T: Real>(base: &BaseEdges<T>, lengths: &CableLengths<T>, error: NotClosing) -> Contradiction {
    match base.coordinates(lengths) {
        Err(length) => Contradiction::Length(length),
        Ok(_) => Contradiction::NotClosing(error),
    }
}
