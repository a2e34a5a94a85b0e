//! How exact an identification can be expected to be, from what is known of the wearer and nothing that the board says.
//!
//! This is the Cramér-Rao bound, written here from the geometry alone. With O the joint centre in {B}, C the joint
//! centre seen from the platform, R the arm's rotation and u the unit vector along a cable from B to P_i,
//!
//! ```text
//! L = |R (P_i - C) + O - B|,   dL/dO = u,   dL/dC = -Rᵀu,   dL/dφ = R (P_i - C) × u
//! ```
//!
//! where φ, a small turn of the arm, is unknown anew in each pose and is eliminated there (Schur complement).

use crate::wearer::FittedArm;
use glenoid::rig::{ATTACHMENTS, CABLES, Rig};
use nalgebra::{Matrix3, Rotation3, SMatrix, Vector3};

/// Standard deviation of one cable length, mm: uniform noise within ±`noise_mm`, and rounding to whole counts.
pub fn length_sigma_mm(noise_mm: f64, mm_per_count: f64) -> f64 {
    // A uniform distribution of full width w has the standard deviation w / sqrt(12).
    (2.0 * noise_mm).hypot(mm_per_count) / 12f64.sqrt()
}

/// Smallest standard deviations of x, y, z, p1, p2, p3, mm, that any unbiased identification from these poses can have
/// when each length has a standard deviation of `length_sigma_mm`. None when the poses do not determine the centre.
pub fn sigma_mm(rig: &Rig<f64>, arm: &FittedArm, poses: &[Rotation3<f64>], length_sigma_mm: f64) -> Option<[f64; 6]> {
    let information: SMatrix<f64, 12, 12> = poses.iter().map(|rotation| pose_information(rig, arm, rotation)).sum();
    // Of O and C, in mm² for lengths with a standard deviation of 1 mm.
    let covariance = information.fixed_view::<6, 6>(0, 0).into_owned().cholesky()?.inverse();
    Some(parameters(arm, &covariance).map(|sigma| sigma * length_sigma_mm))
}

/// The same, and that of each encoder's zero, when every zero is drawn anew with a standard deviation of
/// `zero_prior_mm`, which the identification knows.
pub fn sigma_with_zeros_mm(
    rig: &Rig<f64>,
    arm: &FittedArm,
    poses: &[Rotation3<f64>],
    length_sigma_mm: f64,
    zero_prior_mm: f64,
) -> Option<([f64; 6], [f64; CABLES])> {
    let mut information: SMatrix<f64, 12, 12> = poses.iter().map(|rotation| pose_information(rig, arm, rotation)).sum();
    for zero in 6..12 {
        information[(zero, zero)] += (length_sigma_mm / zero_prior_mm).powi(2);
    }
    let covariance = information.cholesky()?.inverse();
    let of_parameters = parameters(arm, &covariance.fixed_view::<6, 6>(0, 0).into_owned());
    let of_zeros = std::array::from_fn(|k| covariance[(6 + k, 6 + k)].sqrt());
    Some((of_parameters.map(|sigma| sigma * length_sigma_mm), of_zeros.map(|sigma: f64| sigma * length_sigma_mm)))
}

/// Standard deviations of x, y, z, p1, p2, p3 from the covariance of O and C.
fn parameters(arm: &FittedArm, covariance: &SMatrix<f64, 6, 6>) -> [f64; 6] {
    // p_i = |P_i - C|: only the part of C counts.
    let of_c = covariance.fixed_view::<3, 3>(3, 3).into_owned();
    let of_radius = |end: &Vector3<f64>| {
        let direction = end.normalize();
        (direction.transpose() * of_c * direction).x
    };
    let [p1, p2, p3] = arm.end_points_mm().map(|end| of_radius(&end));
    let variances = [covariance[(0, 0)], covariance[(1, 1)], covariance[(2, 2)], p1, p2, p3];
    variances.map(f64::sqrt)
}

/// What the six lengths of one pose tell about O, C and the six zeros when the pose's own rotation is unknown, 1/mm² for lengths with
/// a standard deviation of 1 mm.
fn pose_information(rig: &Rig<f64>, arm: &FittedArm, rotation: &Rotation3<f64>) -> SMatrix<f64, 12, 12> {
    let mut of_all = SMatrix::<f64, 12, 12>::zeros();
    let mut mixed = SMatrix::<f64, 12, 3>::zeros();
    let mut of_turn = Matrix3::zeros();
    for cable in 0..CABLES {
        let (point, end) = (cable / 2, cable % 2);
        let lever = rotation * arm.end_points_mm()[point];
        let along = (arm.centre_mm() + lever - rig.base_mm()[ATTACHMENTS[point][end]]).normalize();
        let seen_from_arm = -(rotation.inverse() * along);
        let zero = (0..CABLES).map(|k| if k == cable { 1.0 } else { 0.0 });
        let by_all =
            SMatrix::<f64, 12, 1>::from_iterator(along.iter().chain(seen_from_arm.iter()).copied().chain(zero));
        let by_turn = lever.cross(&along);
        of_all += by_all * by_all.transpose();
        mixed += by_all * by_turn.transpose();
        of_turn += by_turn * by_turn.transpose();
    }
    match of_turn.try_inverse() {
        Some(inverse) => of_all - mixed * inverse * mixed.transpose(),
        // A pose whose turn the lengths do not show tells nothing that could be relied on.
        None => SMatrix::zeros(),
    }
}
