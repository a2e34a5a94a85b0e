//! The Cramér-Rao bound of the joint centre, from all six lengths of all poses, written out the long way.
//!
//! Unknown are the six parameters (x, y, z, p1, p2, p3), the six encoder zeros if nobody homed the machine, and three
//! rotations a pose. Every length contributes one row to
//! the Jacobian; noise of equal variance on every length makes the Fisher information JᵀJ / σ². Nothing is
//! shared with the library: derivatives are taken in {B}, with the platform's shape at home.

use super::scene::Scene;
use nalgebra::{Matrix3, Matrix6, Rotation3, SMatrix, SVector, Vector3};

/// The six parameters and the six encoder zeros.
const ALL: usize = 12;

/// End-point and attachment point of each cable, from 0: L1 = P1 B1, L2 = P1 B2, L3 = P2 B2, L4 = P2 B3, L5 = P3 B3,
/// L6 = P3 B1 (Eq. 2, 3, 5, 6, 8, 9).
const CABLES: [(usize, usize); 6] = [(0, 0), (0, 1), (1, 1), (1, 2), (2, 2), (2, 0)];

/// Smallest covariance that any unbiased estimate of (x, y, z, p1, p2, p3) can have, mm², with noise of standard
/// deviation `noise_mm` on every length. `None` when the poses do not determine the parameters.
pub fn bound(scene: &Scene, rotations: &[Rotation3<f64>], noise_mm: f64) -> Option<Matrix6<f64>> {
    let known: Matrix6<f64> = information(scene, rotations)?.fixed_view::<6, 6>(0, 0).into();
    Some(known.cholesky()?.inverse() * (noise_mm * noise_mm))
}

/// The same for (x, y, z, p1, p2, p3, z1, …, z6) when every length reads too much by a zero z of which nothing is known
/// (`prior_mm` is `None`), or which is drawn from a normal distribution of that standard deviation (the bound of van
/// Trees 1968, on the mean square over the draws).
pub fn bound_with_zeros(
    scene: &Scene,
    rotations: &[Rotation3<f64>],
    noise_mm: f64,
    prior_mm: Option<f64>,
) -> Option<SMatrix<f64, ALL, ALL>> {
    let mut information = information(scene, rotations)? / (noise_mm * noise_mm);
    if let Some(prior_mm) = prior_mm {
        for zero in 6..ALL {
            information[(zero, zero)] += 1.0 / (prior_mm * prior_mm);
        }
    }
    Some(information.cholesky()?.inverse())
}

/// Fisher information on the parameters and the zeros for noise of 1 mm, the rotations eliminated.
fn information(scene: &Scene, rotations: &[Rotation3<f64>]) -> Option<SMatrix<f64, ALL, ALL>> {
    let shape = shape_by_radii(scene)?;
    let mut information = SMatrix::zeros();
    for rotation in rotations {
        // The rows of this pose: [global | its own rotation]; then its rotation is eliminated (Schur complement).
        let mut global = SMatrix::<f64, ALL, ALL>::zeros();
        let mut mixed = SMatrix::<f64, 3, ALL>::zeros();
        let mut own = Matrix3::zeros();
        for (by_global, by_turn) in rows(scene, &shape, rotation) {
            global += by_global * by_global.transpose();
            mixed += by_turn * by_global.transpose();
            own += by_turn * by_turn.transpose();
        }
        information += global - mixed.transpose() * own.try_inverse()? * mixed;
    }
    Some(information)
}

/// The six rows of a pose: derivatives of the lengths with the six parameters and the six zeros, and with a small turn
/// about axes of {B}.
fn rows(scene: &Scene, shape: &Matrix3<f64>, rotation: &Rotation3<f64>) -> [(SVector<f64, ALL>, Vector3<f64>); 6] {
    std::array::from_fn(|k| {
        let (end_point, attachment) = CABLES[k];
        let arm = rotation * scene.end_points_mm[end_point];
        let cable = scene.centre_mm + arm - scene.rig().base_mm()[attachment];
        let along = cable / cable.norm();
        let mut by_global = SVector::<f64, ALL>::zeros();
        by_global.fixed_rows_mut::<3>(0).copy_from(&along);
        by_global.fixed_rows_mut::<3>(3).copy_from(&(shape.transpose() * (rotation.inverse() * along)));
        by_global[6 + k] = 1.0;
        (by_global, arm.cross(&along))
    })
}

/// How the three end-points, seen from the joint centre at home, move together when the radii change: the platform is
/// rigid, so it is the centre that moves against it. From |q_i|² = p_i²: q_i·dq = p_i dp_i for all three i.
fn shape_by_radii(scene: &Scene) -> Option<Matrix3<f64>> {
    let [q1, q2, q3] = scene.end_points_mm;
    let arms = Matrix3::from_rows(&[q1.transpose(), q2.transpose(), q3.transpose()]);
    Some(arms.try_inverse()? * Matrix3::from_diagonal(&Vector3::new(q1.norm(), q2.norm(), q3.norm())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::scene::{Reach, Spread};
    use crate::study::trials::random;
    use nalgebra::DMatrix;

    /// The lengths of a pose at moved parameters, solving the platform's place from the radii anew.
    fn lengths(scene: &Scene, rotation: &Rotation3<f64>, moved: &[f64; 6], turn: Vector3<f64>) -> [f64; 6] {
        let mut radii = scene.truth().radii_mm;
        let mut ends = scene.end_points_mm;
        radii.iter_mut().zip(&moved[3..]).for_each(|(radius, by)| *radius += by);
        // Newton's method on the platform's offset: plain, and with nothing in common with the code above.
        let mut offset = Vector3::zeros();
        for _ in 0..20 {
            let miss = Vector3::from_fn(|i, _| (ends[i] + offset).norm() - radii[i]);
            let slope = Matrix3::from_fn(|i, j| ((ends[i] + offset) / (ends[i] + offset).norm())[j]);
            offset -= slope.try_inverse().unwrap() * miss;
        }
        ends.iter_mut().for_each(|end| *end += offset);
        let centre = scene.centre_mm + Vector3::new(moved[0], moved[1], moved[2]);
        let rotation = Rotation3::new(turn) * rotation;
        CABLES.map(|(end, attachment)| (centre + rotation * ends[end] - scene.rig().base_mm()[attachment]).norm())
    }

    /// All lengths in all parameters, zeros and rotations, by differences; the zeros' columns stand last.
    fn whole_jacobian(scene: &Scene, rotations: &[Rotation3<f64>]) -> DMatrix<f64> {
        let turns = 6 + 3 * rotations.len();
        let mut jacobian = DMatrix::zeros(6 * rotations.len(), turns + 6);
        let h = 1e-4;
        for (pose, rotation) in rotations.iter().enumerate() {
            for unknown in (0..6).chain(6 + 3 * pose..9 + 3 * pose) {
                let at = |step: f64| {
                    let (mut moved, mut turn) = ([0.0; 6], Vector3::zeros());
                    // A turn of 1e-6 rad moves an end-point by some 1e-4 mm.
                    if unknown < 6 {
                        moved[unknown] = step
                    } else {
                        turn[unknown - 6 - 3 * pose] = step / 100.0
                    }
                    lengths(scene, rotation, &moved, turn)
                };
                let scale = if unknown < 6 { 1.0 } else { 100.0 };
                for (row, (after, before)) in at(h).iter().zip(at(-h)).enumerate() {
                    jacobian[(6 * pose + row, unknown)] = (after - before) / (2.0 * h) * scale;
                }
            }
            for row in 0..6 {
                jacobian[(6 * pose + row, turns + row)] = 1.0;
            }
        }
        jacobian
    }

    fn random_poses(poses: usize) -> (Scene, Vec<Rotation3<f64>>) {
        let mut random = random(5, "cramer-rao", 0);
        let scene = Scene::random(&mut random, &Spread::ANY_RIG).unwrap();
        let rotations = (0..poses).map(|_| Reach::USUAL.rotation(&mut random)).collect();
        (scene, rotations)
    }

    #[test]
    fn the_bound_is_that_of_the_whole_jacobian_by_differences() {
        let (scene, rotations) = random_poses(7);
        let jacobian = whole_jacobian(&scene, &rotations).columns(0, 6 + 3 * rotations.len()).into_owned();
        let dense = (jacobian.transpose() * &jacobian).try_inverse().unwrap() * (0.05 * 0.05);
        let bound = bound(&scene, &rotations, 0.05).unwrap();
        for i in 0..6 {
            for j in 0..6 {
                let scale = (dense[(i, i)] * dense[(j, j)]).sqrt();
                assert!((bound[(i, j)] - dense[(i, j)]).abs() < 1e-5 * scale, "{i} {j}");
            }
        }
    }

    #[test]
    fn the_bound_with_unknown_zeros_is_that_of_the_whole_jacobian_too() {
        let (scene, rotations) = random_poses(20);
        let jacobian = whole_jacobian(&scene, &rotations);
        let turns = 6 + 3 * rotations.len();
        let place = |i: usize| if i < 6 { i } else { turns + i - 6 };
        for prior_mm in [None, Some(0.5)] {
            let mut information = jacobian.transpose() * &jacobian / (0.05 * 0.05);
            for zero in 0..6 {
                information[(turns + zero, turns + zero)] += prior_mm.map_or(0.0, |prior: f64| 1.0 / (prior * prior));
            }
            let dense = information.try_inverse().unwrap();
            let bound = bound_with_zeros(&scene, &rotations, 0.05, prior_mm).unwrap();
            for i in 0..ALL {
                for j in 0..ALL {
                    let expected = dense[(place(i), place(j))];
                    let scale = (dense[(place(i), place(i))] * dense[(place(j), place(j))]).sqrt();
                    assert!((bound[(i, j)] - expected).abs() < 1e-4 * scale, "{i} {j} {prior_mm:?}");
                }
            }
        }
    }

    #[test]
    fn zeros_that_are_nearly_known_bound_the_centre_as_known_ones() {
        let (scene, rotations) = random_poses(10);
        let known = bound(&scene, &rotations, 0.05).unwrap();
        let nearly = bound_with_zeros(&scene, &rotations, 0.05, Some(1e-5)).unwrap();
        assert!((0..6).all(|i| (nearly[(i, i)] / known[(i, i)] - 1.0).abs() < 1e-3));
    }

    #[test]
    fn two_poses_never_suffice() {
        let mut random = random(6, "cramer-rao", 0);
        let scene = Scene::table_1(150.0).unwrap();
        let rotations: Vec<_> = (0..2).map(|_| Reach::USUAL.rotation(&mut random)).collect();
        assert!(bound(&scene, &rotations, 0.05).is_none_or(|bound| bound.trace() > 1e3));
    }
}
