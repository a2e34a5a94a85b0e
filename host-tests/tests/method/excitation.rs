//! Rotational excitation: against its definition, closed forms, and nalgebra's singular values.

use crate::common::rng;
use crate::common::sets::sweep;
use glenoid::identification::excitation::{Excitation, MeanRotation};
use glenoid::scalar::Real;
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

fn excitation<T: Real>(rotations: &[Rotation3<f64>]) -> Excitation<T> {
    let mut sum = MeanRotation::default();
    for rotation in rotations {
        sum.add(&rotation.matrix().map(T::of));
    }
    sum.excitation()
}

/// Root-mean-square length by which the rotations move `from` away from `to`.
fn moved(rotations: &[Rotation3<f64>], from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
    let squares: f64 = rotations.iter().map(|rotation| (rotation * from - to).norm_squared()).sum();
    (squares / rotations.len() as f64).sqrt()
}

fn any_axis(rng: &mut ChaCha8Rng) -> Unit<Vector3<f64>> {
    Unit::new_normalize(Vector3::from_fn(|_, _| crate::common::sets::normal(rng)))
}

/// Turns about one axis, all after the same first rotation.
fn about(rng: &mut ChaCha8Rng, axis: &Unit<Vector3<f64>>, count: usize, limit_deg: f64) -> Vec<Rotation3<f64>> {
    let first = Rotation3::from_axis_angle(&any_axis(rng), rng.random_range(-1.0..1.0));
    let mut angle = || rng.random_range(-limit_deg..=limit_deg).to_radians();
    (0..count).map(|_| Rotation3::from_axis_angle(axis, angle()) * first).collect()
}

#[test]
fn excitation_is_the_least_motion_of_any_pair_of_axes() {
    let mut rng = rng(2401);
    for _ in 0..200 {
        let limit = 10_f64.powf(rng.random_range(-1.0..1.8));
        let rotations = sweep(&mut rng, 20, limit, limit);
        let Excitation { axis, axis_in_platform, least_rad, second_rad } = excitation::<f64>(&rotations);
        assert!((axis.norm() - 1.0).abs() < 1e-12 && (axis_in_platform.norm() - 1.0).abs() < 1e-12);
        // The figure is what the definition says for these axes,
        assert!((moved(&rotations, &axis_in_platform, &axis) - least_rad).abs() < 1e-7, "{least_rad}");
        // and no other pair does better: neighbours, and the whole sphere.
        for near in [1e-3, 0.1, 10.0] {
            let mut other = |axis: &Vector3<f64>| (axis + near * any_axis(&mut rng).into_inner()).normalize();
            assert!(moved(&rotations, &other(&axis_in_platform), &other(&axis)) > least_rad - 1e-7);
        }
        // Singular values of the mean rotation, by nalgebra: the mean of |R a' - a|² is 2 (1 - σ).
        let mean = rotations.iter().map(|rotation| *rotation.matrix()).sum::<Matrix3<f64>>() / 20.0;
        let values = mean.singular_values();
        let expected = |k: usize| (2.0 * (1.0 - values[k])).max(0.0).sqrt();
        assert!((least_rad - expected(0)).abs() < 1e-7, "{least_rad} instead of {}", expected(0));
        assert!((second_rad - expected(1)).abs() < 1e-7, "{second_rad} instead of {}", expected(1));
    }
}

#[test]
fn turns_about_one_axis_do_not_move_it() {
    let mut rng = rng(2402);
    for _ in 0..200 {
        let axis = any_axis(&mut rng);
        let rotations = about(&mut rng, &axis, 8, 60.0);
        let double = excitation::<f64>(&rotations);
        assert!(double.least_rad < 1e-7 && double.axis.cross(&axis).norm() < 1e-7, "{double:?}, axis {axis:?}");
        let single = excitation::<f32>(&rotations);
        let off = single.axis.map(f64::from).cross(&axis).norm();
        // A rounding of 6e-8 in the mean is 3e-4 rad of excitation.
        assert!(single.least_rad < 2e-3 && off < 5e-3, "{single:?}, axis {axis:?}, off by {off}");
    }
}

#[test]
fn known_excitations() {
    let turn = |axis: Vector3<f64>, angle: f64| Rotation3::new(axis * angle);
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    // By θ to either side about x and about y: of z, every pose moves by 2 sin(θ/2); of x and y every other one.
    for theta in [0.01, 0.1, 0.5] {
        let poses = [turn(x, theta), turn(x, -theta), turn(y, theta), turn(y, -theta)];
        let found = excitation::<f64>(&poses);
        let chord = 2.0 * f64::sin(theta / 2.0);
        assert!((found.least_rad - chord / 2.0_f64.sqrt()).abs() < 1e-9, "{found:?}");
        assert!((found.second_rad - chord / 2.0_f64.sqrt()).abs() < 1e-9, "{found:?}");
        assert!(found.axis.z.abs() < 1e-6, "z is moved most: {found:?}");
    }
    // A common rotation beforehand changes nothing but the axis in {P}.
    let first = turn(Vector3::new(0.3, -0.7, 1.1), 1.0);
    let found = excitation::<f64>(&[turn(z, 0.3) * first, turn(z, -0.2) * first, first]);
    assert!(found.least_rad < 1e-7 && found.axis.cross(&z).norm() < 1e-7, "{found:?}");
    assert!((found.axis_in_platform - first.inverse() * found.axis).norm() < 1e-7, "{found:?}");
    // Alike altogether, one, or none.
    for poses in [vec![first; 5], vec![first], Vec::new()] {
        let found = excitation::<f64>(&poses);
        assert!(found.least_rad < 1e-7 && found.second_rad < 1e-7, "{found:?}");
    }
}
