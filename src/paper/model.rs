//! The identification model Y = D X of one pose (Eq. 10-13, Appendix), in the closed form.
//!
//! An end-point reacts to the six unknowns by one number only, q_i = OP_i·δO + p_i δp_i: it turns about its base edge
//! by a3_i q_i, and the rest of its motion is common to all three end-points. So the row of edge (i, j) with unit
//! vector e is `(e·a3_i) q_i - (e·a3_j) q_j`, which equals the Appendix's (1/p) C A⁻¹ B, and a pose's D is the 3x3
//! **edge Jacobian** K with two entries a row, times the 3x6 matrix W whose rows are the q_i. D itself is never formed
//! to solve (see `pass_sum`).

use super::tetrahedron::{Foot, TetrahedronBase};
use crate::kinematics::base_edges::{BaseEdges, HingeCoordinates};
use crate::kinematics::{CableLengths, LengthError};
use crate::rig::{EDGE_ENDS, POINTS, Parameters};
use crate::scalar::Real;
use nalgebra::Vector3;

/// The three tetrahedra at one estimate of the parameters; poses are evaluated against it one by one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model<T> {
    tetrahedra: [TetrahedronBase<T>; POINTS],
    edges_mm: [T; POINTS],
}

/// One pose evaluated with the model: Y, and what D is made from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EvaluatedPose<T> {
    /// Y: actual minus computed p12, p23, p31, mm.
    pub residuals_mm: [T; POINTS],
    /// OP_1..OP_3 in the axes of the base plane, mm.
    pub points_mm: [Vector3<T>; POINTS],
    feet: [Foot<T>; POINTS],
    heights_mm: [T; POINTS],
    spans_mm: [Vector3<T>; POINTS],
    computed_mm: [T; POINTS],
}

/// K of a pose: for each edge (i, j) its change with q_i and with q_j, 1/mm.
pub type EdgeJacobian<T> = [[T; 2]; POINTS];

/// The tetrahedron of an end-point does not close: no point has its two cable lengths and its distance from the
/// estimated centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotClosing {
    /// End-point, 1 to 3.
    pub end_point: u8,
}

/// Why a pose cannot be evaluated.
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
        let centre_mm = base.in_plane(&parameters.centre_mm);
        let edges = base.as_array();
        let tetrahedron = |i: usize| TetrahedronBase::new(&edges[i], &centre_mm, parameters.radii_mm[i]);
        Self { tetrahedra: [tetrahedron(0), tetrahedron(1), tetrahedron(2)], edges_mm: *edges_mm }
    }

    /// Moves the model of the same platform to other parameters.
    pub fn move_to(&mut self, base: &BaseEdges<T>, parameters: &Parameters<T>) {
        let centre_mm = base.in_plane(&parameters.centre_mm);
        for (i, tetrahedron) in self.tetrahedra.iter_mut().enumerate() {
            *tetrahedron = TetrahedronBase::new(&base.as_array()[i], &centre_mm, parameters.radii_mm[i]);
        }
    }

    /// Evaluates the pose with these cable lengths (Eq. 1-12).
    ///
    /// # Errors
    /// [`Contradiction`]; a broken triangle goes before a tetrahedron that does not close.
    pub fn evaluate(&self, base: &BaseEdges<T>, lengths: &CableLengths<T>) -> Result<EvaluatedPose<T>, Contradiction> {
        // No tetrahedron closes over a broken triangle, so the triangles are checked only when a tetrahedron does not
        // close.
        self.evaluate_hinges(&base.unchecked(lengths)).map_err(|error| contradiction(base, lengths, error))
    }

    fn evaluate_hinges(&self, hinges: &[HingeCoordinates<T>; POINTS]) -> Result<EvaluatedPose<T>, NotClosing> {
        let [t1, t2, t3] = &self.tetrahedra;
        let [q1, q2, q3] = hinges;
        let foot1 = t1.foot(q1).ok_or(NotClosing { end_point: 1 })?;
        let foot2 = t2.foot(q2).ok_or(NotClosing { end_point: 2 })?;
        let foot3 = t3.foot(q3).ok_or(NotClosing { end_point: 3 })?;
        let heights_mm @ [h1, h2, h3] =
            [foot1.height_squared_mm2.root(), foot2.height_squared_mm2.root(), foot3.height_squared_mm2.root()];
        let points_mm @ [p1, p2, p3] = [t1.apex(&foot1, h1), t2.apex(&foot2, h2), t3.apex(&foot3, h3)];
        let spans_mm @ [s1, s2, s3] = [p1 - p2, p2 - p3, p3 - p1];
        let computed_mm @ [c1, c2, c3] = [s1.norm_squared().root(), s2.norm_squared().root(), s3.norm_squared().root()];
        let [p12, p23, p31] = self.edges_mm;
        let residuals_mm = [p12 - c1, p23 - c2, p31 - c3];
        let feet = [foot1, foot2, foot3];
        Ok(EvaluatedPose { residuals_mm, points_mm, feet, heights_mm, spans_mm, computed_mm })
    }

    /// K of a pose evaluated with this model.
    pub fn edge_jacobian(&self, pose: &EvaluatedPose<T>) -> EdgeJacobian<T> {
        let (by_height, by_length) = (reciprocals(pose.heights_mm), reciprocals(pose.computed_mm));
        let [t1, t2, t3] = &self.tetrahedra;
        let [foot1, foot2, foot3] = &pose.feet;
        let [h1, h2, h3] = by_height;
        let [g1, g2, g3] = [t1.gradient(foot1, h1), t2.gradient(foot2, h2), t3.gradient(foot3, h3)];
        let [p12, p23, p31] = &pose.spans_mm;
        let [l1, l2, l3] = by_length;
        [
            [p12.dot(&g1) * l1, -(p12.dot(&g2) * l1)],
            [p23.dot(&g2) * l2, -(p23.dot(&g3) * l2)],
            [p31.dot(&g3) * l3, -(p31.dot(&g1) * l3)],
        ]
    }

    /// D of a pose, 3x6: change of the computed p12, p23, p31 with x, y, z, p1, p2, p3 (dimensionless), at the radii of
    /// the model. For reading; nothing here is solved with it.
    pub fn rows(&self, base: &BaseEdges<T>, radii_mm: &[T; POINTS], pose: &EvaluatedPose<T>) -> [[T; 6]; POINTS] {
        let mut rows = [[T::zero(); 6]; POINTS];
        for ((row, ends), turns) in rows.iter_mut().zip(EDGE_ENDS).zip(self.edge_jacobian(pose)) {
            for (end, turn) in ends.into_iter().zip(turns) {
                let centre = base.in_base(&pose.points_mm[end]) * turn;
                for axis in 0..3 {
                    row[axis] += centre[axis];
                }
                row[3 + end] = turn * radii_mm[end];
            }
        }
        rows
    }
}

impl<T: Real> EvaluatedPose<T> {
    /// Sum of the three squared residuals, mm².
    pub fn squares_mm2(&self) -> T {
        let [y1, y2, y3] = self.residuals_mm;
        y1 * y1 + y2 * y2 + y3 * y3
    }
}

fn reciprocals<T: Real>(of: [T; 3]) -> [T; 3] {
    of.map(|x| T::one() / x)
}

/// The cause behind a tetrahedron that does not close.
fn contradiction<T: Real>(base: &BaseEdges<T>, lengths: &CableLengths<T>, error: NotClosing) -> Contradiction {
    base.first_broken(lengths).map_or(Contradiction::NotClosing(error), Contradiction::Length)
}
