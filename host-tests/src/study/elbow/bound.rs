//! The Cramér-Rao bound of a hinge, computed without the library's model: central differences of the lengths, and the
//! whole information matrix of the nine unknowns and every pose's angle, inverted at once.

use super::scene::{NOISE_SIGMA_MM, across};
use glenoid::identification::hinge::{HINGE_UNKNOWNS, Hinge};
use glenoid::rig::CableEnds;
use nalgebra::{DMatrix, Rotation3, SMatrix, Unit, Vector3};

/// Steps of the central differences: angles (rad) and places (mm).
const TURN: f64 = 1e-5;
const MOVE_MM: f64 = 1e-3;

/// Nine numbers about a hinge, in the order and the tangent directions of the library's unknowns.
struct Moved<'a> {
    about: &'a Hinge<f64>,
    by: [f64; HINGE_UNKNOWNS],
}

impl Moved<'_> {
    /// Where a platform point stands at an angle. The axes are moved and normalised, the foot points moved and made
    /// perpendicular again, and the platform turned the smallest way from the one axis to the other.
    fn at_mm(&self, point_mm: &Vector3<f64>, angle_rad: f64) -> Vector3<f64> {
        let x = &self.by;
        let (a0, d0) = (self.about.axis(), self.about.axis_in_platform());
        let ([e1, e2], [f1, f2]) = (across(a0), across(&d0));
        let a = (a0 + e1 * x[0] + e2 * x[1]).normalize();
        let d = (d0 + f1 * x[4] + f2 * x[5]).normalize();
        let c = self.about.foot_mm() + e1 * x[2] + e2 * x[3];
        let q = self.about.foot_in_platform_mm() + f1 * x[6] + f2 * x[7];
        let (c, q) = (c - a * a.dot(&c), q - d * d.dot(&q));
        let half_turn = || Rotation3::from_axis_angle(&Unit::new_normalize(across(&d)[0]), std::f64::consts::PI);
        let align = Rotation3::rotation_between(&d, &a).unwrap_or_else(half_turn);
        let turn = Rotation3::from_axis_angle(&Unit::new_normalize(a), angle_rad);
        c + a * (self.about.along_mm() + x[8]) + turn * (align * (point_mm - q))
    }
}

/// Smallest covariance that an unbiased estimate of the hinge can have from these angles with every cable's length known
/// to the noise; `prior`: 1σ that each unknown is known to beforehand. `None` where they do not determine it.
pub fn bound(
    hinge: &Hinge<f64>,
    cables: &[CableEnds<f64>],
    angles_rad: &[f64],
    prior: Option<&[f64; HINGE_UNKNOWNS]>,
) -> Option<SMatrix<f64, HINGE_UNKNOWNS, HINGE_UNKNOWNS>> {
    let mut information = information(hinge, cables, angles_rad);
    for (k, sigma) in prior.into_iter().flatten().enumerate() {
        information[(k, k)] += 1.0 / (sigma * sigma);
    }
    let inverse = information.cholesky()?.inverse();
    Some(inverse.fixed_view::<HINGE_UNKNOWNS, HINGE_UNKNOWNS>(0, 0).into())
}

/// Fisher information on the nine unknowns and all angles.
pub fn information(hinge: &Hinge<f64>, cables: &[CableEnds<f64>], angles_rad: &[f64]) -> DMatrix<f64> {
    let (rows, columns) = (cables.len() * angles_rad.len(), HINGE_UNKNOWNS + angles_rad.len());
    let mut jacobian = DMatrix::zeros(rows, columns);
    let length = |by: [f64; HINGE_UNKNOWNS], cable: &CableEnds<f64>, angle: f64| {
        (Moved { about: hinge, by }.at_mm(&cable.end_mm, angle) - cable.base_mm).norm()
    };
    for (pose, angle) in angles_rad.iter().enumerate() {
        for (k, cable) in cables.iter().enumerate() {
            let row = pose * cables.len() + k;
            for unknown in 0..HINGE_UNKNOWNS {
                let step = if matches!(unknown, 0 | 1 | 4 | 5) { TURN } else { MOVE_MM };
                let moved = |sign: f64| {
                    let mut by = [0.0; HINGE_UNKNOWNS];
                    by[unknown] = sign * step;
                    length(by, cable, *angle)
                };
                jacobian[(row, unknown)] = (moved(1.0) - moved(-1.0)) / (2.0 * step);
            }
            let none = [0.0; HINGE_UNKNOWNS];
            let turned = length(none, cable, angle + TURN) - length(none, cable, angle - TURN);
            jacobian[(row, HINGE_UNKNOWNS + pose)] = turned / (2.0 * TURN);
        }
    }
    jacobian.transpose() * jacobian / (NOISE_SIGMA_MM * NOISE_SIGMA_MM)
}
