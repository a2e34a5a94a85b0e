//! The oracle itself against what can be known without it: distances, differences, the geometry of Table I.

mod common;

use common::differences::{central_differences, flattest_mm, relative_difference};
use common::{Worn, arm, distance, poses, rng, tilted};
use host_tests::literal::{
    Ending, Failure, Lengths, Machine, Workspace, apex, identify, invert_6x6, pose_model,
    root_mean_square,
};
use nalgebra::{Matrix6, Rotation3, Vector3, Vector6};

/// Runs the iteration in memory of its own and returns the outcome with all `δE`.
fn run(
    machine: &Machine<f64>,
    poses: &[Lengths<f64>],
    start: host_tests::literal::Estimate<f64>,
    epsilon_mm: f64,
) -> (host_tests::literal::Outcome<f64>, Vec<f64>) {
    let cap = 20;
    let (mut d, mut y, mut deviations) = (
        vec![[0.0; 6]; 3 * poses.len()],
        vec![0.0; 3 * poses.len()],
        vec![0.0; cap + 1],
    );
    let mut workspace = Workspace {
        d: &mut d,
        y_mm: &mut y,
        deviations_mm: &mut deviations,
    };
    let outcome = identify(machine, poses, start, epsilon_mm, cap, &mut workspace);
    deviations.truncate(outcome.deviations);
    (outcome, deviations)
}

/// The normal matrix of a pose set at an estimate.
fn normal_matrix(worn: &Worn, poses: &[Lengths<f64>]) -> Matrix6<f64> {
    let mut normal = Matrix6::zeros();
    for (pose, lengths) in poses.iter().enumerate() {
        for row in pose_model(&worn.machine(), &worn.truth(), lengths, pose)
            .expect("truth closes")
            .d
        {
            let row = Vector6::from(row);
            normal += row * row.transpose();
        }
    }
    normal
}

#[test]
fn the_home_apexes_are_the_home_end_points() {
    for base_radius_mm in [120.0, 150.0, 200.0, 350.0] {
        let worn = Worn::table_one(base_radius_mm);
        let model = pose_model(
            &worn.machine(),
            &worn.truth(),
            &worn.lengths_mm(&Rotation3::identity()),
            0,
        )
        .unwrap();
        for (found, expected) in model.end_points_mm.iter().zip(worn.home_mm) {
            assert!(
                (found - expected).norm() < 1e-10,
                "radius {base_radius_mm}: {found} instead of {expected}"
            );
        }
    }
}

#[test]
fn a_rig_numbered_clockwise_gives_the_same_end_points() {
    let mut rng = rng(1);
    for _ in 0..1000 {
        let worn = Worn::random(&mut rng, 20.0);
        let mirror = |v: Vector3<f64>| Vector3::new(v.x, -v.y, v.z);
        let other = Worn {
            base_mm: worn.base_mm.map(mirror),
            centre_mm: mirror(worn.centre_mm),
            home_mm: worn.home_mm.map(mirror),
        };
        let lengths = worn.lengths_mm(&arm(&mut rng, 25.0));
        let one = pose_model(&worn.machine(), &worn.truth(), &lengths, 0).unwrap();
        let two = pose_model(&other.machine(), &other.truth(), &lengths, 0).unwrap();
        for (p, q) in one.end_points_mm.iter().zip(two.end_points_mm) {
            assert!((mirror(*p) - q).norm() < 1e-9);
        }
    }
}

#[test]
fn an_apex_has_the_three_distances_and_lies_on_its_side() {
    let mut rng = rng(2);
    for _ in 0..10_000 {
        let worn = Worn::random(&mut rng, 20.0);
        let lengths = worn.lengths_mm(&arm(&mut rng, 30.0));
        let base = [
            worn.base_mm[0] - worn.centre_mm,
            worn.base_mm[1] - worn.centre_mm,
        ];
        let radius = worn.home_mm[0].norm();
        for (counter_clockwise, sign) in [(true, 1.0), (false, -1.0)] {
            let p = apex(base, radius, [lengths[0], lengths[1]], counter_clockwise).unwrap();
            assert!((p.norm() - radius).abs() < 1e-9); // Eq. 1
            assert!(((p - base[0]).norm() - lengths[0]).abs() < 1e-9); // Eq. 2
            assert!(((p - base[1]).norm() - lengths[1]).abs() < 1e-9); // Eq. 3
            assert!(sign * base[0].cross(&base[1]).dot(&p) >= 0.0);
        }
    }
}

/// How often the true end-point lies beyond its plane O-B_a-B_b, as a share of poses with at least one such.
fn share_beyond_plane(base_radius_mm: f64, tilt_deg: f64) -> f64 {
    let mut rng = rng(3);
    let worn = Worn::table_one(base_radius_mm);
    let count = 20_000;
    let beyond = (0..count).filter(|_| {
        let arm = tilted(&mut rng, tilt_deg, 30.0);
        (0..3).any(|i| {
            let [a, b] = [
                worn.base_mm[i] - worn.centre_mm,
                worn.base_mm[(i + 1) % 3] - worn.centre_mm,
            ];
            a.cross(&b).dot(&(arm * worn.home_mm[i])) < 0.0
        })
    });
    beyond.count() as f64 / f64::from(count)
}

#[test]
fn the_side_rule_holds_near_home_and_not_far_from_it() {
    for (radius, tilt) in [
        (120.0, 40.0),
        (120.0, 50.0),
        (120.0, 60.0),
        (120.0, 75.0),
        (150.0, 60.0),
        (350.0, 60.0),
    ] {
        eprintln!("{radius} {tilt} {}", share_beyond_plane(radius, tilt));
    }
    assert_eq!(share_beyond_plane(120.0, 40.0), 0.0);
}

#[test]
fn a_tetrahedron_that_does_not_close_is_named() {
    let worn = Worn::table_one(150.0);
    let mut rng = rng(4);
    for pose in 0..5 {
        for end_point in 0..3 {
            let mut lengths = poses(&worn, &mut rng, 5, 20.0);
            lengths[pose][2 * end_point] = 1000.0; // no point 140.8 mm from O is that far from a base point
            let (outcome, deviations) = run(&worn.machine(), &lengths, worn.truth(), 1e-3);
            assert_eq!(
                outcome.ending,
                Ending::Failed(Failure::DoesNotClose { pose, end_point })
            );
            assert!(deviations.is_empty());
        }
    }
}

#[test]
fn d_is_the_derivative_of_the_computed_edges() {
    let mut rng = rng(5);
    let (mut worst, mut compared, mut flat, mut open) = (0.0_f64, 0, 0, 0);
    while compared < 10_000 {
        let worn = Worn::random(&mut rng, 20.0);
        let (machine, start) = (worn.machine(), worn.start(&mut rng, 30.0));
        let lengths = worn.lengths_mm(&arm(&mut rng, 30.0));
        let Ok(model) = pose_model(&machine, &start, &lengths, 0) else {
            open += 1;
            continue;
        };
        if flattest_mm(&machine, &start, &model) < 1.0 {
            flat += 1;
            continue;
        }
        let expected = central_differences(&machine, &start, &lengths).expect("closes all around");
        worst = worst.max(relative_difference(&model.d, &expected));
        compared += 1;
    }
    eprintln!("{worst:e} {compared} {flat} {open}");
    assert!(worst < 1e-8, "{worst}");
    assert!(flat < compared / 100, "{flat} poses too flat to compare");
}

#[test]
fn at_the_truth_of_table_one_nothing_is_left_over() {
    let mut rng = rng(6);
    for base_radius_mm in [120.0, 150.0, 200.0, 350.0] {
        let worn = Worn::table_one(base_radius_mm);
        for lengths in poses(&worn, &mut rng, 100, 25.0) {
            let model = pose_model(&worn.machine(), &worn.truth(), &lengths, 0).unwrap();
            assert!(
                model.y_mm.iter().all(|y| y.abs() < 1e-9),
                "{:?}",
                model.y_mm
            );
        }
    }
}

#[test]
fn the_printed_edge_of_table_one_leaves_more_than_epsilon() {
    let worn = Worn::table_one(150.0);
    let machine = Machine {
        edges_mm: [178.4; 3],
        ..worn.machine()
    };
    let model = pose_model(
        &machine,
        &worn.truth(),
        &worn.lengths_mm(&Rotation3::identity()),
        0,
    )
    .unwrap();
    // sqrt(3 (140.8² - 96²)) = 178.398206...
    assert!((root_mean_square(&model.y_mm) - 1.794e-3).abs() < 1e-6);
}

#[test]
fn two_poses_leave_the_centre_free_along_the_axis_of_their_relative_rotation() {
    let mut rng = rng(7);
    for _ in 0..1000 {
        let worn = Worn::random(&mut rng, 20.0);
        let [one, two] = [arm(&mut rng, 25.0), arm(&mut rng, 25.0)];
        let Some(axis) = (two * one.inverse()).axis() else {
            continue;
        };
        let normal = normal_matrix(&worn, &[worn.lengths_mm(&one), worn.lengths_mm(&two)]);
        let eigen = normal.symmetric_eigen();
        let mut order: Vec<usize> = (0..6).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let (smallest, next) = (eigen.eigenvalues[order[0]], eigen.eigenvalues[order[1]]);
        assert!(
            smallest.abs() < 1e-13 && next > 1e-7,
            "rank is not five: {}",
            eigen.eigenvalues
        );

        // A centre that moves by the axis n changes p_i by -n·OP_i / p_i, the same in both poses.
        let radii = worn.home_mm.map(|p| -axis.dot(&(one * p)) / p.norm());
        let expected =
            Vector6::new(axis.x, axis.y, axis.z, radii[0], radii[1], radii[2]).normalize();
        let null = eigen.eigenvectors.column(order[0]);
        assert!(
            null.dot(&expected).abs() > 1.0 - 1e-9,
            "{null} instead of {expected}"
        );
    }
}

#[test]
fn poses_about_one_axis_are_singular_and_others_are_not() {
    let mut rng = rng(8);
    for count in [2, 3, 10, 100] {
        let worn = Worn::random(&mut rng, 20.0);
        let (first, axis) = (
            arm(&mut rng, 10.0),
            tilted(&mut rng, 90.0, 0.0) * Vector3::z_axis(),
        );
        let one_axis: Vec<_> = (0..count)
            .map(|i| {
                Rotation3::from_axis_angle(&axis, 0.6 * (i as f64 / count as f64 - 0.5)) * first
            })
            .map(|arm| worn.lengths_mm(&arm))
            .collect();
        let (outcome, _) = run(&worn.machine(), &one_axis, worn.truth(), -1.0);
        assert_eq!(
            outcome.ending,
            Ending::Failed(Failure::SingularNormalMatrix),
            "{count} poses"
        );
        if count > 2 {
            let (outcome, _) = run(
                &worn.machine(),
                &poses(&worn, &mut rng, count, 30.0),
                worn.truth(),
                -1.0,
            );
            assert_ne!(
                outcome.ending,
                Ending::Failed(Failure::SingularNormalMatrix),
                "{count} poses"
            );
        }
    }
}

#[test]
fn the_inverse_of_a_normal_matrix_is_its_inverse() {
    let mut rng = rng(9);
    for _ in 0..1000 {
        let worn = Worn::random(&mut rng, 20.0);
        let count = 10;
        let normal = normal_matrix(&worn, &poses(&worn, &mut rng, count, 30.0));
        let inverse = invert_6x6(&normal.transpose().data.0).unwrap();
        let product = normal * Matrix6::from_fn(|row, column| inverse[row][column]);
        assert!((product - Matrix6::identity()).amax() < 1e-10);
    }
}

#[test]
fn starts_within_ten_millimetres_converge() {
    let mut rng = rng(10);
    for base_radius_mm in [150.0, 350.0] {
        let worn = Worn::table_one(base_radius_mm);
        let (mut converged, mut most) = (0, 0);
        for _ in 0..1000 {
            let lengths = poses(&worn, &mut rng, 6, 30.0);
            let (outcome, deviations) =
                run(&worn.machine(), &lengths, worn.start(&mut rng, 10.0), 1e-3);
            if outcome.ending == Ending::Converged {
                converged += 1;
                most = most.max(outcome.iterations);
                assert!(
                    distance(&outcome.estimate, &worn.truth()) < 1e-1,
                    "{outcome:?}"
                );
                assert_eq!(deviations.len(), outcome.iterations + 1);
                let (again, _) = run(&worn.machine(), &lengths, outcome.estimate, 1e-9);
                assert!(distance(&again.estimate, &worn.truth()) < 1e-6, "{again:?}");
            }
        }
        eprintln!("{base_radius_mm} {converged} {most}");
    }
}

#[test]
fn too_little_memory_is_said_and_not_written_past() {
    let worn = Worn::table_one(150.0);
    let lengths = poses(&worn, &mut rng(11), 3, 20.0);
    for (rows, residues, deviations) in [(8, 9, 3), (9, 8, 3), (9, 9, 2)] {
        let (mut d, mut y, mut e) = (
            vec![[0.0; 6]; rows],
            vec![0.0; residues],
            vec![0.0; deviations],
        );
        let mut workspace = Workspace {
            d: &mut d,
            y_mm: &mut y,
            deviations_mm: &mut e,
        };
        let outcome = identify(
            &worn.machine(),
            &lengths,
            worn.truth(),
            1e-3,
            2,
            &mut workspace,
        );
        assert_eq!(outcome.ending, Ending::Failed(Failure::TooLittleRoom));
    }
}
