//! The identification model Y = D X of one pose (Eq. 10-13, Appendix), in the closed form.

use super::normal_equations::NormalEquations;
use crate::kinematics::hinge::{BaseEdges, HingeCoordinates};
use crate::kinematics::tetrahedron::{Apex, TetrahedronBase};
use crate::rig::{EDGE_ENDS, POINTS, Parameters};
use crate::scalar::Real;

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
    /// D, 3x6: change of the computed p12, p23, p31 with x, y, z, p1, p2, p3 (dimensionless).
    pub rows: [[T; 6]; POINTS],
}

/// The tetrahedron of an end-point does not close: no point has its two cable lengths and its distance from the
/// estimated centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotClosing {
    /// End-point, 1 to 3.
    pub end_point: u8,
}

impl<T: Real> Model<T> {
    /// The model at `parameters`, for a platform with edges `edges_mm` (p12, p23, p31).
    pub fn new(base: &BaseEdges<T>, edges_mm: &[T; POINTS], parameters: &Parameters<T>) -> Self {
        let base = base.as_array();
        let tetrahedra =
            core::array::from_fn(|i| TetrahedronBase::new(&base[i], &parameters.centre_mm, parameters.radii_mm[i]));
        Self { tetrahedra, edges_mm: *edges_mm }
    }

    /// The end-points OP_1..OP_3 of a pose and their differentials (Eq. 1-9).
    ///
    /// # Errors
    /// The first end-point whose tetrahedron does not close.
    pub fn apices(&self, hinges: &[HingeCoordinates<T>; POINTS]) -> Result<[Apex<T>; POINTS], NotClosing> {
        let close = |i: usize| self.tetrahedra[i].apex(&hinges[i]).ok_or(NotClosing { end_point: i as u8 + 1 });
        Ok([close(0)?, close(1)?, close(2)?])
    }

    /// Y and D of a pose.
    ///
    /// The row of edge (i, j) with unit vector e is
    /// e · [a3_i (OP_i·δO + p_i δp_i) - a3_j (OP_j·δO + p_j δp_j)], which equals the Appendix's (1/p) C A⁻¹ B.
    ///
    /// # Errors
    /// As for [`Model::apices`].
    pub fn equations(
        &self,
        hinges: &[HingeCoordinates<T>; POINTS],
        radii_mm: &[T; POINTS],
    ) -> Result<PoseEquations<T>, NotClosing> {
        let apices = self.apices(hinges)?;
        let mut residuals_mm = [T::zero(); POINTS];
        let mut rows = [[T::zero(); 6]; POINTS];
        for (edge, &[i, j]) in EDGE_ENDS.iter().enumerate() {
            let (from, to) = (&apices[i], &apices[j]);
            let span = from.point_mm - to.point_mm;
            let computed = span.norm_squared().root();
            let direction = span / computed;
            residuals_mm[edge] = self.edges_mm[edge] - computed;
            let (turn_i, turn_j) = (direction.dot(&from.gradient), -direction.dot(&to.gradient));
            let centre = from.point_mm * turn_i + to.point_mm * turn_j;
            let row = &mut rows[edge];
            (row[0], row[1], row[2]) = (centre.x, centre.y, centre.z);
            row[3 + i] = turn_i * radii_mm[i];
            row[3 + j] = turn_j * radii_mm[j];
        }
        Ok(PoseEquations { residuals_mm, rows })
    }
}

impl<T: Real> PoseEquations<T> {
    /// Adds the three equations to the normal equations.
    #[inline]
    pub fn add_to(&self, equations: &mut NormalEquations<T>) {
        for (row, residual) in self.rows.iter().zip(&self.residuals_mm) {
            equations.add(row, *residual);
        }
    }
}
