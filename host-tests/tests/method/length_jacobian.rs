//! The joint centre in both bodies: the Jacobian of the lengths against differences, radii against spheres.

use crate::common::dense::{derivative, lengths_mm};
use crate::common::library::{as_cables, as_parameters, rig};
use crate::common::sets::machines;
use crate::common::{Worn, arm, rng};
use glenoid::kinematics::{Geometry, JointCentre, LengthJacobian};
use glenoid::rig::Parameters;
use nalgebra::{Matrix3, Rotation3, SMatrix, Vector3};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Axes of {P} in those of the platform at home: x from P1 to P2, z normal to the plane, away from the base.
fn platform_axes(worn: &Worn) -> Matrix3<f64> {
    let [p1, p2, p3] = worn.home_mm;
    let x = (p2 - p1).normalize();
    let normal = (p2 - p1).cross(&(p3 - p1)).normalize();
    let z = normal * normal.z.signum();
    Matrix3::from_columns(&[x, z.cross(&x), z])
}

/// A machine, its centre and the estimate of a wrong centre, each a few centimetres off.
fn case(rng: &mut ChaCha8Rng) -> (Worn, Vector3<f64>, Vector3<f64>, Rotation3<f64>) {
    let mut off = || Vector3::from_fn(|_, _| rng.random_range(-20.0..20.0));
    let (centre_off, platform_off) = (off(), off());
    (Worn::random(rng, 20.0), centre_off, platform_off, arm(rng, 40.0))
}

#[test]
fn the_rows_are_the_derivatives_of_the_lengths() {
    let mut rng = rng(2101);
    for _ in 0..500 {
        let (worn, centre_off, platform_off, turn) = case(&mut rng);
        let centre = worn.centre_mm + centre_off;
        // δ moves the centre, ω turns the platform about it: nine unknowns, the last three of C through -R δC.
        let lengths = |step: &SMatrix<f64, 9, 1>| {
            let part = |at: usize| Vector3::new(step[at], step[at + 1], step[at + 2]);
            lengths_mm(&worn, &(centre + part(0)), &(platform_off + part(3)), &(Rotation3::new(part(6)) * turn))
        };
        let expected = derivative::<6, 9>(lengths);
        let axes = platform_axes(&worn);
        let centre_in_both =
            JointCentre { in_base_mm: centre, in_platform_mm: axes.transpose() * (platform_off - worn.home_mm[0]) };
        let rotation = turn.matrix() * axes;
        let measured = worn.lengths_mm(&arm(&mut rng, 40.0));
        let geometry = Geometry::new(&rig::<f64>(&worn));
        let jacobian = LengthJacobian::new(&geometry, &centre_in_both, &rotation, &as_cables(&measured));
        let computed = lengths(&SMatrix::zeros());
        for cable in 0..6 {
            let (translation, turning) = (jacobian.rows[cable].translation, jacobian.rows[cable].rotation_mm);
            let row = expected.fixed_rows::<1>(cable);
            assert!(
                (row.fixed_columns::<3>(0).transpose() - translation).amax() < 1e-9,
                "translation of cable {cable}"
            );
            assert!(
                (row.fixed_columns::<3>(3).transpose() + turn.inverse() * translation).amax() < 1e-9,
                "δ = δO - R δC"
            );
            assert!((row.fixed_columns::<3>(6).transpose() - turning).amax() < 1e-7, "rotation of cable {cable}");
            let residual = measured[cable] - computed[cable];
            assert!((jacobian.rows[cable].residual_mm - residual).abs() < 1e-9, "residual of cable {cable}");
        }
    }
}

#[test]
fn points_keep_their_distances_and_look_away_from_the_base() {
    let mut rng = rng(2102);
    for _ in 0..200 {
        let worn = Worn::random(&mut rng, 20.0);
        let rig = rig::<f64>(&worn);
        let geometry = Geometry::new(&rig);
        let [b1, b2, b3] = worn.base_mm;
        assert_eq!(geometry.base_mm, [b1, b2, b2, b3, b3, b1]);
        // The same triangle as at home, turned into the axes of {P}: no mirror image.
        let axes = platform_axes(&worn);
        for (mine, home) in geometry.end_points_mm().iter().zip(worn.home_mm) {
            let expected = axes.transpose() * (home - worn.home_mm[0]);
            assert!((mine - expected).amax() < 1e-9, "{mine} instead of {expected}");
        }
    }
}

#[test]
fn radii_become_the_centre_below_the_platform_and_back() {
    let mut rng = rng(2103);
    for _ in 0..500 {
        let worn = Worn::random(&mut rng, 20.0);
        let geometry = Geometry::new(&rig::<f64>(&worn));
        let truth = as_parameters::<f64>(&worn.truth());
        let centre = JointCentre::from_parameters(&truth, &geometry);
        let expected = platform_axes(&worn).transpose() * -worn.home_mm[0];
        assert!((centre.in_platform_mm - expected).amax() < 1e-9, "{} instead of {expected}", centre.in_platform_mm);
        assert_eq!(centre.in_base_mm, worn.centre_mm);
        for (end_point, radius) in geometry.end_points_mm().iter().zip(truth.radii_mm) {
            let mine = (end_point - centre.in_platform_mm).norm();
            assert!((mine - radius).abs() < 1e-9, "{mine} instead of {radius}");
        }
    }
}

#[test]
fn single_precision_round_trips_to_a_few_roundings() {
    let mut rng = rng(2104);
    for _ in 0..500 {
        let worn = Worn::random(&mut rng, 20.0);
        let geometry = Geometry::new(&rig::<f32>(&worn));
        let truth = as_parameters::<f32>(&worn.truth());
        let centre = JointCentre::from_parameters(&truth, &geometry);
        for (end_point, radius) in geometry.end_points_mm().iter().zip(truth.radii_mm) {
            let mine = (end_point - centre.in_platform_mm).norm();
            assert!((mine - radius).abs() < 2e-4, "{mine} instead of {radius}");
        }
    }
}

#[test]
fn spheres_that_do_not_meet_give_the_nearest_point_of_the_plane() {
    for (name, worn) in machines() {
        let geometry = Geometry::new(&rig::<f64>(&worn));
        // Half of the circumradius: three equal spheres that do not reach the middle of the platform.
        let [p1, p2, _] = worn.home_mm;
        let short = (p1 - p2).norm() / 3.0_f64.sqrt() / 2.0;
        let apart = Parameters { centre_mm: worn.centre_mm, radii_mm: [short; 3] };
        let centre = JointCentre::from_parameters(&apart, &geometry);
        let middle = geometry.end_points_mm().iter().sum::<Vector3<f64>>() / 3.0;
        assert!((centre.in_platform_mm - middle).amax() < 1e-9, "{name}: {}", centre.in_platform_mm);
    }
}

#[test]
fn six_numbers_are_the_centre_in_both_bodies() {
    let centre = JointCentre::from_array(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(centre.in_base_mm, Vector3::new(1.0, 2.0, 3.0));
    assert_eq!(centre.in_platform_mm, Vector3::new(4.0, 5.0, 6.0));
}
