//! Can the poses tell the centre, and how well will they? Sways against their definition and closed forms, the foretold
//! error bar against the final one, covariances against nalgebra's dense algebra.

use crate::common::dense::derivative;
use crate::common::library::{as_cables, as_poses, rig};
use crate::common::sets::{machines, noisy, sound, sweep};
use crate::common::{Worn, rng};
use glenoid::identification::blocks::Blocks;
use glenoid::identification::normal_equations::{PACKED, at};
use glenoid::identification::observability::{RotationSum, Sway};
use glenoid::identification::uncertainty::{parameters_of, sigmas, worst_centre_direction, worst_direction};
use glenoid::identification::{Solver, SolverSettings, Survey};
use glenoid::kinematics::{OctahedronError, Pivot, RigPoints};
use glenoid::rig::Parameters;
use glenoid::scalar::Real;
use glenoid::symmetric::Symmetric;
use nalgebra::{Matrix3, Matrix6, Rotation3, SMatrix, Unit, Vector3, Vector6};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

fn sway<T: Real>(rotations: &[Rotation3<f64>]) -> Sway<T> {
    let mut sum = RotationSum::default();
    for rotation in rotations {
        sum.add(&rotation.matrix().map(T::of));
    }
    sum.sway()
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
fn sway_is_the_least_motion_of_any_pair_of_axes() {
    let mut rng = rng(2401);
    for _ in 0..200 {
        let limit = 10_f64.powf(rng.random_range(-1.0..1.8));
        let rotations = sweep(&mut rng, 20, limit, limit);
        let Sway { axis, axis_in_platform, least_rad, second_rad } = sway::<f64>(&rotations);
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
        let double = sway::<f64>(&rotations);
        assert!(double.least_rad < 1e-7 && double.axis.cross(&axis).norm() < 1e-7, "{double:?}, axis {axis:?}");
        let single = sway::<f32>(&rotations);
        let off = single.axis.map(f64::from).cross(&axis).norm();
        // A rounding of 6e-8 in the mean is 3e-4 rad of sway.
        assert!(single.least_rad < 2e-3 && off < 5e-3, "{single:?}, axis {axis:?}, off by {off}");
    }
}

#[test]
fn known_sways() {
    let turn = |axis: Vector3<f64>, angle: f64| Rotation3::new(axis * angle);
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    // By θ to either side about x and about y: of z, every pose moves by 2 sin(θ/2); of x and y every other one.
    for theta in [0.01, 0.1, 0.5] {
        let poses = [turn(x, theta), turn(x, -theta), turn(y, theta), turn(y, -theta)];
        let found = sway::<f64>(&poses);
        let chord = 2.0 * f64::sin(theta / 2.0);
        assert!((found.least_rad - chord / 2.0_f64.sqrt()).abs() < 1e-9, "{found:?}");
        assert!((found.second_rad - chord / 2.0_f64.sqrt()).abs() < 1e-9, "{found:?}");
        assert!(found.axis.z.abs() < 1e-6, "z is moved most: {found:?}");
    }
    // A common rotation beforehand changes nothing but the axis in {P}.
    let first = turn(Vector3::new(0.3, -0.7, 1.1), 1.0);
    let found = sway::<f64>(&[turn(z, 0.3) * first, turn(z, -0.2) * first, first]);
    assert!(found.least_rad < 1e-7 && found.axis.cross(&z).norm() < 1e-7, "{found:?}");
    assert!((found.axis_in_platform - first.inverse() * found.axis).norm() < 1e-7, "{found:?}");
    // Alike altogether, one, or none.
    for poses in [vec![first; 5], vec![first], Vec::new()] {
        let found = sway::<f64>(&poses);
        assert!(found.least_rad < 1e-7 && found.second_rad < 1e-7, "{found:?}");
    }
}

#[test]
fn the_foretold_error_bar_is_the_final_one() {
    for (seed, (name, worn)) in machines().into_iter().enumerate() {
        let rig = rig::<f64>(&worn);
        for count in [5, 10, 30, 100] {
            // Without noise: the survey's own centre, and the nominal one, are the true centre.
            let poses = as_poses(&sound(&worn, 2403 + seed as u64, count));
            let mut survey = Survey::new(&rig);
            for pose in &poses {
                survey.add(pose).expect(name);
            }
            let foretold = survey.foretold().expect(name);
            let found = Solver::<f64, 128>::new(&rig, SolverSettings::for_rig(&rig)).run(&poses).expect(name);
            let (sigma_mm, direction) = found.worst_centre_sigma_mm();
            assert!((foretold.sigma_mm / sigma_mm - 1.0).abs() < 1e-6, "{name}: {foretold:?} or {sigma_mm}");
            let along: f64 = foretold.direction.iter().zip(direction).map(|(a, b)| a * b).sum();
            assert!(along.abs() > 0.999, "{name}: {:?} or {direction:?}", foretold.direction);
            assert!((survey.sway().least_rad - found.sway_rad).abs() < 1e-6, "{name}");
        }
    }
}

#[test]
fn the_foretold_error_bar_only_shrinks() {
    for (name, worn) in machines() {
        let mut survey = Survey::<f32>::new(&rig(&worn));
        let mut before = f32::INFINITY;
        let mut steps = 0;
        for lengths in noisy(&worn, 2405, 100) {
            survey.add(&as_cables(&lengths)).expect(name);
            if let Some(foretold) = survey.foretold() {
                assert!(foretold.sigma_mm <= before * 1.0001, "{name}: {} after {before} mm", foretold.sigma_mm);
                before = foretold.sigma_mm;
                steps += 1;
            }
        }
        assert!(steps >= 95 && before < 0.2, "{name}: {steps} forecasts, the last {before} mm");
    }
}

#[test]
fn a_survey_foretells_nothing_of_poses_that_determine_nothing() {
    let mut rng = rng(2406);
    for (name, worn) in machines() {
        let mut survey = Survey::<f64>::new(&rig(&worn));
        assert_eq!(survey.foretold(), None);
        let axis = Unit::new_normalize(Vector3::new(0.2, 0.1, 1.0));
        for _ in 0..10 {
            let turn = Rotation3::from_axis_angle(&axis, rng.random_range(-0.4..0.4));
            survey.add(&as_cables(&worn.lengths_mm(&turn))).expect(name);
            assert_eq!(survey.foretold(), None, "{name}: one axis only");
        }
        assert!(survey.sway().least_rad < 1e-5 && survey.sway().axis.cross(&axis).norm() < 1e-4, "{name}");
        // A pose that cannot be is told, and leaves no trace.
        let before = survey.sway();
        let broken = as_cables(&[1.0, 500.0, 250.0, 250.0, 250.0, 250.0]);
        assert!(matches!(survey.add(&broken), Err(OctahedronError::Length(_))), "{name}");
        assert_eq!(survey.sway(), before);
    }
}

/// A random covariance, packed and dense.
fn covariance(rng: &mut ChaCha8Rng) -> ([f64; PACKED], Matrix6<f64>) {
    let root = Matrix6::from_fn(|_, _| rng.random_range(-1.0..1.0));
    let dense = root * root.transpose() + Matrix6::identity() * 0.01;
    let mut packed = [0.0; PACKED];
    for i in 0..6 {
        for j in 0..=i {
            packed[at(i, j)] = dense[(i, j)];
        }
    }
    (packed, dense)
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
        let points = RigPoints::new(&rig::<f64>(&worn));
        let pivot = Pivot { in_base_mm: worn.centre_mm, in_platform_mm: Vector3::new(70.0, 40.0, -90.0) };
        let (_, dense) = covariance(&mut rng);
        let jacobian = derivative::<6, 6>(|step| pivot_parameters(&pivot, &points, step));
        let expected = jacobian * dense * jacobian.transpose();
        let symmetric = |at: usize| {
            let block = dense.fixed_view::<3, 3>(at, at);
            Symmetric([block[(0, 0)], block[(1, 0)], block[(1, 1)], block[(2, 0)], block[(2, 1)], block[(2, 2)]])
        };
        let mixed = dense.fixed_view::<3, 3>(3, 0).into_owned();
        let of_pivot = Blocks { first: symmetric(0), mixed, second: symmetric(3) };
        let mut parameters = Parameters { centre_mm: Vector3::zeros(), radii_mm: [0.0; 3] };
        let mut mine = [0.0; 21];
        parameters_of(&pivot, &of_pivot, 1.0, &points, &mut parameters, &mut mine);
        let there = pivot_parameters(&pivot, &points, &Vector6::zeros());
        let [p1, p2, p3] = parameters.radii_mm;
        let found = Vector6::new(worn.centre_mm.x, worn.centre_mm.y, worn.centre_mm.z, p1, p2, p3);
        assert!((found - Vector6::from(there)).norm() < 1e-9 && parameters.centre_mm == worn.centre_mm);
        for i in 0..6 {
            for j in 0..=i {
                assert!((mine[at(i, j)] - expected[(i, j)]).abs() < 1e-8, "entry {i}, {j}");
            }
        }
    }
}

/// x, y, z, p1, p2, p3 of a moved pivot, from distances alone.
fn pivot_parameters(pivot: &Pivot<f64>, points: &RigPoints<f64>, step: &Vector6<f64>) -> [f64; 6] {
    let centre = pivot.in_base_mm + step.fixed_rows::<3>(0);
    let in_platform = pivot.in_platform_mm + step.fixed_rows::<3>(3);
    let [p1, p2, p3] = points.platform_mm.map(|point| (point - in_platform).norm());
    [centre.x, centre.y, centre.z, p1, p2, p3]
}
