//! Maximum likelihood the long way: one big dense least-squares problem over the centre in both bodies and every
//! pose's rotation, derivatives by differences, solved and inverted by nalgebra. It shares no formula with the library:
//! the platform is given as the end-points at home, in axes of its own.

use super::{Worn, parameters};
use host_tests::literal::{Estimate, Lengths};
use nalgebra::{DMatrix, DVector, Matrix6, Rotation3, SMatrix, Vector3, Vector6};

/// One end of each cable: end-point and base point (Eq. 2, 3, 5, 6, 8, 9).
const CABLES: [(usize, usize); 6] = [(0, 0), (0, 1), (1, 1), (1, 2), (2, 2), (2, 0)];

/// Step of the differences, mm or rad: the sixth-order formula is exact to rounding there.
const STEP: f64 = 1e-3;

/// All unknowns: the centre in {B}, the centre in the platform's axes, a rotation for each pose.
#[derive(Clone, Debug)]
pub struct Unknowns {
    /// O in {B}, mm.
    pub centre_mm: Vector3<f64>,
    /// The centre relative to its true place in the platform, in the platform's axes at home, mm.
    pub in_platform_mm: Vector3<f64>,
    /// Rotation of the platform from home, one for each pose.
    pub rotations: Vec<Rotation3<f64>>,
}

/// The solution with what is known of it.
pub struct Dense {
    /// Centre and radii, mm.
    pub estimate: Estimate<f64>,
    /// Covariance of x, y, z, p1, p2, p3 for a noise of 1 mm: the Cramér-Rao bound.
    pub covariance: Matrix6<f64>,
    /// Sum of the squared residuals, mm².
    pub squares_mm2: f64,
}

impl Unknowns {
    fn moved(&self, step: &DVector<f64>) -> Self {
        let part = |at: usize| Vector3::new(step[at], step[at + 1], step[at + 2]);
        let turned = |(pose, rotation): (usize, &Rotation3<f64>)| Rotation3::new(part(6 + 3 * pose)) * rotation;
        Self {
            centre_mm: self.centre_mm + part(0),
            in_platform_mm: self.in_platform_mm + part(3),
            rotations: self.rotations.iter().enumerate().map(turned).collect(),
        }
    }

    /// Centre and radii of a machine with this centre.
    pub fn estimate(&self, worn: &Worn) -> Estimate<f64> {
        Estimate { centre_mm: self.centre_mm, radii_mm: worn.home_mm.map(|point| (point - self.in_platform_mm).norm()) }
    }
}

/// The six lengths of a pose, mm.
pub fn lengths_mm(worn: &Worn, centre: &Vector3<f64>, in_platform: &Vector3<f64>, turn: &Rotation3<f64>) -> [f64; 6] {
    CABLES.map(|(end, base)| (centre + turn * (worn.home_mm[end] - in_platform) - worn.base_mm[base]).norm())
}

/// Derivative of a vector function at zero, by six-point central differences.
pub fn derivative<const ROWS: usize, const COLUMNS: usize>(
    of: impl Fn(&SMatrix<f64, COLUMNS, 1>) -> [f64; ROWS],
) -> SMatrix<f64, ROWS, COLUMNS> {
    let mut jacobian = SMatrix::zeros();
    for column in 0..COLUMNS {
        for (weight, offset) in [(45.0, 1.0), (-9.0, 2.0), (1.0, 3.0)] {
            let mut step = SMatrix::<f64, COLUMNS, 1>::zeros();
            step[column] = offset * STEP;
            let (ahead, behind) = (of(&step), of(&-step));
            for row in 0..ROWS {
                jacobian[(row, column)] += weight * (ahead[row] - behind[row]) / (60.0 * STEP);
            }
        }
    }
    jacobian
}

/// Residuals and Jacobian of the whole problem, rows pose by pose.
fn linearised(worn: &Worn, poses: &[Lengths<f64>], at: &Unknowns) -> (DVector<f64>, DMatrix<f64>) {
    let mut residuals = DVector::zeros(6 * poses.len());
    let mut jacobian = DMatrix::zeros(6 * poses.len(), 6 + 3 * poses.len());
    for (pose, (measured, rotation)) in poses.iter().zip(&at.rotations).enumerate() {
        let lengths = |step: &SMatrix<f64, 9, 1>| {
            let part = |from: usize| Vector3::new(step[from], step[from + 1], step[from + 2]);
            let turn = Rotation3::new(part(6)) * rotation;
            lengths_mm(worn, &(at.centre_mm + part(0)), &(at.in_platform_mm + part(3)), &turn)
        };
        let computed = lengths(&SMatrix::zeros());
        let rows = derivative::<6, 9>(lengths);
        for cable in 0..6 {
            residuals[6 * pose + cable] = measured[cable] - computed[cable];
        }
        jacobian.view_mut((6 * pose, 0), (6, 6)).copy_from(&rows.fixed_columns::<6>(0));
        jacobian.view_mut((6 * pose, 6 + 3 * pose), (6, 3)).copy_from(&rows.fixed_columns::<3>(6));
    }
    (residuals, jacobian)
}

/// Levenberg-Marquardt from `start` until no unknown moves by more than 1e-10.
pub fn maximum_likelihood(worn: &Worn, poses: &[Lengths<f64>], start: Unknowns) -> Dense {
    let mut at = start;
    let mut damping = 1e-3;
    let (mut residuals, mut jacobian) = linearised(worn, poses, &at);
    for _ in 0..200 {
        let normal = jacobian.transpose() * &jacobian;
        let damped = &normal + DMatrix::from_diagonal(&(normal.diagonal() * damping));
        let step = damped.cholesky().expect("a sound set").solve(&(jacobian.transpose() * &residuals));
        let trial = at.moved(&step);
        let (new_residuals, new_jacobian) = linearised(worn, poses, &trial);
        // At the bottom rounding decides; a step that small is taken either way.
        if new_residuals.norm_squared() <= residuals.norm_squared() || step.amax() < 1e-7 {
            (at, residuals, jacobian) = (trial, new_residuals, new_jacobian);
            damping *= 0.01;
            if step.amax() < 1e-10 {
                return finished(worn, at, &residuals, &jacobian);
            }
        } else {
            damping = (damping * 10.0).max(1e-9);
        }
    }
    panic!("the dense problem does not settle");
}

fn finished(worn: &Worn, at: Unknowns, residuals: &DVector<f64>, jacobian: &DMatrix<f64>) -> Dense {
    let fisher = jacobian.transpose() * jacobian;
    let inverse = fisher.cholesky().expect("a sound set").inverse();
    let of_pivot: Matrix6<f64> = inverse.fixed_view::<6, 6>(0, 0).into_owned();
    let parameters = derivative::<6, 6>(|step: &Vector6<f64>| {
        let moved = Unknowns {
            centre_mm: at.centre_mm + step.fixed_rows::<3>(0),
            in_platform_mm: at.in_platform_mm + step.fixed_rows::<3>(3),
            rotations: Vec::new(),
        };
        parameters(&moved.estimate(worn))
    });
    Dense {
        estimate: at.estimate(worn),
        covariance: parameters * of_pivot * parameters.transpose(),
        squares_mm2: residuals.norm_squared(),
    }
}
