//! Inverse kinematics of the 3-3 machine: a rotation of the arm to six cable lengths.

use crate::rig::{ATTACHMENTS, CABLES, POINTS, Rig};
use crate::scalar::Real;
use nalgebra::{Rotation3, Vector3};

/// The six cable lengths L1..L6, mm, at a rotation of the arm (Eq. 2, 3, 5, 6, 8, 9).
///
/// * `centre_mm`: joint centre O in {B}.
/// * `end_points_mm`: OP_1..OP_3 at home (rotation identity), relative to O, mm.
/// * `rotation`: R_OP, from home.
pub fn cable_lengths<T: Real>(
    rig: &Rig<T>,
    centre_mm: &Vector3<T>,
    end_points_mm: &[Vector3<T>; POINTS],
    rotation: &Rotation3<T>,
) -> [T; CABLES] {
    let base = rig.base_mm();
    let turned = end_points_mm.map(|p| centre_mm + rotation * p);
    core::array::from_fn(|cable| {
        let (point, end) = (cable / 2, cable % 2);
        (turned[point] - base[ATTACHMENTS[point][end]]).norm_squared().root()
    })
}
