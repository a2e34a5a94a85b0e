//! What cannot be known is refused, with its cause: poses about one axis (which), poses that are alike, a standard
//! deviation past its limit (which direction), a joint that is no ball (how far its centre migrates), sets without
//! redundancy.

use crate::common::library::{as_poses, estimate, identify, rig, settings};
use crate::common::sets::{NOISE_MM, add_noise, lengths_at, machines, noisy, normal, sound, sweep};
use crate::common::{Worn, rng};
use glenoid::identification::{EstimatorSettings, Machine, Refusal};
use glenoid::kinematics::LengthFault;
use host_tests::literal::Lengths;
use nalgebra::{Rotation3, Unit, Vector3};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

fn any_axis(rng: &mut ChaCha8Rng) -> Unit<Vector3<f64>> {
    Unit::new_normalize(Vector3::from_fn(|_, _| normal(rng)))
}

/// Asserts that the poses are refused as turning about `axis`, to a degree, in both precisions.
fn assert_one_axis(worn: &Worn, poses: &[Lengths<f64>], axis: &Unit<Vector3<f64>>, what: &str) {
    for refusal in [identify::<f64>(worn, poses).expect_err(what), identify::<f32>(worn, poses).expect_err(what)] {
        let Refusal::OneAxis { axis: named, excitation_rad } = refusal else { panic!("{what}: {refusal:?}") };
        let off = Vector3::from(named).map(f64::from).cross(axis).norm().asin().to_degrees();
        assert!(off < 1.0, "{what}: {off} degrees off {axis:?}: {refusal:?}");
        assert!(excitation_rad < 0.02, "{what}: {refusal:?}");
    }
}

#[test]
fn poses_about_one_axis_are_refused_and_the_axis_named() {
    let mut rng = rng(2701);
    for (name, worn) in machines() {
        for noise_mm in [0.0, NOISE_MM] {
            for _ in 0..200 {
                let axis = any_axis(&mut rng);
                let first = sweep(&mut rng, 1, 15.0, 15.0)[0];
                let count = rng.random_range(3..=30);
                // From end to end, so that a degree of the axis can be told from the noise.
                let angle = |pose: usize| f64::to_radians(60.0 * pose as f64 / (count - 1) as f64 - 30.0);
                let turns: Vec<_> = (0..count).map(|p| Rotation3::from_axis_angle(&axis, angle(p)) * first).collect();
                let mut poses = lengths_at(&worn, &turns);
                add_noise(&mut poses, &mut rng, noise_mm);
                assert_one_axis(&worn, &poses, &axis, &format!("{name}, {count} poses, {noise_mm} mm"));
            }
        }
    }
}

#[test]
fn two_rotations_repeated_are_refused_and_their_axis_named() {
    let mut rng = rng(2702);
    for (name, worn) in machines() {
        for noise_mm in [0.0, NOISE_MM] {
            for _ in 0..100 {
                let two = sweep(&mut rng, 2, 40.0, 30.0);
                let between = two[0] * two[1].inverse();
                // Where the two are hardly apart they are alike, which is another refusal.
                let Some((axis, angle)) = between.axis_angle() else { continue };
                if angle < 0.2 {
                    continue;
                }
                let turns: Vec<_> = (0..12).map(|pose| two[pose % 2]).collect();
                let mut poses = lengths_at(&worn, &turns);
                add_noise(&mut poses, &mut rng, noise_mm);
                assert_one_axis(&worn, &poses, &axis, &format!("{name}, {angle} rad apart, {noise_mm} mm"));
            }
        }
    }
}

#[test]
fn pure_torsion_and_a_single_plane_are_one_axis_too() {
    let mut rng = rng(2703);
    for (name, worn) in machines() {
        for _ in 0..50 {
            let azimuth: f64 = rng.random_range(0.0..core::f64::consts::TAU);
            let plane = Unit::new_normalize(Vector3::new(azimuth.cos(), azimuth.sin(), 0.0));
            for axis in [Vector3::z_axis(), plane] {
                let mut angle = || rng.random_range(-40.0_f64..40.0).to_radians();
                let turns: Vec<_> = (0..15).map(|_| Rotation3::from_axis_angle(&axis, angle())).collect();
                let mut poses = lengths_at(&worn, &turns);
                add_noise(&mut poses, &mut rng, NOISE_MM);
                assert_one_axis(&worn, &poses, &axis, name);
            }
        }
    }
}

#[test]
fn poses_within_two_degrees_are_refused() {
    let mut rng = rng(2704);
    for (name, worn) in machines() {
        for noise_mm in [0.0, NOISE_MM] {
            for _ in 0..200 {
                let first = sweep(&mut rng, 1, 30.0, 30.0)[0];
                let count = rng.random_range(3..=60);
                let turns: Vec<_> = sweep(&mut rng, count, 2.0, 2.0).iter().map(|turn| turn * first).collect();
                let mut poses = lengths_at(&worn, &turns);
                add_noise(&mut poses, &mut rng, noise_mm);
                for refusal in
                    [identify::<f64>(&worn, &poses).expect_err(name), identify::<f32>(&worn, &poses).expect_err(name)]
                {
                    let Refusal::TooAlike { spread_rad } = refusal else { panic!("{name}, {count}: {refusal:?}") };
                    assert!(spread_rad < 0.0436, "{name}: {spread_rad} rad");
                }
            }
        }
    }
}

#[test]
fn a_wide_standard_deviation_is_refused_with_its_size_and_direction() {
    for (name, worn) in machines() {
        let rig = rig::<f64>(&worn);
        let poses = as_poses::<f64>(&noisy(&worn, 2705, 15));
        let within = |sigma_limit_mm: f64| {
            let settings = EstimatorSettings { sigma_limit_mm, ..settings(&rig) };
            estimate(&rig, &Machine::new(&rig), settings, &poses)
        };
        let (sigma, direction) = within(1.0).expect(name).worst_centre_sigma_mm();
        assert!(within(sigma * 1.001).is_ok(), "{name}");
        match within(sigma * 0.999) {
            Err(Refusal::Weak { direction: named, sigma_mm }) => {
                assert!((f64::from(sigma_mm) / sigma - 1.0).abs() < 1e-6, "{name}: {sigma_mm} or {sigma}");
                assert_eq!(named, direction.map(|x| x as f32), "{name}");
            }
            other => panic!("{name}: {other:?}"),
        }
    }
}

#[test]
fn lengths_without_noise_do_not_hide_a_weak_geometry() {
    // The rig's own noise judges, or a simulation would accept what no machine can measure.
    let mut rng = rng(2706);
    for (name, worn) in machines() {
        let mut weak = 0;
        for _ in 0..100 {
            let poses = lengths_at(&worn, &sweep(&mut rng, 5, 5.0, 10.0));
            weak += usize::from(matches!(identify::<f64>(&worn, &poses), Err(Refusal::Weak { .. })));
        }
        assert!(weak > 10, "{name}: only {weak} of 100 weak");
    }
}

/// A centre that migrates by `migration_mm` along each axis, from pose to pose.
fn migrating(worn: &Worn, rng: &mut ChaCha8Rng, count: usize, migration_mm: f64) -> Vec<Lengths<f64>> {
    let turns = sweep(rng, count, 45.0, 30.0);
    let mut poses: Vec<_> = turns
        .iter()
        .map(|turn| {
            let mut moved = *worn;
            moved.centre_mm += Vector3::from_fn(|_, _| migration_mm * normal(rng));
            moved.lengths_mm(turn)
        })
        .collect();
    add_noise(&mut poses, rng, NOISE_MM);
    poses
}

#[test]
fn a_migrating_centre_is_refused_with_its_size() {
    let mut rng = rng(2707);
    for (name, worn) in machines() {
        // In proportion: five millimetres in a wrist are no small motion.
        let size = worn.base_mm[0].norm() / 150.0;
        for true_mm in [1.0 * size, 2.0 * size, 5.0 * size] {
            let (mut told, mut squares) = (0, 0.0);
            for _ in 0..100 {
                let poses = migrating(&worn, &mut rng, 30, true_mm);
                match identify::<f64>(&worn, &poses).expect_err(name) {
                    Refusal::CentreNotFixed { migration_mm } => {
                        told += 1;
                        squares += f64::from(migration_mm).powi(2);
                    }
                    Refusal::TooManyOutliers { .. } => {}
                    other => panic!("{name}, {true_mm} mm: {other:?}"),
                }
                assert!(identify::<f32>(&worn, &poses).is_err(), "{name}, {true_mm} mm");
            }
            assert!(told >= 95, "{name}, {true_mm} mm: named {told} times of 100");
            let size = (squares / f64::from(told)).sqrt() / true_mm;
            assert!((0.8..1.25).contains(&size), "{name}: {size} times the true {true_mm} mm");
        }
    }
}

#[test]
fn migration_that_noise_explains_is_none() {
    let mut rng = rng(2708);
    for (name, worn) in machines() {
        for _ in 0..100 {
            let poses = migrating(&worn, &mut rng, 30, 0.2 * NOISE_MM);
            assert!(identify::<f64>(&worn, &poses).is_ok(), "{name}");
        }
    }
}

#[test]
fn three_poses_are_not_redundant() {
    for (name, worn) in machines() {
        for seed in 2710..2760 {
            let refusal = identify::<f64>(&worn, &sound(&worn, seed, 3)).expect_err(name);
            let of_three = matches!(
                refusal,
                Refusal::NotRedundant { pose: 0..3 } | Refusal::OneAxis { .. } | Refusal::Weak { .. }
            );
            assert!(of_three, "{name}: {refusal:?}");
        }
        // Who trusts every reading may have the centre all the same.
        let rig = rig::<f64>(&worn);
        let trusting = EstimatorSettings { require_redundancy: false, ..settings(&rig) };
        let poses = as_poses(&sound(&worn, 2710, 3));
        let identified = estimate(&rig, &Machine::new(&rig), trusting, &poses).expect(name);
        assert!((identified.parameters.centre_mm - worn.centre_mm).norm() < 1e-6, "{name}");
    }
}

#[test]
fn the_pose_that_alone_determines_the_centre_is_named() {
    let mut rng = rng(2709);
    for (name, worn) in machines() {
        // All about one axis, but for one pose that alone tells where on the axis the centre is.
        let turn = |angle: f64| Rotation3::from_axis_angle(&Vector3::y_axis(), angle);
        let mut turns: Vec<_> = (0..8).map(|pose| turn(0.2 * f64::from(pose) - 0.7)).collect();
        turns.insert(5, Rotation3::new(Vector3::new(0.5, 0.0, 0.1)));
        let mut poses = lengths_at(&worn, &turns);
        add_noise(&mut poses, &mut rng, NOISE_MM);
        // Whichever way it is told, it is not accepted: the other eight turn about y.
        match identify::<f64>(&worn, &poses).expect_err(name) {
            Refusal::NotRedundant { pose } => assert_eq!(pose, 5, "{name}"),
            Refusal::OneAxis { axis: [x, y, z], .. } => assert!(y.abs() > 0.9, "{name}: {x} {y} {z}"),
            other => panic!("{name}: {other:?}"),
        }
    }
}

#[test]
fn sets_that_are_no_sets() {
    for (name, worn) in machines() {
        for count in 0..3 {
            let refusal = identify::<f64>(&worn, &noisy(&worn, 2760, count)).expect_err(name);
            assert_eq!(refusal, Refusal::TooFewPoses { poses: count as u32 }, "{name}");
        }
        // Every triangle broken by cable 5 or 6; then every pose of a platform that does not fit.
        let mut broken = noisy(&worn, 2761, 10);
        broken.iter_mut().for_each(|pose| pose[5] *= 30.0);
        let expected = Refusal::BadLength { pose: 0, cable: 5, fault: LengthFault::BreaksTriangle };
        assert_eq!(identify::<f64>(&worn, &broken).expect_err(name), expected, "{name}");
        let mut far = worn;
        far.base_mm = far.base_mm.map(|point| point * 0.2);
        let refusal = identify::<f64>(&far, &noisy(&worn, 2762, 10)).expect_err(name);
        assert!(
            matches!(refusal, Refusal::PlatformDoesNotClose { pose: 0 } | Refusal::BadLength { pose: 0, .. }),
            "{name}: {refusal:?}"
        );
    }
}

#[test]
fn codes_and_texts_are_unique() {
    let fault = LengthFault::Jump;
    let all = [
        Refusal::TooFewPoses { poses: 0 },
        Refusal::BadLength { pose: 0, cable: 1, fault },
        Refusal::NotClosing { pose: 0, end_point: 1, iteration: 0 },
        Refusal::Singular,
        Refusal::IterationCap,
        Refusal::PlatformDoesNotClose { pose: 0 },
        Refusal::OneAxis { axis: [0.0; 3], excitation_rad: 0.0 },
        Refusal::TooAlike { spread_rad: 0.0 },
        Refusal::Weak { direction: [0.0; 3], sigma_mm: 0.0 },
        Refusal::TooManyOutliers { rejected: 0, poses: 0 },
        Refusal::CentreNotFixed { migration_mm: 0.0 },
        Refusal::OffsetNotDetermined { cable: 1, sigma_mm: 0.0 },
        Refusal::NotRedundant { pose: 0 },
    ];
    for (index, refusal) in all.iter().enumerate() {
        assert_eq!(usize::from(refusal.code()), index + 1, "{refusal:?} was renumbered");
        assert!(all.iter().filter(|other| other.text() == refusal.text()).count() == 1, "{refusal:?}");
    }
}
