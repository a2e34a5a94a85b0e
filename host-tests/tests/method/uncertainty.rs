//! Standard deviations and worst directions against nalgebra's dense algebra and differences.

use crate::common::dense::derivative;
use crate::common::library::rig;
use crate::common::{Worn, rng};
use glenoid::identification::outcome::RESULT_PACKED;
use glenoid::identification::uncertainty::{
    packed, parameters_of, sigmas, unpacked, worst_centre_direction, worst_direction,
};
use glenoid::kinematics::{Geometry, JointCentre};
use glenoid::linear_algebra::packed_index;
use nalgebra::{Matrix6, SMatrix, Vector3, Vector6};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// A random covariance, packed and dense.
fn covariance(rng: &mut ChaCha8Rng) -> ([f64; RESULT_PACKED], Matrix6<f64>) {
    let root = Matrix6::from_fn(|_, _| rng.random_range(-1.0..1.0));
    let dense = root * root.transpose() + Matrix6::identity() * 0.01;
    let by_rows = packed(&dense);
    for i in 0..6 {
        for j in 0..=i {
            assert_eq!(by_rows[packed_index(i, j)], dense[(i, j)]);
        }
    }
    assert_eq!(unpacked::<f64, 6>(&by_rows), dense);
    (by_rows, dense)
}

/// Largest eigenvalue and its vector.
fn largest<const N: usize>(values: &[f64; N], vectors: &SMatrix<f64, N, N>) -> (f64, SMatrix<f64, N, 1>) {
    let best = (0..N).fold(0, |best, k| if values[k] > values[best] { k } else { best });
    (values[best], vectors.column(best).into_owned())
}

#[test]
fn worst_directions_are_the_largest_eigenvectors() {
    let mut rng = rng(2407);
    for _ in 0..300 {
        let (packed, dense) = covariance(&mut rng);
        let eigen = dense.symmetric_eigen();
        let (value, vector) = largest(&eigen.eigenvalues.into(), &eigen.eigenvectors);
        let (direction, sigma) = worst_direction(&packed);
        // Where no direction stands out by a factor of two, a mixture of the worst may be given.
        let stands_out = eigen.eigenvalues.iter().filter(|other| **other > value / 2.0).count() == 1;
        let tolerance = if stands_out { 1e-4 } else { 0.1 };
        assert!((sigma / value.sqrt() - 1.0).abs() < tolerance, "{sigma} instead of {}", value.sqrt());
        let along = Vector6::from(direction).dot(&vector).abs();
        assert!(!stands_out || along > 0.9999, "{direction:?} instead of {vector}");

        let centre = dense.fixed_view::<3, 3>(0, 0).into_owned().symmetric_eigen();
        let (value, _) = largest(&centre.eigenvalues.into(), &centre.eigenvectors);
        let (sigma, direction) = worst_centre_direction(&packed);
        assert!((sigma / value.sqrt() - 1.0).abs() < 0.1, "{sigma} instead of {}", value.sqrt());
        assert!((Vector3::from(direction).norm() - 1.0).abs() < 1e-12);
        for (mine, variance) in sigmas(&packed).iter().zip(dense.diagonal().iter()) {
            assert!((mine - variance.sqrt()).abs() < 1e-14);
        }
    }
}

#[test]
fn covariance_of_the_radii_follows_from_that_of_the_platforms_centre() {
    let mut rng = rng(2408);
    for _ in 0..300 {
        let worn = Worn::random(&mut rng, 20.0);
        let geometry = Geometry::new(&rig::<f64>(&worn));
        let centre = JointCentre { in_base_mm: worn.centre_mm, in_platform_mm: Vector3::new(70.0, 40.0, -90.0) };
        let (_, dense) = covariance(&mut rng);
        let jacobian = derivative::<6, 6>(|step| moved_parameters(&centre, &geometry, step));
        let expected = jacobian * dense * jacobian.transpose();
        let (parameters, mine) = parameters_of(&centre, &dense, &Matrix6::zeros(), &geometry);
        let there = moved_parameters(&centre, &geometry, &Vector6::zeros());
        assert!((Vector6::from(parameters.to_array()) - Vector6::from(there)).norm() < 1e-9);
        assert_eq!(parameters.centre_mm, worn.centre_mm);
        for i in 0..6 {
            for j in 0..=i {
                assert!((mine[packed_index(i, j)] - expected[(i, j)]).abs() < 1e-8, "entry {i}, {j}");
            }
        }
    }
}

/// x, y, z, p1, p2, p3 of a moved joint centre, from distances alone.
fn moved_parameters(centre: &JointCentre<f64>, geometry: &Geometry<f64>, step: &Vector6<f64>) -> [f64; 6] {
    let in_base = centre.in_base_mm + step.fixed_rows::<3>(0);
    let in_platform = centre.in_platform_mm + step.fixed_rows::<3>(3);
    let [p1, p2, p3] = geometry.end_points_mm().map(|point| (point - in_platform).norm());
    [in_base.x, in_base.y, in_base.z, p1, p2, p3]
}
